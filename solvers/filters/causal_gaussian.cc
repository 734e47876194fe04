#include "solvers/filters/causal_gaussian.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

namespace kinegraph {
namespace {

// The entry at `index` of a list of `length` entries that half-sample symmetric
// reflection continues in both directions.
int Reflect(int index, int length) {
  const int period = 2 * length;
  int wrapped = index % period;
  if (wrapped < 0) wrapped += period;
  return wrapped < length ? wrapped : period - 1 - wrapped;
}

class CausalGaussian final : public Estimator {
 public:
  CausalGaussian(const SceneModel& scene, const CausalGaussianOptions& options)
      : options_(options),
        clock_(scene.frame_rate_hz),
        kept_matches_(scene.kept_matches),
        joint_count_(scene.skeleton.joint_count()),
        is_wrist_(joint_count_),
        velocity_(joint_count_, Eigen::Vector3d::Zero()),
        last_triangulated_(joint_count_, 0) {
    for (int j = 0; j < joint_count_; ++j) {
      is_wrist_[j] = scene.skeleton.joint_class(j) == JointClass::kWrist;
    }
  }

  void Add(const EstimatorFrame& frame) override {
    CHECK(frame.has_initial || !stored_.empty());
    FinalPose& final_pose = finals_.emplace_back();
    final_pose.frame = frame.frame;
    final_pose.time = frame.time;
    if (!frame.has_initial) return;
    Store(frame);
    UpdateVelocity();
    final_pose.person.joints = stored_.back().pose;
    DescribeViews(frame, kept_matches_, &final_pose.person);
  }

  const Pose3d& Last() const override {
    static const Pose3d kNone;
    return stored_.empty() ? kNone : stored_.back().pose;
  }

  TimeNs LastTime() const override {
    return stored_.empty() ? 0 : stored_.back().time;
  }

  void Predict(TimeNs time, Pose3d* pose) const override {
    const Pose3d& last = Last();
    const TimeNs elapsed = time - LastTime();
    const double dt = VelocityUnits(elapsed);
    pose->resize(last.size());
    for (size_t j = 0; j < last.size(); ++j) {
      Joint3d& joint = (*pose)[j];
      joint = last[j];
      if (!joint.present()) continue;
      joint.status = JointStatus::kInferred;
      const bool held_too_long = options_.hold_frames > 0.0 &&
                                 !clock_.Less(time - last_triangulated_[j],
                                              options_.hold_frames + 1.0);
      joint.position_m += dt * (held_too_long ? body_velocity_ : velocity_[j]);
    }
  }

  void ExtractFinals(std::vector<FinalPose>* finals) override {
    MoveFinals(&finals_, finals);
  }

  void Finish() override {}

 private:
  struct StoredPose {
    TimeNs time = 0;
    Pose3d pose;
  };

  // `duration` in the time unit of velocity_: seconds for kOverTime; otherwise
  // frames, because velocity_ is then per stored pose and a stored pose counts
  // as one frame.
  double VelocityUnits(TimeNs duration) const {
    return options_.velocity == VelocityRule::kOverTime
               ? ToSeconds(duration)
               : clock_.Frames(duration);
  }

  void Store(const EstimatorFrame& frame) {
    const bool birth = stored_.empty();
    // At most one old pose is dropped at a time, as in the authors' code.
    StoredPose entry;
    if (!birth && clock_.Frames(frame.time - stored_.front().time) >
                      options_.history_frames + 0.5) {
      entry = std::move(stored_.front());  // reuses its memory
      stored_.pop_front();
    }
    entry.time = frame.time;
    entry.pose = frame.initial;
    stored_.push_back(std::move(entry));
    for (int j = 0; j < joint_count_; ++j) {
      if (frame.triangulated[j]) last_triangulated_[j] = frame.time;
    }
    if (!birth && options_.smooth) Smooth();
  }

