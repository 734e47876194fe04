#include "solvers/window/window_estimator.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/marginalise.h"
#include "solvers/graph/outcome.h"
#include "solvers/noise/bone_spreads.h"
#include "solvers/noise/person_noise.h"
#include "solvers/noise/pixel_noise.h"
#include "solvers/person/person_solver.h"

namespace kinegraph {
namespace {

State Advance(const State& state, double dt_s) {
  State advanced = state;
  advanced.head<3>() += dt_s * state.tail<3>();
  return advanced;
}

// Frames from one solve to the next. Results change at the rate of the motion,
// not of the camera: at 120 frames per second and more, several frames share
// one solve, with at least 60 solves per second, but none waits for longer than
// the lag.
size_t SolveEvery(double frame_rate_hz, double lag_s) {
  constexpr double kSolveRateHz = 60.0;
  const double rounding = 1e-6;
  const double frames =
      std::min(frame_rate_hz / kSolveRateHz, frame_rate_hz * lag_s) + rounding;
  return static_cast<size_t>(std::max(1.0, std::floor(frames)));
}

class WindowEstimator final : public Estimator {
 public:
  WindowEstimator(const SceneModel& scene, const GraphOptions& options,
                  std::shared_ptr<RecordingNotes> notes)
      : scene_(scene),
        options_(options),
        assembler_(scene_, options_),
        solver_(options_),
        noise_(scene_, options_),
        notes_(std::move(notes)),
        learnt_(notes_->NewPerson()),
        bones_(scene_, options_),
        written_lengths_(scene_.skeleton),
        supports_(scene_.skeleton.joint_count()),
        solve_every_(SolveEvery(scene_.frame_rate_hz, options_.lag_s)),
        last_states_(scene_.skeleton.joint_count(), State::Zero()) {}

  void Add(const EstimatorFrame& frame) override {
    // The first frame is solved at once.
    const bool birth = last_.empty();
    if (birth) first_frame_ = frame.frame;
    unsolved_ = birth ? solve_every_ : unsolved_ + 1;
    records_.push_back(assembler_.Append(frame, &problem_));
    for (JointChain& chain : problem_.joints) {
      for (auto m = chain.measurements.begin() + chain.first[newest()];
           m != chain.measurements.end(); ++m) {
        m->sigma_px *= noise_scale_;
      }
    }
    if (options_.LearnsNoise()) {
      noise_.AddFrame(
          problem_, newest(),
          IsDue() ? PersonNoise::Refit::kNow : PersonNoise::Refit::kLater);
    }
    const std::vector<bool> placed_anew = StartNewStates();
    DropFinalFrames();
    PlaceAnew(placed_anew);
    if (!IsDue()) return;
    Solve();
    UpdateLast();
    const size_t end = DueEnd();
    if (end > final_count_) Emit(end);
  }
  const Pose3d& Last() const override { return last_; }
  TimeNs LastTime() const override { return last_time_; }

  void Predict(TimeNs time, Pose3d* pose) const override {
    *pose = last_;
    const double dt_s = ToSeconds(time - last_time_);
    for (size_t j = 0; j < pose->size(); ++j) {
      Joint3d& joint = (*pose)[j];
      if (!joint.present()) continue;
      joint.position_m = Advance(last_states_[j], dt_s).head<3>();
      joint.status = JointStatus::kInferred;
    }
  }

  void ExtractFinals(std::vector<FinalPose>* finals) override {
    MoveFinals(&finals_, finals);
  }

  void Finish() override {
    if (unsolved_ > 0) Solve();
    if (final_count_ < records_.size()) Emit(records_.size());
    if (options_.LearnsNoise()) {
      *learnt_ = noise_.Learnt();
      VLOG(1) << ToString(*learnt_);
    }
    VLOG(1) << "noise scale " << noise_scale_;
    if (!records_.empty()) {
      solver_.HandInCounts(first_frame_, records_.back().frame);
    }
  }

 private:
  int joint_count() const { return scene_.skeleton.joint_count(); }
  size_t newest() const { return records_.size() - 1; }
  // Whether a solve is due: after solve_every_ frames, or after their duration
  // where frames are missing.
  bool IsDue() const {
    if (unsolved_ >= solve_every_) return true;
    const double frames = static_cast<double>(solve_every_) - 0.5;
    return records_.back().time - solved_time_ >=
           FromSeconds(frames / scene_.frame_rate_hz);
  }

