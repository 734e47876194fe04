#include "solvers/scene/doctor.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <utility>

#include "core/evaluation/statistics.h"
#include "solvers/scene/camera_break.h"
#include "solvers/scene/clock_jumps.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/confidence_scale.h"
#include "solvers/scene/doctor_words.h"
#include "solvers/scene/explain_residuals.h"
#include "solvers/scene/fit_error.h"
#include "solvers/scene/frame_faults.h"
#include "solvers/scene/reading_search.h"
#include "solvers/scene/readings.h"
#include "solvers/scene/refine.h"
#include "solvers/scene/view_agreement.h"
#include "solvers/scene/view_checks.h"

namespace kinegraph {

const char* ToString(DoctorVerdict verdict) {
  switch (verdict) {
    case DoctorVerdict::kSound:
      return "sound";
    case DoctorVerdict::kSuspect:
      return "suspect";
    case DoctorVerdict::kNotExamined:
      return "not_examined";
  }
  return "";
}

namespace {

constexpr double kMinConfidence = 0.3;  // of the joints that are looked at

class Doctor {
 public:
  Doctor(const DoctorInput& input, const DoctorOptions& options)
      : input_(input),
        options_(options),
        cameras_(input.cameras),
        detections_(WithUsualConfidences(input.detections)) {}

  Diagnosis Run() {
    diagnosis_.findings = FindFrameFaults(input_);
    LookAtFrameRanges();
    LookAgain();
    if (frames_.empty() || cameras_.size() < 2) {
      diagnosis_.notes.push_back(
          "nothing was examined: there is no frame in which two views see six "
          "joints of somebody");
      return Closed(DoctorVerdict::kNotExamined);
    }
    LookForTwins();
    LookAtViews();
    LookAtUnit();
    if (input_.match) {
      if (options_.looks_for_break) LookForBreak();
      LookAtMatches();
    }
    return Closed(examined_ ? DoctorVerdict::kSound
                            : DoctorVerdict::kNotExamined);
  }

 private:
  // With `otherwise` where nothing was found to be wrong.
  Diagnosis Closed(DoctorVerdict otherwise) {
    // The corrected file gives each view the right camera under the name that
    // the view is paired with.
    for (size_t v = 0; v < cameras_.size(); ++v) {
      CameraParameters parameters = cameras_[v].parameters();
      parameters.name = NameOf(v);
      cameras_[v] = Camera(parameters);
    }
    diagnosis_.cameras = cameras_;
    const bool suspect =
        std::any_of(diagnosis_.findings.begin(), diagnosis_.findings.end(),
                    [](const Finding& finding) { return finding.told; });
    diagnosis_.verdict = suspect ? DoctorVerdict::kSuspect : otherwise;
    return diagnosis_;
  }

  std::string NameOf(size_t view) const { return input_.cameras[view].name(); }

  void Add(Finding finding) {
    diagnosis_.findings.push_back(std::move(finding));
  }

  // ---- Without tracking ----

  // Two views with one calibration: the one that agrees less with the other
  // views has another one's. It takes no part in what follows, else a clock or
  // a turn would be made up for it.
  void LookForTwins() {
    for (size_t a = 0; a < cameras_.size(); ++a) {
      for (size_t b = a + 1; b < cameras_.size(); ++b) {
        // Nobody mounts two cameras within a millimetre, looking one way.
        if ((cameras_[a].centre() - cameras_[b].centre()).norm() > 1e-3 ||
            (cameras_[a].R() - cameras_[b].R()).cwiseAbs().maxCoeff() > 1e-4) {
          continue;
        }
        const bool first = AgreementWithOthers(a) < AgreementWithOthers(b);
        AddTwin(first ? a : b, first ? b : a);
      }
    }
  }

  double AgreementWithOthers(size_t view) const {
    PairAgreement all;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (v == view) continue;
      all.Add(AgreementOf(cameras_[v], ideal_[v], cameras_[view], ideal_[view],
                          frames_));
    }
    return all.score();
  }

