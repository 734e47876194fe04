#include "core/evaluation/markers/agreement.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/constants.h"
#include "core/base/median.h"
#include "core/evaluation/mpjpe.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNormal95 = 1.959963984540054;

Skeleton SkeletonOf(const Skeleton& from, const JointPairs& joints) {
  std::vector<std::string> names;
  std::vector<int> place(static_cast<size_t>(from.joint_count()), -1);
  for (const JointPair& pair : joints) {
    place[pair.a] = static_cast<int>(names.size());
    names.push_back(from.joints()[pair.a]);
  }
  std::vector<Bone> bones;
  for (const Bone& bone : from.bones()) {
    const int a = place[bone.a];
    const int b = place[bone.b];
    if (a >= 0 && b >= 0) bones.push_back({a, b});
  }
  return {"common", std::move(names), std::move(bones)};
}

// The person's joints in the truth's world.
PersonPose Moved(const PersonPose& person, const JointPairs& joints,
                 const Eigen::Isometry3d& motion) {
  PersonPose moved;
  moved.id = TrackId(0);
  const Matrix3d turn = motion.linear();
  for (const JointPair& pair : joints) {
    Joint3d joint = person.joints[pair.b];
    joint.position_m = motion * joint.position_m;
    moved.joints.push_back(joint);
    if (person.covariances.empty()) continue;
    auto covariance = person.covariances[pair.b];
    if (covariance) covariance = turn * *covariance * turn.transpose();
    moved.covariances.push_back(covariance);
  }
  return moved;
}

// The person to compare with `truth`, in its world; nullopt if there is none.
std::optional<PersonPose> Choose(const TrackFrame& frame, TrackId person,
                                 bool only, const Pose3d& truth,
                                 const JointPairs& joints,
                                 const WorldFit& world) {
  const JointPairs all = SameJoints(joints.size());
  std::optional<PersonPose> nearest;
  double least_m = kPersonGateM;
  for (const PersonPose& pose : frame.people) {
    if (only && pose.id != person) continue;
    PersonPose moved = Moved(pose, joints, world.truth_from_tracks);
    if (pose.id == person) return moved;
    const auto distance_m = MeanDistance(truth, moved.joints, all);
    if (!distance_m || !(*distance_m <= least_m)) continue;
    least_m = *distance_m;
    nearest = std::move(moved);
  }
  return nearest;
}

// Probability that a normal error in three dimensions has a squared Mahalanobis
// distance of at most `squared` >= 0 (chi-square, three degrees of freedom).
double ChiSquareCdf3(double squared) {
  constexpr double kTwoOverPi = 0.6366197723675814;
  return std::erf(std::sqrt(0.5 * squared)) -
         std::sqrt(kTwoOverPi * squared) * std::exp(-0.5 * squared);
}

// ---- Scores -----------------------------------------------------------------

// One joint in one frame.
struct Error {
  size_t frame = 0;
  TimeNs time = 0;
  size_t joint = 0;
  Vector3d world_m;
  std::optional<Vector3d> body_m;  // right, forward, up
  bool observed = false;
  std::optional<Matrix3d> covariance;
  Matrix3d body = Matrix3d::Identity();
};

std::vector<Error> Errors(const PairedMotion& motion, const Vector3d& up) {
  std::vector<Error> errors;
  const Skeleton& skeleton = motion.truth.header.skeleton;
  for (size_t f = 0; f < motion.truth.frames.size(); ++f) {
    const PersonPose& truth = motion.truth.frames[f].people.front();
    const PersonPose& found = motion.tracks.frames[f].people.front();
    const auto body = BodyFrame(truth.joints, skeleton, up);
    for (size_t j = 0; j < truth.joints.size(); ++j) {
      if (!truth.joints[j].present() || !found.joints[j].present()) continue;
      Error error;
      error.frame = f;
      error.time = motion.truth.frames[f].time;
      error.joint = j;
      error.world_m = found.joints[j].position_m - truth.joints[j].position_m;
      if (body) {
        error.body = *body;
        error.body_m = body->transpose() * error.world_m;
      }
      error.observed = found.joints[j].status == JointStatus::kObserved;
      if (!found.covariances.empty()) error.covariance = found.covariances[j];
      errors.push_back(std::move(error));
    }
  }
  return errors;
}

Vector3d MedianOffset(const std::vector<const Error*>& errors, size_t begin,
                      size_t end) {
  Vector3d offset = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (size_t i = begin; i < end; ++i) {
      if (errors[i]->body_m) values.push_back((*errors[i]->body_m)[axis]);
    }
    if (!values.empty()) offset[axis] = Quantile(std::move(values), 0.5);
  }
  return offset;
}