  void Solve() {
    if (options_.LearnsNoise()) noise_.Apply(&problem_);
    if (options_.bones) {
      solver_.SolveJoints(solver_.schedule(), &problem_);
      SolveBones();
      solver_.Refine(&problem_);
    } else {
      solver_.SolveJointsAndRefine(&problem_);
    }
    unsolved_ = 0;
    solved_time_ = problem_.times.back();
  }

  // A new state starts where the frame's own views triangulate the joint, else
  // at the prediction, with the previous velocity. A joint that was missing in
  // the last frame but is triangulated in this one starts there at rest;
  // returns which joints these are.
  std::vector<bool> StartNewStates() {
    std::vector<bool> placed_anew(joint_count(), false);
    if (records_.size() < 2) return placed_anew;
    const size_t k = newest();
    const double dt_s = ToSeconds(problem_.times[k] - problem_.times[k - 1]);
    for (int j = 0; j < joint_count(); ++j) {
      JointChain& chain = problem_.joints[j];
      placed_anew[j] = records_[k].triangulated[j] &&
                       StatusAt(k - 1, j) == JointStatus::kMissing;
      if (placed_anew[j]) continue;
      const Eigen::Vector3d triangulated = chain.states[k].head<3>();
      chain.states[k] = Advance(chain.states[k - 1], dt_s);
      if (records_[k].triangulated[j]) {
        chain.states[k].head<3>() = triangulated;
      }
    }
    return placed_anew;
  }

  // Sets all states of these joints in the window to their newest one.
  void PlaceAnew(const std::vector<bool>& joints) {
    for (int j = 0; j < joint_count(); ++j) {
      if (!joints[j]) continue;
      JointChain& chain = problem_.joints[j];
      const State start = chain.states.back();
      std::fill(chain.states.begin(), chain.states.end(), start);
    }
  }

  void DropFinalFrames() {
    for (; final_count_ > 0; --final_count_) {
      for (int j = 0; j < joint_count(); ++j) {
        Extend(problem_.times[0],
               CountInliers(problem_.joints[j], 0, options_.inlier_weight),
               &supports_[j]);
      }
      DropFirstFrame(solver_.correction(), &problem_);
      if (options_.LearnsNoise()) noise_.DropFirstFrame();
      records_.erase(records_.begin());
    }
  }

  void UpdateLast() {
    const bool birth = last_.empty();
    // The newest frame with views; several frames may share the solve.
    size_t k = newest();
    while (k > 0 && records_[k].views.empty()) --k;
    const bool measured = !records_[k].views.empty();
    if (!birth && (!measured || records_[k].time <= last_time_)) return;
    last_.resize(joint_count());
    last_time_ = records_[k].time;
    for (int j = 0; j < joint_count(); ++j) {
      last_states_[j] = problem_.joints[j].states[k];
      last_[j].position_m = last_states_[j].head<3>();
      last_[j].status = StatusAt(k, j);
    }
  }

  void SolveBones() {
    // Bones are learnt from estimates without bones, of frames that are about
    // to become final.
    const size_t end = DueEnd();
    for (size_t k = final_count_; k < end; ++k) bones_.AddFrame(problem_, k);
    std::vector<bool> placed(joint_count());
    for (int j = 0; j < joint_count(); ++j) {
      placed[j] = StatusAt(newest(), j) != JointStatus::kMissing;
    }
    bones_.SetLasting(noise_.correlation());
    problem_.bones = bones_.Constraints(placed);
    solver_.SolveBones(&problem_);
  }

  // End of the frames that are old enough to be final.
  size_t DueEnd() const {
    // No frame waits for longer than the lag, including those waiting for the
    // next solve. Half a millisecond is a tolerance for rounded times.
    const double next_s =
        static_cast<double>(solve_every_ - 1) / scene_.frame_rate_hz;
    const TimeNs lag = FromSeconds(options_.lag_s - next_s - 5e-4);
    size_t end = final_count_;
    while (end < records_.size() &&
           problem_.times.back() - problem_.times[end] >= lag) {
      ++end;
    }
    return end;
  }

  // Updates the factor on all sigmas of the window if it changes by 2 % or
  // more.
  void LearnNoiseScale(const std::vector<double>& squares) {
    constexpr double kWorthIt = 0.02;
    learnt_scale_.Add(squares, noise_scale_);
    const double change = learnt_scale_.scale() / noise_scale_;
    if (std::abs(change - 1.0) < kWorthIt) return;
    ScaleSigmas(change, &problem_);
    noise_scale_ *= change;
  }

