// Joints, bones and mirror pairs of body models.
#ifndef KINEGRAPH_CORE_SKELETON_SKELETON_H_
#define KINEGRAPH_CORE_SKELETON_SKELETON_H_

#include <cstddef>
#include <string>
#include <vector>

namespace kinegraph {

// Classes of joints with common noise parameters.
enum class JointClass {
  kHead,   // nose, eyes, ears, mouth, face, top and bottom of the head
  kTrunk,  // neck, mid-hip
  kShoulder,
  kElbow,
  kWrist,
  kHip,
  kKnee,
  kAnkle,
  kFoot,   // heels and toes
  kOther,  // fingers and joints of other names
};
inline constexpr int kJointClassCount = 10;
const char* ToString(JointClass joint_class);

// Class by joint name; "l_" and "r_" are ignored.
JointClass ClassOfJoint(const std::string& joint_name);

struct Bone {
  int a = 0;  // joint indices
  int b = 0;
};

class Skeleton {
 public:
  Skeleton() = default;
  // Mirror partners follow from names ("l_x" and "r_x"). Throws OptionError for
  // no or more than 10000 joints, an empty or repeated joint name, or a bone
  // that does not join two of the joints.
  Skeleton(std::string name, std::vector<std::string> joints,
           std::vector<Bone> bones);

  const std::string& name() const { return name_; }
  int joint_count() const { return static_cast<int>(joints_.size()); }
  const std::vector<std::string>& joints() const { return joints_; }
  const std::vector<Bone>& bones() const { return bones_; }
  // Index of the joint on the other side; the joint itself if there is none.
  int mirror(int joint_idx) const { return mirror_[joint_idx]; }
  JointClass joint_class(int joint_idx) const { return classes_[joint_idx]; }
  // -1 if there is no such joint.
  int IndexOf(const std::string& joint_name) const;

  // The joints that association compares: those of COCO-17 by name, so that
  // feet and hands do not outvote the body; all joints if the skeleton has
  // fewer than nine of COCO-17's or is not human (IsHuman).
  const std::vector<int>& association_joints() const {
    return association_joints_;
  }

 private:
  std::string name_;
  std::vector<std::string> joints_;
  std::vector<Bone> bones_;
  std::vector<int> mirror_;
  std::vector<JointClass> classes_;
  std::vector<int> association_joints_;
};

bool operator==(const Skeleton& a, const Skeleton& b);
inline bool operator!=(const Skeleton& a, const Skeleton& b) {
  return !(a == b);
}

// Built-in skeletons. Left and right are the person's own.
const Skeleton& Coco17();
const Skeleton& Body25();      // OpenPose
const Skeleton& Body25B();     // OpenPose, not identified in its files
const Skeleton& Coco18();      // OpenPose's 18-joint COCO layout
const Skeleton& Tum14();       // Campus and Shelf ground truth
const Skeleton& Panoptic19();  // CMU Panoptic
const Skeleton& Panoptic15();  // its first fifteen joints (SMAP)
const Skeleton& FourDA19();    // 4D association's result
const Skeleton& Tum15();       // Tum14 and mid_hip (4D association's gt.txt)
// AlphaPose, RTMPose ("body with feet"), Pose2Sim: COCO-17, head_top, neck,
// mid_hip, toes and heels.
const Skeleton& Halpe26();
// MediaPipe's (BlazePose's) 33 landmarks; foot_index takes the place of
// big_toe.
const Skeleton& MediaPipe33();
// COCO-WholeBody: COCO-17, six joints of the feet, 68 points of the face in
// iBUG's order, 21 of each hand (0 its root, then four per finger, thumb
// first). Both points of a pair in the face have the number of the right one:
// r_face_0 and l_face_0 are iBUG's points 0 and 16.
const Skeleton& WholeBody133();

// nullptr if no built-in skeleton has that name.
const Skeleton* FindSkeleton(const std::string& name);
// Names of the built-in skeletons, for messages and documentation.
std::vector<std::string> SkeletonNames();
// The built-in skeleton with these joints in this order, or nullptr.
const Skeleton* FindSkeletonOf(const std::vector<std::string>& joints);
// The built-in skeletons with that number of joints, the most common first.
std::vector<const Skeleton*> SkeletonsOfSize(size_t joint_count);

// Converts a number of joints given for COCO-17, as by Chu et al. 2021, to
// `count` joints: the same share, rounded up.
int ScaledJoints(double joints_of_17, size_t count);

// For each joint of `to`, the joint of `from` with the same name, or -1.
std::vector<int> MapByName(const Skeleton& from, const Skeleton& to);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SKELETON_SKELETON_H_
