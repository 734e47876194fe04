#include "core/association/affinity.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/data/box.h"

namespace kinegraph {

void AssociationOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("affinity", &affinity, {"part", "body", "cross_view"},
                 "mean over positive joints, over all, or Chen et al.'s sum");
  visitor.Number("alpha_2d", &alpha_2d_px_per_frame, Positive(), "px per frame",
                 "2D speed at which a joint's affinity falls to zero (Eq. 1)");
  visitor.Number("lambda_a", &lambda_a_per_frame, NonNegative(), "1/frame",
                 "decay of the affinity with the age of the 3D pose (Eq. 1)");
  visitor.Number("epsilon", &epsilon_joints, Between(0.0, 17.0), "joints of 17",
                 "share of the common joints that must be positive");
  visitor.Number("min_common_joints", &min_common_joints, Between(0.0, 17.0),
                 "joints of 17", "fewer common joints are no match");
  visitor.Number("max_speed", &max_speed_mps, NonNegative(), "m/s",
                 "graph mode: how fast the gate of a lost person grows; 0: by "
                 "alpha_2d");
  visitor.Number("prediction_s", &prediction_s, NonNegative(), "s",
                 "graph mode: how long a person is expected to go on moving; "
                 "0: stays where last seen");
  visitor.Choice("target_2d", &target_2d, {"matched", "projected"},
                 "cross_view: the 2D joint last matched, or the 3D one there");
  visitor.Number("alpha_3d", &alpha_3d_m, Positive(), "m",
                 "cross_view: ray distance at which a joint counts nothing");
}

void ProjectPose(const Pose3d& pose, const Camera& camera,
                 const std::vector<int>& joints, ProjectedPose* projected) {
  projected->px.resize(pose.size());
  projected->valid.assign(pose.size(), 0);
  for (const int j : joints) {
    if (!pose[j].present()) continue;
    const std::optional<Eigen::Vector2d> px =
        camera.Project(pose[j].position_m);
    if (!px.has_value()) continue;
    projected->px[j] = *px;
    projected->valid[j] = 1;
  }
}

double GatePx(const Pose3d& pose, double age_frames, const Camera& camera,
              const AssociationOptions& options) {
  const double paper_px = options.alpha_2d_px_per_frame * age_frames;
  if (!(options.reach_m_per_frame > 0.0)) return paper_px;
  // Frames off the beat may follow each other closely; errors of the detector
  // and of the prediction are as large then.
  if (!(age_frames > 1.0)) return options.alpha_2d_px_per_frame;
  const std::optional<Eigen::Vector3d> centre = MeanPosition(pose);
  if (!centre.has_value()) return paper_px;
  const double depth_m = camera.Depth(*centre);
  if (!(depth_m > 0.0)) return paper_px;
  const double reach_m = options.reach_m_per_frame * (age_frames - 1.0);
  return std::min(paper_px, options.alpha_2d_px_per_frame +
                                camera.focal_px() * reach_m / depth_m);
}

double Affinity(const Observation& observation, const ProjectedPose& projected,
                double age_frames, double gate_px,
                const std::vector<int>& joints,
                const AssociationOptions& options) {
  // Eq. 1, of joint n at age dt = t - t':
  //   g_n = (1 - d_n / (alpha_2d dt)) exp(-lambda_a dt),
  // whose second factor is that of the whole pair. The part-aware affinity is
  // the mean over the joints with g_n > 0 if these are epsilon or more.
  const double scale = 1.0 / gate_px;
  int common = 0;
  int positive = 0;
  double positive_sum = 0.0;
  double sum = 0.0;
  for (const int j : joints) {
    if (!projected.valid[j] || !observation.joints[j].found) continue;
    ++common;
    const double distance_px =
        (observation.joints[j].px - projected.px[j]).norm();
    const double affinity = 1.0 - distance_px * scale;
    sum += affinity;
    if (affinity > 0.0) {
      ++positive;
      positive_sum += affinity;
    }
  }
  if (common == 0 ||
      common < ScaledJoints(options.min_common_joints, joints.size())) {
    return 0.0;
  }
  const double decay = std::exp(-options.lambda_a_per_frame * age_frames);
  if (options.affinity == AffinityKind::kBody) return sum / common * decay;
  if (positive == 0 || positive < ScaledJoints(options.epsilon_joints,
                                               static_cast<size_t>(common))) {
    return 0.0;
  }
  return positive_sum / positive * decay;
}

double CrossViewAffinity(const Observation& observation,
                         const std::vector<LastSeenJoint>& last_seen,
                         const Pose3d& expected, double expected_age_frames,
                         const Camera& camera, const std::vector<int>& joints,
                         const AssociationOptions& options) {
  const double decay_3d =
      options.weight_3d *
      std::exp(-options.lambda_a_per_frame * expected_age_frames);
  int common = 0;
  double sum = 0.0;
  for (const int j : joints) {
    if (!observation.joints[j].found) continue;
    bool takes_part = false;
    if (!last_seen.empty() && last_seen[j].valid) {
      const LastSeenJoint& last = last_seen[j];
      const double distance_px = (observation.joints[j].px - last.px).norm();
      sum += options.weight_2d *
             (1.0 -
              distance_px / (options.alpha_2d_px_per_frame * last.age_frames)) *
             std::exp(-options.lambda_a_per_frame * last.age_frames);
      takes_part = true;
    }
    if (expected[j].present() && camera.Depth(expected[j].position_m) > 0.0) {
      const double distance_m = DistanceToRay(camera, observation.ideal_px[j],
                                              expected[j].position_m);
      sum += decay_3d * (1.0 - distance_m / options.alpha_3d_m);
      takes_part = true;
    }
    common += takes_part;
  }
  if (common == 0 ||
      common < ScaledJoints(options.min_common_joints, joints.size())) {
    return 0.0;
  }
  return sum;
}

