#include "core/evaluation/held_out.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <utility>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::string Describe(const HeldOutDetection& item) {
  return "view '" + Printable(item.view_name) + "', frame " +
         std::to_string(item.frame) + ", detection " +
         std::to_string(item.detection_idx);
}

const Detection& FindDetection(const DetectionSequence& detections,
                               int view_idx, const HeldOutDetection& item) {
  if (const DetectionFrame* frame =
          FindDetectionFrame(detections, item.frame)) {
    for (const Detection& detection : frame->views[view_idx].detections) {
      if (detection.index_in_file == item.detection_idx) return detection;
    }
  }
  throw InputError("held-out set: " + Describe(item) +
                   ": no such detection in the detections given");
}

// The person of the run (nullptr: none) matched with each person of the
// reference in a frame.
using PeopleOfRun = std::map<TrackId, const PersonPose*>;

// `frame` is one of PairRuns: its `truth` is the run, its `tracks` the
// reference.
PeopleOfRun PairPeopleOf(const FramePair& frame, const JointPairs& joints,
                         double gate_m, HeldOutRules::Pairing pairing) {
  PeopleOfRun pairs;
  const std::vector<PersonPose>& expected = PeopleOf(frame.tracks);
  const std::vector<PersonPose>& found = PeopleOf(frame.truth);
  for (const PersonPose& person : expected) pairs[person.id] = nullptr;
  if (pairing == HeldOutRules::Pairing::kById) {
    for (const PersonPose& person : found) {
      const auto at = pairs.find(person.id);
      if (at != pairs.end()) at->second = &person;
    }
    return pairs;
  }
  for (const CostPair& pair :
       MatchOneToOne(PersonDistances(expected, found, joints), gate_m)) {
    pairs[expected[pair.row].id] = &found[pair.column];
  }
  return pairs;
}

// Each frame of the reference (`tracks` of a pair) and its frame of the run.
std::map<int64_t, FramePair> PairRuns(const TrackSequence& reference,
                                      const TrackSequence& run) {
  const FramePairing pairing =
      PairFrames(run, reference, {}, {"the run", "the reference"});
  std::map<int64_t, FramePair> frames;
  for (const FramePair& pair : pairing.pairs) {
    if (pair.tracks != nullptr) frames[pair.frame] = pair;
  }
  // At different rates PairFrames leaves out frames of the reference that lie
  // between those of the run, but every detection of the set must be scored.
  if (frames.size() < reference.frames.size()) {
    throw InputError(fmt::format(
        "the run has {:.5g} Hz, the reference {:.5g} Hz: expected equal "
        "rates, because a held-out camera is scored in all its frames",
        pairing.truth_rate_hz, pairing.tracks_rate_hz));
  }
  return frames;
}

// Projection of a joint of `person`; nullopt without a person or a joint, or if
// the joint cannot be projected.
std::optional<Vector2d> Predict(const PersonPose* person, int joint,
                                const Camera& camera) {
  if (person == nullptr || joint < 0) return std::nullopt;
  if (!person->joints[joint].present()) return std::nullopt;
  return camera.Project(person->joints[joint].position_m);
}

// HeldOutJoint::normalised_squared; nullopt without `sigma_px` or a covariance,
// or if the joint cannot be projected.
std::optional<double> NormalisedSquared(const PersonPose& person, int joint,
                                        const Keypoint& seen,
                                        JointClass joint_class,
                                        const Camera& camera,
                                        const DetectorSigma& sigma_px) {
  if (!sigma_px || person.covariances.empty()) return std::nullopt;
  const std::optional<Matrix3d>& covariance = person.covariances[joint];
  if (!covariance.has_value()) return std::nullopt;
  const Vector3d& point_m = person.joints[joint].position_m;
  Matrix23d jacobian;
  const auto pixel = camera.Project(point_m, &jacobian);
  if (!pixel.has_value()) return std::nullopt;
  const double sigma = sigma_px(joint_class, seen.confidence,
                                camera.Depth(point_m), camera.focal_px());
  const Matrix2d predicted = jacobian * *covariance * jacobian.transpose() +
                             sigma * sigma * Matrix2d::Identity();
  const Vector2d residual = seen.px - *pixel;
  return residual.dot(predicted.inverse() * residual);
}

