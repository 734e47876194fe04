#include "solvers/session/recording_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/median.h"
#include "core/base/text.h"
#include "core/base/weighted_quantile.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

// Limits of plausibility, not tuned on any benchmark.
constexpr double kMaxErrorShare = 0.06;     // of a person's size (Shelf: 0.02)
constexpr double kMinMatched = 0.4;         // fraction of detections
constexpr double kNearlyAllMatched = 0.9;   // fraction of detections
constexpr double kMaxSpread = 0.5;          // (p90 - p10) / median of a limb
constexpr double kMaxSideDifference = 0.2;  // relative

class Warnings {
 public:
  Warnings(const RecordingFacts& facts, RecordingReport* report)
      : facts_(facts), report_(report) {}

  void AddAll() {
    const bool scale_is_wrong = AddScale();
    AddSteps();
    if (report_->poses == 0) return AddNoPerson();
    AddErrors();
    if (!scale_is_wrong) {
      AddBones();
      AddSpeed();
    }
    AddIdentities();
    AddUnfollowed();
  }

 private:
  void Add(const std::string& kind, std::string evidence, std::string fix) {
    report_->warnings.push_back(
        {kind, "", 0.0, 0.0, 0.0, std::move(fix), std::move(evidence)});
  }

  // Adds a warning about an implausible result that may have many causes.
  void AddIf(bool holds, const std::string& kind, std::string evidence) {
    if (holds) Add(kind, std::move(evidence), kLookCloser);
  }

  // Checks the unit of the calibration. Returns true if people's heights or,
  // if no height is known, the working distance is implausible. Non-human
  // subjects may have any size; only their distance is limited.
  bool AddScale() {
    if (!report_->is_human) return AddScaleOfOthers();
    // If the world is much too small or too large, no person is tracked, and
    // only the stature from single frames is known.
    const double height_m =
        report_->height_m > 0.0 ? report_->height_m : facts_.stature_m;
    const double distance_m = report_->working_distance_m;
    const bool height_is_wrong = height_m > 0.0 && !IsStature(height_m);
    if (!height_is_wrong && (height_m > 0.0 || IsWorkingDistance(distance_m))) {
      return false;
    }
    const std::string units =
        height_is_wrong ? UnitsThatFit(height_m, kMinHeight, kMaxHeight)
                        : UnitsThatFit(distance_m, kMinDistance, kMaxDistance);
    const std::string found =
        height_is_wrong ? fmt::format("people are {:.3g} m tall", height_m)
                        : fmt::format("the cameras view a volume {:.3g} m away",
                                      distance_m);
    Add("unit",
        found + ", which is implausible" +
            (units.empty() ? "; the scale of the calibration (cameras.unit), "
                             "the skeleton (detections.skeleton) or the "
                             "pairing of views and cameras may be wrong"
                           : "; lengths of the calibration seem to be in "
                             "another unit"),
        units.empty() ? kLookCloser : units);
    return true;
  }

  bool AddScaleOfOthers() {
    const double distance_m = report_->working_distance_m;
    if (distance_m <= kMaxDistance) return false;
    Add("unit",
        fmt::format("the cameras view a volume {:.3g} m away", distance_m) +
            (report_->subject_m > 0.0
                 ? fmt::format(", with a subject of {:.3g} m",
                               report_->subject_m)
                 : "") +
            "; lengths of the calibration seem to be in another unit",
        UnitsThatFit(distance_m, kNearest, kMaxDistance));
    return true;
  }

  void AddNoPerson() {
    // In short recordings few detections are enough.
    const int64_t enough =
        std::clamp<int64_t>(report_->frames / 2, 1, kEnoughDetections);
    size_t views = 0;
    size_t showing = 0;  // views with any detections
    for (const CameraReport& camera : report_->cameras) {
      views += camera.detections >= enough ? 1 : 0;
      showing += camera.detections > 0 ? 1 : 0;
    }
    if (showing >= 2 && report_->frames < facts_.confirm_hits) {
      Add("nobody",
          fmt::format("no person was found: {} {} few, because a person must "
                      "be detected in {} frames to be written",
                      report_->frames,
                      report_->frames == 1 ? "frame is too" : "frames are too",
                      facts_.confirm_hits),
          "--set=input.independent_frames=true if frames are single pictures");
      return;
    }
    if (views < 2) {
      Add("nobody",
          showing < 2
              ? "no person was found: fewer than two views show anybody"
              : fmt::format("no person was found: fewer than two views have "
                            "{} or more",
                            Counted(enough, "detection", "detections")),
          "inspect the detections with `kinegraph report`, or the video");
      return;
    }
    if (AddFewJoints() || AddEmptyFrames()) return;
    Add("nobody",
        fmt::format("no person was found, though {} views show people: views "
                    "may be paired with wrong cameras (cameras.map), their "
                    "frames may not correspond, images may be rotated or "
                    "mirrored, or the calibration may belong to another set-up",
                    views),
        kLookCloser);
  }

