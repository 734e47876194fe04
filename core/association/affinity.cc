#include "core/association/affinity.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/data/box.h"

namespace kinegraph {

void AssociationOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice(
      "affinity", &affinity, {"part", "body", "cross_view"},
      "mean over the joints with a positive affinity, over all joints, "
      "or Chen et al.'s sum");
  visitor.Number("alpha_2d", &alpha_2d_px_per_frame, Positive(), "px per frame",
                 "2D speed at which a joint's affinity falls to zero (Eq. 1)");
  visitor.Number("lambda_a", &lambda_a_per_frame, NonNegative(), "1/frame",
                 "decay of the affinity with the age of the 3D pose (Eq. 1)");
  visitor.Number("epsilon", &epsilon_joints, Between(0.0, 17.0), "joints of 17",
                 "common joints that must have a positive affinity");
  visitor.Number("min_common_joints", &min_common_joints, Between(0.0, 17.0),
                 "joints of 17", "pairs with fewer common joints cannot match");
  visitor.Number("max_speed", &max_speed_mps, NonNegative(), "m/s",
                 "graph mode: how fast the gate of a lost person grows; 0: by "
                 "alpha_2d");
  visitor.Number("prediction_s", &prediction_s, NonNegative(), "s",
                 "graph mode: how long a person is expected to keep moving; 0: "
                 "expected where last seen");
  visitor.Choice(
      "target_2d", &target_2d, {"matched", "projected"},
      "cross_view: what a detected joint is compared with: the 2D joint "
      "last matched in its view, or the projected 3D joint");
  visitor.Number(
      "alpha_3d", &alpha_3d_m, Positive(), "m",
      "cross_view: distance from the ray at which a joint's affinity "
      "falls to zero");
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
  // Irregular frames may follow each other closely, but errors of the detector
  // and of the prediction do not shrink with the interval.
  if (!(age_frames > 1.0)) return options.alpha_2d_px_per_frame;
  const std::optional<Eigen::Vector3d> centre = MeanPosition(pose);
  if (!centre.has_value()) return paper_px;
  const double depth_m = camera.Depth(*centre);
  if (!(depth_m > 0.0)) return paper_px;
  const double reach_m = options.reach_m_per_frame * (age_frames - 1.0);
  return std::min(paper_px, options.alpha_2d_px_per_frame +
                                camera.focal_px() * reach_m / depth_m);
}

namespace {

// Graph mode: whether a match on few joints counts. Chance agreement is
// excluded by requiring that every common joint is within the gate, with a mean
// affinity (before the decay with age) of at least a half.
bool FewMatch(int common, int positive, double positive_sum, size_t joints) {
  constexpr double kWellWithin = 0.5;
  return common >= ScaledJoints(kFewestJoints, joints) && positive == common &&
         positive_sum >= kWellWithin * common;
}

}  // namespace

double Affinity(const Observation& observation, const ProjectedPose& projected,
                double age_frames, double gate_px,
                const std::vector<int>& joints,
                const AssociationOptions& options) {
  // Eq. 1, of joint n at age dt = t - t':
  //   g_n = (1 - d_n / (alpha_2d dt)) exp(-lambda_a dt)
  // `gate_px` takes the place of alpha_2d dt (GatePx). The second factor is
  // common to all joints. The part-aware affinity is the mean over the joints
  // with g_n > 0 if there are at least epsilon of them.
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
  if (common == 0) return 0.0;
  if (common < ScaledJoints(options.min_common_joints, joints.size()) &&
      !(options.reach_m_per_frame > 0.0 &&
        FewMatch(common, positive, positive_sum, joints.size()))) {
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

void ViewMatcher::SetTarget(const AssociationTarget& target,
                            const Camera& camera) {
  last_seen_.clear();
  const bool cross_view = options_.affinity == AffinityKind::kCrossView;
  if (cross_view && options_.target_2d == Target2d::kMatched) return;
  ProjectPose(*target.pose, camera, joints_, &projected_);
  if (cross_view) last_seen_.resize(target.pose->size());
  box_.setEmpty();
  for (const int j : joints_) {
    if (!projected_.valid[j]) continue;
    if (cross_view) last_seen_[j] = {true, projected_.px[j], target.age_frames};
    box_.extend(projected_.px[j]);
  }
  gate_px_ = GatePx(*target.pose, target.age_frames, camera, options_);
}

double ViewMatcher::AffinityOf(const AssociationTarget& target,
                               const Observation& observation,
                               const Eigen::AlignedBox2d& box,
                               const Camera& camera) const {
  if (options_.affinity != AffinityKind::kCrossView) {
    // If the boxes are farther apart than the gate, so are all pairs of joints,
    // and no affinity is positive.
    if (GapPx(box, box_) > gate_px_) return 0.0;
    return Affinity(observation, projected_, target.age_frames, gate_px_,
                    joints_, options_);
  }
  const bool is_matched = options_.target_2d == Target2d::kMatched;
  const auto& last_seen = is_matched && target.last_seen != nullptr
                              ? *target.last_seen
                              : last_seen_;
  const bool has_expected = target.expected != nullptr;
  return CrossViewAffinity(
      observation, last_seen, has_expected ? *target.expected : *target.pose,
      has_expected ? target.expected_age_frames : target.age_frames, camera,
      joints_, options_);
}

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
    SetTarget(targets[row], camera);
    for (size_t col = 0; col < cols; ++col) {
      // A pair that cannot match must not influence the assignment, so negative
      // affinities are set to zero.
      const size_t pair = row * cols + col;
      affinities_[pair] =
          !barred.empty() && barred[pair]
              ? 0.0
              : std::max(0.0, AffinityOf(targets[row], observations[col],
                                         boxes_[col], camera));
    }
  }
  solver_.MaximisePositive(affinities_, static_cast<int>(targets.size()),
                           static_cast<int>(cols), match);
}

}  // namespace kinegraph