size_t UnitOf(const std::vector<int64_t>& frames, int64_t frame) {
  return static_cast<size_t>(
      std::lower_bound(frames.begin(), frames.end(), frame) - frames.begin());
}

// The selected joints by ascending error, and how often each occurs in a set of
// drawn frames.
class SortedErrors {
 public:
  SortedErrors(const HeldOutScores& scores, const HeldOutFilter& filter,
               const std::vector<int64_t>& frames) {
    std::vector<std::pair<double, size_t>> sorted;  // error, unit
    for (const HeldOutJoint& joint : scores.joints) {
      const HeldOutPerson& person = scores.people[joint.person_idx];
      if (!filter(person, joint)) continue;
      sorted.emplace_back(joint.error_px, UnitOf(frames, person.frame));
    }
    std::sort(sorted.begin(), sorted.end());
    for (const auto& [error, unit] : sorted) {
      errors_px_.push_back(error);
      units_.push_back(unit);
    }
  }

  std::vector<double> Figures(const DrawCounts& counts) const {
    std::vector<int64_t> upto(errors_px_.size());
    int64_t total = 0;
    double sum = 0.0;
    for (size_t i = 0; i < errors_px_.size(); ++i) {
      const int64_t times = counts[units_[i]];
      total += times;
      upto[i] = total;
      sum += static_cast<double>(times) *
             std::min(errors_px_[i], kHeldOutTruncationPx);
    }
    return {QuantileOfRepeated(errors_px_, upto, 0.5),
            QuantileOfRepeated(errors_px_, upto, 0.9),
            QuantileOfRepeated(errors_px_, upto, 0.97),
            total == 0 ? kNan : sum / static_cast<double>(total)};
  }

 private:
  std::vector<double> errors_px_;
  std::vector<size_t> units_;
};

}  // namespace

HeldOutSet MakeHeldOutSet(const TrackSequence& reference, double cap_px) {
  HeldOutSet set;
  set.cap_px = cap_px;
  for (const TrackFrame& frame : reference.frames) {
    for (const PersonPose& person : frame.people) {
      for (const ViewMatch& match : person.matches) {
        set.detections.push_back({frame.frame,
                                  reference.header.view_names[match.view_idx],
                                  match.detection_idx, person.id});
      }
    }
  }
  return set;
}

void ScoreHeldOutCamera(const HeldOutSet& set,
                        const DetectionSequence& detections, int view_idx,
                        const Camera& camera, const TrackSequence& reference,
                        const TrackSequence& run, HeldOutScores* scores,
                        const HeldOutRules& rules) {
  const Skeleton& detected = detections.header.skeleton;
  const std::string& view_name = detections.header.view_names[view_idx];
  const JointPairs scored = CommonJoints(detected, reference.header.skeleton);
  const std::vector<int> run_joint = MapByName(run.header.skeleton, detected);
  const JointPairs compared =
      CommonBodyJoints(reference.header.skeleton, run.header.skeleton);
  const std::map<int64_t, FramePair> frames = PairRuns(reference, run);
  std::map<int64_t, PeopleOfRun> people;  // by frame
  for (const HeldOutDetection& item : set.detections) {
    if (item.view_name != view_name) continue;
    const Detection& detection = FindDetection(detections, view_idx, item);
    const auto [in_frame, is_new] = people.try_emplace(item.frame);
    if (is_new) {
      const auto both = frames.find(item.frame);
      if (both != frames.end()) {
        in_frame->second = PairPeopleOf(both->second, compared,
                                        set.pairing_gate_m, rules.pairing);
      }
    }
    const auto found = in_frame->second.find(item.person);
    if (found == in_frame->second.end()) {
      throw InputError(
          "held-out set: " + Describe(item) + ": person " +
          std::to_string(item.person.value()) +
          " is not in this frame of the reference tracks, expected "
          "the tracks that the set was made from");
    }
    const PersonPose* person = found->second;
    scores->people.push_back({item.frame, view_idx, person != nullptr});
    for (const auto& [joint, of_reference] : scored) {
      const Keypoint& keypoint = detection.joints[joint];
      if (!keypoint.found || keypoint.confidence < set.min_confidence) continue;
      HeldOutJoint score;
      score.person_idx = scores->people.size() - 1;
      score.joint_class = detected.joint_class(joint);
      score.error_px = set.cap_px;
      if (auto pixel = Predict(person, run_joint[joint], camera)) {
        if (rules.bias_px) {
          *pixel += rules.bias_px(*person, run_joint[joint], camera);
        }
        const double error_px = (*pixel - keypoint.px).norm();
        score.predicted = error_px < set.cap_px;
        score.error_px = std::min(set.cap_px, error_px);
        score.normalised_squared =
            NormalisedSquared(*person, run_joint[joint], keypoint,
                              score.joint_class, camera, rules.sigma_px);
      }
      scores->joints.push_back(score);
    }
  }
}

