#include "core/evaluation/held_out.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

using Figures = std::vector<double>;

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

// Which person of the run stands for each person of the reference, per frame.
class PeopleOfRun {
 public:
  PeopleOfRun(const TrackSequence& reference, const TrackSequence& run,
              double gate_m, HeldOutRules::Pairing pairing)
      : reference_(reference),
        pairing_(pairing),
        run_(run),
        joints_(
            CommonBodyJoints(reference.header.skeleton, run.header.skeleton)),
        gate_m_(gate_m) {}

  // nullptr when the run has nobody for this person.
  const PersonPose* Find(const HeldOutDetection& item) {
    if (!at_ || *at_ != item.frame) Pair(item);
    const auto found = run_of_reference_.find(item.person);
    if (found == run_of_reference_.end()) {
      throw InputError(
          "held-out set: " + Describe(item) + ": person " +
          std::to_string(item.person.value()) +
          " is not in this frame of the reference tracks, expected "
          "the tracks that the set was made from");
    }
    return found->second;
  }

 private:
  void Pair(const HeldOutDetection& item) {
    at_ = item.frame;
    run_of_reference_.clear();
    const TrackFrame* expected = FindFrame(reference_, item.frame);
    if (expected == nullptr) return;
    for (const PersonPose& person : expected->people) {
      run_of_reference_[person.id] = nullptr;
    }
    const TrackFrame* found = FindFrame(run_, item.frame);
    if (found == nullptr) return;
    if (pairing_ == HeldOutRules::Pairing::kById) {
      for (const PersonPose& person : found->people) {
        const auto at = run_of_reference_.find(person.id);
        if (at != run_of_reference_.end()) at->second = &person;
      }
      return;
    }
    for (const CostPair& pair : MatchOneToOne(
             PersonDistances(expected->people, found->people, joints_),
             gate_m_)) {
      run_of_reference_[expected->people[pair.row].id] =
          &found->people[pair.column];
    }
  }

  const TrackSequence& reference_;
  HeldOutRules::Pairing pairing_;
  const TrackSequence& run_;
  JointPairs joints_;
  double gate_m_;
  std::optional<int64_t> at_;
  std::map<TrackId, const PersonPose*> run_of_reference_;
};

// Projection of a joint of `person`; nullopt without a person, a joint or a
// pixel.
std::optional<Eigen::Vector2d> Predict(const PersonPose* person, int joint,
                                       const Camera& camera) {
  if (person == nullptr || joint < 0) return std::nullopt;
  if (!person->joints[joint].present()) return std::nullopt;
  return camera.Project(person->joints[joint].position_m);
}

// See HeldOutJoint; nullopt without a covariance.
std::optional<double> NormalisedSquared(const PersonPose& person, int joint,
                                        const Keypoint& seen,
                                        JointClass joint_class,
                                        const Camera& camera,
                                        const DetectorSigma& sigma_px) {
  if (!sigma_px || person.covariances.empty()) return std::nullopt;
  const std::optional<Eigen::Matrix3d>& covariance = person.covariances[joint];
  if (!covariance.has_value()) return std::nullopt;
  const Eigen::Vector3d& point_m = person.joints[joint].position_m;
  Matrix23d jacobian;
  const auto pixel = camera.Project(point_m, &jacobian);
  if (!pixel.has_value()) return std::nullopt;
  const double sigma = sigma_px(joint_class, seen.confidence,
                                camera.Depth(point_m), camera.focal_px());
  const Eigen::Matrix2d predicted =
      jacobian * *covariance * jacobian.transpose() +
      sigma * sigma * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d residual = seen.px - *pixel;
  return residual.dot(predicted.inverse() * residual);
}

// Joints of `detections` that `reference` names too.
std::vector<int> ScoredJoints(const Skeleton& detections,
                              const Skeleton& reference) {
  std::vector<int> joints;
  for (const JointPair& pair : CommonJoints(detections, reference)) {
    joints.push_back(pair.a);
  }
  return joints;
}