// Errors of one joint, with the offset of each half of the recording subtracted
// from the other half.
std::vector<Vector3d> WithoutOffset(const std::vector<const Error*>& errors) {
  const size_t middle = errors.size() / 2;
  const Vector3d of_first = MedianOffset(errors, 0, middle);
  const Vector3d of_second = MedianOffset(errors, middle, errors.size());
  std::vector<Vector3d> freed;
  for (size_t i = 0; i < errors.size(); ++i) {
    const Vector3d& offset = i < middle ? of_second : of_first;
    freed.push_back(errors[i]->body_m ? Vector3d(errors[i]->world_m -
                                                 errors[i]->body * offset)
                                      : errors[i]->world_m);
  }
  return freed;
}

// Root mean square of the errors' central differences of the given order (1 or
// 2), over each three successive errors of a joint that are at most
// 1.5 `step_s` apart; NaN if there are none.
double DerivativeRms(const std::vector<const Error*>& errors, size_t order,
                     double step_s) {
  double sum = 0.0;
  int64_t count = 0;
  for (size_t i = 2; i < errors.size(); ++i) {
    const double before_s =
        ToSeconds(errors[i - 1]->time - errors[i - 2]->time);
    const double after_s = ToSeconds(errors[i]->time - errors[i - 1]->time);
    if (errors[i]->joint != errors[i - 2]->joint ||
        !(std::min(before_s, after_s) > 0.0) ||
        std::max(before_s, after_s) > 1.5 * step_s) {
      continue;
    }
    const double rate_hz = 2.0 / (before_s + after_s);
    const Vector3d& a = errors[i - 2]->world_m;
    const Vector3d& b = errors[i - 1]->world_m;
    const Vector3d& c = errors[i]->world_m;
    sum += order == 1 ? (0.5 * rate_hz * (c - a)).squaredNorm()
                      : (rate_hz * rate_hz * (c - 2.0 * b + a)).squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : kNan;
}

Interval MedianInterval(const std::vector<const Error*>& errors,
                        size_t frame_count, int64_t block_frames) {
  constexpr int64_t kResamples = 500;
  std::vector<std::pair<double, size_t>> ascending;
  for (const Error* error : errors) {
    ascending.push_back({error->world_m.norm(), error->frame});
  }
  std::sort(ascending.begin(), ascending.end());
  std::vector<double> values;
  for (const auto& one : ascending) values.push_back(one.first);
  BootstrapOptions options;
  options.block_length = block_frames;
  options.resamples = kResamples;
  std::vector<int64_t> upto(values.size());
  return BlockBootstrap(
      {static_cast<int64_t>(frame_count)},
      [&](const DrawCounts& counts) {
        int64_t sum = 0;
        for (size_t i = 0; i < upto.size(); ++i) {
          upto[i] = sum += counts[ascending[i].second];
        }
        return QuantileOfRepeated(values, upto, 0.5);
      },
      options);
}

// The usual time between two frames [s]; 0 for fewer than two.
double UsualStep(const std::vector<TrackFrame>& frames) {
  std::vector<double> steps_s;
  for (size_t f = 1; f < frames.size(); ++f) {
    steps_s.push_back(ToSeconds(frames[f].time - frames[f - 1].time));
  }
  return Median(std::move(steps_s));
}

struct Sampling {
  double step_s = 0.0;  // the usual time between two frames
  size_t frames = 0;
  int64_t block_frames = 1;  // of the bootstrap
};

JointAgreement Summarise(const std::string& joint,
                         const std::vector<const Error*>& errors,
                         const std::vector<Vector3d>& freed,
                         const Sampling& sampling) {
  JointAgreement result;
  result.joint = joint;
  result.count = static_cast<int64_t>(errors.size());
  std::vector<double> sizes_m, freed_m;
  double squared = 0.0;
  std::array<std::vector<double>, 3> axes;
  for (size_t i = 0; i < errors.size(); ++i) {
    const Error& error = *errors[i];
    sizes_m.push_back(error.world_m.norm());
    freed_m.push_back(freed[i].norm());
    squared += error.world_m.squaredNorm();
    for (int axis = 0; axis < 3 && error.body_m; ++axis) {
      axes[axis].push_back((*error.body_m)[axis]);
    }
    if (error.covariance) {
      result.calibration.Add(error.world_m, *error.covariance);
      result.after_offset.Add(freed[i], *error.covariance);
    }
  }
  result.median_m = Quantile(sizes_m, 0.5);
  result.mean_m = Mean(sizes_m);
  result.rms_m = std::sqrt(squared / static_cast<double>(errors.size()));
  result.p95_m = Quantile(sizes_m, 0.95);
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<Eigen::Index>(axis);
    result.bias_m[at] = Mean(axes[axis]);
    result.limits_m[at] = kNormal95 * StandardDeviation(axes[axis]);
  }
  result.after_offset_median_m = Quantile(freed_m, 0.5);
  result.velocity_rms_m_s = DerivativeRms(errors, 1, sampling.step_s);
  result.acceleration_rms_m_s2 = DerivativeRms(errors, 2, sampling.step_s);
  result.median_interval =
      MedianInterval(errors, sampling.frames, sampling.block_frames);
  return result;
}

