#include "core/synthetic/recorded_people.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

using RecordedPeople = std::vector<std::shared_ptr<const Actor>>;

// Placement of a clip in space and time.
struct ClipSetting {
  // Rotation about the vertical axis through `centre_m`, which is then moved to
  // `place_m`. Heights do not change, and neither does the contact with the
  // ground.
  Vector2d centre_m = Vector2d::Zero();
  Vector2d place_m = Vector2d::Zero();
  double turn_rad = 0.0;
  double start_s = 0.0;      // time of appearance in the scene
  double hold_s = 0.0;       // time for which the first pose is held
  double hold_sway_m = 0.0;  // of a held body: RMS, forward, 1 m above ankles
  // Joint centres are not points of rigid bones: each oscillates in the frame
  // of the trunk as its joint bends, with an amplitude drawn uniformly from
  // half to one and a half times this, in a direction of its own. The whole
  // range (from minus to plus the amplitude) corresponds to the range of the
  // angle's cosine in the clip, or to twice kLeastHalfRange if the joint bends
  // less. Wrist and ankle follow elbow and knee. 0: none.
  double joint_sway_m = 0.0;
};

// Time of the clip at a time of the scene.
double ClipTimeAt(const ClipSetting& setting, double time_s) {
  const double moving = time_s - setting.start_s - setting.hold_s;
  if (setting.hold_s <= 0.0) return moving;
  if (moving <= 0.0) return 0.0;
  if (moving >= kStartRamp) return moving - 0.5 * kStartRamp;
  // The integral of SmoothStep.
  const double x = moving / kStartRamp;
  return kStartRamp * x * x * x * x * (2.5 + x * (x - 3.0));
}

// Duration of a clip in the scene, the held pose included.
double TimeInScene(const ClipSetting& setting, double clip_length_s) {
  if (setting.hold_s <= 0.0) return clip_length_s;
  if (clip_length_s >= 0.5 * kStartRamp) {
    return setting.hold_s + clip_length_s + 0.5 * kStartRamp;
  }
  // A clip that ends before reaching full speed.
  double low = 0.0;
  double high = kStartRamp;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const double reached =
        ClipTimeAt(setting, setting.start_s + setting.hold_s + middle);
    (reached < clip_length_s ? low : high) = middle;
  }
  return setting.hold_s + high;
}

// Clips have times in microseconds, scenes in nanoseconds: a time beyond a
// clip's end by rounding is treated as the end [s].
constexpr double kTimeSlack = 1e-4;

// Time in which the body's sway fades before the clip moves [s].
constexpr double kSwayFade = 1.0;
// Standing people sway less to the side than forward.
constexpr double kSideShare = 0.6;
// Quiet standing has nearly all of its sway below 1 Hz (Winter 1995, Human
// balance and posture control during standing and walking). The sum repeats
// only after 100 s.
constexpr std::array<double, 5> kSwayHz = {0.11, 0.23, 0.37, 0.59, 0.83};

// Least half range of an angle's cosine: a range of 15 degrees about a right
// angle, of 42 degrees up to a straight joint.
constexpr double kLeastHalfRange = 0.13;

Vector3d HorizontalPart(const Vector3d& v) { return {v.x(), v.y(), 0.0}; }

std::array<int, 2> BothSides(const Skeleton& skeleton,
                             const std::string& joint) {
  return {skeleton.IndexOf("l_" + joint), skeleton.IndexOf("r_" + joint)};
}

bool HasBoth(const std::array<int, 2>& joints) {
  return joints[0] >= 0 && joints[1] >= 0;
}

double CosineOf(const std::vector<Vector3d>& points,
                const std::array<int, 3>& joints) {
  const Vector3d a = points[joints[0]] - points[joints[1]];
  const Vector3d b = points[joints[2]] - points[joints[1]];
  const double norms = a.norm() * b.norm();
  return norms > 0.0 ? a.dot(b) / norms : 0.0;
}

