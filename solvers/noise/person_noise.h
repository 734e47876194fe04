// The noise of one person in a recording: of the detector and of the motion.
#ifndef KINEGRAPH_SOLVERS_NOISE_PERSON_NOISE_H_
#define KINEGRAPH_SOLVERS_NOISE_PERSON_NOISE_H_

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/frame_points.h"
#include "solvers/noise/information.h"
#include "solvers/noise/motion_level.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// The noise of a whole recording after learning.
struct AppliedNoise {
  struct Frame {
    TimeNs time = 0;
    // Mean variance per axis of the joint's last triangulated point, by joint.
    std::vector<double> variance_m2;
    std::vector<double> process_noise;  // by joint [m^2/s^3]
    // InformationDivisor by joint, if computed.
    std::vector<double> divisors;
  };
  struct ByClass {
    JointClassTable scale;    // factor of modelled sigmas
    JointClassTable level{};  // of motion: ln relative to the typical
    JointClassTable points;   // LagLearner::Ratios::noise
    JointClassTable lag;      // LagLearner::Ratios::lag
  };
  std::vector<Frame> frames;
  LearntNoise learnt;
  ByClass by_class;
  ConfidenceWeighting weighting;
};

// Learns the noise. The batch estimator passes the whole recording at once, the
// window estimator frame by frame.
class PersonNoise {
 public:
  // `scene` and `options` must outlive this object.
  PersonNoise(const SceneModel& scene, const GraphOptions& options);

  // Learns everything from a whole recording.
  void LearnRecording(const PersonProblem& recording);

  // Learns frame by frame: AddFrame adds the problem's frame `k`, which must
  // follow the kept frames; DropFirstFrame removes the oldest of these. The
  // detector's errors need a fit (kNow) only in frames that precede a call of
  // Apply.
  enum class Refit { kNow, kLater };
  void AddFrame(const PersonProblem& problem, size_t k, Refit refit);
  void DropFirstFrame();

  // Writes process noise, and sigmas and information, to all frames of
  // `problem`, which must be the kept frames; each only if its source in the
  // options is NoiseFrom::kRecording. For a whole recording it may be called
  // once only; nothing is learnt afterwards.
  void Apply(PersonProblem* problem);
  // Moves out the noise applied to a whole recording.
  AppliedNoise ExtractApplied();
  // Instead of learning, adopts the `noise` that an earlier pass learnt for the
  // same person: frame k, at times[k], has the noise of frame frame_of[k].
  void Adopt(const AppliedNoise& noise, const std::vector<size_t>& frame_of,
             const std::vector<TimeNs>& times);
  // After Adopt: learns the motion and the points' variances in frames `begin`
  // .. `end` - 1 again, from frames `from` .. `to` - 1, which include them; all
  // other adopted noise is unchanged.
  void LearnMotionAgain(const PersonProblem& recording, size_t from, size_t to,
                        size_t begin, size_t end);

  // Factor by which to multiply the solver's covariance of a joint in frame `k`
  // of the problem last passed to Apply; 1 if pixel noise is not learnt. If the
  // joint is not `observed`, the learnt ratios of noise and lag are not
  // applied.
  double CovarianceFactorOf(int joint_idx, size_t k, bool observed);

  LearntNoise Learnt() const;
  // Correlation of the detector's errors.
  const ErrorCorrelation& correlation() const { return correlation_; }

 private:
  using Frame = AppliedNoise::Frame;

  int joint_count() const { return scene_.skeleton.joint_count(); }
  int ClassOf(int joint_idx) const {
    return static_cast<int>(scene_.skeleton.joint_class(joint_idx));
  }
  // `place`: the frame's index among the frames used for learning.
  bool Load(const PersonProblem& problem, size_t k, int joint_idx,
            size_t place);
  void LearnPixels(const PersonProblem& problem, size_t k);
  void LearnRecordingsPixels(const PersonProblem& recording);
  void LearnCorrelation(const PersonProblem& problem, size_t k, size_t place);
  void LookBack();
  void RefreshScales();
  void Locate(const PersonProblem& problem, size_t k, size_t place);
  // Adds a frame's evidence about the levels, by group; returns their
  // likelihoods.
  std::vector<LevelChain::Vector> Count(const std::vector<Levels>& evidence);
  double FrameSeconds(size_t k) const;
  std::vector<double> LevelsOf(int group);
  // `belief_` of a group, propagated to `time`.
  LevelChain::Vector Foresee(int group, TimeNs time);
  double ProcessNoiseOf(int joint_idx, size_t k, double level,
                        double activity) const;
  void FindLevels();
  void FindProcessNoise();
  void FindLag();
  void ApplyProcessNoise(PersonProblem* problem);
  void ApplyPixelNoise(PersonProblem* problem);

  const SceneModel& scene_;
  const GraphOptions& options_;
  FrameTriangulator triangulator_;
  // During learning, which visits each frame several times: the starts of these
  // frames, [frame][joint] in a row. Otherwise empty.
  std::vector<FrameTriangulator::Start> starts_;
  ConfidenceLearner confidences_;
  bool knows_confidences_ = false;  // whether their weighting is final
  NoiseScales scales_;
  CorrelationLearner correlations_;
  const MotionGroups groups_;
  ErrorCorrelation correlation_;
  // Set once the noise of a whole recording is learnt or adopted.
  std::optional<CovarianceFactorTable> covariance_factors_;
  std::vector<FilterBank> banks_;         // by joint
  std::vector<double> last_variance_m2_;  // by joint
  bool taken_over_ = false;  // adopted: Apply keeps the process noise
  AppliedNoise::ByClass by_class_;
  std::vector<Frame> frames_;
  // For a whole recording, until its lag is known: triangulated points and the
  // variances of their axes, [frame][joint] in a row; NaN if there is no point.
  // Points are relative to the first, because float rounds georeferenced
  // positions to decimetres.
  bool keeps_points_ = false;
  std::optional<Eigen::Vector3d> origin_m_;
  std::vector<Eigen::Matrix<float, 3, 2>> points_;
  // Likelihoods of the levels by frame and group; all one if none of the
  // group's joints was triangulated.
  std::vector<std::vector<LevelChain::Vector>> likelihoods_;
  std::array<Levels, kJointClassCount> evidence_{};  // of all frames so far
  std::array<bool, kJointClassCount> present_{};     // in the skeleton
  // By group, for the frame before the first kept frame; empty for the
  // stationary belief.
  std::vector<LevelChain::Vector> belief_;
  TimeNs belief_time_ = 0;
  std::vector<LevelChain> chains_;  // by class, at the recording's level
  // Process noise of any frame interval so far [m^2/s^3], by class; 0: none.
  std::array<double, kJointClassCount> least_{};
  std::array<double, kJointClassCount> greatest_{};
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_PERSON_NOISE_H_