  void AddTwin(size_t wrong, size_t right) {
    if (!strangers_.insert(wrong).second) return;
    Add({"never_matched", NameOf(wrong), 0.9, 0.0, 0.0,
         "--without_cameras=" + NameOf(wrong) + ", or calibrate it anew",
         "its calibration equals that of " + NameOf(right) +
             Format(", and it agrees to %.2f with the other views instead of "
                    "%.2f",
                    AgreementWithOthers(wrong), AgreementWithOthers(right))});
    for (DetectionFrame& frame : detections_.frames) {
      frame.views[wrong].detections.clear();
    }
    LookAgain();
  }

  // At detections or cameras that have changed.
  void LookAgain() {
    // At each pair of views, or so: most in the search for readings.
    constexpr int kLooks = 30;
    raw_ = PeopleOfViews(detections_, kMinConfidence);
    frames_ = FramesToLookAt(raw_, options_.frames_to_look_at, kLooks);
    ideal_ = Ideal(raw_);
  }

  std::vector<ViewPeople> Ideal(const std::vector<ViewPeople>& raw) const {
    std::vector<ViewPeople> ideal;
    for (size_t v = 0; v < raw.size(); ++v) {
      ideal.push_back(Undistorted(raw[v], cameras_[v]));
    }
    return ideal;
  }

  int LongestLag() const {
    return static_cast<int>(options_.longest_lag_s * input_.frame_rate_hz);
  }

  // Views that share no frame with the others.
  void LookAtFrameRanges() {
    const std::vector<ShownFrames> shown = FramesShown(detections_);
    const std::vector<int64_t> offsets = FrameOffsets(shown);
    if (offsets.empty()) return;
    std::string others;
    for (size_t v = 0; v < shown.size(); ++v) {
      if (offsets[v] == 0) others += Range(v, shown[v]);
    }
    detections_ = WithFrameOffsets(detections_, offsets);
    std::string keys;
    for (size_t v = 0; v < shown.size(); ++v) {
      if (offsets[v] == 0) continue;
      keys += (keys.empty() ? "" : ";") +
              ("input.view_frame_offset." + ViewName(v)) + "=" +
              std::to_string(offsets[v]);
    }
    for (size_t v = 0; v < shown.size(); ++v) {
      if (offsets[v] == 0) continue;
      Add({"frame_range", NameOf(v), 0.95, 0.0, 0.0, "'--set=" + keys + "'",
           "it shares no frame with the others:" + Range(v, shown[v]) +
               " against" + others +
               "; where they begin together its numbers are too high by " +
               std::to_string(offsets[v])});
    }
  }

  std::string Range(size_t view, const ShownFrames& shown) const {
    return " " + ViewName(view) + " " + std::to_string(shown.first) + ".." +
           std::to_string(shown.last);
  }

  const std::string& ViewName(size_t view) const {
    return input_.detections.header.view_names[view];
  }

  // What is said of single views, of readings of the file and of clocks: what
  // brings the views together best is taken, and asked again.
  void LookAtViews() {
    constexpr int kMostChanges = 3;
    constexpr double kSoundEnough = 0.85;  // nothing can gain what is asked
    bool first = true;
    for (int change = 0; change < kMostChanges; ++change) {
      const PairAgreement as_read = AgreementOfAll(cameras_, ideal_, frames_);
      if (first) {
        diagnosis_.notes.push_back(
            Format("people seen by two views agree to %.2f of 1 as the "
                   "calibration is read (%.1f px from each other's epipolar "
                   "lines)",
                   as_read.score(), as_read.mean_px()));
      }
      std::vector<Candidate> candidates;
      if (as_read.score() < kSoundEnough) {
        AddImageCandidate(&candidates);
        AddRateCandidate(&candidates);
        AddReadingCandidates(&candidates);
      }
      AddSidesCandidate(&candidates);
      AddClockCandidate(&candidates);
      if (candidates.empty()) {
        if (first) LookForAnotherRoom(as_read);
        return;
      }
      // Of what is as good the simplest comes first.
      std::max_element(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) {
                         return a.score < b.score;
                       })
          ->apply();
      LookAgain();
      first = false;
    }
  }

