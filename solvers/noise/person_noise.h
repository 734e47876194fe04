// What a recording tells of its own noise: the detector's and the motion's, of
// one person.
#ifndef KINEGRAPH_SOLVERS_NOISE_PERSON_NOISE_H_
#define KINEGRAPH_SOLVERS_NOISE_PERSON_NOISE_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/frame_points.h"
#include "solvers/noise/information.h"
#include "solvers/noise/motion_level.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// What a whole recording's noise is, once it is learnt.
struct AppliedNoise {
  struct Frame {
    TimeNs time = 0;
    std::vector<double> variance_m2;  // by joint: of the located point, an axis
    std::vector<double> process_noise;  // by joint [m^2/s^3]
    // By joint, as far as they were found (InformationDivisor).
    std::vector<double> divisors;
  };
  struct ByClass {
    JointClassTable scale;   // on modelled sigmas
    JointClassTable level;   // of motion, ln over the usual
    JointClassTable points;  // LagLearner's ratios
    JointClassTable lag;
  };
  std::vector<Frame> frames;
  LearntNoise learnt;
  ByClass by_class;
  ConfidenceWeighting weighting;
};

// The batch gives it the whole recording at once, the window frame by frame.
class PersonNoise {
 public:
  // `scene` and `options` must outlive it.
  PersonNoise(const SceneModel& scene, const GraphOptions& options);

  // Everything from a whole recording.
  void LearnRecording(const PersonProblem& recording);

  // From what was seen so far: the problem's frame `k`, which follows those
  // that are kept; and how to forget the oldest of those. What the detector's
  // errors are is fitted in frames before Apply, and in those alone.
  enum class Refit { kNow, kLater };
  void AddFrame(const PersonProblem& problem, size_t k, Refit refit);
  void DropFirstFrame();

  // Writes process noise, sigmas and information of all frames of `problem`,
  // which are those kept here. To a whole recording once: then nothing more is
  // learnt.
  void Apply(PersonProblem* problem);
  // What was applied to a whole recording; nothing is left here.
  AppliedNoise ExtractApplied();
  // In place of learning: `noise` of the same person, whose frame frame_of[k]
  // is the one that stands at times[k].
  void Adopt(const AppliedNoise& noise, const std::vector<size_t>& frame_of,
             const std::vector<TimeNs>& times);
  // Motion in frames begin .. end - 1 anew, from frames from .. to - 1 around
  // them; the rest of what was taken over stays.
  void LearnMotionAgain(const PersonProblem& recording, size_t from, size_t to,
                        size_t begin, size_t end);

  // On the covariance of that joint, in a frame that Apply has seen. Where the
  // joint is not `observed` both ratios are 1.
  double CovarianceFactorOf(int joint_idx, size_t k, bool observed);

  LearntNoise Learnt() const;
  // How long the detector's errors last.
  const ErrorCorrelation& correlation() const { return correlation_; }

 private:
  using Frame = AppliedNoise::Frame;

  int joint_count() const { return scene_.skeleton.joint_count(); }
  int ClassOf(int joint_idx) const {
    return static_cast<int>(scene_.skeleton.joint_class(joint_idx));
  }
  // `place` is the frame's among those that are learnt from.
  bool Load(const PersonProblem& problem, size_t k, int joint_idx,
            size_t place);
  void LearnPixels(const PersonProblem& problem, size_t k);
  void LearnRecordingsPixels(const PersonProblem& recording);
  void LearnCorrelation(const PersonProblem& problem, size_t k, size_t place);
  void LookBack();
  void RefreshScales();
  void Locate(const PersonProblem& problem, size_t k, size_t place);
  // Counts a frame's evidence of the levels, by group; returns their
  // likelihoods.
  std::vector<LevelChain::Vector> Count(const std::vector<Levels>& evidence);
  double FrameSeconds(size_t k) const;
  std::vector<double> LevelsOf(int group);
  // `belief_` of that group, carried on to `time`.
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
  // While frames are learnt from, which looks at each several times: of those
  // frames, [frame][joint] in a row. Else empty.
  std::vector<FrameTriangulator::Start> starts_;
  ConfidenceLearner confidences_;
  bool knows_confidences_ = false;  // all that there is to know
  NoiseScales scales_;
  CorrelationLearner correlations_;
  const MotionGroups groups_;
  ErrorCorrelation correlation_;
  std::optional<CovarianceFactorTable>
      covariance_factors_;                // of a whole recording
  std::vector<FilterBank> banks_;         // by joint
  std::vector<double> last_variance_m2_;  // by joint
  bool taken_over_ = false;  // nothing is found anew when it is applied
  AppliedNoise::ByClass by_class_;
  std::vector<Frame> frames_;
  // Of a whole recording, until its lag is known: located points and the
  // variances of their axes, [frame][joint] in a row; NaN: none.
  bool keeps_points_ = false;
  std::vector<Eigen::Matrix<float, 3, 2>> points_;
  // Of the levels in the same frames, by group; where no joint of it was
  // located all one.
  std::vector<std::vector<LevelChain::Vector>> likelihoods_;
  std::array<Levels, kJointClassCount> evidence_{};  // of all frames ever
  std::array<bool, kJointClassCount> present_{};     // in the skeleton
  // By group, of the frame before the first kept one; empty: the stationary
  // belief.
  std::vector<LevelChain::Vector> belief_;
  TimeNs belief_time_ = 0;
  std::vector<LevelChain> chains_;  // by class, at the recording's level
  std::array<double, kJointClassCount> least_{};
  std::array<double, kJointClassCount> greatest_{};
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_PERSON_NOISE_H_