  // Replaces the newest pose by the weighted mean of the stored poses.
  void Smooth() {
    const int length = static_cast<int>(stored_.size());
    const std::vector<double>& body =
        Weights(&body_weights_, options_.sigma_frames, length);
    const std::vector<double>& wrist =
        Weights(&wrist_weights_, options_.wrist_sigma_frames, length);
    for (int j = 0; j < joint_count_; ++j) {
      const std::vector<double>& weights = is_wrist_[j] ? wrist : body;
      Joint3d& newest = stored_.back().pose[j];
      if (!newest.present()) continue;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double total = 0.0;
      for (size_t k = 0; k < weights.size(); ++k) {
        const Joint3d& joint = stored_[length - 1 - k].pose[j];
        if (!joint.present()) continue;
        sum += weights[k] * joint.position_m;
        total += weights[k];
      }
      newest.position_m = sum / total;
    }
  }

  // Weights for a list of this length, computed once per length.
  static const std::vector<double>& Weights(
      std::vector<std::vector<double>>* cache, double sigma, int length) {
    while (static_cast<int>(cache->size()) <= length) {
      cache->push_back(CausalGaussianWeights(
          sigma, std::max<int>(1, static_cast<int>(cache->size()))));
    }
    return (*cache)[length];
  }

  // Mean of the last differences of stored poses, the new one included.
  void UpdateVelocity() {
    const int length = static_cast<int>(stored_.size());
    const int differences = std::min<int>(
        static_cast<int>(options_.velocity_differences), length - 1);
    if (differences < 1) return;
    const StoredPose& newest = stored_.back();
    Eigen::Vector3d body = Eigen::Vector3d::Zero();
    int moving = 0;
    for (int j = 0; j < joint_count_; ++j) {
      // A joint that appeared recently has fewer differences.
      int back = differences;
      while (back > 0 && !stored_[length - 1 - back].pose[j].present()) --back;
      velocity_[j].setZero();
      if (back == 0 || !newest.pose[j].present()) continue;
      const StoredPose& oldest = stored_[length - 1 - back];
      const double span = options_.velocity == VelocityRule::kOverTime
                              ? ToSeconds(newest.time - oldest.time)
                              : back;
      velocity_[j] =
          (newest.pose[j].position_m - oldest.pose[j].position_m) / span;
      if (last_triangulated_[j] != newest.time) continue;
      body += velocity_[j];
      ++moving;
    }
    if (moving > 0) body_velocity_ = body / moving;
  }

  CausalGaussianOptions options_;
  FrameClock clock_;
  KeptMatches kept_matches_;
  int joint_count_;
  std::vector<char> is_wrist_;
  std::vector<std::vector<double>> body_weights_;   // [length]
  std::vector<std::vector<double>> wrist_weights_;  // [length]
  std::deque<StoredPose> stored_;
  // Per second or per stored pose (VelocityUnits).
  std::vector<Eigen::Vector3d> velocity_;
  Eigen::Vector3d body_velocity_ = Eigen::Vector3d::Zero();
  std::vector<TimeNs> last_triangulated_;
  std::vector<FinalPose> finals_;
};

}  // namespace

std::vector<double> CausalGaussianWeights(double sigma, int length) {
  const int radius = static_cast<int>(4.0 * sigma + 0.5);
  std::vector<double> kernel(radius + 1);
  double total = 0.0;
  for (int k = 0; k <= radius; ++k) {
    kernel[k] = std::exp(-0.5 * k * k / (sigma * sigma));
    total += k == 0 ? kernel[k] : 2.0 * kernel[k];
  }
  std::vector<double> weights(length, 0.0);
  for (int k = -radius; k <= radius; ++k) {
    const int place = Reflect(length - 1 + k, length);
    weights[length - 1 - place] += kernel[std::abs(k)] / total;
  }
  while (weights.size() > 1 && weights.back() == 0.0) weights.pop_back();
  return weights;
}

std::unique_ptr<Estimator> MakeCausalGaussian(
    const SceneModel& scene, const CausalGaussianOptions& options) {
  return std::make_unique<CausalGaussian>(scene, options);
}

}  // namespace kinegraph