  struct Candidate {
    double score = 0.0;  // of all pairs of views, with it
    std::function<void()> apply;
  };

  double ScoreOf(const CameraRig& cameras,
                 const DetectionSequence& detections) const {
    std::vector<ViewPeople> people = PeopleOfViews(detections, kMinConfidence);
    for (size_t v = 0; v < people.size(); ++v) {
      people[v] = Undistorted(people[v], cameras[v]);
    }
    return AgreementOfAll(cameras, people, frames_).score();
  }

  void AddImageCandidate(std::vector<Candidate>* candidates) {
    const auto image = FindOtherImage(cameras_, raw_, frames_);
    if (!image.has_value()) return;
    CameraRig rig = cameras_;
    rig[image->view] = WithImage(cameras_[image->view], *image);
    candidates->push_back({ScoreOf(rig, detections_), [this, image, rig] {
                             AddOtherImage(*image);
                             cameras_ = rig;
                           }});
  }

  void AddOtherImage(const OtherImage& image) {
    const Camera& camera = cameras_[image.view];
    std::string what;
    if (image.scaled()) {
      what = Format(
          "its video is %.4g times as large as the calibration's "
          "image",
          image.scale);
    }
    if (image.cropped()) {
      what += (what.empty() ? "its video" : ", and") +
              Format(" begins at pixel (%.0f, %.0f) of ", image.offset_px.x(),
                     image.offset_px.y()) +
              (image.scaled() ? "that" : "the calibration's image");
    }
    // Cameras that are turned by little look alike; by a tenth of the image
    // nobody turns one without moving it.
    const double share = image.offset_px.norm() / ImageWidth(camera);
    const double most = image.scaled() || share > 0.1 ? 0.95 : 0.5;
    Add({image.cropped() ? "crop" : "image_size", NameOf(image.view),
         std::min(most, Sureness(image.score_after - image.score_before,
                                 image.score_after)),
         image.before_px, image.after_px, kUseCorrected,
         what + Agreement(image.score_before, image.score_after)});
  }

  static std::string Agreement(double before, double after) {
    return Format("; agreement %.2f instead of %.2f", after, before);
  }

  void AddRateCandidate(std::vector<Candidate>* candidates) {
    const auto rate =
        FindOtherRate(cameras_, ideal_, detections_, input_.frame_rate_hz);
    if (!rate.has_value()) return;
    const DetectionSequence moved = WithViewRate(
        detections_, rate->view, rate->rate_hz / input_.frame_rate_hz);
    candidates->push_back(
        {ScoreOf(cameras_, moved), [this, rate, moved] {
           Add({"view_rate", NameOf(rate->view),
                Sureness(rate->score_after - rate->score_before,
                         rate->score_after),
                rate->before_px, rate->after_px,
                "--set=input.view_frame_rate." + ViewName(rate->view) + "=" +
                    Format("%.4g", rate->rate_hz),
                Format("its files count at %.4g Hz, the others' at %.4g",
                       rate->rate_hz, input_.frame_rate_hz) +
                    Agreement(rate->score_before, rate->score_after)});
           detections_ = moved;
         }});
  }

  void AddSidesCandidate(std::vector<Candidate>* candidates) {
    const auto sides = FindExchangedSides(cameras_, ideal_, frames_,
                                          detections_.header.skeleton);
    if (!sides.has_value()) return;
    DetectionSequence moved = detections_;
    ExchangeSides(sides->views, &moved);
    candidates->push_back({ScoreOf(cameras_, moved), [this, sides, moved] {
                             AddExchangedSides(*sides);
                             detections_ = moved;
                           }});
  }

