#include "solvers/filters/offline_filter.h"

#include <glog/logging.h>

#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "core/tracking/final_poses.h"

namespace kinegraph {
namespace {

class OfflineFilter final : public Estimator {
 public:
  OfflineFilter(const SceneModel& scene, const OfflineFilterOptions& options,
                JointPoints points, SegmentFilter filter)
      : scene_(scene),
        point_source_(std::move(points)),
        filter_(std::move(filter)),
        // Half a frame of slack, as FrameClock gives.
        max_gap_s_(options.max_gap_s + 0.5 / scene.frame_rate_hz),
        samples_(scene.skeleton.joint_count()) {}

  void Add(const EstimatorFrame& frame) override;
  const Pose3d& Last() const override { return last_; }
  TimeNs LastTime() const override { return last_time_; }
  void Predict(TimeNs time, Pose3d* pose) const override;
  void ExtractFinals(std::vector<FinalPose>* finals) override;
  void Finish() override;

 private:
  struct Sample {
    size_t frame_idx = 0;  // into collected_
    JointPoint point;
  };

  void FilterJoint(size_t joint_idx);
  JointSegment Segment(const std::vector<Sample>& samples, size_t first,
                       size_t last) const;
  double SecondsAt(size_t frame_idx) const {
    return ToSeconds(collected_[frame_idx].time - collected_.front().time);
  }

  const SceneModel scene_;
  JointPoints point_source_;
  const SegmentFilter filter_;
  const double max_gap_s_;
  std::vector<FinalPose> collected_;          // one a frame
  std::vector<std::vector<Sample>> samples_;  // by joint
  std::vector<FinalPose> finals_;
  std::vector<std::optional<JointPoint>> points_;  // scratch
  Pose3d last_;
  TimeNs last_time_ = 0;
};

void OfflineFilter::Add(const EstimatorFrame& frame) {
  CHECK(collected_.empty() || frame.time > collected_.back().time);
  FinalPose& collected = collected_.emplace_back();
  collected.frame = frame.frame;
  collected.time = frame.time;
  DescribeViews(frame, scene_.kept_matches, &collected.person);
  collected.person.joints.resize(samples_.size());
  point_source_.Find(frame, &points_, &collected.person);
  for (size_t j = 0; j < samples_.size(); ++j) {
    if (points_[j]) samples_[j].push_back({collected_.size() - 1, *points_[j]});
  }
  if (frame.has_initial) {
    last_ = frame.initial;
    last_time_ = frame.time;
  }
}

void OfflineFilter::Predict(TimeNs, Pose3d* pose) const {
  ExpectUnmoved(last_, pose);
}

void OfflineFilter::ExtractFinals(std::vector<FinalPose>* finals) {
  MoveFinals(&finals_, finals);
}

void OfflineFilter::Finish() {
  for (size_t j = 0; j < samples_.size(); ++j) FilterJoint(j);
  finals_ = std::move(collected_);
  collected_.clear();
}

void OfflineFilter::FilterJoint(size_t joint_idx) {
  const std::vector<Sample>& samples = samples_[joint_idx];
  for (size_t first = 0, next = 0; first < samples.size(); first = next) {
    next = first + 1;
    while (next < samples.size() &&
           SecondsAt(samples[next].frame_idx) -
                   SecondsAt(samples[next - 1].frame_idx) <=
               max_gap_s_) {
      ++next;
    }
    JointSegment segment = Segment(samples, first, next - 1);
    segment.joint_class =
        scene_.skeleton.joint_class(static_cast<int>(joint_idx));
    const SegmentEstimate estimate = filter_(segment);
    for (size_t i = 0; i < segment.times_s.size(); ++i) {
      PersonPose& person = collected_[samples[first].frame_idx + i].person;
      Joint3d& joint = person.joints[joint_idx];
      joint.position_m =
          estimate.positions_m.row(static_cast<Eigen::Index>(i)).transpose();
      joint.status =
          segment.sampled[i] ? JointStatus::kObserved : JointStatus::kInferred;
      if (estimate.covariances_m2.empty()) continue;
      person.covariances.resize(samples_.size());
      person.covariances[joint_idx] = estimate.covariances_m2[i];
    }
  }
}

// The frames from sample `first` to sample `last`.
JointSegment OfflineFilter::Segment(const std::vector<Sample>& samples,
                                    size_t first, size_t last) const {
  const size_t begin = samples[first].frame_idx;
  const size_t count = samples[last].frame_idx - begin + 1;
  JointSegment segment;
  segment.times_s.resize(count);
  segment.positions_m.resize(static_cast<Eigen::Index>(count), 3);
  segment.sampled.assign(count, 0);
  segment.covariances_m2.assign(count, Eigen::Matrix3d::Identity());
  for (size_t i = 0; i < count; ++i) segment.times_s[i] = SecondsAt(begin + i);
  for (size_t s = first; s <= last; ++s) {
    const Sample& from = samples[s];
    segment.sampled[from.frame_idx - begin] = 1;
    segment.covariances_m2[from.frame_idx - begin] = from.point.covariance_m2;
    const size_t end =
        s == last ? from.frame_idx + 1 : samples[s + 1].frame_idx;
    for (size_t k = from.frame_idx; k < end; ++k) {
      Eigen::Vector3d position_m = from.point.position_m;
      if (k > from.frame_idx) {
        const Sample& to = samples[s + 1];
        const double share = (SecondsAt(k) - SecondsAt(from.frame_idx)) /
                             (SecondsAt(end) - SecondsAt(from.frame_idx));
        position_m += share * (to.point.position_m - from.point.position_m);
      }
      segment.positions_m.row(static_cast<Eigen::Index>(k - begin)) =
          position_m.transpose();
    }
  }
  return segment;
}

}  // namespace

std::unique_ptr<Estimator> MakeOfflineFilter(
    const SceneModel& scene, const OfflineFilterOptions& options,
    JointPoints points, SegmentFilter filter) {
  CheckOptions(options);
  return std::make_unique<OfflineFilter>(scene, options, std::move(points),
                                         std::move(filter));
}

}  // namespace kinegraph