  std::string WhatWasFound() const {
    const auto found = static_cast<int>(report_->people.size());
    if (report_->poses == 0) return "no person was found";
    if (found < report_->most_people_in_a_view) {
      return fmt::format("{} of {} people were found", found,
                         report_->most_people_in_a_view);
    }
    return fmt::format("{:.0f} % of the detections belong to a tracked person",
                       100.0 * MatchedShare());
  }

  // Warns if detections have too few joints for a new person.
  bool AddFewJoints() {
    const auto fewer =
        FewerJoints(report_->joints_of_17, facts_.least_joints_of_17);
    if (!fewer.has_value()) return false;
    Add("joints",
        fmt::format("{}, and half of the detections show {:.0f} of 17 joints "
                    "or fewer: a new person requires {:.0f} in two views",
                    WhatWasFound(), report_->joints_of_17,
                    facts_.least_joints_of_17),
        fmt::format("--set=\"initialisation.min_common_joints={0};"
                    "initialisation.min_joints={0}\"",
                    *fewer));
    return true;
  }

  // Warns of many empty frames, as written by a detector that did not run on
  // every frame, because paper mode treats them as misses.
  bool AddEmptyFrames() {
    constexpr double kMany = 0.2;  // of the frames
    const double share =
        static_cast<double>(facts_.empty_frames) /
        static_cast<double>(std::max<int64_t>(1, report_->frames));
    if (share < kMany || facts_.in_seconds) return false;
    Add("nobody",
        fmt::format(
            "no person was found, and in {:.0f} % of the frames no view "
            "shows anybody: a new person must be detected in several "
            "consecutive frames",
            100.0 * share),
        "omit the frames on which the detector did not run from the file, or "
        "track with --mode=graph, which adapts to the detector's frame rate");
    return true;
  }

  void AddErrors() {
    std::vector<double> shares;
    for (const CameraReport& camera : report_->cameras) {
      if (camera.joints > 0) shares.push_back(camera.error_share());
    }
    const double share = Median(shares);
    AddIf(share > kMaxErrorShare, "error",
          fmt::format(
              "the median distance of poses from detections is {:.1f} px, "
              "{:.0f} % of a person's size in the image: calibration, pairing "
              "of views and cameras, or clocks may be wrong",
              report_->median_px, 100.0 * share));
    // A small share of matches is no error if views also show people whom no
    // other view shows, such as patients in the other beds of a ward. So it is
    // only reported if the doctor could not examine the views.
    AddIf(!facts_.views_examined && MatchedShare() < kMinMatched, "matched",
          fmt::format(
              "{:.0f} % of the detections belong to a tracked person: views "
              "may be paired with wrong cameras (cameras.map), their frames "
              "may not correspond, or images may be rotated or mirrored",
              100.0 * MatchedShare()));
  }

  // Fraction of the detections matched with a person; 1 if there are few
  // detections.
  double MatchedShare() const {
    int64_t detections = 0;
    int64_t matched = 0;
    for (const CameraReport& camera : report_->cameras) {
      detections += camera.detections;
      matched += camera.matched;
    }
    if (detections < kEnoughDetections) return 1.0;
    return static_cast<double>(matched) / static_cast<double>(detections);
  }

  void AddBones() {
    double frames = 0.0;
    double spread = 0.0;
    double difference = 0.0;
    for (const PersonReport& person : report_->people) {
      if (person.height_m == 0.0) continue;
      const auto weight = static_cast<double>(person.frames);
      frames += weight;
      spread += weight * person.bone_spread;
      difference += weight * person.side_difference;
    }
    if (frames == 0.0) return;
    spread /= frames;
    difference /= frames;
    AddIf(spread > kMaxSpread, "bones",
          fmt::format("lengths of limbs vary by {:.0f} % during the recording: "
                      "calibration, clocks or skeleton may be wrong",
                      100.0 * spread));
    AddIf(difference > kMaxSideDifference, "bones",
          fmt::format("left and right limbs differ by {:.0f} %: a view may be "
                      "mirrored, or the skeleton's order of joints may be "
                      "wrong (detections.skeleton)",
                      100.0 * difference));
  }

