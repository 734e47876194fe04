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
#include "solvers/batch/recording_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/outcome.h"
#include "solvers/noise/bias_learner.h"
#include "solvers/noise/bone_spreads.h"
#include "solvers/noise/person_noise.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {
namespace {

// A smaller relative change of the noise scale does not justify another solve.
constexpr double kLeastChange = 0.02;

// Linear interpolation of the starts between triangulated frames; constant
// before the first and after the last.
void InterpolateStarts(const std::vector<FrameRecord>& records, int joint_idx,
                       const std::vector<TimeNs>& times, JointChain* chain) {
  std::optional<size_t> previous;
  for (size_t k = 0; k < records.size(); ++k) {
    if (!records[k].triangulated[joint_idx]) continue;
    const size_t first = previous.has_value() ? *previous + 1 : 0;
    const Eigen::Vector3d to = chain->states[k].head<3>();
    const Eigen::Vector3d from = chain->states[previous.value_or(k)].head<3>();
    for (size_t i = first; i < k; ++i) {
      const double share = previous.has_value()
                               ? ToSeconds(times[i] - times[*previous]) /
                                     ToSeconds(times[k] - times[*previous])
                               : 0.0;
      chain->states[i].head<3>() = from + share * (to - from);
    }
    previous = k;
  }
  // Never triangulated: all stay at the person's centre.
  if (!previous.has_value()) return;
  for (size_t i = *previous + 1; i < records.size(); ++i) {
    chain->states[i].head<3>() = chain->states[*previous].head<3>();
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

bool EverTwo(const std::vector<int>& inliers) {
  return std::any_of(inliers.begin(), inliers.end(),
                     [](int count) { return count >= 2; });
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
        bias_(notes_->view_bias()),
        series_(notes_->NewSeries(bias_joints_,
                                  static_cast<int>(scene_.cameras.size()))),
        learnt_(notes_->NewPerson()) {}

  void Add(const EstimatorFrame& frame) override {
    frames_.Push(frame);
    if (frame.has_initial || frames_.size() == 1) {
      last_ = frame.initial;
      last_.resize(joint_count());
      last_time_ = frame.time;
    }
  }
  const Pose3d& Last() const override { return last_; }
  TimeNs LastTime() const override { return last_time_; }

  void Predict(TimeNs, Pose3d* pose) const override {
    ExpectUnmoved(last_, pose);
  }

  void ExtractFinals(std::vector<FinalPose>* finals) override {
    MoveFinals(&finals_, finals);
  }

  void Finish() override {
    if (frames_.empty()) return;
    Solve();
    if (series_ != nullptr) {
      AddBiasResiduals(bias_joints_, scene_.cameras, scene_.frame_rate_hz,
                       noise_->correlation(), recording_, series_.get());
    }
    const std::shared_ptr<SolvedPerson> solution = Solution();
    WriteFinals();
    solver_.HandInCounts(records_.front().frame, records_.back().frame);
    if (solution != nullptr) {
      solution->noise = noise_->ExtractApplied();
      solution->records = std::move(records_);
      notes_->Keep(solution);
    }
    // This object lives until its final poses are written, which may wait for
    // other people; the rest of its memory is freed now.
    recording_ = {};
    stated_bones_.clear();
    noise_.reset();
    records_ = std::vector<FrameRecord>();
    solver_.FreeWorkSpace();
  }

 private:
  int joint_count() const { return scene_.skeleton.joint_count(); }

  void Assemble() {
    Assembler assembler(scene_, options_);
    records_.reserve(frames_.size());
    while (!frames_.empty()) {
      records_.push_back(assembler.Append(frames_.Pop(), &recording_));
    }
    for (int j = 0; j < joint_count(); ++j) {
      InterpolateStarts(records_, j, recording_.times, &recording_.joints[j]);
    }
  }

  void Solve() {
    Assemble();
    if (bias_ != nullptr && !bias_->empty()) {
      WriteBias(bias_joints_, *bias_, records_, &recording_);
    }
    if (SolveAgain()) return;
    if (options_.LearnsNoise()) LearnNoise();
    if (options_.EstimatesNoiseScale()) {
      LearnNoiseScale();
    } else {
      solver_.SolveJoints(solver_.schedule(), &recording_);
    }
    if (options_.bones) AddBones();
    solver_.SolveTogether(&recording_);
  }

  // Reuses the previous pass's result for this person and solves only where
  // matches changed. False if that pass has no such person.
  bool SolveAgain() {
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
      *learnt_ = before.noise.learnt;
    }
    recording_.bones = before.bones;
    stated_bones_ = before.stated_bones;
    if (!solver_.SolveAnew(changed, &recording_)) recording_.bones.clear();
    for (const Chunk& chunk : changed) {
      std::fill(known->same.begin() + chunk.own_begin,
                known->same.begin() + chunk.own_end, 0);
    }
    PasteKnown(*known, &recording_);
    notes_->Forget(&before);
    return true;
  }

  // Data for reuse of this result by the next pass; null if no other pass is
  // expected or the result cannot be reused.
  std::shared_ptr<SolvedPerson> Solution() const {
    if (!notes_->expects_another_pass()) return nullptr;
    // Not reusable where the result depends on more than the matches nearby:
    // the noise scale depends on all residuals, user factors may depend on the
    // initial pose. A result is not reused either if a chunk was solved without
    // its bones.
    if (options_.EstimatesNoiseScale() || options_.user_factors ||
        !solver_.KeptBones()) {
      return nullptr;
    }
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

  // Scales all sigmas to fit the residuals after the stage. Returns false,
  // without scaling, if they would change by a fraction of `least_change` or
  // less.
  bool RescaleNoise(const SolveStage& stage, double least_change) {
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

  // Solves the joints with one estimated factor on all sigmas.
  void LearnNoiseScale() {
    const SolveSchedule& whole = solver_.schedule();
    // The first stage is convex: its residuals do not depend on the start.
    SolveSchedule first = whole;
    first.stages.resize(1);
    first.doubt_unsettled = false;
    solver_.SolveJoints(first, &recording_);
    RescaleNoise(first.stages.front(), 0.0);
    // Residuals of the whole schedule separate outliers better. Starts with the
    // convex stage again, because a redescending loss must not start from an
    // earlier estimate (MakeSchedule).
    solver_.SolveJoints(whole, &recording_);
    if (RescaleNoise(whole.stages.back(), kLeastChange)) {
      solver_.SolveJoints(whole, &recording_);
    }
  }

  // Learns the bones from the estimates without bones.
  void AddBones() {
    PersonBones bones(scene_, options_);
    bones.SetLasting(noise_->correlation());
    for (size_t k = 0; k < records_.size(); ++k) bones.AddFrame(recording_, k);
    std::vector<bool> placed;
    for (const std::vector<int>& inliers : Inliers()) {
      placed.push_back(EverTwo(inliers));
    }
    recording_.bones = bones.Constraints(placed);
    stated_bones_ = bones.Constraints(placed, BoneUse::kCovariance);
  }

  std::vector<std::vector<Eigen::Matrix3d>> Covariances() {
    // The next pass needs only an uncertainty of each position, for which
    // covariances without bones suffice.
    if (notes_->expects_another_pass()) {
      return solver_.JointCovariances(recording_);
    }
    // The recording has no bones if their solve failed; covariances must not
    // include them then.
    const bool held = !recording_.bones.empty();
    if (held) std::swap(recording_.bones, stated_bones_);
    std::vector<std::vector<Eigen::Matrix3d>> covariances =
        solver_.Covariances(recording_);
    if (held) std::swap(recording_.bones, stated_bones_);
    // With fixed bone sigmas the covariances are reported unchanged.
    if (held && options_.bone_sigma_from == NoiseFrom::kRecording) {
      DistrustBones(&covariances);
    }
    solver_.FreeWorkSpace();
    return covariances;
  }

  void LearnNoise() {
    noise_->LearnRecording(recording_);
    noise_->Apply(&recording_);
    *learnt_ = noise_->Learnt();
    VLOG(1) << ToString(*learnt_);
  }

  void WriteFinals() {
    std::vector<std::vector<Eigen::Matrix3d>> covariances = Covariances();
    const std::vector<std::vector<int>> inliers = Inliers();
    // The final poses take as much memory as the measurements, which are still
    // needed only where poses contain the weights.
    if (scene_.kept_matches != KeptMatches::kWeights) {
      for (JointChain& chain : recording_.joints) {
        // clear() would keep the memory.
        chain.measurements = decltype(chain.measurements)();
      }
    }
    finals_.clear();
    finals_.reserve(records_.size());
    for (const FrameRecord& record : records_) {
      finals_.push_back(PoseOf(record, scene_, /*covariances=*/true));
    }
    for (int j = 0; j < joint_count(); ++j) {
      const std::vector<double> nearest_s =
          SecondsToSupport(recording_.times, inliers[j], 1);
      const bool ever_two = EverTwo(inliers[j]);
      if (!ever_two) covariances[j].clear();
      for (size_t k = 0; k < records_.size(); ++k) {
        const JointStatus status = StatusOf(
            inliers[j][k], ever_two, nearest_s[k], options_.bridging_limit_s);
        const bool known = k < covariances[j].size();
        if (known) {
          covariances[j][k] *= noise_->CovarianceFactorOf(
              j, k, status == JointStatus::kObserved);
        }
        WriteJoint(recording_.joints[j], k, j, status, inliers[j][k],
                   known ? &covariances[j][k] : nullptr, &finals_[k].person);
      }
      covariances[j] = std::vector<Eigen::Matrix3d>();
    }
    DropUnsure();
  }

  // Marks uncertain joints of the final poses as missing (DropUnsureJoints), by
  // bone lengths from the frames in which both ends were observed. Then removes
  // the covariances if the options do not request them.
  void DropUnsure() {
    BoneLengths lengths(scene_.skeleton);
    for (const FinalPose& one : finals_) {
      lengths.AddPose(one.person.joints, 1.0 / scene_.frame_rate_hz);
    }
    const std::vector<KnownBone> bones = lengths.Known();
    for (FinalPose& one : finals_) {
      DropUnsureJoints(bones, &one.person);
      if (options_.covariance) continue;
      // clear() would keep the memory.
      one.person.covariances = decltype(one.person.covariances)();
    }
  }

  // A bone leaves a joint seen by one view two possible positions on its ray,
  // and a joint seen by no view a whole sphere. Shortly before or after two
  // views saw the joint, its motion determines which position is correct;
  // elsewhere the estimate may be wrong, which a local covariance cannot
  // express. There the covariance without bones is reported.
  void DistrustBones(std::vector<std::vector<Eigen::Matrix3d>>* stated) {
    constexpr double kSurelyS = 0.1;
    const std::vector<std::vector<Eigen::Matrix3d>> alone =
        solver_.JointCovariances(recording_);
    const std::vector<std::vector<int>> inliers = Inliers();
    for (size_t j = 0; j < alone.size(); ++j) {
      if ((*stated)[j].empty()) continue;
      const std::vector<double> nearest =
          SecondsToSupport(recording_.times, inliers[j], 2);
      for (size_t k = 0; k < alone[j].size(); ++k) {
        if (nearest[k] > kSurelyS) (*stated)[j][k] = alone[j][k];
      }
    }
  }

  // Numbers of inlier views [joint][frame].
  std::vector<std::vector<int>> Inliers() const {
    std::vector<std::vector<int>> inliers(static_cast<size_t>(joint_count()));
    for (int j = 0; j < joint_count(); ++j) {
      for (size_t k = 0; k < records_.size(); ++k) {
        inliers[j].push_back(
            CountInliers(recording_.joints[j], k, options_.inlier_weight));
      }
    }
    return inliers;
  }

  const SceneModel scene_;
  const GraphOptions options_;
  RecordingSolver solver_;
  PackedFrames frames_;      // until Finish
  PersonProblem recording_;  // during Finish
  // Replace the bones of recording_ where covariances are computed.
  std::vector<BoneConstraint> stated_bones_;
  std::optional<PersonNoise> noise_;  // until Finish ends
  const std::shared_ptr<RecordingNotes> notes_;
  const BiasJoints bias_joints_;
  // The bias to subtract; null: none.
  const std::shared_ptr<const ViewBias> bias_;
  const std::shared_ptr<BiasSeries> series_;
  const std::shared_ptr<LearntNoise> learnt_;
  std::vector<FrameRecord> records_;
  std::vector<FinalPose> finals_;
  Pose3d last_;
  TimeNs last_time_ = 0;
};

}  // namespace

std::unique_ptr<Estimator> MakeBatchEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<RecordingNotes> notes) {
  CheckGraphOptions(options);
  if (notes == nullptr) notes = std::make_shared<RecordingNotes>(options);
  return std::make_unique<BatchEstimator>(scene, options, std::move(notes));
}

}  // namespace kinegraph