HeldOutFilter AllJoints() {
  return [](const HeldOutPerson&, const HeldOutJoint&) { return true; };
}

HeldOutFilter JointsOfClass(JointClass joint_class) {
  return [joint_class](const HeldOutPerson&, const HeldOutJoint& joint) {
    return joint.joint_class == joint_class;
  };
}

HeldOutFilter JointsOfView(int view_idx) {
  return [view_idx](const HeldOutPerson& person, const HeldOutJoint&) {
    return person.view_idx == view_idx;
  };
}

HeldOutFilter JointsWithoutFace() {
  return [](const HeldOutPerson&, const HeldOutJoint& joint) {
    return joint.joint_class != JointClass::kHead;
  };
}

HeldOutSummary SummariseHeldOut(const HeldOutScores& scores,
                                const HeldOutFilter& filter,
                                const BootstrapOptions& options) {
  HeldOutSummary summary;
  std::vector<bool> selected(scores.people.size(), false);
  for (const HeldOutJoint& joint : scores.joints) {
    if (!filter(scores.people[joint.person_idx], joint)) continue;
    summary.predicted.Add(joint.predicted);
    selected[joint.person_idx] = true;
  }
  for (size_t i = 0; i < selected.size(); ++i) {
    if (selected[i]) summary.paired.Add(scores.people[i].paired);
  }
  const std::vector<int64_t> frames = FramesOf(scores);
  const SortedErrors errors(scores, filter, frames);
  const std::vector<double> figures =
      errors.Figures(DrawCounts(frames.size(), 1));
  const std::vector<Interval> intervals = BlockBootstrapAll(
      {static_cast<int64_t>(frames.size())}, kHeldOutFigureCount,
      [&errors](const DrawCounts& counts) { return errors.Figures(counts); },
      options);
  for (int i = 0; i < kHeldOutFigureCount; ++i) {
    summary.figures_px[i] = figures[i];
    summary.intervals_px[i] = intervals[i];
  }
  return summary;
}

// These frames are the units of the bootstrap.
std::vector<int64_t> FramesOf(const HeldOutScores& scores) {
  std::vector<int64_t> frames;
  for (const HeldOutPerson& person : scores.people) {
    frames.push_back(person.frame);
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

RatioSeries TruncatedErrors(const HeldOutScores& scores,
                            const HeldOutFilter& filter) {
  const std::vector<int64_t> frames = FramesOf(scores);
  RatioSeries units(frames.size());
  for (const HeldOutJoint& joint : scores.joints) {
    const HeldOutPerson& person = scores.people[joint.person_idx];
    if (!filter(person, joint)) continue;
    units[UnitOf(frames, person.frame)].Add(
        std::min(joint.error_px, kHeldOutTruncationPx));
  }
  return units;
}

Consistency HeldOutConsistency(const HeldOutScores& scores) {
  // Contains 95 % of normal residuals: the quantile of chi-square with two
  // degrees of freedom.
  constexpr double kChiSquare95Of2 = 5.991464547107979;
  Consistency consistency;
  std::vector<double> squared;
  for (const HeldOutJoint& joint : scores.joints) {
    if (!joint.normalised_squared.has_value()) continue;
    squared.push_back(*joint.normalised_squared);
    consistency.covered.Add(squared.back() <= kChiSquare95Of2);
  }
  consistency.nees_per_dof = Mean(squared) / 2.0;
  return consistency;
}

}  // namespace kinegraph
