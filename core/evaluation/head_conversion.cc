#include "core/evaluation/head_conversion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <initializer_list>

namespace kinegraph {
namespace {

using Eigen::Vector3d;

constexpr double kFaceForwardM = 0.125;  // k4d
constexpr double kFaceUpM = 0.145;
constexpr double kMvposeShare = 0.75;  // kVoxelposeShelf

JointStatus Worst(std::initializer_list<const Joint3d*> joints) {
  JointStatus worst = JointStatus::kObserved;
  for (const Joint3d* joint : joints) worst = std::min(worst, joint->status);
  return worst;
}

const Joint3d& At(const Pose3d& pose, int joint) {
  static const Joint3d kMissing;
  return joint < 0 ? kMissing : pose[joint];
}

// From m towards the nose n, each world axis with its own factor.
Vector3d Towards(const Vector3d& m, const Vector3d& n, double x, double y,
                 double z) {
  return m + (n - m).cwiseProduct(Vector3d(x, y, z));
}

}  // namespace

const char* ToString(HeadConversion conversion) {
  switch (conversion) {
    case HeadConversion::kChu:
      return "chu";
    case HeadConversion::kMvpose:
      return "mvpose";
    case HeadConversion::kVoxelposeCampus:
      return "voxelpose_campus";
    case HeadConversion::kVoxelposeShelf:
      return "voxelpose_shelf";
    case HeadConversion::k4d:
      return "4d";
    case HeadConversion::kRaw:
      break;
  }
  return "raw";
}

std::optional<HeadConversion> HeadConversionByName(const std::string& name,
                                                   bool campus) {
  if (name == "chu") return HeadConversion::kChu;
  if (name == "mvpose") return HeadConversion::kMvpose;
  if (name == "voxelpose") {
    return campus ? HeadConversion::kVoxelposeCampus
                  : HeadConversion::kVoxelposeShelf;
  }
  if (name == "4d") return HeadConversion::k4d;
  if (name == "raw") return HeadConversion::kRaw;
  return std::nullopt;
}

struct Tum14Converter::Head {
  Joint3d bottom;
  Joint3d top;
};

Joint3d Middle(const Joint3d& a, const Joint3d& b) {
  return {0.5 * (a.position_m + b.position_m), Worst({&a, &b})};
}

Tum14Converter::Tum14Converter(const Skeleton& from, HeadConversion conversion)
    : conversion_(conversion),
      source_(MapByName(from, Tum14())),
      nose_(from.IndexOf("nose")),
      l_ear_(from.IndexOf("l_ear")),
      r_ear_(from.IndexOf("r_ear")),
      l_shoulder_(from.IndexOf("l_shoulder")),
      r_shoulder_(from.IndexOf("r_shoulder")),
      l_hip_(from.IndexOf("l_hip")),
      r_hip_(from.IndexOf("r_hip")),
      neck_(from.IndexOf("neck")),
      mid_hip_(from.IndexOf("mid_hip")) {}

Pose3d Tum14Converter::operator()(const Pose3d& pose) const {
  static const int kBottom = Tum14().IndexOf("head_bottom");
  static const int kTop = Tum14().IndexOf("head_top");
  Pose3d converted;
  converted.reserve(source_.size());
  for (const int joint : source_) converted.push_back(At(pose, joint));
  if (source_[kBottom] < 0 || source_[kTop] < 0) {
    const Head head = ConvertHead(pose);
    converted[kBottom] = head.bottom;
    converted[kTop] = head.top;
  }
  return converted;
}

Tum14Converter::Head Tum14Converter::ConvertHead(const Pose3d& pose) const {
  const Joint3d& l_shoulder = At(pose, l_shoulder_);
  const Joint3d& r_shoulder = At(pose, r_shoulder_);
  const Joint3d shoulders = Middle(l_shoulder, r_shoulder);
  const Joint3d ears = Middle(At(pose, l_ear_), At(pose, r_ear_));
  const Joint3d& nose = At(pose, nose_);
  const Vector3d& m = shoulders.position_m;
  const Vector3d& n = nose.position_m;
  const Vector3d& e = ears.position_m;
  const JointStatus by_nose = Worst({&shoulders, &nose});
  const JointStatus by_ears = Worst({&shoulders, &ears});

  switch (conversion_) {
    case HeadConversion::kChu:
      return {{Towards(m, n, 0.3, 0.4, 0.6), by_nose},
              {Towards(m, n, 0.78, 0.5, 1.5), by_nose}};
    case HeadConversion::kMvpose:
      return {{Towards(m, n, 0.5, 0.5, 0.5), by_nose},
              {Towards(m, n, 0.75, 0.75, 1.5), by_nose}};
    case HeadConversion::kVoxelposeCampus: {
      const Vector3d bottom = 0.5 * (m + e);
      return {{bottom, by_ears}, {2.0 * e - bottom, by_ears}};
    }
    case HeadConversion::kVoxelposeShelf: {
      const Vector3d bottom = 0.5 * (m + e);
      const Vector3d top = 2.0 * e - bottom;
      const JointStatus status = Worst({&shoulders, &nose, &ears});
      return {{kMvposeShare * Towards(m, n, 0.5, 0.5, 0.5) +
                   (1.0 - kMvposeShare) * bottom,
               status},
              {kMvposeShare * Towards(m, n, 0.75, 0.75, 1.5) +
                   (1.0 - kMvposeShare) * top,
               status}};
    }
    case HeadConversion::k4d: {
      const Joint3d& own_neck = At(pose, neck_);
      const Joint3d& own_mid_hip = At(pose, mid_hip_);
      const Joint3d neck = own_neck.present() ? own_neck : shoulders;
      const Joint3d hips = own_mid_hip.present()
                               ? own_mid_hip
                               : Middle(At(pose, l_hip_), At(pose, r_hip_));
      const Vector3d face =
          (neck.position_m - hips.position_m)
              .cross(r_shoulder.position_m - l_shoulder.position_m)
              .normalized();
      const Vector3d bottom = 0.5 * (m + e);
      return {{bottom, by_ears},
              {bottom + kFaceForwardM * face + kFaceUpM * Vector3d::UnitZ(),
               Worst({&shoulders, &ears, &neck, &hips})}};
    }
    case HeadConversion::kRaw:
      break;
  }
  return {{m, shoulders.status}, {n, nose.status}};
}

}  // namespace kinegraph
