// A modelled detector: noisy, incomplete, sometimes wrong 2D detections of a
// synthetic scene, and the truth about each.
#ifndef KINEGRAPH_CORE_SYNTHETIC_NOISE_H_
#define KINEGRAPH_CORE_SYNTHETIC_NOISE_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/data/detection.h"
#include "core/synthetic/scene.h"

namespace kinegraph {

// Noise of one joint. The variance of the pixel noise is split into a static
// share (constant over the recording for each person, view and joint), a white
// share and the remaining share, which is time-correlated (AR(1)), or white
// without a correlation time.
struct JointNoise {
  double sigma_px = 0.0;  // standard deviation of each axis
  // Depth to which values in pixels refer; they scale with 1/depth. 0: the same
  // at every depth.
  double reference_depth_m = 0.0;
  double floor_px = 0.0;     // white noise added at all depths
  double student_dof = 0.0;  // tails of the non-static part; 0: Gaussian
  double static_share = 0.0;
  double white_share = 0.0;
  double correlation_time_s = 0.0;

  double outlier_rate = 0.0;     // share of the observed joints
  double outlier_burst_s = 0.0;  // exact length; 0: independent
  // Distance beyond the noise, uniform, in a direction that is constant in a
  // burst (reversed where it would lead out of the image).
  double outlier_min_px = 30.0;
  double outlier_max_px = 200.0;
  double outlier_on_other = 0.0;  // share on the same joint of a nearby person

  double missing_rate = 0.0;
  double missing_burst_s = 0.0;      // mean length; 0: independent
  double hidden_missing_rate = 0.0;  // where another body is in front
  double hidden_noise_factor = 1.0;  // factor on the sigma there

  void Describe(OptionVisitor& visitor);
};

// The configuration's table [noise]. The defaults give exact projections of all
// joints inside the images.
struct NoiseOptions {
  int64_t seed = 1;
  JointNoise joints;
  // Replaces `joints` for classes that were measured separately.
  std::map<JointClass, JointNoise> by_class;

  // Confidence: a mean, lower for outliers and, if any option for hidden
  // joints or people is set, for hidden joints. Each observation's sigma has a
  // log-normal factor, whose log has the standard deviation `noise_spread`; its
  // confidence is divided by the factor's square.
  double confidence = 1.0;
  double confidence_sigma = 0.0;
  double noise_spread = 0.0;

  // People, as shares of person-views or means per image.
  double missed_rate = 0.0;
  double missed_burst_s = 0.0;
  double hidden_missed_rate = 0.0;  // when most joints are hidden
  int64_t min_joints = 1;           // with fewer found: no detection
  double false_people = 0.0;        // mean number per image
  double swap_whole_rate = 0.0;     // left and right exchanged
  double swap_arm_rate = 0.0;
  double swap_leg_rate = 0.0;
  double swap_burst_s = 0.0;      // mean length; 0: independent frames
  double fragment_rate = 0.0;     // split at the hips into two detections
  double double_rate = 0.0;       // found twice
  double fragment_burst_s = 0.0;  // of fragments and duplicates

  // Clocks.
  double dropped_frame_rate = 0.0;  // missing whole frames
  double dropped_view_rate = 0.0;   // single views without detections
  double drop_burst_s = 0.0;        // mean length; 0: independent
  // How much later each camera captures; 0 for cameras without an entry.
  std::vector<double> clock_offset_s;
  // Standard deviation of the frame times from the nominal ones.
  double time_jitter_s = 0.0;
  bool tell_times = true;  // false: nominal times, without offset and jitter

  const JointNoise& Of(JointClass joint_class) const;
  // Throws OptionError for options outside their limits.
  void Check(size_t cameras) const;
  void Describe(OptionVisitor& visitor);
};

enum class Swap { kNone, kWhole, kArm, kLeg };
enum class DetectionKind { kPerson, kUpperPart, kLowerPart, kDouble, kFalse };

// The origin of one detection.
struct DetectionTruth {
  int person = -1;  // index in the scene; -1: none
  DetectionKind kind = DetectionKind::kPerson;
  Swap swap = Swap::kNone;
  std::vector<int> outliers;  // joints with gross errors
};

// "", "swap_whole", "swap_arm", "swap_leg", "fragment_upper", "fragment_lower",
// "double", "false_positive"; two joined by '+'.
std::string NoteOf(const DetectionTruth& truth);

// truth.frames[frame][view][detection], in the order of the DetectionSequence.
struct ObservationTruth {
  std::vector<std::vector<std::vector<DetectionTruth>>> frames;
};

// The same scene and options give the same bits. `truth` may be null. Pixels,
// outliers, missing joints, confidences, people, false people, the order of
// detections, dropped frames and jitter each have their own random numbers,
// unaffected by options of the others. Throws OptionError for options outside
// their limits.
DetectionSequence Observe(const Scene& scene, const NoiseOptions& options,
                          ObservationTruth* truth);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_NOISE_H_
