// How long a tracked person's limbs are, and so how tall the person is.
#ifndef KINEGRAPH_SOLVERS_SESSION_LIMBS_H_
#define KINEGRAPH_SOLVERS_SESSION_LIMBS_H_

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "core/data/pose.h"
#include "core/skeleton/skeleton.h"
#include "solvers/session/stream_sample.h"

namespace kinegraph {

inline constexpr size_t kLimbCount = 4;

// Lengths [m] of one person's limbs, left and right, and of the trunk.
struct LimbSamples {
  std::array<std::array<StreamSample, 2>, kLimbCount> limbs;
  StreamSample trunk;
};

struct LimbFigures {
  double height_m = 0.0;         // 0: too few limbs were seen
  double bone_spread = 0.0;      // median over limbs of (p90 - p10) / median
  double side_difference = 0.0;  // of left and right limbs, relative, mean
};
LimbFigures FiguresOf(const LimbSamples& samples);

// Where limbs are in the poses of a skeleton; one that is no human's has none.
class Limbs {
 public:
  explicit Limbs(const Skeleton& skeleton);

  // Adds what was observed in a pose.
  void See(const Pose3d& pose, LimbSamples* samples) const;
  // Stature that one pose tells [m]; nullopt where too little was observed.
  std::optional<double> HeightOf(const Pose3d& pose) const;
  // Between two hips that were observed.
  std::optional<Eigen::Vector3d> MiddleOfHips(const Pose3d& pose) const;

 private:
  // Joints; -1 where the skeleton has none.
  struct Sides {
    int left = -1;
    int right = -1;
  };
  struct Ends {
    Sides a;
    Sides b;
  };
  static Sides SidesOf(const Skeleton& skeleton, const std::string& part);
  static std::optional<Eigen::Vector3d> Middle(const Pose3d& pose,
                                               const Sides& sides);

  std::array<Ends, kLimbCount> limbs_;
  Sides hips_;
  Sides shoulders_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_LIMBS_H_