// The names of the joints that define the angle of a joint, without the side.
struct AngleNames {
  const char* joint;
  std::array<const char*, 3> span;
};
constexpr std::array<AngleNames, 6> kAngles = {{
    {"shoulder", {"hip", "shoulder", "elbow"}},
    {"elbow", {"shoulder", "elbow", "wrist"}},
    {"wrist", {"shoulder", "elbow", "wrist"}},
    {"hip", {"shoulder", "hip", "knee"}},
    {"knee", {"hip", "knee", "ankle"}},
    {"ankle", {"hip", "knee", "ankle"}},
}};

std::vector<Vector3d> PointsOfVector(const Eigen::VectorXd& coordinates) {
  std::vector<Vector3d> points;
  points.reserve(static_cast<size_t>(coordinates.size()) / 3);
  for (Eigen::Index i = 0; i < coordinates.size(); i += 3) {
    points.emplace_back(coordinates.segment<3>(i));
  }
  return points;
}

// From lengths of segments as shares of the stature (Drillis and Contini 1966):
// hip to shoulder 0.29, thigh and shank together 0.49.
double StatureOf(const Skeleton& skeleton, const std::vector<Vector3d>& points,
                 double hip_to_shoulder_m) {
  const int hip = skeleton.IndexOf("l_hip");
  const int knee = skeleton.IndexOf("l_knee");
  const int ankle = skeleton.IndexOf("l_ankle");
  if (knee < 0 || ankle < 0) return hip_to_shoulder_m / 0.29;
  const double leg = (points[hip] - points[knee]).norm() +
                     (points[knee] - points[ankle]).norm();
  return (hip_to_shoulder_m + leg) / 0.78;
}

Vector3d RandomDirection(Random* random) {
  const double x = random->Normal();
  const double y = random->Normal();
  const double z = random->Normal();
  return Vector3d(x, y, z).normalized();
}

// A person with recorded motion: a spline through the joints of a tracks file,
// placed in the scene, optionally holding the first pose for a while.
class RecordedActor : public Actor {
 public:
  // Throws OptionError("clips", ...) if the skeleton has no shoulders or hips
  // or they coincide, so that the trunk has no frame.
  RecordedActor(RecordedMotion motion, const ClipSetting& setting,
                uint64_t joint_sway_seed, uint64_t body_sway_seed)
      : motion_(std::move(motion)),
        setting_(setting),
        shoulders_(BothSides(motion_.skeleton, "shoulder")),
        hips_(BothSides(motion_.skeleton, "hip")) {
    if (!HasBoth(shoulders_) || !HasBoth(hips_)) {
      throw OptionError("clips", "skeleton '" + motion_.skeleton.name() +
                                     "' has no shoulders or hips, which "
                                     "determine a person's front");
    }
    const Points first = PointsOfVector(motion_.pieces.front().values().col(0));
    const double across = (first[shoulders_[0]] - first[shoulders_[1]]).norm();
    const double along = (first[shoulders_[0]] - first[hips_[0]]).norm();
    constexpr double kLeast = 0.01;  // [m]
    if (across < kLeast || along < kLeast) {
      throw OptionError("clips", motion_.clip +
                                     ": shoulders and hips coincide; positions "
                                     "are expected in metres");
    }
    stature_m_ = StatureOf(motion_.skeleton, first, along);
    PlanCentreSway(joint_sway_seed);
    Random random(body_sway_seed);
    for (auto& axis : phases_) {
      for (double& phase : axis) phase = random.Uniform(0.0, 2.0 * kPi);
    }
  }

  bool PresentAt(double time_s) const override {
    return time_s >= setting_.start_s - kTimeSlack &&
           PieceAt(ClipTimeAt(setting_, time_s)) != nullptr;
  }

  Pose3d PoseAt(double time_s) const override {
    Pose3d pose;
    for (const Vector3d& point : PointsAt(time_s)) {
      pose.push_back({point, JointStatus::kObserved});
    }
    return pose;
  }