// One of them, ready for one person after another. Keeps its memory between
// calls.
class AffinityMeasure {
 public:
  virtual ~AffinityMeasure() = default;
  // Whom the calls of Of() that follow are about, in the view of `camera`.
  // What `target` points at must not change before the last of them.
  virtual void SetTarget(const AssociationTarget& target,
                         const Camera& camera) = 0;
  // Whether an observation whose joints lie in `box` may have one above zero.
  virtual bool MayMatch(const Eigen::AlignedBox2d& /*box*/) const {
    return true;
  }
  // > 0: may be matched, the greater the better.
  virtual double Of(const Observation& observation) const = 0;
};

namespace {

class ProjectionMeasure final : public AffinityMeasure {
 public:
  ProjectionMeasure(const AssociationOptions& options, std::vector<int> joints)
      : options_(options), joints_(std::move(joints)) {}

  void SetTarget(const AssociationTarget& target,
                 const Camera& camera) override {
    ProjectPose(*target.pose, camera, joints_, &projected_);
    age_frames_ = target.age_frames;
    gate_px_ = GatePx(*target.pose, age_frames_, camera, options_);
    box_.setEmpty();
    for (const int j : joints_) {
      if (projected_.valid[j]) box_.extend(projected_.px[j]);
    }
  }
  // A joint beyond its gate adds nothing, or less.
  bool MayMatch(const Eigen::AlignedBox2d& box) const override {
    return !(GapPx(box, box_) > gate_px_);
  }
  double Of(const Observation& observation) const override {
    return Affinity(observation, projected_, age_frames_, gate_px_, joints_,
                    options_);
  }

 private:
  AssociationOptions options_;
  std::vector<int> joints_;
  ProjectedPose projected_;
  Eigen::AlignedBox2d box_;  // around what is projected
  double age_frames_ = 0.0;
  double gate_px_ = 0.0;
};

class CrossViewMeasure final : public AffinityMeasure {
 public:
  CrossViewMeasure(const AssociationOptions& options, std::vector<int> joints)
      : options_(options), joints_(std::move(joints)) {}

  void SetTarget(const AssociationTarget& target,
                 const Camera& camera) override {
    camera_ = &camera;
    const bool has_expected = target.expected != nullptr;
    expected_ = has_expected ? target.expected : target.pose;
    expected_age_frames_ =
        has_expected ? target.expected_age_frames : target.age_frames;
    last_seen_ = &kNever;
    if (options_.target_2d == Target2d::kMatched) {
      if (target.last_seen != nullptr) last_seen_ = target.last_seen;
      return;
    }
    ProjectPose(*target.pose, camera, joints_, &projected_);
    projected_joints_.assign(target.pose->size(), LastSeenJoint());
    for (const int j : joints_) {
      if (!projected_.valid[j]) continue;
      projected_joints_[j] = {true, projected_.px[j], target.age_frames};
    }
    last_seen_ = &projected_joints_;
  }
  double Of(const Observation& observation) const override {
    return CrossViewAffinity(observation, *last_seen_, *expected_,
                             expected_age_frames_, *camera_, joints_, options_);
  }

 private:
  inline static const std::vector<LastSeenJoint> kNever;

  AssociationOptions options_;
  std::vector<int> joints_;
  const Camera* camera_ = nullptr;
  const Pose3d* expected_ = nullptr;
  double expected_age_frames_ = 0.0;
  const std::vector<LastSeenJoint>* last_seen_ = &kNever;
  ProjectedPose projected_;
  std::vector<LastSeenJoint> projected_joints_;
};

}  // namespace

ViewMatcher::ViewMatcher(const AssociationOptions& options,
                         std::vector<int> joints) {
  if (options.affinity == AffinityKind::kCrossView) {
    measure_ = std::make_unique<CrossViewMeasure>(options, std::move(joints));
  } else {
    measure_ = std::make_unique<ProjectionMeasure>(options, std::move(joints));
  }
}

ViewMatcher::~ViewMatcher() = default;

void ViewMatcher::Match(const std::vector<AssociationTarget>& targets,
                        Span<Observation> observations, const Camera& camera,
                        const std::vector<char>& barred,
                        std::vector<int>* match) {
  const size_t cols = observations.size();
  affinities_.resize(targets.size() * cols);
  boxes_.clear();
  for (const Observation& observation : observations) {
    boxes_.push_back(BoxAround(observation.joints));
  }
  for (size_t row = 0; row < targets.size(); ++row) {
    if (cols == 0) break;
    measure_->SetTarget(targets[row], camera);
    for (size_t col = 0; col < cols; ++col) {
      // A pair that may not match must not influence the assignment either, so
      // a negative affinity counts as zero.
      const size_t pair = row * cols + col;
      const bool may =
          (barred.empty() || !barred[pair]) && measure_->MayMatch(boxes_[col]);
      affinities_[pair] =
          may ? std::max(0.0, measure_->Of(observations[col])) : 0.0;
    }
  }
  solver_.MaximisePositive(affinities_, static_cast<int>(targets.size()),
                           static_cast<int>(cols), match);
}

}  // namespace kinegraph
