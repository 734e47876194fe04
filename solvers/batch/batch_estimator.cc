#include "solvers/batch/batch_estimator.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/tracking/final_poses.h"
#include "solvers/batch/take_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/bone_lengths.h"
#include "solvers/graph/noise_scale.h"
#include "solvers/graph/outcome.h"
#include "solvers/graph/problem_store.h"
#include "solvers/noise/bone_spreads.h"
#include "solvers/noise/person_bias.h"
#include "solvers/noise/person_noise.h"

namespace kinegraph {
namespace {

// A noise scale that moves less is not worth another solve.
constexpr double kLeastChange = 0.02;

// Starts between triangulated frames lie on the line between them, those
// before the first and after the last stay where it was.
void InterpolateStarts(const std::vector<FrameRecord>& records, int joint_idx,
                       const std::vector<TimeNs>& times, JointChain* chain) {
  const size_t count = records.size();
  size_t previous = count;  // none yet
  for (size_t k = 0; k < count; ++k) {
    if (!records[k].triangulated[joint_idx]) continue;
    const Eigen::Vector3d to = chain->states[k].head<3>();
    const Eigen::Vector3d from =
        previous == count ? to
                          : Eigen::Vector3d(chain->states[previous].head<3>());
    for (size_t i = previous == count ? 0 : previous + 1; i < k; ++i) {
      const double share = previous == count
                               ? 0.0
                               : ToSeconds(times[i] - times[previous]) /
                                     ToSeconds(times[k] - times[previous]);
      chain->states[i].head<3>() = from + share * (to - from);
    }
    previous = k;
  }
  if (previous == count) return;  // all stand at the person's centre
  for (size_t i = previous + 1; i < count; ++i) {
    chain->states[i].head<3>() = chain->states[previous].head<3>();
  }
}

// Time to the nearest frame with `views` inlier views or more, for every frame
// [s].
std::vector<double> SecondsToSupport(const std::vector<TimeNs>& times,
                                     const std::vector<int>& inliers,
                                     int views) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<double> nearest(times.size(), kFar);
  double since = kFar;
  for (size_t k = 0; k < times.size(); ++k) {
    if (k > 0) since += ToSeconds(times[k] - times[k - 1]);
    if (inliers[k] >= views) since = 0.0;
    nearest[k] = since;
  }
  double until = kFar;
  for (size_t k = times.size(); k-- > 0;) {
    if (k + 1 < times.size()) until += ToSeconds(times[k + 1] - times[k]);
    if (inliers[k] >= views) until = 0.0;
    nearest[k] = std::min(nearest[k], until);
  }
  return nearest;
}

class BatchEstimator final : public Estimator {
 public:
  BatchEstimator(const SceneModel& scene, const GraphOptions& options,
                 std::shared_ptr<TakeNotes> notes)
      : scene_(scene),
        options_(options),
        assembler_(scene_, options_),
        solver_(options_),
        store_(assembler_.EmptyProblem()),
        noise_(std::in_place, scene_, options_),
        notes_(std::move(notes)),
        bias_(scene_, notes_ == nullptr ? nullptr : notes_->view_bias()),
        learnt_(notes_ == nullptr ? nullptr : notes_->NewPerson()) {}

  void Add(const EstimatorFrame& frame) override;
  const Pose3d& Last() const override { return last_; }
  TimeNs LastTime() const override { return last_time_; }
  void Predict(TimeNs time, Pose3d* pose) const override;
  void TakeFinals(std::vector<FinalPose>* finals) override;
  void Finish() override;

 private:
  int joint_count() const { return scene_.skeleton.joint_count(); }
  void SolveAll();
  bool RescaleNoise(const SolveStage& stage, double least_change);
  void LearnNoiseScale();
  void AddBones();
  void AddBonesOfTheTake();
  void AddFixedBones();
  std::vector<std::vector<Eigen::Matrix3d>> Covariances();
  void WriteFinals();
  void DistrustBones(std::vector<std::vector<Eigen::Matrix3d>>* covariances);
  void WriteFinalsOf(int joint_idx, const std::vector<int>& inliers,
                     bool ever_two,
                     const std::vector<Eigen::Matrix3d>& covariances);
  std::vector<int> InliersOf(int joint_idx) const;