  SegmentPose TrunkAt(double time_s) const override {
    return TrunkOf(PointsAt(time_s));
  }

  // The parts and radii of ObstacleOf, between the recorded joints.
  Obstacle ObstacleAt(double time_s) const override {
    const Points points = PointsAt(time_s);
    const Skeleton& skeleton = motion_.skeleton;
    const double h = stature_m_;
    const SegmentPose trunk = TrunkOf(points);
    const Vector3d top = 0.5 * (points[shoulders_[0]] + points[shoulders_[1]]);
    std::vector<Capsule> capsules = {{trunk.origin_m, top, 0.085 * h}};
    const auto bone = [&](const std::string& a, const std::string& b,
                          double radius_m) {
      const int from = skeleton.IndexOf(a);
      const int to = skeleton.IndexOf(b);
      if (from < 0 || to < 0) return;
      capsules.push_back({points[from], points[to], radius_m});
    };
    bone("l_ear", "r_ear", 0.05 * h);
    for (const std::string side : {"l_", "r_"}) {
      bone(side + "shoulder", side + "elbow", 0.026 * h);
      bone(side + "elbow", side + "wrist", 0.022 * h);
      bone(side + "hip", side + "knee", 0.04 * h);
      bone(side + "knee", side + "ankle", 0.03 * h);
    }
    return Obstacle(std::move(capsules), trunk.origin_m);
  }

  ActorFacts Facts() const override {
    ActorFacts facts;
    facts.stature_m = stature_m_;
    facts.clip = motion_.clip;
    facts.clip_id = motion_.id;
    for (const KnotSpline& piece : motion_.pieces) {
      const bool held = piece.begin_s() <= 0.0;
      facts.present.push_back(
          {setting_.start_s +
               (held ? 0.0 : TimeInScene(setting_, piece.begin_s())),
           setting_.start_s + TimeInScene(setting_, piece.end_s())});
    }
    return facts;
  }

 private:
  using Points = std::vector<Vector3d>;

  // Motion of a joint's centre in the frame of the trunk.
  struct CentreSway {
    int joint = 0;
    std::array<int, 3>
        angle{};          // the joints that define it, its vertex in the middle
    double middle = 0.0;  // of the angle's cosine
    double half_range = 1.0;
    Vector3d amplitude_m = Vector3d::Zero();  // in the trunk
  };

  const KnotSpline* PieceAt(double clip_time_s) const {
    for (const KnotSpline& piece : motion_.pieces) {
      if (clip_time_s >= piece.begin_s() - kTimeSlack &&
          clip_time_s <= piece.end_s() + kTimeSlack) {
        return &piece;
      }
    }
    return nullptr;
  }

  Points RecordedPoints(double clip_time_s) const {
    return PointsOfVector(PieceAt(clip_time_s)->At(clip_time_s));
  }

  SegmentPose TrunkOf(const Points& points) const {
    const Vector3d top = 0.5 * (points[shoulders_[0]] + points[shoulders_[1]]);
    SegmentPose trunk;
    trunk.origin_m = 0.5 * (points[hips_[0]] + points[hips_[1]]);
    const Vector3d left = points[shoulders_[0]] - points[shoulders_[1]] +
                          points[hips_[0]] - points[hips_[1]];
    const Vector3d up = (top - trunk.origin_m).normalized();
    const Vector3d forward = left.cross(up).normalized();
    trunk.R << forward, up.cross(forward), up;
    return trunk;
  }

