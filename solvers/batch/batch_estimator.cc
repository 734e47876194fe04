#include "solvers/batch/batch_estimator.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/tracking/estimator.h"
#include "core/tracking/packed_queue.h"
#include "solvers/batch/chunks.h"
#include "solvers/batch/recording_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/bone_lengths.h"
#include "solvers/graph/noise_scale.h"
#include "solvers/graph/outcome.h"
#include "solvers/noise/bias_learner.h"
#include "solvers/noise/bone_spreads.h"
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
                 std::shared_ptr<RecordingNotes> notes)
      : scene_(scene),
        options_(options),
        solver_(options_),
        noise_(std::in_place, scene_, options_),
        notes_(std::move(notes)),
        bias_joints_(scene_.skeleton),
        bias_(notes_ == nullptr ? nullptr : notes_->view_bias()),
        series_(
            notes_ == nullptr
                ? nullptr
                : notes_->NewSeries(bias_joints_,
                                    static_cast<int>(scene_.cameras.size()))),
        learnt_(notes_ == nullptr ? nullptr : notes_->NewPerson()) {}

  void Add(const EstimatorFrame& frame) override;
  const Pose3d& Last() const override { return last_; }
  TimeNs LastTime() const override { return last_time_; }
  void Predict(TimeNs time, Pose3d* pose) const override;
  void ExtractFinals(std::vector<FinalPose>* finals) override;
  void Finish() override;

 private:
  // What is known of a joint in a frame without bones.
  struct KnownAlone {
    size_t joint_idx = 0;
    size_t frame = 0;
    Eigen::Matrix3d covariance_m2;
  };
  // What final poses say of one joint.
  struct Written {
    std::vector<int> inliers;       // by frame
    std::vector<double> nearest_s;  // by frame: time to a view that saw it
    bool ever_two = false;          // views agreed
    std::vector<Eigen::Matrix3d> covariances;  // m^2, by frame; or none
  };

  int joint_count() const { return scene_.skeleton.joint_count(); }
  void Assemble();
  void Solve();
  bool SolveAgain();
  std::shared_ptr<SolvedPerson> Solution() const;
  void TellBias() const;
  bool RescaleNoise(const SolveStage& stage, double least_change);
  void LearnNoiseScale();
  void AddBones();
  void AddBonesOfTheRecording();
  void AddFixedBones();
  std::vector<std::vector<Eigen::Matrix3d>> Covariances();
  void LearnNoise();
  void WriteFinals();
  std::vector<KnownAlone> DistrustBones();
  void WriteFinalsOf(int joint_idx, const Written& written);
  std::vector<std::vector<int>> Inliers() const;

  const SceneModel scene_;
  const GraphOptions options_;
  RecordingSolver solver_;
  PackedFrames frames_;      // until all are there
  PersonProblem recording_;  // then
  // As recording_'s, for covariances.
  std::vector<BoneConstraint> stated_bones_;
  std::optional<PersonNoise> noise_;             // until all is solved
  const std::shared_ptr<RecordingNotes> notes_;  // null: nothing is shared
  const BiasJoints bias_joints_;
  // What is taken away, and where the solution is told; null: nothing, nowhere.
  const std::shared_ptr<const ViewBias> bias_;
  const std::shared_ptr<BiasSeries> series_;
  const std::shared_ptr<LearntNoise> learnt_;
  std::vector<FrameRecord> records_;
  std::vector<FinalPose> finals_;
  Pose3d last_;
  TimeNs last_time_ = 0;
};

void BatchEstimator::Add(const EstimatorFrame& frame) {
  frames_.Push(frame);
  if (frame.has_initial || frames_.size() == 1) {
    last_ = frame.initial;
    last_.resize(joint_count());
    last_time_ = frame.time;
  }
}

void BatchEstimator::Predict(TimeNs, Pose3d* pose) const {
  ExpectUnmoved(last_, pose);
}

void BatchEstimator::ExtractFinals(std::vector<FinalPose>* finals) {
  MoveFinals(&finals_, finals);
}