// ---- Published protocols ----------------------------------------------------

std::optional<Vector3d> MidHip(const PersonPose& person,
                               const Skeleton& skeleton) {
  const int mid = skeleton.IndexOf("mid_hip");
  const int left = skeleton.IndexOf("l_hip"), right = skeleton.IndexOf("r_hip");
  const auto at = [&](int j) { return person.joints[j]; };
  if (left >= 0 && right >= 0 && at(left).present() && at(right).present()) {
    return Vector3d(0.5 * (at(left).position_m + at(right).position_m));
  }
  if (mid >= 0 && at(mid).present()) return at(mid).position_m;
  return std::nullopt;
}

void AddProtocols(const PairedMotion& motion, MotionAgreement* result) {
  constexpr double kPckM = 0.150;
  constexpr int kSteps = 30;
  const Skeleton& skeleton = motion.truth.header.skeleton;
  const JointPairs joints = SameJoints(skeleton.joints().size());
  RatioSeries aligned;
  double auc_sum = 0.0;
  result->root_aligned =
      (skeleton.IndexOf("l_hip") >= 0 && skeleton.IndexOf("r_hip") >= 0) ||
      skeleton.IndexOf("mid_hip") >= 0;
  for (size_t f = 0; f < motion.truth.frames.size(); ++f) {
    const PersonPose& truth = motion.truth.frames[f].people.front();
    const PersonPose& found = motion.tracks.frames[f].people.front();
    aligned.push_back(AlignedError(truth.joints, found.joints, joints));
    Vector3d shift = Vector3d::Zero();
    if (result->root_aligned) {
      const auto true_root = MidHip(truth, skeleton);
      const auto found_root = MidHip(found, skeleton);
      if (!true_root || !found_root) continue;
      shift = *true_root - *found_root;
    }
    for (size_t j = 0; j < joints.size(); ++j) {
      const Joint3d& a = truth.joints[j];
      const Joint3d& b = found.joints[j];
      if (!a.present() || !b.present()) continue;
      const double error_m = (b.position_m + shift - a.position_m).norm();
      result->pck_150.Add(error_m <= kPckM);
      for (int step = 0; step <= kSteps; ++step) {
        auc_sum += error_m <= kPckM * step / kSteps ? 1.0 : 0.0;
      }
    }
  }
  result->pa_mpjpe_m = PooledRatio({aligned});
  result->auc =
      auc_sum / ((kSteps + 1) * static_cast<double>(result->pck_150.total));
}

}  // namespace

bool PairedMotion::IsPooled(size_t joint) const {
  return is_centre[joint] ||
         std::count(is_centre.begin(), is_centre.end(), true) == 0;
}

PairedMotion PairMotion(const TrackSequence& truth, const JointPaths& paths,
                        const TrackSequence& tracks, TrackId person, bool only,
                        const JointPairs& joints, const ClockFit& clock,
                        const WorldFit& world) {
  PairedMotion motion;
  motion.truth.header = truth.header;
  motion.truth.header.skeleton = SkeletonOf(truth.header.skeleton, joints);
  motion.tracks.header = tracks.header;
  motion.tracks.header.skeleton = motion.truth.header.skeleton;
  for (const TrackFrame& frame : tracks.frames) {
    const double at_s = clock.Map(ToSeconds(frame.time));
    PersonPose expected;
    expected.id = TrackId(0);
    for (size_t j = 0; j < joints.size(); ++j) {
      const auto at_m = paths.At(at_s, j);
      expected.joints.push_back(at_m ? Joint3d{*at_m, JointStatus::kObserved}
                                     : Joint3d{});
    }
    if (CountPresent(expected.joints) == 0) continue;
    auto found = Choose(frame, person, only, expected.joints, joints, world);
    if (!found) continue;
    const TimeNs time = FromSeconds(at_s);
    motion.truth.frames.push_back({frame.frame, time, {std::move(expected)}});
    motion.tracks.frames.push_back({frame.frame, time, {std::move(*found)}});
  }
  return motion;
}

void Calibration::Add(const Vector3d& error_m, const Matrix3d& covariance) {
  constexpr double kLogTwoPi = 1.8378770664093453;
  ++count_;
  const Eigen::LLT<Matrix3d> root(covariance);
  // Not positive definite: counts as an ellipsoid that contains no error.
  if (root.info() != Eigen::Success) return;
  const Matrix3d lower = root.matrixL();
  const double squared = root.matrixL().solve(error_m).squaredNorm();
  const double share = ChiSquareCdf3(squared);
  for (int level = 0; level < kLevels; ++level) {
    if (share <= (level + 1) / static_cast<double>(kLevels + 1)) {
      ++within_[level];
    }
  }
  ++definite_;
  trace_m2_ += covariance.trace();
  log_score_ += 0.5 * squared + 1.5 * kLogTwoPi +
                lower.diagonal().array().log().sum() +
                3.0 * std::log(kMillimetresPerMetre);
}