  void PlanCentreSway(uint64_t seed) {
    if (setting_.joint_sway_m <= 0.0) return;
    Random random(seed);
    for (const AngleNames& names : kAngles) {
      for (const std::string side : {"l_", "r_"}) {
        CentreSway centre;
        centre.joint = motion_.skeleton.IndexOf(side + names.joint);
        for (size_t i = 0; i < names.span.size(); ++i) {
          centre.angle[i] = motion_.skeleton.IndexOf(side + names.span[i]);
        }
        centre.amplitude_m = setting_.joint_sway_m * random.Uniform(0.5, 1.5) *
                             RandomDirection(&random);
        if (centre.joint < 0 ||
            std::min({centre.angle[0], centre.angle[1], centre.angle[2]}) < 0) {
          continue;
        }
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (const KnotSpline& piece : motion_.pieces) {
          for (Eigen::Index k = 0; k < piece.values().cols(); ++k) {
            const double cosine =
                CosineOf(PointsOfVector(piece.values().col(k)), centre.angle);
            low = std::min(low, cosine);
            high = std::max(high, cosine);
          }
        }
        centre.middle = 0.5 * (low + high);
        centre.half_range = std::max(0.5 * (high - low), kLeastHalfRange);
        centre_sway_.push_back(centre);
      }
    }
  }

  void AddCentreSway(Points* points) const {
    if (centre_sway_.empty()) return;
    const Points rigid = *points;
    const Matrix3d R = TrunkOf(rigid).R;
    for (const CentreSway& centre : centre_sway_) {
      const double share =
          (CosineOf(rigid, centre.angle) - centre.middle) / centre.half_range;
      (*points)[centre.joint] += share * (R * centre.amplitude_m);
    }
  }

  // A held body rotates rigidly about its ankles (an inverted pendulum).
  void AddBodySway(double time_s, Points* points) const {
    const double left_s = setting_.start_s + setting_.hold_s - time_s;
    if (setting_.hold_sway_m <= 0.0 || left_s <= 0.0) return;
    std::array<double, 2> sway = {0.0, 0.0};
    double power = 0.0;
    for (int term = 0; term < kSwayTerms; ++term) {
      const double amplitude = kSwayHz[0] / kSwayHz[term];
      power += 0.5 * amplitude * amplitude;
      for (int axis = 0; axis < 2; ++axis) {
        sway[axis] += amplitude * std::sin(2.0 * kPi * kSwayHz[term] *
                                               (time_s - setting_.start_s) +
                                           phases_[axis][term]);
      }
    }
    const double fade =
        SmoothStep(left_s / std::min(kSwayFade, setting_.hold_s));
    const double angle =
        fade * setting_.hold_sway_m / std::sqrt(power);  // at 1 m

    const SegmentPose trunk = TrunkOf(*points);
    Vector3d pivot = HorizontalPart(trunk.origin_m);
    const std::array<int, 2> ankles = BothSides(motion_.skeleton, "ankle");
    if (HasBoth(ankles)) {
      pivot = 0.5 * ((*points)[ankles[0]] + (*points)[ankles[1]]);
    }
    // Horizontal directions of the body. For a body that lies on its side these
    // are the world's.
    Vector3d left = HorizontalPart(trunk.R.col(1));
    left = left.norm() > 0.1 ? left.normalized() : Vector3d::UnitY();
    const Vector3d forward = left.cross(Vector3d::UnitZ());
    // Rotation about `left` leans forward, about `forward` to the right.
    const Vector3d turn =
        angle * (sway[0] * left + kSideShare * sway[1] * forward);
    const double size = turn.norm();
    if (size <= 0.0) return;
    const Matrix3d R = Eigen::AngleAxisd(size, turn / size).toRotationMatrix();
    for (Vector3d& point : *points) point = pivot + R * (point - pivot);
  }

  void Place(Points* points) const {
    const Matrix3d R = Eigen::AngleAxisd(setting_.turn_rad, Vector3d::UnitZ())
                           .toRotationMatrix();
    const Vector3d centre(setting_.centre_m.x(), setting_.centre_m.y(), 0.0);
    const Vector3d place(setting_.place_m.x(), setting_.place_m.y(), 0.0);
    for (Vector3d& point : *points) point = place + R * (point - centre);
  }

  Points PointsAt(double time_s) const {
    Points points = RecordedPoints(ClipTimeAt(setting_, time_s));
    AddCentreSway(&points);
    AddBodySway(time_s, &points);
    Place(&points);
    return points;
  }

