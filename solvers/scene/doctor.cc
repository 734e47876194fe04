#include "solvers/scene/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <utility>

#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {

const char* ToString(DoctorVerdict verdict) {
  constexpr std::array kNames = {"sound", "suspect", "not_examined"};
  return kNames[static_cast<size_t>(verdict)];
}

Finding Found(const char* kind, const std::string& camera,
              const AgreementGain& gain, const std::string& fix,
              const std::string& what) {
  return {kind,
          camera,
          gain.sureness(),
          gain.before.mean_px(),
          gain.after.mean_px(),
          fix,
          what + fmt::format("; agreement {:.2f} instead of {:.2f}",
                             gain.after.score(), gain.before.score())};
}

Answer AnswerWith(Finding finding) {
  Answer answer;
  answer.findings.push_back(std::move(finding));
  return answer;
}

double Shared(double confidence, size_t count) {
  return std::min(0.95, confidence) / static_cast<double>(count);
}

SetUp::SetUp(const DoctorInput& the_input, const DoctorOptions& the_options)
    : input(the_input),
      options(the_options),
      cameras(input.cameras),
      detections(WithUsualConfidences(input.detections)),
      rate_hz(detections.header.frame_rate_hz) {
  if (input.independent_frames) return;
  number_step = UsualStep(detections.frames);
  rate_hz /= static_cast<double>(number_step);
  detections = OnGrid(detections, number_step, LongestLag());
}

void SetUp::Look() {
  // Approximate number of times each pair of views will be compared;
  // FramesToLookAt() returns fewer frames if it is large. Most comparisons come
  // from the search for other interpretations of the files (Stage::kReadings),
  // which tries every camera for each of the two views.
  const int looks = 25 + 2 * static_cast<int>(cameras.size());
  raw = PeopleOfViews(detections);
  frames = FramesToLookAt(raw, kFramesToLookAt, looks);
  ideal = Undistorted(raw, cameras);
  agreement = AgreementOfAll(cameras, ideal, frames);
}

void SetUp::Match() {
  segments = MakeSegments(cameras, detections, input.match(cameras, detections),
                          options.bundle.segments);
}

FitError SetUp::Fit() const {
  return MeasureFit(cameras, segments, NoChanges(cameras.size()),
                    options.bundle.segments);
}

CameraRig SetUp::NamedCameras() const {
  CameraRig named;
  for (size_t v = 0; v < cameras.size(); ++v) {
    named.push_back(Edited(cameras[v], [&](CameraParameters* camera) {
      camera->name = CameraName(v);
    }));
  }
  return named;
}

int SetUp::LongestLag() const {
  return static_cast<int>(options.longest_lag_s * rate_hz);
}

double SetUp::ScoreOf(const CameraRig& other_cameras,
                      const DetectionSequence& other_detections) const {
  return AgreementOfAll(other_cameras,
                        IdealPeople(other_detections, other_cameras), frames)
      .score();
}

PairAgreement SetUp::WithOthers(size_t view) const {
  return WithOthers(view, cameras[view], ideal[view], frames);
}

PairAgreement SetUp::WithOthers(size_t view, const Camera& camera,
                                const ViewPeople& own,
                                const std::vector<int>& in_frames) const {
  PairAgreement all;
  for (const auto& [a, b] : ComparedPairs(cameras.size())) {
    if (a != view && b != view) continue;
    const size_t v = a == view ? b : a;
    all.Add(AgreementOf(cameras[v], ideal[v], camera, own, in_frames));
  }
  return all;
}

namespace {

class Doctor {
 public:
  Doctor(const DoctorInput& input, const DoctorOptions& options)
      : set_up_(input, options) {}

  Diagnosis Run() {
    Ask(Stage::kFiles);
    set_up_.Look();
    if (set_up_.frames.empty() || set_up_.cameras.size() < 2) {
      Note(set_up_.detections.header.skeleton.joint_count() < 2
               ? "nothing was examined: the subject is a single point, but at "
                 "least two joints are needed"
               : "nothing was examined: this needs frames in which two views "
                 "see people with at least six joints (all, for smaller "
                 "skeletons)");
      return Closed(DoctorVerdict::kNotExamined);
    }
    Ask(Stage::kTwins);
    AskThoseThatCompete();
    Ask(Stage::kWorld);
    const bool examined = !set_up_.input.match || AskOfMatches();
    return Closed(examined ? DoctorVerdict::kSound
                           : DoctorVerdict::kNotExamined);
  }

