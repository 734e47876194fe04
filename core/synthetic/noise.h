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
#include "core/data/pose.h"
#include "core/synthetic/scene.h"

namespace kinegraph {

// Of single joints. The variance of the pixel noise is split into a static
// share (constant over the recording for each person, view and joint), a white
// share and the rest, which is time-correlated (AR(1)); without a correlation
// time the rest is white too.
struct JointNoise {
  double sigma_px = 0.0;           // standard deviation of each axis
  double reference_depth_m = 0.0;  // pixel figures hold there and fall with
                                   // 1/depth; 0: they hold everywhere
  double floor_px = 0.0;           // white noise added at all depths
  double student_dof = 0.0;        // tails of what is not static; 0: Gaussian
  double static_share = 0.0;
  double white_share = 0.0;
  double correlation_time_s = 0.0;

  double outlier_rate = 0.0;      // share of the observed joints
  double outlier_burst_s = 0.0;   // exact length; 0: each one by itself
  double outlier_min_px = 30.0;   // distance from the truth, uniform, in a
  double outlier_max_px = 200.0;  // direction that stays for the burst
  double outlier_on_other = 0.0;  // share on the same joint of a near person

  double missing_rate = 0.0;
  double missing_burst_s = 0.0;      // mean length; 0: each by itself
  double hidden_missing_rate = 0.0;  // where another body is in front
  double hidden_noise_factor = 1.0;  // on the sigma, there

  void Describe(OptionVisitor& visitor);
};

// Table [noise]. All zero, as it comes: exact projections of all joints inside
// the images.
struct NoiseOptions {
  int64_t seed = 1;
  JointNoise joints;
  // Instead of `joints`, for classes that were measured apart.
  std::map<JointClass, JointNoise> by_class;
  // Joint name to the share of frames in which it is found, by the azimuth of
  // the camera around the person: equal bins from -180 degrees, 0 in front, +90
  // on the right-hand side. Instead of `missing_rate`.
  std::map<std::string, std::vector<double>> found_by_azimuth;

  // Confidence: a mean, less for hidden and wrong joints; each observation's
  // sigma varies by `noise_spread` (log), and its confidence tells: it falls
  // with the square of the sigma.
  double confidence = 1.0;
  double confidence_sigma = 0.0;
  double hidden_confidence_factor = 0.9;
  double outlier_confidence_factor = 0.8;
  double noise_spread = 0.0;

  // People, as shares of person-views or means per image.
  double missed_rate = 0.0;
  double missed_burst_s = 0.0;
  double hidden_missed_rate = 0.0;  // when most joints are hidden
  int64_t min_joints = 1;           // fewer found: no detection
  double false_people = 0.0;        // mean number per image
  double false_life_s = 0.24;       // mean
  double swap_whole_rate = 0.0;     // left and right exchanged
  double swap_arm_rate = 0.0;
  double swap_leg_rate = 0.0;
  double swap_burst_s = 0.0;      // mean length; 0: each frame by itself
  double fragment_rate = 0.0;     // split at the hips into two detections
  double double_rate = 0.0;       // found twice
  double fragment_burst_s = 0.0;  // of fragments and duplicates

  // Clocks.
  double dropped_frame_rate = 0.0;     // whole frames that are not there
  double dropped_view_rate = 0.0;      // single views without detections
  double drop_burst_s = 0.0;           // mean length; 0: each by itself
  std::vector<double> clock_offset_s;  // one a camera, the rest 0: it looks
                                       // this much later
  double time_jitter_s = 0.0;          // frames come off the beat by this sigma
  bool tell_times = true;  // times tell offset and jitter; else the beat

  const JointNoise& Of(JointClass joint_class) const;
  // Throws OptionError for options outside their limits.
  void Check(size_t cameras) const;
  void Describe(OptionVisitor& visitor);
};

enum class Swap { kNone, kWhole, kArm, kLeg };
enum class DetectionKind { kPerson, kUpperPart, kLowerPart, kDouble, kFalse };

// What stands behind one detection.
struct DetectionTruth {
  int person = -1;  // index in the scene; -1: nobody
  DetectionKind kind = DetectionKind::kPerson;
  Swap swap = Swap::kNone;
  std::vector<int> outliers;  // joints that are wrong by far
};

// "", "swap_whole", "swap_arm", "swap_leg", "fragment_upper", "fragment_lower",
// "double", "false_positive"; two joined by '+'.
std::string NoteOf(const DetectionTruth& truth);

// truth.frames[frame][view][detection], in the order of the DetectionSequence.
struct ObservationTruth {
  std::vector<std::vector<std::vector<DetectionTruth>>> frames;
};

// Same scene, same options, same bits. `truth` may be null. Turning one kind of
// noise on or off leaves the draws of the others as they were. Throws
// OptionError for options outside their limits.
DetectionSequence Observe(const Scene& scene, const NoiseOptions& options,
                          ObservationTruth* truth);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_NOISE_H_
