// Observations of one person by one camera, frame by frame: from exact
// projections to detections with all modelled errors.
#ifndef KINEGRAPH_CORE_SYNTHETIC_PERSON_OBSERVER_H_
#define KINEGRAPH_CORE_SYNTHETIC_PERSON_OBSERVER_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/data/detection.h"
#include "core/skeleton/skeleton.h"
#include "core/synthetic/labelled_detection.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/noise_process.h"
#include "core/synthetic/sight.h"

namespace kinegraph {

class PersonObserver {
 public:
  // References must outlive the observer.
  PersonObserver(const NoiseOptions& options, const Skeleton& skeleton,
                 ImageBounds image, double frame_rate_hz, int view_idx,
                 int person_idx);

  // The next frame; `sights` are those of all people in this view.
  void Step(const std::vector<PersonSight>& sights,
            std::vector<LabelledDetection>* detections);

 private:
  struct JointState {
    bool started = false;
    Eigen::Vector2d fixed = Eigen::Vector2d::Zero();
    SlowGaussian slow;
    SlowGaussian spread;
    SlowStudentScale tails;
    MarkovBursts missing;
    FixedBursts outlier;
    Eigen::Vector2d displacement = Eigen::Vector2d::Zero();
    int other = -1;  // the person on whom the outlier lies
  };
  struct Displacement {
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    double sigma_factor = 1.0;  // what the confidence tells
  };

  double Frames(double seconds) const { return seconds * frame_rate_hz_; }
  double DepthScale(const JointNoise& noise, const JointSight& sight) const;
  bool Misses(int joint, const PersonSight& person);
  Displacement PixelNoise(int joint, const JointSight& sight);
  int NearestOther(int joint, const std::vector<PersonSight>& sights) const;
  // Whether the joint is an outlier; moves `px` then.
  bool Outlier(int joint, const std::vector<PersonSight>& sights,
               Eigen::Vector2d* px);
  Keypoint Measure(int joint, const std::vector<PersonSight>& sights,
                   bool* outlier);
  Swap ChooseSwap();
  void ExchangeSides(Swap swap, LabelledDetection* labelled) const;
  LabelledDetection PartOf(const LabelledDetection& whole,
                           DetectionKind kind) const;
  LabelledDetection SecondOf(const LabelledDetection& first);

  const NoiseOptions& options_;
  const Skeleton& skeleton_;
  ImageBounds image_;
  double frame_rate_hz_;
  int person_;
  Random pixels_;
  Random outliers_;
  Random missing_;
  Random confidence_;
  Random people_;
  MarkovBursts missed_;
  MarkovBursts swap_whole_;
  MarkovBursts swap_arm_;
  MarkovBursts swap_leg_;
  MarkovBursts fragment_;
  MarkovBursts double_;
  std::vector<JointState> joints_;
  // By joint; null where the table does not name it.
  std::vector<const std::vector<double>*> found_by_azimuth_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_PERSON_OBSERVER_H_