  // Makes the frames final_count_ .. end - 1 final.
  void Emit(size_t end) {
    const size_t offset = finals_.size();
    for (size_t k = final_count_; k < end; ++k) {
      finals_.push_back(PoseOf(records_[k], scene_, /*covariances=*/true));
    }
    const bool coupled = problem_.coupled();
    const bool learns =
        options_.EstimatesNoiseScale() && learnt_scale_.AwaitTurn();
    std::vector<double> squares;
    const std::vector<std::vector<Matrix6d>> covariances =
        coupled ? solver_.BoneCovariances(problem_, end)
                : solver_.JointCovariances(problem_, solver_.correction(), end);
    for (int j = 0; j < joint_count(); ++j) {
      if (learns && covariances[j].size() >= end) {
        CollectSquares(problem_.joints[j], covariances[j], final_count_, end,
                       &squares);
      }
      for (size_t k = final_count_; k < end; ++k) {
        Eigen::Matrix3d covariance;
        const bool known = k < covariances[j].size();
        if (known) {
          covariance = noise_.CovarianceFactorOf(
                           j, k, StatusAt(k, j) == JointStatus::kObserved) *
                       covariances[j][k].topLeftCorner<3, 3>();
        }
        WriteJoint(problem_.joints[j], k, j, StatusAt(k, j), InliersAt(k, j),
                   known ? &covariance : nullptr,
                   &finals_[offset + k - final_count_].person);
      }
    }
    for (size_t i = offset; i < finals_.size(); ++i) {
      written_lengths_.AddPose(finals_[i].person.joints,
                               1.0 / scene_.frame_rate_hz);
      DropUnsureJoints(written_lengths_.Known(), &finals_[i].person);
      if (!options_.covariance) finals_[i].person.covariances.clear();
    }
    final_count_ = end;
    if (learns) LearnNoiseScale(squares);
  }

  JointStatus StatusAt(size_t k, int joint_idx) const {
    const JointChain& chain = problem_.joints[joint_idx];
    JointSupport support = supports_[joint_idx];
    double nearest_s = std::numeric_limits<double>::infinity();
    if (support.by_one_view) {
      nearest_s = ToSeconds(problem_.times[k] - support.last_time);
    }
    for (size_t i = 0; i + 1 < chain.first.size(); ++i) {
      const int count = InliersAt(i, joint_idx);
      if (count == 0) continue;
      Extend(problem_.times[i], count, &support);
      const TimeNs away = problem_.times[k] - problem_.times[i];
      nearest_s = std::min(nearest_s, ToSeconds(away < 0 ? -away : away));
    }
    return StatusOf(InliersAt(k, joint_idx), support.by_two_views, nearest_s,
                    options_.bridging_limit_s);
  }
  int InliersAt(size_t k, int joint_idx) const {
    return CountInliers(problem_.joints[joint_idx], k, options_.inlier_weight);
  }

  const SceneModel scene_;
  const GraphOptions options_;
  Assembler assembler_;
  PersonSolver solver_;
  PersonProblem problem_;
  PersonNoise noise_;
  const std::shared_ptr<RecordingNotes> notes_;
  const std::shared_ptr<LearntNoise> learnt_;
  PersonBones bones_;
  BoneLengths written_lengths_;  // for final poses
  CausalNoiseScale learnt_scale_;
  // Factor applied to the problem's sigmas.
  double noise_scale_ = 1.0;
  std::vector<FrameRecord> records_;    // one per problem_.times
  std::vector<JointSupport> supports_;  // over frames that left the window
  int64_t first_frame_ = 0;             // of this person
  const size_t solve_every_;            // in frames
  // Number of newest records_ added since the last solve.
  size_t unsolved_ = 0;
  TimeNs solved_time_ = 0;  // of the newest frame in the last solve
  // Number of oldest records_ that are already final.
  size_t final_count_ = 0;
  std::vector<FinalPose> finals_;
  Pose3d last_;
  std::vector<State> last_states_;
  TimeNs last_time_ = 0;
};

}  // namespace

std::unique_ptr<Estimator> MakeWindowEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<RecordingNotes> notes) {
  CheckGraphOptions(options);
  if (notes == nullptr) notes = std::make_shared<RecordingNotes>(options);
  return std::make_unique<WindowEstimator>(scene, options, std::move(notes));
}

}  // namespace kinegraph