  const SceneModel scene_;
  const GraphOptions options_;
  Assembler assembler_;
  TakeSolver solver_;
  ProblemStore store_;     // until all frames are there
  PersonProblem problem_;  // then
  // As problem_'s, for covariances.
  std::vector<BoneConstraint> stated_bones_;
  std::optional<PersonNoise> noise_;        // until all is solved
  const std::shared_ptr<TakeNotes> notes_;  // null: nothing is shared
  PersonBias bias_;
  const std::shared_ptr<LearntNoise> learnt_;
  std::vector<FrameRecord> records_;
  std::vector<FinalPose> finals_;
  Pose3d last_;
  TimeNs last_time_ = 0;
};

void BatchEstimator::Add(const EstimatorFrame& frame) {
  records_.push_back(assembler_.Append(frame, store_.newest()));
  bias_.Observe(*store_.newest(), store_.newest_frame(),
                records_.back().triangulated);
  store_.Keep();
  if (frame.has_initial || records_.size() == 1) {
    last_ = frame.initial;
    last_.resize(joint_count());
    last_time_ = frame.time;
  }
}

void BatchEstimator::Predict(TimeNs, Pose3d* pose) const {
  ExpectUnmoved(last_, pose);
}

void BatchEstimator::TakeFinals(std::vector<FinalPose>* finals) {
  MoveFinals(&finals_, finals);
}

void BatchEstimator::Finish() {
  if (records_.empty()) return;
  problem_ = store_.TakeAll();
  SolveAll();
  WriteFinals();
  solver_.HandInCounts(records_.front().frame, records_.back().frame);
  // Finals may wait long for those of other people: nothing else should.
  problem_ = {};
  stated_bones_.clear();
  noise_.reset();
  solver_.FreeWorkSpace();
  records_ = std::vector<FrameRecord>();
}

void BatchEstimator::SolveAll() {
  for (int j = 0; j < joint_count(); ++j) {
    InterpolateStarts(records_, j, problem_.times, &problem_.joints[j]);
  }
  bias_.ApplyTake(&problem_);
  if (options_.LearnsNoise()) {
    noise_->LearnTake(problem_);
    noise_->Apply(&problem_);
    if (learnt_ != nullptr) *learnt_ = noise_->Learnt();
    VLOG(1) << ToString(noise_->Learnt());
    noise_->FreeEvidence();
  }
  if (options_.pixel_noise_from == NoiseFrom::kFixed &&
      options_.estimate_noise_scale) {
    LearnNoiseScale();
  } else {
    solver_.SolveJointsWithRivals(solver_.schedule(), &problem_);
  }
  if (options_.bones) AddBones();
  solver_.SolveTogether(&problem_);
}

// Solves the joints under one factor on all sigmas.
void BatchEstimator::LearnNoiseScale() {
  const SolveSchedule& whole = solver_.schedule();
  // The first stage is convex: its residuals do not depend on the start.
  SolveSchedule first = whole;
  first.stages.resize(1);
  first.doubt_unsettled = false;
  solver_.SolveJoints(first, &problem_);
  RescaleNoise(first.stages.front(), 0.0);
  // What the whole schedule leaves tells better who is an outlier. Solved
  // from the convex stage again: a redescending loss may not start warm.
  solver_.SolveJointsWithRivals(whole, &problem_);
  if (RescaleNoise(whole.stages.back(), kLeastChange)) {
    solver_.SolveJointsWithRivals(whole, &problem_);
  }
}

// From the residuals that the stage has left. False where the scale changes by
// no more than the share `least_change`; then nothing is scaled.
bool BatchEstimator::RescaleNoise(const SolveStage& stage,
                                  double least_change) {
  const double correction = InformationCorrection(stage.loss, stage.scale);
  std::vector<double> squares;
  const auto covariances = solver_.StateCovariances(problem_, correction);
  for (int j = 0; j < joint_count(); ++j) {
    if (covariances[j].empty()) continue;
    CollectSquares(problem_.joints[j], covariances[j], 0, records_.size(),
                   &squares);
  }
  const double scale = EstimateNoiseScale(std::move(squares));
  VLOG(1) << "noise scale times " << scale;
  if (std::abs(scale - 1.0) <= least_change) return false;
  ScaleSigmas(scale, &problem_);
  return true;
}

std::vector<int> BatchEstimator::InliersOf(int joint_idx) const {
  std::vector<int> inliers(records_.size());
  for (size_t k = 0; k < inliers.size(); ++k) {
    inliers[k] =
        CountInliers(problem_.joints[joint_idx], k, options_.inlier_weight);
  }
  return inliers;
}

bool EverTwo(const std::vector<int>& inliers) {
  return std::any_of(inliers.begin(), inliers.end(),
                     [](int count) { return count >= 2; });
}

void BatchEstimator::AddBones() {
  if (options_.bone_sigma_from == NoiseFrom::kTake) {
    AddBonesOfTheTake();
  } else {
    AddFixedBones();
  }
}

// Bones as long and as free as the views say in the frames where the estimates
// without bones trust them.
void BatchEstimator::AddBonesOfTheTake() {
  BoneSpreads spreads(scene_.skeleton);
  if (options_.pixel_noise_from == NoiseFrom::kTake) {
    spreads.SetLasting(noise_->correlation(), 1.0 / scene_.frame_rate_hz);
  }
  for (size_t k = 0; k < records_.size(); ++k) {
    spreads.AddFrame(LocateBoneEnds(problem_, k, options_.inlier_weight,
                                    1.0 / scene_.frame_rate_hz));
  }
  std::vector<bool> placed;
  for (int j = 0; j < joint_count(); ++j) {
    placed.push_back(EverTwo(InliersOf(j)));
  }
  problem_.bones = ConstraintsOf(spreads, options_.bone_loss, placed);
  stated_bones_ =
      ConstraintsOf(spreads, options_.bone_loss, placed, BoneUse::kCovariance);
}

// Bones between joints that two views have placed, as long as the estimates
// without bones say.
void BatchEstimator::AddFixedBones() {
  BoneLengths lengths(scene_.skeleton);
  std::vector<std::vector<int>> inliers;
  for (int j = 0; j < joint_count(); ++j) inliers.push_back(InliersOf(j));
  const std::vector<Bone>& bones = lengths.bones();
  for (size_t i = 0; i < bones.size(); ++i) {
    for (size_t k = 0; k < records_.size(); ++k) {
      if (inliers[bones[i].a][k] < 2 || inliers[bones[i].b][k] < 2) continue;
      const double distance_m =
          (problem_.joints[bones[i].a].states[k].head<3>() -
           problem_.joints[bones[i].b].states[k].head<3>())
              .norm();
      lengths.Add(static_cast<int>(i), distance_m, 1.0 / scene_.frame_rate_hz);
    }
  }
  for (size_t i = 0; i < bones.size(); ++i) {
    const std::optional<double> length_m = lengths.Length(static_cast<int>(i));
    if (!length_m.has_value()) continue;
    if (!EverTwo(inliers[bones[i].a]) || !EverTwo(inliers[bones[i].b])) {
      continue;
    }
    problem_.bones.push_back(
        {bones[i].a, bones[i].b, *length_m, options_.bone_sigma_m});
  }
  stated_bones_ = problem_.bones;
}

std::vector<std::vector<Eigen::Matrix3d>> BatchEstimator::Covariances() {
  std::vector<std::vector<Eigen::Matrix3d>> covariances(joint_count());
  if (!options_.covariance) return covariances;
  // Bones that could not be solved do not count.
  const bool held = !problem_.bones.empty();
  if (held) std::swap(problem_.bones, stated_bones_);
  covariances = solver_.Covariances(problem_);
  if (held) {
    std::swap(problem_.bones, stated_bones_);
    // Bones of fixed freedom state what they always did.
    if (options_.bone_sigma_from == NoiseFrom::kTake) {
      DistrustBones(&covariances);
    }
  }
  solver_.FreeWorkSpace();
  return covariances;
}

void BatchEstimator::WriteFinals() {
  std::vector<std::vector<Eigen::Matrix3d>> covariances = Covariances();
  std::vector<std::vector<int>> inliers;
  for (int j = 0; j < joint_count(); ++j) inliers.push_back(InliersOf(j));
  // Poses are as large as the measurements, which only weights still need.
  if (scene_.kept_matches != KeptMatches::kWeights) {
    for (JointChain& chain : problem_.joints) {
      chain.measurements = std::vector<PixelMeasurement>();
    }
  }
  finals_.clear();
  finals_.reserve(records_.size());
  for (const FrameRecord& record : records_) {
    finals_.push_back(PoseOf(record, joint_count(), scene_.kept_matches,
                             options_.covariance));
  }
  for (int j = 0; j < joint_count(); ++j) {
    const bool ever_two = EverTwo(inliers[j]);
    if (!ever_two) covariances[j].clear();
    WriteFinalsOf(j, inliers[j], ever_two, covariances[j]);
    covariances[j] = std::vector<Eigen::Matrix3d>();
  }
}

// A bone leaves two places on the ray of a view that alone sees its end, and a
// circle without one. While two views have just seen the joint the motion tells
// which; later the estimate may stand at the wrong one, and no covariance of
// its surroundings says so. There what is stated is what is known without
// bones.
void BatchEstimator::DistrustBones(
    std::vector<std::vector<Eigen::Matrix3d>>* covariances) {
  constexpr double kSurelyS = 0.1;
  const auto alone = solver_.JointCovariances(problem_);
  for (int j = 0; j < joint_count(); ++j) {
    std::vector<Eigen::Matrix3d>& stated = (*covariances)[j];
    const std::vector<double> nearest =
        SecondsToSupport(problem_.times, InliersOf(j), 2);
    for (size_t k = 0; k < std::min(stated.size(), alone[j].size()); ++k) {
      if (nearest[k] > kSurelyS) stated[k] = alone[j][k];
    }
  }
}

void BatchEstimator::WriteFinalsOf(
    int joint_idx, const std::vector<int>& inliers, bool ever_two,
    const std::vector<Eigen::Matrix3d>& covariances) {
  const JointChain& chain = problem_.joints[joint_idx];
  const std::vector<double> nearest =
      SecondsToSupport(problem_.times, inliers, 1);
  for (size_t k = 0; k < records_.size(); ++k) {
    const JointStatus status =
        StatusOf(inliers[k], ever_two, nearest[k], options_.bridging_limit_s);
    Eigen::Matrix3d covariance;
    const bool known = k < covariances.size();
    if (known) {
      covariance = noise_->CovarianceFactorOf(joint_idx, k) * covariances[k];
    }
    WriteJoint(chain, k, joint_idx, status, inliers[k],
               known ? &covariance : nullptr, &finals_[k].person);
  }
}

}  // namespace

std::unique_ptr<Estimator> MakeBatchEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<TakeNotes> notes) {
  CheckGraphOptions(options);
  return std::make_unique<BatchEstimator>(scene, options, std::move(notes));
}

}  // namespace kinegraph
