// From any skeleton to the 14 joints of the Campus and Shelf ground truth.
//
// Detectors find a nose and ears, the annotation has the bottom and the top of
// the head. Publications differ in how they make one from the other, and the
// choice alone can move a PCP by a percent; so it is named.
#ifndef KINEGRAPH_CORE_EVALUATION_HEAD_CONVERSION_H_
#define KINEGRAPH_CORE_EVALUATION_HEAD_CONVERSION_H_

#include <optional>
#include <string>
#include <vector>

#include "core/data/pose.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// With m = middle of the shoulders, n = nose, e = middle of the ears; products
// are taken axis by axis in the world (z up), as the published ones are.
enum class HeadConversion {
  // top = m + (n - m) * (0.78, 0.5, 1.5), bottom = m + (n - m) * (0.3, 0.4,
  // 0.6)
  // (Chu et al. 2021, Chen et al. 2020)
  kChu,
  // top = m + (n - m) * (0.75, 0.75, 1.5), bottom = m + (n - m) / 2
  // (Dong et al. 2019)
  kMvpose,
  // bottom = (m + e) / 2, top = 2 e - bottom (Tu et al. 2020, Campus)
  kVoxelposeCampus,
  // 0.75 of kMvpose and 0.25 of kVoxelposeCampus (Tu et al. 2020, Shelf)
  kVoxelposeShelf,
  // bottom = (m + e) / 2, top = bottom + 0.125 m along the face + 0.145 m along
  // +z; the face looks along (neck - mid-hip) x (r_shoulder - l_shoulder), neck
  // and mid-hip being the pose's own if it has them (Zhang et al. 2020)
  k4d,
  // top = n, bottom = m
  kRaw,
};

// "chu", "mvpose", "voxelpose_campus", "voxelpose_shelf", "4d", "raw".
const char* ToString(HeadConversion conversion);

// By the name of a command's flag: chu, mvpose, voxelpose, 4d, raw. "voxelpose"
// is the Campus form where `campus` is set. nullopt for another name.
std::optional<HeadConversion> HeadConversionByName(const std::string& name,
                                                   bool campus);

// Poses of one skeleton to Tum14. A joint is taken by its name; the two of the
// head are computed unless the skeleton has both (then it is a ground truth
// itself). What lacks a source, in the skeleton or in the pose, is missing. A
// computed joint is observed only if all its sources are.
class Tum14Converter {
 public:
  Tum14Converter(const Skeleton& from, HeadConversion conversion);
  Pose3d operator()(const Pose3d& pose) const;

 private:
  struct Head;
  Head ConvertHead(const Pose3d& pose) const;

  HeadConversion conversion_;
  std::vector<int> source_;  // of each joint of Tum14, or -1
  int nose_ = -1;
  int l_ear_ = -1;
  int r_ear_ = -1;
  int l_shoulder_ = -1;
  int r_shoulder_ = -1;
  int l_hip_ = -1;
  int r_hip_ = -1;
  int neck_ = -1;
  int mid_hip_ = -1;
};

// The middle of two joints: missing if one of them is.
Joint3d Middle(const Joint3d& a, const Joint3d& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_HEAD_CONVERSION_H_
