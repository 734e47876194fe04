// Determines whether a smoothing strategy removes motion or keeps noise, joint
// by joint, without ground truth.
//
// A detection u of a camera that was left out, the triangulation b of the other
// cameras' detections and the strategy's estimate a from the same detections
// contain the same motion m; the errors of u are independent of those of a and
// b. Expectations over segments of time therefore give these spectra:
//   S = E[u* b]                 the motion's power
//   N = E[b* b] - S             the power of the triangulation's errors
//   D = E[a* a] - 2 Re E[u* a] + S = E[|a - m|^2]      the strategy's error
// which consists of the motion that it removes or delays, |S - E[u* a]|^2 / S,
// and of the noise that it keeps, the remainder. A linear filter of the
// triangulation attains W = S N / (S + N) (Wiener, 1949). Errors that are
// common to all cameras count as motion.
#ifndef KINEGRAPH_CORE_EVALUATION_SMOOTHING_BALANCE_H_
#define KINEGRAPH_CORE_EVALUATION_SMOOTHING_BALANCE_H_

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/frame_range.h"
#include "core/base/ids.h"
#include "core/data/detection.h"
#include "core/data/held_out.h"
#include "core/data/pose.h"
#include "core/evaluation/tapered_transform.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// A joint of one person in consecutive frames. In the world: its position [m].
// In an image: x and y [px], and metres per pixel at the joint's depth (0 for
// detections). NaN where missing.
struct JointTrace {
  int64_t begin = 0;  // the first frame
  std::vector<Eigen::Vector3d> points;
};
// Keyed by person and joint of the tracks' skeleton.
using JointTraces = std::map<std::pair<TrackId, int>, JointTrace>;

JointTraces WorldTraces(const TrackSequence& tracks,
                        const std::vector<FrameRange>& frames);
JointTraces ImageTraces(const TrackSequence& tracks, const Camera& camera,
                        const std::vector<FrameRange>& frames);
// The detections of that view in the set, which must ascend by frame, by the
// joints of `skeleton`.
JointTraces DetectedTraces(const HeldOutSet& set,
                           const DetectionSequence& detections, int view_idx,
                           const Skeleton& skeleton);

// For one joint, or for all: root mean squares [m] of the variation within a
// segment, over the two axes of images or the three of the world together. NaN
// without enough data.
struct SmoothingBalance {
  // The larger part of the error beyond the attainable one.
  enum class Excess {
    kMotionRemoved,  // or delayed
    kNoiseKept,
  };

  int64_t segments = 0;
  double error_m = 0.0;       // of the strategy, from D
  double removed_m = 0.0;     // motion removed or delayed
  double kept_m = 0.0;        // noise kept
  double attainable_m = 0.0;  // from W
  Excess excess = Excess::kNoiseKept;
  // Whether the error is significantly (99 %) greater than 1.35 times the
  // attainable one. The tested estimate lacks one camera. According to the
  // ground truth, for 99 % of such joints the estimate from all cameras then
  // exceeds its attainable error by a quarter or more (research/cutoff_rules
  // prints the count).
  bool is_excessive = false;
};

// Spectra of segments of one second, at least eight frames, with half overlap,
// each detrended and tapered by a Hann window (Welch, 1967), in bands of half
// an octave. A segment counts if at most a fifth of its frames and no more than
// 0.1 s in a row lack one of the three signals, or have a detection farther
// than 0.25 m from the triangulation; these frames are interpolated.
class SmoothingSpectra {
 public:
  explicit SmoothingSpectra(double rate_hz);

  // `reference`: positions whose errors are independent of those of `raw` and
  // `smoothed`, or the truth. `view`: the camera, if the traces are of its
  // images.
  void Add(const JointTraces& reference, const JointTraces& raw,
           const JointTraces& smoothed, std::optional<int> view);
  // Adds the spectra of other cameras.
  void Merge(const SmoothingSpectra& other);

  // The balance of a joint over all people. The excess of the squared error
  // over the attainable one counts as noise kept if E[a* a] - |E[u* a]|, summed
  // over the bands, is at least half of the excess: the sum is 0 for the Wiener
  // filter and at most 0 if motion is removed or delayed and no noise kept.
  SmoothingBalance OfJoint(int joint) const;

 private:
  // Sums over the axes of one segment, in one band.
  struct Band {
    double motion = 0.0;                 // u* b, real part
    std::complex<double> removed = 0.0;  // u* (b - a)
    double raw = 0.0;                    // b* b
    double smoothed = 0.0;               // a* a
  };
  using Segment = std::vector<Band>;

  Segment SegmentOf(const std::array<Eigen::MatrixXd, 3>& signals) const;

  int half_ = 0;     // frames of half a segment
  int longest_ = 0;  // frames in a row that are interpolated
  TaperedTransform transform_;
  std::vector<int> band_of_;  // one per bin
  int band_count_ = 0;
  // Keyed by joint, person, view and first frame.
  std::map<std::tuple<int, TrackId, int, int64_t>, Segment> segments_;
};

// Over all joints, each weighted by its segments; never excessive.
SmoothingBalance PooledBalance(const std::vector<SmoothingBalance>& joints);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_SMOOTHING_BALANCE_H_