void BatchEstimator::Finish() {
  if (frames_.empty()) return;
  Solve();
  if (series_ != nullptr) TellBias();
  const std::shared_ptr<SolvedPerson> solution = Solution();
  WriteFinals();
  solver_.HandInCounts(records_.front().frame, records_.back().frame);
  if (solution != nullptr) {
    solution->noise = noise_->ExtractApplied();
    solution->records = std::move(records_);
    notes_->Keep(solution);
  }
  // Finals may wait long for those of other people: nothing else should.
  recording_ = {};
  stated_bones_.clear();
  noise_.reset();
  records_ = std::vector<FrameRecord>();
  solver_.FreeWorkSpace();
}

void BatchEstimator::TellBias() const {
  BiasObserver observer(bias_joints_, scene_.cameras, scene_.frame_rate_hz,
                        noise_->correlation(), series_.get());
  for (size_t k = 0; k < records_.size(); ++k) observer.Add(recording_, k);
}

void BatchEstimator::Assemble() {
  Assembler assembler(scene_, options_);
  recording_ = assembler.EmptyProblem();
  records_.reserve(frames_.size());
  while (!frames_.empty()) {
    records_.push_back(assembler.Append(frames_.Pop(), &recording_));
  }
  for (int j = 0; j < joint_count(); ++j) {
    InterpolateStarts(records_, j, recording_.times, &recording_.joints[j]);
  }
}

void BatchEstimator::Solve() {
  Assemble();
  if (bias_ != nullptr && !bias_->empty()) {
    WriteBias(bias_joints_, *bias_, records_, &recording_);
  }
  if (SolveAgain()) return;
  if (options_.LearnsNoise()) LearnNoise();
  if (options_.pixel_noise_from == NoiseFrom::kFixed &&
      options_.estimate_noise_scale) {
    LearnNoiseScale();
  } else {
    solver_.SolveJoints(solver_.schedule(), &recording_);
  }
  if (options_.bones) AddBones();
  solver_.SolveTogether(&recording_);
}

// What the next pass needs in order not to solve this person anew; null where
// there is none.
std::shared_ptr<SolvedPerson> BatchEstimator::Solution() const {
  if (notes_ == nullptr || !notes_->expects_another_pass()) return nullptr;
  // One scale on all sigmas follows from residuals; users' factors may see
  // what the next pass starts from.
  const bool scales = options_.pixel_noise_from == NoiseFrom::kFixed &&
                      options_.estimate_noise_scale;
  if (scales || options_.user_factors || !solver_.KeptBones()) return nullptr;
  auto solution = std::make_shared<SolvedPerson>();
  solution->bones = recording_.bones;
  solution->stated_bones = stated_bones_;
  std::vector<JointOutcome> outcomes =
      OutcomesOf(recording_, {0, records_.size(), 0, records_.size()});
  for (size_t j = 0; j < outcomes.size(); ++j) {
    solution->joints.push_back(
        {std::move(outcomes[j]), recording_.joints[j].first});
  }
  return solution;
}

// Takes over what the pass before found of this person, and solves anew where
// matches changed. False where that pass knows nobody like this.
bool BatchEstimator::SolveAgain() {
  if (notes_ == nullptr) return false;
  std::optional<KnownFrames> known =
      FindKnownFrames(notes_->SolvedPeople(), records_, recording_);
  if (!known.has_value()) return false;
  const SolvedPerson& before = *known->person;
  const std::vector<Chunk> changed = ChangedChunks(recording_, known->same);
  if (options_.LearnsNoise()) {
    noise_->Adopt(before.noise, known->frame_of, recording_.times);
    for (const Chunk& chunk : changed) {
      noise_->LearnMotionAgain(recording_, chunk.begin, chunk.end,
                               chunk.own_begin, chunk.own_end);
    }
    noise_->Apply(&recording_);
    if (learnt_ != nullptr) *learnt_ = before.noise.learnt;
  }
  recording_.bones = before.bones;
  stated_bones_ = before.stated_bones;
  if (!solver_.SolveAnew(changed, &recording_)) recording_.bones.clear();
  for (const Chunk& chunk : changed) {
    std::fill(
        known->same.begin() + static_cast<std::ptrdiff_t>(chunk.own_begin),
        known->same.begin() + static_cast<std::ptrdiff_t>(chunk.own_end), 0);
  }
  PasteKnown(*known, &recording_);
  notes_->Forget(&before);
  return true;
}