  RecordedMotion motion_;
  ClipSetting setting_;
  std::array<int, 2> shoulders_{};  // left, right
  std::array<int, 2> hips_{};
  double stature_m_ = 0.0;
  std::vector<CentreSway> centre_sway_;
  // Phases of the body's sway, forward and to the side [rad].
  static constexpr int kSwayTerms = 5;
  std::array<std::array<double, kSwayTerms>, 2> phases_{};
};

// Horizontal positions of all joints of a clip's people over time.
std::vector<Vector2d> GroundPositionsOf(
    const std::vector<RecordedMotion>& motions) {
  std::vector<Vector2d> positions;
  for (const RecordedMotion& motion : motions) {
    for (const KnotSpline& piece : motion.pieces) {
      for (Eigen::Index i = 0; i < piece.values().size(); i += 3) {
        positions.emplace_back(piece.values().data()[i],
                               piece.values().data()[i + 1]);
      }
    }
  }
  return positions;
}

double At(const std::vector<double>& list, size_t i) {
  return i < list.size() ? list[i] : 0.0;
}

// Lists have one number per clip. They may be empty or, if `may_end_early`,
// shorter: missing numbers are 0.
void CheckCount(const char* key, const std::vector<double>& list, size_t clips,
                bool may_end_early) {
  if (list.size() == clips || list.empty()) return;
  if (may_end_early && list.size() < clips) return;
  throw OptionError(key, "found " + std::to_string(list.size()) +
                             (list.size() == 1 ? " number" : " numbers") +
                             " for " + std::to_string(clips) +
                             (clips == 1 ? " clip" : " clips"));
}

void CheckLists(const RecordedPeopleOptions& options, size_t clips) {
  CheckOptions(options);
  CheckCount("start", options.start_s, clips, true);
  CheckCount("hold", options.hold_s, clips, true);
  CheckCount("x", options.x_m, clips, false);
  CheckCount("y", options.y_m, clips, false);
  CheckCount("turn", options.turn_deg, clips, false);
  if (options.x_m.empty() != options.y_m.empty()) {
    throw OptionError(options.x_m.empty() ? "x" : "y",
                      "is missing: a place needs both x and y");
  }
}

// Minimum horizontal distance between two trunks while both are present.
double ClosestOf(const RecordedPeople& some, const RecordedPeople& others) {
  constexpr double kSampleStep =
      0.1;  // [s]: no person moves farther than 0.5 m in it
  double closest = std::numeric_limits<double>::infinity();
  for (const auto& a : some) {
    for (const auto& b : others) {
      for (const TimeSpan& span : a->Facts().present) {
        for (double t = span.begin_s; t <= span.end_s; t += kSampleStep) {
          if (!a->PresentAt(t) || !b->PresentAt(t)) continue;
          const Vector3d apart =
              a->TrunkAt(t).origin_m - b->TrunkAt(t).origin_m;
          closest = std::min(closest, apart.head<2>().norm());
        }
      }
    }
  }
  return closest;
}