 private:
  void Note(std::string note) { diagnosis_.notes.push_back(std::move(note)); }

  void Ask(Stage stage) {
    for (const Hypothesis& one : Hypotheses()) {
      for (int times = 0; one.stage == stage && times < one.most; ++times) {
        std::optional<Answer> answer = one.ask(set_up_);
        if (!answer.has_value()) break;
        Take(std::move(*answer), stage);
      }
    }
  }

  void AskThoseThatCompete() {
    constexpr int kMostChanges = 3;
    Note(
        fmt::format("with the calibration as read, the agreement of the views "
                    "is {:.2f} (1 is perfect; joints lie {:.1f} px from the "
                    "epipolar lines on average)",
                    set_up_.agreement.score(), set_up_.agreement.mean_px()));
    std::vector<Hypothesis> asked = Hypotheses();
    while (set_up_.readings_changed < kMostChanges) {
      std::optional<Answer> best;  // the first of equal answers
      Hypothesis* of_best = nullptr;
      for (Hypothesis& one : asked) {
        std::optional<Answer> answer;
        if (one.stage == Stage::kReadings && one.most > 0) {
          answer = one.ask(set_up_);
        }
        if (!answer || (best && answer->score <= best->score)) continue;
        best = std::move(answer);
        of_best = &one;
      }
      if (!best) return;
      --of_best->most;
      ++set_up_.readings_changed;
      Take(std::move(*best), Stage::kReadings);
    }
  }

  // False if there are too few matches.
  bool AskOfMatches() {
    set_up_.Match();
    Ask(Stage::kStrangers);
    constexpr size_t kEnough = 100;
    if (set_up_.segments.segments.size() < kEnough) {
      Note(
          "too few people are matched between views to examine individual "
          "cameras and clocks: a longer recording is needed");
      return false;
    }
    Ask(Stage::kJumps);
    const double span_s = set_up_.options.bundle.segments.span_s;
    Note(
        fmt::format("matched joints lie {:.2f} px from the projection of their "
                    "best-fitting 3D position (mean, capped at 30 px), in {} "
                    "motion segments of {}",
                    set_up_.Fit().MeanPx(), set_up_.segments.segments.size(),
                    span_s < set_up_.segments.frame_s
                        ? "one frame"
                        : fmt::format("up to {:.2g} s", span_s)));
    Ask(Stage::kMatches);
    return true;
  }

  // Applies exactly the changes of the answer and recomputes what depends on
  // them.
  void Take(Answer answer, Stage stage) {
    std::move(answer.findings.begin(), answer.findings.end(),
              std::back_inserter(diagnosis_.findings));
    std::move(answer.notes.begin(), answer.notes.end(),
              std::back_inserter(diagnosis_.notes));
    diagnosis_.stature_m += answer.stature_m;
    if (!answer.cameras && !answer.detections && answer.strangers.empty()) {
      return;
    }
    if (answer.cameras) set_up_.cameras = std::move(*answer.cameras);
    if (answer.detections) set_up_.detections = std::move(*answer.detections);
    for (const size_t view : answer.strangers) {
      set_up_.strangers.insert(view);
      for (DetectionFrame& frame : set_up_.detections.frames) {
        frame.views[view].detections.clear();
      }
    }
    if (stage == Stage::kFiles) return;  // Run() calls Look() later
    set_up_.Look();
    if (stage < Stage::kStrangers) return;
    if (answer.segments) {
      set_up_.segments = std::move(*answer.segments);
    } else {
      set_up_.Match();
    }
  }

  // The finished diagnosis; its verdict is `otherwise` if no significant fault
  // was found.
  Diagnosis Closed(DoctorVerdict otherwise) {
    diagnosis_.cameras = set_up_.NamedCameras();
    const bool suspect =
        std::any_of(diagnosis_.findings.begin(), diagnosis_.findings.end(),
                    [](const Finding& finding) { return finding.significant; });
    diagnosis_.verdict = suspect ? DoctorVerdict::kSuspect : otherwise;
    return std::move(diagnosis_);
  }

  SetUp set_up_;
  Diagnosis diagnosis_;
};

}  // namespace

Diagnosis Diagnose(const DoctorInput& input, const DoctorOptions& options) {
  return Doctor(input, options).Run();
}

}  // namespace kinegraph
