// A person whose motion was recorded: a spline through the joints of a tracks
// file, placed in the scene, perhaps held at the first pose for a while.
#ifndef KINEGRAPH_CORE_SYNTHETIC_RECORDED_ACTOR_H_
#define KINEGRAPH_CORE_SYNTHETIC_RECORDED_ACTOR_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/synthetic/actor.h"
#include "core/synthetic/knot_spline.h"

namespace kinegraph {

// One person of a clip, in the clip's own frame and time (0: the clip's first
// frame).
struct RecordedMotion {
  std::string clip;  // the file, for messages and scene.json
  TrackId id;        // the person's in it
  Skeleton skeleton;
  // Coordinates of all joints, x y z of the first, then of the next. One piece
  // for each stretch without a gap; at least one.
  std::vector<KnotSpline> pieces;
};

// Where a clip stands in the room: turned about the vertical axis through
// `centre_m`, which then comes to `place_m`. Heights stay as they are, and so
// does the contact with the ground.
struct ClipPlace {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  double turn_rad = 0.0;
};

// When a clip is played.
struct ClipTiming {
  double start_s = 0.0;  // appears, time of the scene
  double hold_s = 0.0;   // the first pose is held for so long before it moves
  double sway_m = 0.0;  // of a held body: RMS, forward, at 1 m above the ankles
};

// After a held pose the clip's time gathers speed for so long, from rest to
// its own pace: people who walk from the first frame on do not start with a
// jump.
inline constexpr double kStartRamp = 0.3;

// Time of the clip at a time of the scene, and how long a clip of
// `clip_length_s` is in the scene.
double ClipTimeAt(const ClipTiming& timing, double time_s);
double TimeInScene(const ClipTiming& timing, double clip_length_s);

// Centres of joints that are no points of rigid bones: each moves to and fro in
// the frame of the trunk as its joint bends, by an amplitude that is drawn
// uniformly between half of `amplitude_m` and one and a half of it, in a
// direction of its own. The whole way (from minus to plus the amplitude) is
// gone over the range of angles in the clip, or over about thirty degrees where
// the joint bends less. Wrist and ankle follow elbow and knee. 0: none.
struct JointSway {
  double amplitude_m = 0.0;
  uint64_t seed = 0;
};

class RecordedActor : public Actor {
 public:
  // Throws OptionError("clips", ...) when the skeleton has no shoulders or hips
  // or they coincide: then there is no frame of the trunk.
  RecordedActor(RecordedMotion motion, const ClipPlace& place,
                const ClipTiming& timing, const JointSway& sway,
                uint64_t body_sway_seed);

  bool PresentAt(double time_s) const override;
  Pose3d PoseAt(double time_s) const override;
  SegmentPose TrunkAt(double time_s) const override;
  Obstacle ObstacleAt(double time_s) const override;
  ActorFacts Facts() const override;

 private:
  using Points = std::vector<Eigen::Vector3d>;

  // How a joint's centre moves in the frame of the trunk.
  struct CentreSway {
    int joint = 0;
    std::array<int, 3>
        angle{};          // the joints that span it, its own in the middle
    double middle = 0.0;  // of the angle's cosine
    double half_range = 1.0;
    Eigen::Vector3d amplitude_m = Eigen::Vector3d::Zero();  // in the trunk
  };

  const KnotSpline* PieceAt(double clip_time_s) const;
  Points RecordedPoints(double clip_time_s) const;
  SegmentPose TrunkOf(const Points& points) const;
  void PlanCentreSway(const JointSway& sway);
  void AddCentreSway(Points* points) const;
  void AddBodySway(double time_s, Points* points) const;
  void Place(Points* points) const;
  Points PointsAt(double time_s) const;

  RecordedMotion motion_;
  ClipPlace place_;
  ClipTiming timing_;
  std::array<int, 2> shoulders_{};  // left, right
  std::array<int, 2> hips_{};
  double stature_m_ = 0.0;
  std::vector<CentreSway> centre_sway_;
  // Phases of the body's sway, forward and to the side [rad].
  static constexpr int kSwayTerms = 5;
  std::array<std::array<double, kSwayTerms>, 2> phases_{};
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_RECORDED_ACTOR_H_