void BatchEstimator::LearnNoise() {
  noise_->LearnRecording(recording_);
  noise_->Apply(&recording_);
  if (learnt_ != nullptr) *learnt_ = noise_->Learnt();
  VLOG(1) << ToString(noise_->Learnt());
  noise_->FreeEvidence();
}

// Solves the joints under one factor on all sigmas.
void BatchEstimator::LearnNoiseScale() {
  const SolveSchedule& whole = solver_.schedule();
  // The first stage is convex: its residuals do not depend on the start.
  SolveSchedule first = whole;
  first.stages.resize(1);
  first.doubt_unsettled = false;
  solver_.SolveJoints(first, &recording_);
  RescaleNoise(first.stages.front(), 0.0);
  // What the whole schedule leaves tells better who is an outlier. Solved
  // from the convex stage again: a redescending loss may not start warm.
  solver_.SolveJoints(whole, &recording_);
  if (RescaleNoise(whole.stages.back(), kLeastChange)) {
    solver_.SolveJoints(whole, &recording_);
  }
}

// From the residuals that the stage has left. False where the scale changes by
// no more than the share `least_change`; then nothing is scaled.
bool BatchEstimator::RescaleNoise(const SolveStage& stage,
                                  double least_change) {
  const double correction = InformationCorrection(stage.loss, stage.scale);
  const auto covariances = solver_.StateCovariances(recording_, correction);
  std::vector<double> squares;
  for (size_t j = 0; j < covariances.size(); ++j) {
    if (covariances[j].empty()) continue;
    CollectSquares(recording_.joints[j], covariances[j], 0, records_.size(),
                   &squares);
  }
  const double scale = EstimateNoiseScale(std::move(squares));
  VLOG(1) << "noise scale times " << scale;
  if (std::abs(scale - 1.0) <= least_change) return false;
  ScaleSigmas(scale, &recording_);
  return true;
}

// [joint][frame].
std::vector<std::vector<int>> BatchEstimator::Inliers() const {
  std::vector<std::vector<int>> inliers(static_cast<size_t>(joint_count()));
  for (int j = 0; j < joint_count(); ++j) {
    for (size_t k = 0; k < records_.size(); ++k) {
      inliers[j].push_back(
          CountInliers(recording_.joints[j], k, options_.inlier_weight));
    }
  }
  return inliers;
}

bool EverTwo(const std::vector<int>& inliers) {
  return std::any_of(inliers.begin(), inliers.end(),
                     [](int count) { return count >= 2; });
}

void BatchEstimator::AddBones() {
  if (options_.bone_sigma_from == NoiseFrom::kRecording) {
    AddBonesOfTheRecording();
  } else {
    AddFixedBones();
  }
}

// Bones as long and as free as the views say in the frames where the estimates
// without bones trust them.
void BatchEstimator::AddBonesOfTheRecording() {
  BoneSpreads spreads(scene_.skeleton);
  if (options_.pixel_noise_from == NoiseFrom::kRecording) {
    spreads.SetLasting(noise_->correlation(), 1.0 / scene_.frame_rate_hz);
  }
  for (size_t k = 0; k < records_.size(); ++k) {
    spreads.AddFrame(LocateBoneEnds(recording_, k, options_.inlier_weight,
                                    1.0 / scene_.frame_rate_hz));
  }
  std::vector<bool> placed;
  for (const std::vector<int>& inliers : Inliers()) {
    placed.push_back(EverTwo(inliers));
  }
  recording_.bones = ConstraintsOf(spreads, placed);
  stated_bones_ = ConstraintsOf(spreads, placed, BoneUse::kCovariance);
}