  void AddSpeed() {
    const auto faster = FasterGate(facts_.body_speed_mps, facts_.followed_mps);
    if (faster.has_value()) {
      Add("speed",
          fmt::format(
              "people move at {:.1f} m/s, but gates cover only {:.1f} m/s at "
              "{:.6g} Hz: fast people may get several identities",
              facts_.body_speed_mps, facts_.followed_mps,
              report_->frame_rate_hz),
          fmt::format("--set=gates.speed_mps={:.0f}", *faster));
    }
    if (!report_->is_human || !(facts_.body_speed_mps > kMaxBodySpeed)) return;
    Add("rate",
        fmt::format("people move at {:.1f} m/s if the frame rate is {:.6g} Hz",
                    facts_.body_speed_mps, report_->frame_rate_hz),
        "the frame rate may be wrong (input.frame_rate)");
  }

  // Warns of times that do not ascend, and of gaps between frames over which
  // people cannot be followed.
  void AddSteps() {
    if (facts_.independent_frames) return;
    if (facts_.steps_back > 0) {
      Add("frames",
          fmt::format("the clock stops or steps back {} {}: tracks end there",
                      facts_.steps_back,
                      facts_.steps_back == 1 ? "time" : "times"),
          "check the times in the detections; without \"time\", a frame's time "
          "is its number divided by the frame rate");
    }
    // The doctor reports recordings most of whose frames are far apart.
    if (2 * static_cast<int64_t>(facts_.holes_s.size()) > report_->frames ||
        facts_.holes_s.empty()) {
      return;
    }
    const double longest_s =
        *std::max_element(facts_.holes_s.begin(), facts_.holes_s.end());
    Add("frames",
        fmt::format("{} {} in the recording, up to {:.3g} s without a frame",
                    facts_.holes_s.size(),
                    facts_.holes_s.size() == 1 ? "gap" : "gaps", longest_s),
        facts_.links ? "tracks end at gaps longer than tracking.max_age_s"
                     : "--set=identity.link=true");
  }

  void AddIdentities() {
    const auto identities = static_cast<int>(report_->people.size());
    if (identities < report_->most_people_in_a_view ||
        MatchedShare() < kNearlyAllMatched) {
      AddFewJoints();
    }
    // Unrelated frames are not linked.
    if (facts_.independent_frames) return;
    if (identities <= 2 * report_->most_people_in_a_view + 2) return;
    Add("identities",
        fmt::format(
            "{} identities, though views hardly ever show more than {} at "
            "once: "
            "people may leave and return, or be lost and found again",
            identities,
            Counted(report_->most_people_in_a_view, "person", "people")),
        facts_.links ? kLookCloser : "--set=identity.link=true");
  }

  // Warns of people who are never tracked, by view; averages over all people do
  // not reveal them.
  void AddUnfollowed() {
    constexpr size_t kMost = 8;  // lines
    if (facts_.independent_frames) return;
    const auto& all = facts_.unfollowed;
    for (size_t i = 0; i < std::min(all.size(), kMost); ++i) {
      const UnfollowedPerson& one = all[i];
      Add("unfollowed",
          fmt::format("view {}: a person is detected in {:.0f} % of the frames "
                      "({}..{}) but never tracked; a new person needs enough "
                      "joints in two views (initialisation.min_joints)",
                      report_->cameras[one.view].view, 100.0 * one.share,
                      one.first_frame, one.last_frame),
          kLookCloser);
    }
  }

  const RecordingFacts& facts_;
  RecordingReport* report_;
};

}  // namespace

double TypicalHeight(const std::vector<PersonReport>& people) {
  std::vector<WeightedValue> heights;
  for (const PersonReport& person : people) {
    if (person.height_m == 0.0) continue;
    heights.emplace_back(person.height_m, person.frames);
  }
  return heights.empty() ? 0.0 : WeightedQuantile(std::move(heights), 0.5);
}

int LeastJoints(const Skeleton& skeleton) {
  return std::min(5, skeleton.joint_count());
}

