#include "core/evaluation/world_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/base/median.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;

// The people of both recordings in one frame, reduced to the common joints.
struct Sample {
  std::vector<Pose3d> truth;
  std::vector<Pose3d> tracks;
};

Pose3d CommonOf(const Pose3d& pose, const JointPairs& joints,
                int JointPair::*side) {
  Pose3d common;
  for (const JointPair& joint : joints) common.push_back(pose[joint.*side]);
  return common;
}

std::vector<Sample> Samples(const FramePairing& frames,
                            const JointPairs& joints) {
  constexpr size_t kMostFrames = 200;
  std::vector<const FramePair*> both;
  for (const FramePair& pair : frames.pairs) {
    if (PeopleOf(pair.truth).empty() || PeopleOf(pair.tracks).empty()) continue;
    both.push_back(&pair);
  }
  const size_t stride = (both.size() + kMostFrames - 1) / kMostFrames;
  std::vector<Sample> samples;
  for (size_t i = 0; i < both.size(); i += stride) {
    Sample& sample = samples.emplace_back();
    for (const PersonPose& person : both[i]->truth->people) {
      sample.truth.push_back(CommonOf(person.joints, joints, &JointPair::a));
    }
    for (const PersonPose& person : both[i]->tracks->people) {
      sample.tracks.push_back(CommonOf(person.joints, joints, &JointPair::b));
    }
  }
  return samples;
}

double ExtentOf(const std::vector<Sample>& samples) {
  std::vector<double> extents_m;
  for (const Sample& sample : samples) {
    for (const Pose3d& pose : sample.truth) {
      if (CountPresent(pose) < 2) continue;
      Eigen::AlignedBox3d box;
      for (const Joint3d& joint : pose) {
        if (joint.present()) box.extend(joint.position_m);
      }
      extents_m.push_back(box.diagonal().norm());
    }
  }
  return Median(std::move(extents_m));
}

struct Fit {
  Share found;
  double distance_m = 0.0;  // sum over the people found

  bool IsBetterThan(const Fit& other) const {
    if (found.count != other.found.count) {
      return found.count > other.found.count;
    }
    return distance_m < other.distance_m;
  }
};

Fit FitOf(const std::vector<Sample>& samples, const JointPairs& joints,
          const Matrix3d& axes, double scale) {
  const Matrix3d tracks_from_truth = scale * axes;
  Fit fit;
  for (const Sample& sample : samples) {
    for (Pose3d pose : sample.truth) {
      for (Joint3d& joint : pose) {
        joint.position_m = tracks_from_truth * joint.position_m;
      }
      double nearest_m = kNoGate;
      for (const Pose3d& one : sample.tracks) {
        nearest_m = std::min(nearest_m,
                             MeanDistance(pose, one, joints).value_or(kNoGate));
      }
      const bool is_found = nearest_m <= kPersonGateM;
      fit.found.Add(is_found);
      if (is_found) fit.distance_m += nearest_m;
    }
  }
  return fit;
}

// All 48 signed permutations of the axes; rotations before reflections.
std::vector<Matrix3d> SignedPermutations() {
  std::vector<Matrix3d> turns, mirrors;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d axes = Matrix3d::Zero();
      for (int i = 0; i < 3; ++i) {
        axes(i, order[i]) = (signs >> i & 1) != 0 ? -1.0 : 1.0;
      }
      (axes.determinant() > 0.0 ? turns : mirrors).push_back(axes);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  turns.insert(turns.end(), mirrors.begin(), mirrors.end());
  return turns;
}

}  // namespace

bool OtherWorld::is_mirrored() const { return axes.determinant() < 0.0; }

std::string OtherWorld::AxesText() const {
  std::string text;
  for (int of_truth = 0; of_truth < 3; ++of_truth) {
    Eigen::Index of_tracks = 0;
    axes.col(of_truth).cwiseAbs().maxCoeff(&of_tracks);
    text += of_truth == 0 ? "" : ",";
    text += axes(of_tracks, of_truth) < 0.0 ? "-" : "";
    text += static_cast<char>('x' + of_tracks);
  }
  return text;
}

std::string WorldCheck::Text() const {
  if (other) {
    const bool turned = other->axes != Matrix3d::Identity();
    return fmt::format(
        "{} of {} true people are near a track; {} would be{}{}", found.count,
        found.total, other->found.count,
        turned ? " with X, Y, Z as " + other->AxesText() + " of the tracks"
               : "",
        other->scale == 1.0
            ? ""
            : fmt::format("{} lengths times {:g}", turned ? " and" : " with",
                          other->scale));
  }
  if (found.total == 0) {
    return "no compared frame has people in both: the frames or the clocks "
           "differ, or no person was tracked";
  }
  if (found.count == 0) {
    return fmt::format(
        "no track is within {} m of a true person; where clocks or worlds "
        "differ, `evaluate --protocol=markers` aligns them",
        kPersonGateM);
  }
  return "";
}

std::string WorldCheck::GateText() const {
  constexpr double kMostGates = 10.0;  // people extend over three or four
  const bool is_small = extent_m < kPersonGateM;
  if (extent_m == 0.0 || (!is_small && extent_m <= kMostGates * kPersonGateM)) {
    return "";
  }
  return fmt::format(
      "the true subjects extend over {:.2g} m, and a track within {} m counts "
      "as theirs{}",
      extent_m, kPersonGateM,
      is_small ? ", even a track beside them"
               : "; a track whose errors are small for their size may not "
                 "be counted");
}

WorldCheck CheckWorld(const FramePairing& frames, const JointPairs& joints) {
  const std::vector<Sample> samples = Samples(frames, joints);
  const JointPairs same = SameJoints(joints.size());
  const Fit as_it_stands = FitOf(samples, same, Matrix3d::Identity(), 1.0);
  WorldCheck check;
  check.found = as_it_stands.found;
  check.extent_m = ExtentOf(samples);
  if (2 * check.found.count > check.found.total) return check;
  Fit best = as_it_stands;
  OtherWorld other;
  const std::vector<Matrix3d> permutations = SignedPermutations();
  // Confusions of metres, centimetres and millimetres.
  for (const double scale : {1.0, 0.001, 1000.0, 0.01, 100.0, 0.1, 10.0}) {
    for (const Matrix3d& axes : permutations) {
      const Fit fit = FitOf(samples, same, axes, scale);
      if (!fit.IsBetterThan(best)) continue;
      best = fit;
      other = {axes, scale, fit.found};
    }
  }
  // In a wrongly rotated world some people coincide with tracks by chance. If
  // the files as they are find at least a quarter of the best number, they are
  // assumed to be correct.
  if (2 * best.found.count > best.found.total &&
      4 * check.found.count < best.found.count) {
    check.other = other;
  }
  return check;
}

}  // namespace kinegraph