// Bones between joints that two views have placed, as long as the estimates
// without bones say.
void BatchEstimator::AddFixedBones() {
  BoneLengths lengths(scene_.skeleton);
  const std::vector<std::vector<int>> inliers = Inliers();
  const std::vector<Bone>& bones = lengths.bones();
  for (size_t i = 0; i < bones.size(); ++i) {
    for (size_t k = 0; k < records_.size(); ++k) {
      if (inliers[bones[i].a][k] < 2 || inliers[bones[i].b][k] < 2) continue;
      const double distance_m =
          (recording_.joints[bones[i].a].states[k].head<3>() -
           recording_.joints[bones[i].b].states[k].head<3>())
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
    recording_.bones.push_back(
        {bones[i].a, bones[i].b, *length_m, options_.bone_sigma_m});
  }
  stated_bones_ = recording_.bones;
}

std::vector<std::vector<Eigen::Matrix3d>> BatchEstimator::Covariances() {
  std::vector<std::vector<Eigen::Matrix3d>> covariances(joint_count());
  if (!options_.covariance) return covariances;
  // The next pass asks how sure a place is, and no more.
  if (notes_ != nullptr && notes_->expects_another_pass()) {
    return solver_.JointCovariances(recording_);
  }
  // Bones that could not be solved do not count.
  const bool held = !recording_.bones.empty();
  // Bones of fixed freedom state what they always did.
  std::vector<KnownAlone> alone;
  if (held && options_.bone_sigma_from == NoiseFrom::kRecording) {
    alone = DistrustBones();
  }
  if (held) std::swap(recording_.bones, stated_bones_);
  covariances = solver_.Covariances(recording_);
  if (held) std::swap(recording_.bones, stated_bones_);
  for (const KnownAlone& one : alone) {
    std::vector<Eigen::Matrix3d>& stated = covariances[one.joint_idx];
    if (!stated.empty()) stated[one.frame] = one.covariance_m2;
  }
  solver_.FreeWorkSpace();
  return covariances;
}

void BatchEstimator::WriteFinals() {
  std::vector<std::vector<Eigen::Matrix3d>> covariances = Covariances();
  std::vector<std::vector<int>> inliers = Inliers();
  std::vector<Written> written(inliers.size());
  for (size_t j = 0; j < written.size(); ++j) {
    Written& one = written[j];
    one.inliers = std::move(inliers[j]);
    one.nearest_s = SecondsToSupport(recording_.times, one.inliers, 1);
    one.ever_two = EverTwo(one.inliers);
    if (one.ever_two) one.covariances = std::move(covariances[j]);
    covariances[j] = std::vector<Eigen::Matrix3d>();
  }
  // Poses are as large as the measurements, which only weights still need.
  if (scene_.kept_matches != KeptMatches::kWeights) {
    for (JointChain& chain : recording_.joints) chain.measurements = {};
  }
  finals_.clear();
  finals_.reserve(records_.size());
  for (const FrameRecord& record : records_) {
    finals_.push_back(PoseOf(record, joint_count(), scene_.kept_matches,
                             options_.covariance));
  }
  for (int j = 0; j < joint_count(); ++j) WriteFinalsOf(j, written[j]);
}

// A bone leaves two places on the ray of a view that alone sees its end, and a
// circle without one. While two views have just seen the joint the motion tells
// which; later the estimate may stand at the wrong one, and no covariance of
// its surroundings says so. There what is stated is what is known without
// bones.
std::vector<BatchEstimator::KnownAlone> BatchEstimator::DistrustBones() {
  constexpr double kSurelyS = 0.1;
  const auto alone = solver_.JointCovariances(recording_);
  const std::vector<std::vector<int>> inliers = Inliers();
  std::vector<KnownAlone> distrusted;
  for (size_t j = 0; j < alone.size(); ++j) {
    const std::vector<double> nearest =
        SecondsToSupport(recording_.times, inliers[j], 2);
    for (size_t k = 0; k < alone[j].size(); ++k) {
      if (nearest[k] > kSurelyS) distrusted.push_back({j, k, alone[j][k]});
    }
  }
  return distrusted;
}

void BatchEstimator::WriteFinalsOf(int joint_idx, const Written& written) {
  const JointChain& chain = recording_.joints[joint_idx];
  for (size_t k = 0; k < records_.size(); ++k) {
    const JointStatus status =
        StatusOf(written.inliers[k], written.ever_two, written.nearest_s[k],
                 options_.bridging_limit_s);
    Eigen::Matrix3d covariance;
    const bool known = k < written.covariances.size();
    if (known) {
      covariance = noise_->CovarianceFactorOf(
                       joint_idx, k, status == JointStatus::kObserved) *
                   written.covariances[k];
    }
    WriteJoint(chain, k, joint_idx, status, written.inliers[k],
               known ? &covariance : nullptr, &finals_[k].person);
  }
}

}  // namespace

std::unique_ptr<Estimator> MakeBatchEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<RecordingNotes> notes) {
  CheckGraphOptions(options);
  return std::make_unique<BatchEstimator>(scene, options, std::move(notes));
}

}  // namespace kinegraph