  void AddExchangedSides(const ExchangedSides& sides) {
    std::string names;
    for (size_t v = 0; v < sides.views.size(); ++v) {
      if (!sides.views[v]) continue;
      names += (names.empty() ? "\"" : ",\"") + ViewName(v) + "\"";
    }
    const std::string fix = "'--set=detections.exchange_sides=[" + names + "]'";
    const bool all = std::count(sides.views.begin(), sides.views.end(), 1) ==
                     static_cast<std::ptrdiff_t>(sides.views.size());
    if (all) {
      Add({"sides", "", 0.9, 0.0, 0.0, fix,
           Format("left and right are exchanged: noses lie behind the "
                  "shoulders in %.0f of %.0f people",
                  sides.backwards, sides.looked_at)});
      return;
    }
    for (size_t v = 0; v < sides.views.size(); ++v) {
      if (!sides.views[v]) continue;
      Add({"sides", NameOf(v),
           Sureness(sides.score_after - sides.score_before, sides.score_after),
           sides.before_px, sides.after_px, fix,
           "left and right are exchanged in it" +
               Agreement(sides.score_before, sides.score_after)});
    }
  }

  void AddReadingCandidates(std::vector<Candidate>* candidates) {
    const ReadingSearch search = SearchReadings(cameras_, raw_, frames_);
    if (search.better.empty()) return;
    candidates->push_back(
        {search.better.front().score, [this, search] { TakeReading(search); }});
  }

  void AddClockCandidate(std::vector<Candidate>* candidates) {
    if (clocks_taken_) return;
    const ClockSearch clocks = SearchClocks(cameras_, ideal_, LongestLag());
    if (!clocks.found()) return;
    candidates->push_back({clocks.score_after, [this, clocks] {
                             clocks_taken_ = true;
                             ApplyClocks(clocks);
                           }});
  }

  // No reading and no clock brings the views together.
  void LookForAnotherRoom(const PairAgreement& as_read) {
    // Sound takes agree to 0.5 and more; people of two views who are paired
    // without any relation agree to 0.1 or so (docs/doctor.md).
    constexpr double kUnrelated = 0.2;
    if (as_read.score() > kUnrelated) return;
    Add({"never_matched", "", 0.8, as_read.mean_px(), as_read.mean_px(),
         "calibrate anew, or check that calibration and detections are of one "
         "recording",
         Format("people seen by two views agree to %.2f of 1, and no other "
                "reading of the calibration and no lag brings them together: "
                "it may be of another set-up",
                as_read.score())});
  }