// The selected joints by ascending error, and how many of each error a set of
// drawn frames has.
class SortedErrors {
 public:
  SortedErrors(const HeldOutScores& scores, const HeldOutFilter& filter,
               const std::vector<int64_t>& frames) {
    std::vector<std::pair<double, size_t>> sorted;  // error, unit
    for (const HeldOutJoint& joint : scores.joints) {
      const HeldOutPerson& person = scores.people[joint.person_idx];
      if (!filter(person, joint)) continue;
      const auto at =
          std::lower_bound(frames.begin(), frames.end(), person.frame);
      sorted.emplace_back(joint.error_px, at - frames.begin());
    }
    std::sort(sorted.begin(), sorted.end());
    for (const auto& [error, unit] : sorted) {
      errors_px_.push_back(error);
      units_.push_back(unit);
    }
  }

  Figures Compute(const DrawCounts& counts) const {
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
    const double mean = total == 0 ? std::numeric_limits<double>::quiet_NaN()
                                   : sum / static_cast<double>(total);
    return {QuantileOfRepeated(errors_px_, upto, 0.5),
            QuantileOfRepeated(errors_px_, upto, 0.9),
            QuantileOfRepeated(errors_px_, upto, 0.97), mean};
  }

 private:
  std::vector<double> errors_px_;
  std::vector<size_t> units_;
};

bool SameJoints(const HeldOutScores& a, const HeldOutScores& b) {
  return std::equal(
      a.joints.begin(), a.joints.end(), b.joints.begin(), b.joints.end(),
      [&](const HeldOutJoint& one, const HeldOutJoint& other) {
        const HeldOutPerson& of_one = a.people[one.person_idx];
        const HeldOutPerson& of_other = b.people[other.person_idx];
        return of_one.frame == of_other.frame &&
               of_one.view_idx == of_other.view_idx &&
               one.joint_class == other.joint_class;
      });
}

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
  const std::vector<int> scored =
      ScoredJoints(detected, reference.header.skeleton);
  const std::vector<int> run_joint = MapByName(run.header.skeleton, detected);
  PeopleOfRun people(reference, run, set.pairing_gate_m, rules.pairing);
  for (const HeldOutDetection& item : set.detections) {
    if (item.view_name != view_name) continue;
    const Detection& detection = FindDetection(detections, view_idx, item);
    const PersonPose* person = people.Find(item);
    scores->people.push_back({item.frame, view_idx, person != nullptr});
    for (const int joint : scored) {
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
  const Figures figures = errors.Compute(DrawCounts(frames.size(), 1));
  const std::vector<Interval> intervals = BlockBootstrapAll(
      {static_cast<int64_t>(frames.size())}, kHeldOutFigureCount,
      [&errors](const DrawCounts& counts) { return errors.Compute(counts); },
      options);
  for (int i = 0; i < kHeldOutFigureCount; ++i) {
    summary.figures_px[i] = figures[i];
    summary.intervals_px[i] = intervals[i];
  }
  return summary;
}

Interval HeldOutRatioInterval(const HeldOutScores& a, const HeldOutScores& b,
                              HeldOutFigure figure,
                              const BootstrapOptions& options) {
  if (!SameJoints(a, b)) {
    throw OptionError("paired difference",
                      "the two runs were not scored on the same joints");
  }
  const std::vector<int64_t> frames = FramesOf(a);
  const SortedErrors errors_a(a, AllJoints(), frames);
  const SortedErrors errors_b(b, AllJoints(), frames);
  const auto index = static_cast<size_t>(figure);
  return BlockBootstrap(
      {static_cast<int64_t>(frames.size())},
      [&](const DrawCounts& counts) {
        return errors_a.Compute(counts)[index] /
               errors_b.Compute(counts)[index];
      },
      options);
}

// The units of the bootstrap.
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
    const auto at =
        std::lower_bound(frames.begin(), frames.end(), person.frame);
    RatioUnit& unit = units[static_cast<size_t>(at - frames.begin())];
    unit.sum += std::min(joint.error_px, kHeldOutTruncationPx);
    unit.weight += 1.0;
  }
  return units;
}

}  // namespace kinegraph