double JointsOf17(const Detection& detection, const Skeleton& skeleton) {
  const std::vector<int>& compared = skeleton.association_joints();
  const auto found = std::count_if(
      compared.begin(), compared.end(),
      [&](int joint_idx) { return detection.joints[joint_idx].found; });
  return 17.0 * static_cast<double>(found) /
         static_cast<double>(compared.size());
}

std::optional<double> FasterGate(double body_speed_mps, double followed_mps) {
  constexpr double kShare = 0.8;  // of the covered speed, which leaves a margin
  constexpr double kLimbs = 1.4;  // speed relative to the body
  if (!(followed_mps > 0.0) || body_speed_mps > kMaxBodySpeed ||
      body_speed_mps <= kShare * followed_mps) {
    return std::nullopt;
  }
  return std::ceil(kLimbs * body_speed_mps);
}

std::optional<int> FewerJoints(double joints_of_17, double least) {
  constexpr double kWellWithin = 1.25;  // times the required joints
  constexpr double kCommon = 0.55;      // fraction of a view's joints
  constexpr double kFewest = 4.0;       // determine position and orientation
  if (!(joints_of_17 > 0.0) || joints_of_17 >= kWellWithin * least) {
    return std::nullopt;
  }
  const double fewer = std::max(kFewest, std::floor(kCommon * joints_of_17));
  if (fewer >= least) return std::nullopt;
  return static_cast<int>(fewer);
}

std::string UnitsThatFit(double length_m, double least_m, double most_m) {
  std::string fixes;
  for (const auto& [unit, metres] :
       {std::pair{"cm", 0.01}, {"mm", 0.001}, {"m", 1000.0}, {"m", 100.0}}) {
    const double length = length_m * metres;
    if (length < least_m || length > most_m) continue;
    fixes +=
        std::string(fixes.empty() ? "" : " or ") + "--set=cameras.unit=" + unit;
    if (metres > 1.0) break;  // the flag is the same for both factors
  }
  return fixes;
}

namespace {

// The doctor's findings for the report, without the unit if the report has its
// own warning about it.
std::vector<Finding> CausesOf(const Diagnosis& diagnosis, bool knows_unit,
                              bool has_clocks) {
  std::vector<Finding> causes;
  for (Finding finding : diagnosis.findings) {
    if (!finding.significant || (finding.kind == "unit" && knows_unit))
      continue;
    // At a resolution of whole frames, misoriented cameras may resemble clock
    // errors; and the report writes no cameras.json.
    if (finding.kind == "clock_offset") {
      if (!has_clocks) {
        finding.evidence += "; if this is a clock error, use " + finding.fix;
      }
      finding.fix = kLookCloser;
    } else if (finding.fix.rfind(kUseCorrected, 0) == 0) {
      finding.fix = kLookCloser;
    }
    causes.push_back(std::move(finding));
  }
  return causes;
}

}  // namespace

void AddWarnings(const RecordingFacts& facts, const Diagnosis& diagnosis,
                 RecordingReport* report) {
  const auto any = [&](const auto& holds) {
    return std::any_of(report->warnings.begin(), report->warnings.end(), holds);
  };
  Warnings(facts, report).AddAll();
  const bool knows_unit =
      any([](const Finding& one) { return one.kind == "unit"; });
  std::vector<Finding> causes =
      CausesOf(diagnosis, knows_unit, facts.has_clocks);
  report->warnings.insert(report->warnings.begin(),
                          std::make_move_iterator(causes.begin()),
                          std::make_move_iterator(causes.end()));
  // Whether the doctor has found an explanation of the other problems and a
  // flag that corrects it. Findings whose fix is another run of the doctor may
  // have another cause: misoriented cameras resemble cropped images or clock
  // errors.
  const bool is_explained = any([](const Finding& one) {
    return one.confidence > 0.5 && one.fix != kLookCloser;
  });
  if (!is_explained) {
    for (const CameraWarning& camera : report->cameras_off) {
      report->warnings.push_back(
          {"camera", "", 0.0, 0.0, 0.0, kLookCloser, camera.text});
    }
    return;
  }
  // Implausible results are omitted if their cause is reported.
  auto& all = report->warnings;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [](const Finding& one) {
                             return one.confidence == 0.0 &&
                                    one.fix == kLookCloser;
                           }),
            all.end());
}

}  // namespace kinegraph