// Appends the people of clip `clip_idx`. A given position is used even if
// people of different clips are then too close; otherwise positions are drawn
// until they keep their distance. The rotation is given or drawn.
void AddClip(const RecordedPeopleOptions& options, const ClipRoom& room,
             const std::vector<RecordedMotion>& motions, size_t clip_idx,
             Random* seeds, RecordedPeople* people) {
  constexpr int kAttempts = 300;
  // One fork per kind of randomness, so that one does not affect the others.
  Random random(seeds->Fork());
  const uint64_t joint_sway_seed = seeds->Fork();
  const uint64_t body_sway_seed = seeds->Fork();
  const std::vector<Vector2d> positions = GroundPositionsOf(motions);
  Vector2d low = positions.front(), high = low;
  for (const Vector2d& point : positions) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  ClipSetting setting;
  setting.centre_m = 0.5 * (low + high);
  setting.start_s = At(options.start_s, clip_idx);
  setting.hold_s = At(options.hold_s, clip_idx);
  setting.hold_sway_m = options.hold_sway_m;
  setting.joint_sway_m = options.joint_sway_m;
  double reach = 0.0;
  for (const Vector2d& point : positions) {
    reach = std::max(reach, (point - setting.centre_m).norm());
  }
  const double free = std::max(0.0, room.radius_m - reach);
  const bool has_place = !options.x_m.empty();
  const bool has_turn = !options.turn_deg.empty();
  const int attempts = has_place && has_turn ? 1 : kAttempts;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    // Uniform over a disc and all directions.
    const double distance = free * std::sqrt(random.Uniform());
    const double angle = random.Uniform(0.0, 2.0 * kPi);
    const double turn_rad = random.Uniform(-kPi, kPi);
    setting.place_m =
        has_place
            ? Vector2d(options.x_m[clip_idx], options.y_m[clip_idx])
            : Vector2d(distance * Vector2d(std::cos(angle), std::sin(angle)));
    setting.turn_rad =
        has_turn ? options.turn_deg[clip_idx] * kPi / 180.0 : turn_rad;
    RecordedPeople placed;
    for (size_t i = 0; i < motions.size(); ++i) {
      placed.push_back(std::make_shared<RecordedActor>(
          motions[i], setting, joint_sway_seed + i, body_sway_seed + i));
    }
    const bool apart = ClosestOf(placed, *people) >= room.min_distance_m;
    if (!apart && !has_place) continue;
    people->insert(people->end(), placed.begin(), placed.end());
    return;
  }
  throw OptionError(
      "clips", motions.front().clip +
                   ": no place found where its people keep apart from those "
                   "of the earlier clips; give x and y, later starts or a "
                   "larger scene.motion.area_radius");
}

}  // namespace

void RecordedPeopleOptions::Describe(OptionVisitor& visitor) {
  visitor.TextList("clips", &clips,
                   "tracks files whose people replace simulated ones; paths "
                   "relative to the configuration's folder");
  visitor.NumberList("start", &start_s, Between(0.0, 36000.0), "s",
                     "when the people of each clip appear; 0 if not listed");
  visitor.NumberList("hold", &hold_s, Between(0.0, 36000.0), "s",
                     "for how long the people of each clip hold its first pose "
                     "before they move; 0 if not listed");
  visitor.NumberList("x", &x_m, Between(-1000.0, 1000.0), "m",
                     "x of the centre of each clip's path; empty: random");
  visitor.NumberList("y", &y_m, Between(-1000.0, 1000.0), "m",
                     "y of the centre of each clip's path; empty: random");
  visitor.NumberList("turn", &turn_deg, Between(-360.0, 360.0), "deg",
                     "rotation of each clip about the vertical; empty: random");
  visitor.Number("hold_sway", &hold_sway_m, Between(0.0, 0.1), "m",
                 "sway of a body that holds its pose: RMS, forward, 1 m above "
                 "the ankles");
  visitor.Number("joint_sway", &joint_sway_m, Between(0.0, 0.1), "m",
                 "joint centres move with the joint's angle, by half to one "
                 "and a half times this; 0: bones keep their recorded lengths");
}

RecordedPeople MakeRecordedPeople(const RecordedPeopleOptions& options,
                                  const std::vector<MotionClip>& clips,
                                  const Skeleton& skeleton,
                                  const ClipRoom& room) {
  CheckLists(options, clips.size());
  Random seeds(room.seed);
  RecordedPeople people;
  for (size_t i = 0; i < clips.size(); ++i) {
    AddClip(options, room, MotionsOf(clips[i], skeleton), i, &seeds, &people);
  }
  return people;
}

double EndOf(const RecordedPeople& people) {
  double end_s = 0.0;
  for (const auto& person : people) {
    for (const TimeSpan& span : person->Facts().present) {
      end_s = std::max(end_s, span.end_s);
    }
  }
  return end_s;
}

}  // namespace kinegraph