double Calibration::Covered(double level) const {
  if (count_ == 0) return kNan;
  const auto at = static_cast<size_t>(std::lround(level * (kLevels + 1))) - 1;
  return static_cast<double>(within_[at]) / static_cast<double>(count_);
}

double Calibration::ExpectedCalibrationError() const {
  double sum = 0.0;
  for (int level = 1; level <= kLevels; ++level) {
    const double wanted = level / static_cast<double>(kLevels + 1);
    sum += std::abs(Covered(wanted) - wanted);
  }
  return sum / kLevels;
}

double Calibration::StatedRms() const {
  return std::sqrt(trace_m2_ / static_cast<double>(definite_));
}

double Calibration::LogScore() const {
  return log_score_ / static_cast<double>(definite_);
}

MotionAgreement CompareMotion(const PairedMotion& motion, const Vector3d& up,
                              double block_s) {
  const std::vector<Error> errors = Errors(motion, up);
  const std::vector<std::string>& names = motion.truth.header.skeleton.joints();
  Sampling sampling;
  sampling.step_s = UsualStep(motion.tracks.frames);
  sampling.frames = motion.truth.frames.size();
  if (sampling.step_s > 0.0) {
    sampling.block_frames =
        std::max<int64_t>(1, std::llround(block_s / sampling.step_s));
  }
  MotionAgreement result;
  std::vector<const Error*> pooled;
  std::vector<Vector3d> pooled_freed;
  std::vector<double> medians_m;
  for (size_t j = 0; j < names.size(); ++j) {
    std::vector<const Error*> of_joint;
    for (const Error& error : errors) {
      if (error.joint == j) of_joint.push_back(&error);
    }
    if (of_joint.empty()) continue;
    const std::vector<Vector3d> freed = WithoutOffset(of_joint);
    JointAgreement& joint = result.joints.emplace_back(
        Summarise(names[j], of_joint, freed, sampling));
    joint.is_pooled = motion.IsPooled(j);
    if (!joint.is_pooled) continue;
    medians_m.push_back(joint.median_m);
    pooled.insert(pooled.end(), of_joint.begin(), of_joint.end());
    pooled_freed.insert(pooled_freed.end(), freed.begin(), freed.end());
  }
  result.pooled = Summarise("pooled", pooled, pooled_freed, sampling);
  result.mean_of_medians_m = Mean(medians_m);
  for (const Error* error : pooled) {
    if (!error->covariance) continue;
    (error->observed ? result.observed : result.inferred)
        .Add(error->world_m, *error->covariance);
  }
  AddProtocols(motion, &result);
  return result;
}

ValueAgreement CompareValues(const std::vector<PairedValue>& values,
                             double period) {
  std::vector<PairedValue> there;
  std::vector<double> differences;
  for (const PairedValue& value : values) {
    const double difference = value.found - value.truth;
    if (!std::isfinite(difference)) continue;
    there.push_back(value);
    differences.push_back(period > 0.0 ? std::remainder(difference, period)
                                       : difference);
  }
  const auto median = [&](size_t begin, size_t end) {
    return Quantile({differences.begin() + static_cast<std::ptrdiff_t>(begin),
                     differences.begin() + static_cast<std::ptrdiff_t>(end)},
                    0.5);
  };
  ValueAgreement result;
  result.count = static_cast<int64_t>(there.size());
  result.bias = Mean(differences);
  result.limits = kNormal95 * StandardDeviation(differences);
  const size_t middle = there.size() / 2;
  const double of_first = median(0, middle);
  const double of_second = median(middle, there.size());
  double squared = 0.0, freed_squared = 0.0;
  for (size_t i = 0; i < there.size(); ++i) {
    const double offset = i < middle ? of_second : of_first;
    const double freed = differences[i] - offset;
    squared += differences[i] * differences[i];
    freed_squared += freed * freed;
    // The interval relative to the found value: it applies to truth - found.
    const double below = there[i].low - there[i].found;
    const double above = there[i].high - there[i].found;
    if (!std::isfinite(below) || !std::isfinite(above)) continue;
    const auto holds = [&](double difference) {
      return -difference >= below && -difference <= above;
    };
    result.covered.Add(holds(differences[i]));
    result.covered_after_offset.Add(holds(freed));
  }
  const auto count = static_cast<double>(there.size());
  result.rms = std::sqrt(squared / count);
  result.after_offset_rms = std::sqrt(freed_squared / count);
  return result;
}

}  // namespace kinegraph