  void ApplyClocks(const ClockSearch& clocks) {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const int lag = clocks.lag_frames[v];
      if (lag == 0) continue;
      const double offset_s = -lag / input_.frame_rate_hz;
      Add({"clock_offset", NameOf(v),
           Shared(Sureness(clocks.moved_gain, clocks.score_after), 1),
           clocks.before_px, clocks.after_px, "--set=cameras.refine_clock=true",
           Format("its frames agree best with those of the first view %+.0f "
                  "frames away (%+.3f s)",
                  static_cast<double>(lag), offset_s)});
    }
    detections_ = Realigned(detections_, clocks.lag_frames);
  }

  // How sure a change is that gains so much agreement, up to `after`.
  static double Sureness(double gain, double after) {
    return 0.95 * std::min(1.0, gain / 0.15) * std::min(1.0, after / 0.5);
  }

  void TakeReading(const ReadingSearch& search) {
    for (const ReadingScore& score : search.better) {
      AddReading(search.as_read, score, search.better.size());
    }
    const Reading& reading = search.better.front().reading;
    CameraRig rig = CamerasOf(cameras_, reading);
    bool mirrored = false;
    for (size_t v = 0; v < rig.size(); ++v) {
      if (const auto seeing = Seeing(rig[v], reading.images[v])) {
        rig[v] = *seeing;
      } else {
        mirrored = true;
        MirrorBack(v, rig[v]);
      }
    }
    cameras_ = std::move(rig);
    if (mirrored) {
      diagnosis_.notes.push_back(
          "no camera sees mirrored images: the corrected calibration holds "
          "for the images mirrored back");
    }
  }

  void MirrorBack(size_t view, const Camera& camera) {
    const double width =
        camera.width_px() > 0 ? camera.width_px() : 2.0 * camera.K()(0, 2);
    for (DetectionFrame& frame : detections_.frames) {
      for (Detection& detection : frame.views[view].detections) {
        for (Keypoint& joint : detection.joints) {
          joint.px.x() = width - 1.0 - joint.px.x();
        }
      }
    }
  }

  void AddReading(const ReadingScore& before, const ReadingScore& after,
                  size_t alike) {
    const double confidence =
        Shared(Sureness(after.score - before.score, after.score), alike);
    const std::string agreement =
        Format("; agreement %.2f instead of %.2f", after.score, before.score);
    const Reading& reading = after.reading;
    const auto add = [&](const std::string& kind, const std::string& camera,
                         const std::string& fix, const std::string& what) {
      Add({kind, camera, confidence, before.distance_px, after.distance_px, fix,
           what + agreement});
    };
    if (reading.pose != PoseReading::kAsRead) {
      add("convention", "", kUseCorrected,
          std::string("the poses fit as: ") + Describe(reading.pose));
    }
    if (reading.image_scale != 1.0) {
      add("intrinsics", "", kUseCorrected,
          Format("the camera matrix fits multiplied by %.4g",
                 reading.image_scale));
    }
    AddImages(reading, add);
    std::string map;
    std::string names;
    for (size_t v = 0; v < reading.camera_of_view.size(); ++v) {
      const auto camera = static_cast<size_t>(reading.camera_of_view[v]);
      if (camera == v) continue;
      const std::string& view = input_.detections.header.view_names[v];
      map += (map.empty() ? "--set=cameras.map." : ";cameras.map.") + view +
             "=" + NameOf(camera);
      names +=
          (names.empty() ? "" : ", ") + view + " is seen by " + NameOf(camera);
    }
    if (!map.empty()) add("swapped_views", "", map, names);
  }

  template <typename AddFunction>
  void AddImages(const Reading& reading, const AddFunction& add) {
    const bool all_alike = std::all_of(
        reading.images.begin(), reading.images.end(),
        [&](ImageReading image) { return image == reading.images.front(); });
    for (size_t v = 0; v < reading.images.size(); ++v) {
      const ImageReading image = reading.images[v];
      if (image == ImageReading::kAsRead) continue;
      const bool mirrored = image == ImageReading::kMirrored;
      add("image", all_alike ? "" : NameOf(v),
          mirrored ? "mirror the images back before people are detected"
                   : kUseCorrected,
          std::string("the images were ") + Describe(image));
      if (all_alike) return;
    }
  }

  // ---- Unit ----

  void LookAtUnit() {
    const Stature stature =
        StatureOf(cameras_, ideal_, frames_, detections_.header.skeleton);
    constexpr int kEnough = 20;
    if (stature.count < kEnough) {
      diagnosis_.notes.push_back("too few whole bodies to tell the unit");
      return;
    }
    diagnosis_.notes.push_back(
        Format("people are %.3g m tall (median of %.0f bodies)",
               stature.median_m, stature.count));
    // Infants to basketball players.
    constexpr double kSmallest = 0.5;
    constexpr double kTallest = 2.3;
    if (stature.median_m >= kSmallest && stature.median_m <= kTallest) return;
    Finding finding{"unit", "", 0.95, 0.0, 0.0, "", ""};
    finding.before_px = finding.after_px = MeanDistancePx();
    finding.evidence = Format("people would be %.3g m tall", stature.median_m);
    for (const double factor : {0.001, 0.01, 0.1, 10.0, 100.0, 1000.0}) {
      const double height = stature.median_m * factor;
      if (height < kSmallest || height > kTallest) continue;
      finding.fix = UnitFix(input_.units_per_metre / factor);
      finding.evidence +=
          Format("; lengths times %.4g make them %.2f m", factor, height);
      Add(finding);
      Rescale(factor);
      return;
    }
    // No unit explains it: a board whose squares were given wrongly.
    finding.confidence = 0.5;
    finding.fix = "measure a length in the room and scale the calibration";
    finding.evidence += " and no unit makes them 0.5 to 2.3 m";
    Add(finding);
  }

  std::string UnitFix(double units_per_metre) const {
    if (!input_.unit_can_be_set) return kUseCorrected;
    for (const auto& [units, name] :
         {std::pair{1.0, "m"}, {100.0, "cm"}, {1000.0, "mm"}}) {
      if (std::abs(units_per_metre / units - 1.0) < 1e-9) {
        return std::string("--set=cameras.unit=") + name;
      }
    }
    return kUseCorrected;
  }

  double MeanDistancePx() const {
    return AgreementOfAll(cameras_, ideal_, frames_).mean_px();
  }

  void Rescale(double factor) {
    for (Camera& camera : cameras_) {
      CameraParameters parameters = camera.parameters();
      parameters.t *= factor;
      camera = Camera(parameters);
    }
  }

  // ---- A camera that was moved in the middle ----

  // The two sides of a break are diagnosed apart: what is said of the view on
  // the worse one and not on the other is the break. The rest of the diagnosis
  // is of the better side.
  void LookForBreak() {
    const auto found = FindCameraBreak(cameras_, ideal_, detections_);
    if (!found.has_value()) return;
    const int worse = found->worse_after() ? 1 : 0;
    if (IsLag(*found, worse)) return;
    std::vector<Finding> of_view;
    for (const int side : {worse, 1 - worse}) {
      const Diagnosis part =
          DiagnosePart(SideOf(detections_, found->from, side));
      for (const Finding& finding : part.findings) {
        if (finding.camera != NameOf(found->view)) continue;
        const bool sure = finding.confidence > 0.5;
        if (side != worse || (finding.kind == "clock_offset" && sure)) return;
        of_view.push_back(finding);
      }
    }
    if (of_view.empty()) return;
    for (const Finding& finding : of_view) AddBreak(*found, finding);
    detections_ = SideOf(detections_, found->from, 1 - worse);
    LookAgain();
  }

  // Whether a lag makes the worse side as good as the other one: pictures were
  // lost, which are looked for later.
  bool IsLag(const CameraBreak& found, int worse) const {
    constexpr double kNearly = 0.05;  // of agreement
    const auto ideal_of = [&](int side) {
      return Ideal(
          PeopleOfViews(SideOf(detections_, found.from, side), kMinConfidence));
    };
    const ClockSearch lags =
        SearchClocks(cameras_, ideal_of(worse), LongestLag());
    const std::vector<ViewPeople> better = ideal_of(1 - worse);
    const double score =
        AgreementOfAll(cameras_, better,
                       FramesToLookAt(better, options_.frames_to_look_at))
            .score();
    return lags.found() && lags.score_after > score - kNearly;
  }

  Diagnosis DiagnosePart(DetectionSequence part) const {
    DoctorInput input = input_;
    input.cameras.clear();
    for (size_t v = 0; v < cameras_.size(); ++v) {
      CameraParameters parameters = cameras_[v].parameters();
      parameters.name = NameOf(v);
      input.cameras.emplace_back(parameters);
    }
    input.detections = std::move(part);
    DoctorOptions options = options_;
    options.looks_for_break = false;
    options.longest_lag_s = 0.0;
    return Diagnose(input, options);
  }

  void AddBreak(const CameraBreak& found, Finding finding) {
    const auto& frames = detections_.frames;
    const auto first = static_cast<double>(frames.front().frame);
    const auto from = static_cast<double>(frames[found.from].frame);
    const auto end = static_cast<double>(frames.back().frame + 1);
    const bool after = found.worse_after();
    const std::string fix =
        finding.kind == "never_matched"
            ? finding.fix
            : Format(
                  "take the cameras.json that doctor --frames=%.0f:%.0f "
                  "writes",
                  after ? from : first, after ? end : from);
    finding.fix =
        Format("track the frames before and from %.0f on apart; for ", from) +
        (after ? "those from it on " : "those before it ") + fix;
    finding.evidence = Format(after ? "from about frame %.0f on: "
                                    : "before about frame %.0f: ",
                              from) +
                       finding.evidence +
                       "; it was moved in the middle of the recording";
    Add(std::move(finding));
  }

  // ---- With the tracker's matches ----

  void LookAtMatches() {
    Match();
    LookForStrangers();
    constexpr size_t kEnough = 100;
    if (segments_.segments.size() < kEnough) {
      diagnosis_.notes.push_back(
          "too few people are matched between views to look at single "
          "cameras and clocks");
      return;
    }
    LookForJumps();
    const FitError before =
        MeasureFit(cameras_, segments_, changes_, options_.bundle.segments);
    diagnosis_.notes.push_back(Format(
        "matched joints lie %.2f px from their best place in 3D (mean, "
        "capped at 30 px), %.0f stretches of a fifth of a second",
        before.MeanPx(), static_cast<double>(segments_.segments.size())));
    LookAtSpeeds();
    LookAtLens(before);
    std::vector<std::string> names;
    for (const Camera& camera : input_.cameras) names.push_back(camera.name());
    changes_ =
        ExplainResiduals({cameras_, segments_, strangers_, names,
                          input_.frame_rate_hz, SubjectSize()},
                         options_.bundle, changes_, &diagnosis_.findings);
    cameras_ = RefinedCameras(cameras_, changes_);
  }

  void Match() {
    const FrozenMatches matches = input_.match(cameras_, detections_);
    segments_ =
        MakeSegments(cameras_, detections_, matches, options_.bundle.segments);
    changes_.assign(cameras_.size(), CameraChange::Zero());
  }

  // Of the bodies, by their boxes in the images and how far they are away [m].
  double SubjectSize() const {
    std::vector<double> sizes_m;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      std::vector<double> sizes_px;
      for (const auto& frame : raw_[v].frames) {
        for (const auto& person : frame) sizes_px.push_back(person.size_px);
      }
      std::vector<double> depths_m;
      for (const MotionSegment& segment : segments_.segments) {
        depths_m.push_back(cameras_[v].Depth(PositionOf(segment)));
      }
      if (sizes_px.empty()) continue;
      sizes_m.push_back(Quantile(std::move(sizes_px), 0.5) *
                        Quantile(std::move(depths_m), 0.5) /
                        cameras_[v].focal_px());
    }
    return sizes_m.empty() ? 1.7 : Quantile(std::move(sizes_m), 0.5);
  }

  // Pictures that were lost, one jump after the other.
  void LookForJumps() {
    constexpr int kMostJumps = 5;
    for (int i = 0; i < kMostJumps && ApplyJump(); ++i) {
    }
  }

  bool ApplyJump() {
    if (!MoveEnough(segments_)) return false;
    const double frame_s = 1.0 / std::max(1.0, input_.frame_rate_hz);
    const auto jump = FindClockJump(cameras_, segments_, changes_,
                                    options_.bundle.segments, frame_s);
    if (!jump.has_value()) return false;
    const auto view = static_cast<size_t>(jump->view_idx);
    if (strangers_.count(view) > 0) return false;
    const auto& frames = detections_.frames;
    const TimeNs middle =
        frames.front().time + (frames.back().time - frames.front().time) / 2;
    const auto at = std::lower_bound(
        frames.begin(), frames.end(), middle + FromSeconds(jump->at_s),
        [](const DetectionFrame& f, TimeNs time) { return f.time < time; });
    const auto from = static_cast<int64_t>(at - frames.begin());
    const auto number = static_cast<double>(
        at == frames.end() ? frames.back().frame : at->frame);
    const double before_px =
        MeasureFit(cameras_, segments_, changes_, options_.bundle.segments)
            .MeanPx(jump->view_idx);
    DetectionSequence moved = WithoutJump(detections_, *jump, from);
    std::swap(detections_, moved);
    SceneSegments old = segments_;
    Match();
    const double after_px =
        MeasureFit(cameras_, segments_, changes_, options_.bundle.segments)
            .MeanPx(jump->view_idx);
    constexpr double kLeastShare = 0.05;
    if (before_px - after_px < kLeastShare * before_px) {
      std::swap(detections_, moved);
      segments_ = std::move(old);
      return false;
    }
    const double count = std::abs(jump->missing);
    Add({"frames", NameOf(view), 0.9, before_px, after_px,
         jump->missing > 0
             ? Format("give its files from about %.0f on numbers that are %.0f "
                      "higher",
                      number, count)
             : Format("take %.0f pictures out before about frame %.0f", count,
                      number),
         Format(jump->missing > 0
                    ? "%.0f pictures are missing before about frame %.0f"
                    : "%.0f pictures are too many before about frame %.0f",
                count, number) +
             Format(": its clock jumps by %+.1f +- %.1f ms", 1e3 * jump->jump_s,
                    1e3 * jump->sigma_s)});
    return true;
  }

  // People who are faster than any: the frame rate is less than told.
  void LookAtSpeeds() {
    constexpr double kFastestMps = 8.0;  // sprinters reach 10
    // A recording that is told as too short by its rate has few stretches.
    constexpr size_t kEnough = 20;
    std::vector<double> speeds;
    for (const MotionSegment& segment : segments_.segments) {
      const std::string& name =
          detections_.header.skeleton
              .joints()[static_cast<size_t>(segment.joint)];
      if (name != "l_hip" && name != "r_hip") continue;
      speeds.push_back(segment.state.segment<3>(3).norm());
    }
    if (speeds.size() < kEnough) return;
    const double speed_mps = Quantile(speeds, 0.95);
    if (speed_mps <= kFastestMps) return;
    Add({"frame_rate", "", 0.8, 0.0, 0.0, "the right input.frame_rate",
         Format("people move at %.1f m/s at %.4g Hz", speed_mps,
                input_.frame_rate_hz)});
  }

  // Views that are hardly ever matched. The few matches that they have are
  // wrong, and take no part in what follows.
  void LookForStrangers() {
    bool any = false;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const double all = static_cast<double>(segments_.detections[v]);
      const double share =
          all > 0.0 ? static_cast<double>(segments_.matched[v]) / all : 1.0;
      constexpr double kStranger = 0.2;
      constexpr double kEnough = 20.0;
      if (all < kEnough || share > kStranger) continue;
      strangers_.insert(v);
      any = true;
      for (DetectionFrame& frame : detections_.frames) {
        frame.views[v].detections.clear();
      }
      std::string evidence = Format(
          "%.0f of %.0f detections are matched where two other views match "
          "somebody",
          static_cast<double>(segments_.matched[v]), all);
      Add({"never_matched", NameOf(v), 0.9, 0.0, 0.0,
           "--without_cameras=" + NameOf(v) + ", or calibrate it anew",
           evidence});
    }
    if (any) Match();
  }

  void LookAtLens(const FitError& before) {
    CameraRig bare;
    bool any = false;
    for (const Camera& camera : cameras_) {
      CameraParameters parameters = camera.parameters();
      any = any || parameters.lens != nullptr;
      parameters.lens = nullptr;
      bare.emplace_back(parameters);
    }
    if (!any) return;
    const FitGain gain = CompareFits(
        before,
        MeasureFit(bare, segments_, changes_, options_.bundle.segments));
    // Lenses of a few coefficients that hardly bend anything fit either way.
    constexpr double kLeastShare = 0.05;
    if (!gain.certain() ||
        gain.before_px - gain.after_px < kLeastShare * gain.before_px) {
      return;
    }
    Add({"lens", "", 0.9, gain.before_px, gain.after_px,
         "--set=cameras.ignore_distortion=true",
         "the detections fit better without the lens: their images were "
         "undistorted, or the lens is another one's"});
    cameras_ = bare;
  }

  const DoctorInput& input_;
  const DoctorOptions& options_;
  Diagnosis diagnosis_;
  CameraRig cameras_;
  DetectionSequence detections_;
  std::vector<ViewPeople> raw_;
  std::vector<ViewPeople> ideal_;  // of the cameras as they are now
  std::vector<int> frames_;
  std::set<size_t> strangers_;
  SceneSegments segments_;
  std::vector<CameraChange> changes_;
  bool examined_ = true;
  bool clocks_taken_ = false;
};

}  // namespace

Diagnosis Diagnose(const DoctorInput& input, const DoctorOptions& options) {
  return Doctor(input, options).Run();
}

}  // namespace kinegraph
