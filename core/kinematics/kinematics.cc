#include "core/kinematics/kinematics.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/constants.h"
#include "core/kinematics/angles.h"
#include "core/kinematics/ground.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

using MaybePoint = std::optional<Vector3d>;

// A segment of one side: its share of the mass, and the position of its centre
// of mass between its first and second joint, as a share of its length.
struct BodySegment {
  const char* from;
  const char* to;
  double mass;
  double centre;
};

// The trunk with head and neck (0.578) extends from hip to shoulder, half of it
// on each side.
constexpr BodySegment kSegments[] = {{"hip", "shoulder", 0.5 * 0.578, 0.66},
                                     {"shoulder", "elbow", 0.028, 0.436},
                                     {"elbow", "wrist", 0.022, 0.682},
                                     {"hip", "knee", 0.100, 0.433},
                                     {"knee", "ankle", 0.061, 0.606}};

// Weights of the joints in the centre of mass, their weighted mean, by the
// segments of Winter, "Biomechanics and Motor Control of Human Movement" (4th
// ed., table 4.1): trunk with head and neck, upper arms, forearms with hands,
// thighs, shanks with feet. The weights sum to 1. Empty when the skeleton lacks
// one of the twelve joints.
using MassWeights = std::vector<std::pair<int, double>>;
MassWeights MassWeightsOf(const Skeleton& skeleton) {
  std::vector<double> weights(static_cast<size_t>(skeleton.joint_count()));
  for (const std::string side : {"l_", "r_"}) {
    for (const BodySegment& segment : kSegments) {
      const int from = skeleton.IndexOf(side + segment.from);
      const int to = skeleton.IndexOf(side + segment.to);
      if (from < 0 || to < 0) return {};
      weights[from] += segment.mass * (1.0 - segment.centre);
      weights[to] += segment.mass * segment.centre;
    }
  }
  MassWeights result;
  for (size_t j = 0; j < weights.size(); ++j) {
    if (weights[j] > 0.0) result.emplace_back(static_cast<int>(j), weights[j]);
  }
  return result;
}

// Weighted mean of the joints [m]; nullopt without weights or when one of the
// joints is missing.
MaybePoint CentreOf(const MassWeights& weights, const Pose3d& pose) {
  if (weights.empty()) return std::nullopt;
  Vector3d centre = Vector3d::Zero();
  for (const auto& [joint_idx, weight] : weights) {
    const Joint3d& joint = pose[joint_idx];
    if (!joint.present()) return std::nullopt;
    centre += weight * joint.position_m;
  }
  return centre;
}

bool IsFinger(const std::string& joint) {
  for (const char* finger :
       {"hand_", "thumb", "index", "middle", "ring", "pinky"}) {
    for (const char* side : {"l_", "r_"}) {
      if (joint.rfind(std::string(side) + finger, 0) == 0) return true;
    }
  }
  return false;
}

// Whether the joint has a column of speeds: all joints but fingers and head; of
// the head only the nose.
bool HasSpeed(const Skeleton& skeleton, int joint_idx) {
  const std::string& joint = skeleton.joints()[joint_idx];
  if (IsFinger(joint)) return false;
  return skeleton.joint_class(joint_idx) != JointClass::kHead ||
         joint == "nose";
}

bool HasCovariances(const TrackSequence& tracks) {
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      for (const auto& covariance : person.covariances) {
        if (covariance.has_value()) return true;
      }
    }
  }
  return false;
}

// The median time between consecutive frames [ns]; 0 if that is not positive or
// there are fewer than two frames.
TimeNs FrameTime(const TrackSequence& tracks) {
  std::vector<TimeNs> steps;
  for (size_t k = 1; k < tracks.frames.size(); ++k) {
    steps.push_back(tracks.frames[k].time - tracks.frames[k - 1].time);
  }
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<long>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return std::max<TimeNs>(0, *middle);
}

// A point with a speed, and whether only its horizontal motion counts.
struct MovingPoint {
  std::string name;
  MassWeights weights;
  bool along_floor = false;

  // Horizontal motion is only defined where up is known.
  MaybePoint Of(const PersonPose& person,
                const std::optional<Vector3d>& up) const {
    MaybePoint point = CentreOf(weights, person.joints);
    if (point && along_floor) *point -= up->dot(*point) * *up;
    return point;
  }
};

std::vector<MovingPoint> MovingPoints(const Skeleton& skeleton,
                                      const MassWeights& mass, bool has_floor) {
  std::vector<MovingPoint> points;
  const int left = skeleton.IndexOf("l_hip"), right = skeleton.IndexOf("r_hip");
  if (left >= 0 && right >= 0 && has_floor) {
    points.push_back({"pelvis", {{left, 0.5}, {right, 0.5}}, true});
  }
  if (!mass.empty()) points.push_back({"com", mass, false});
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    if (!HasSpeed(skeleton, j)) continue;
    points.push_back({skeleton.joints()[j], {{j, 1.0}}, false});
  }
  return points;
}

// All angles or, where up is unknown, only those that do not depend on it.
std::vector<JointAngle> DefinedAngles(const Skeleton& skeleton, bool has_up) {
  std::vector<JointAngle> angles = AnglesOf(skeleton);
  if (has_up) return angles;
  angles.erase(
      std::remove_if(angles.begin(), angles.end(),
                     [](const JointAngle& angle) { return angle.needs_up; }),
      angles.end());
  return angles;
}

// Fills the columns of one table.
class Measurement {
 public:
  Measurement(const TrackSequence& tracks, const KinematicsOptions& options)
      : tracks_(tracks),
        observed_only_(options.observed_only),
        up_(options.up.has_value() ? options.up
                                   : UpDirection(tracks, options.known)),
        angles_(DefinedAngles(tracks.header.skeleton, up_.has_value())),
        mass_(MassWeightsOf(tracks.header.skeleton)),
        points_(MovingPoints(tracks.header.skeleton, mass_, up_.has_value())),
        frame_time_(FrameTime(tracks)),
        intervals_(HasCovariances(tracks)) {
    table_.has_times = frame_time_ > 0;
    table_.up = up_;
  }

  KinematicsTable Run() {
    NameColumns();
    for (const TrackFrame& frame : tracks_.frames) {
      for (const PersonPose& person : frame.people) AddRow(frame, person);
    }
    if (frame_time_ > 0) {
      for (const auto& [id, rows] : rows_of_) AddMotion(rows);
    }
    WriteNotes();
    return std::move(table_);
  }

 private:
  void NameColumns() {
    for (const JointAngle& angle : angles_) {
      table_.angles.push_back(angle.name);
      table_.columns.push_back(angle.name + "_deg");
      if (!intervals_) continue;
      table_.columns.push_back(angle.name + "_low_deg");
      table_.columns.push_back(angle.name + "_high_deg");
    }
    if (!mass_.empty()) {
      for (const char* axis : {"x", "y", "z"}) {
        table_.columns.push_back(std::string("com_") + axis + "_m");
      }
    }
    if (frame_time_ == 0) return;
    for (const MovingPoint& point : points_) {
      table_.columns.push_back(point.name + "_speed_m_s");
    }
    if (HasPelvis()) table_.columns.push_back("pelvis_path_m");
  }

  bool HasPelvis() const {
    return !points_.empty() && points_.front().along_floor;
  }

  // Values that do not depend on neighbouring frames; the rest stays NaN.
  void AddRow(const TrackFrame& frame, const PersonPose& given) {
    const PersonPose person = Usable(given);
    KinematicsRow row{frame.frame, frame.time, person.id, {}};
    for (const JointAngle& angle : angles_) {
      const auto estimate =
          MeasureAngle(angle, person, up_.value_or(Vector3d::Zero()));
      row.values.push_back(estimate ? estimate->deg : kNan);
      if (!intervals_) continue;
      row.values.push_back(estimate ? estimate->low_deg.value_or(kNan) : kNan);
      row.values.push_back(estimate ? estimate->high_deg.value_or(kNan) : kNan);
    }
    if (!mass_.empty()) {
      const MaybePoint com = CentreOf(mass_, person.joints);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        row.values.push_back(com ? (*com)[axis] : kNan);
      }
    }
    row.values.resize(table_.columns.size(), kNan);
    std::vector<MaybePoint> places;
    if (frame_time_ > 0) {
      for (const MovingPoint& point : points_) {
        places.push_back(point.Of(person, up_));
      }
    }
    rows_of_[person.id].push_back({table_.rows.size(), std::move(places)});
    table_.rows.push_back(std::move(row));
  }

  PersonPose Usable(const PersonPose& given) const {
    PersonPose person = given;
    for (Joint3d& joint : person.joints) {
      if (observed_only_ && joint.status != JointStatus::kObserved) {
        joint.status = JointStatus::kMissing;
      }
    }
    return person;
  }

  // Index of a person's row in the table, and the positions of its points.
  struct At {
    size_t row;
    std::vector<MaybePoint> places;
  };

  void AddMotion(const std::vector<At>& rows) {
    const size_t first =
        table_.columns.size() - points_.size() - (HasPelvis() ? 1 : 0);
    for (size_t p = 0; p < points_.size(); ++p) {
      for (size_t k = 1; k + 1 < rows.size(); ++k) {
        table_.rows[rows[k].row].values[first + p] =
            Speed(rows[k - 1], rows[k], rows[k + 1], p);
      }
    }
    if (HasPelvis()) AddPath(rows);
  }

  double Speed(const At& before, const At& now, const At& after,
               size_t point) const {
    const MaybePoint& from = before.places[point];
    const MaybePoint& to = after.places[point];
    if (!from || !to || !now.places[point]) return kNan;
    const TimeNs t0 = table_.rows[before.row].time;
    const TimeNs t1 = table_.rows[now.row].time;
    const TimeNs t2 = table_.rows[after.row].time;
    const TimeNs longest = frame_time_ + frame_time_ / 2;
    if (t1 - t0 > longest || t2 - t1 > longest || t2 <= t0) return kNan;
    return (*to - *from).norm() / ToSeconds(t2 - t0);
  }

  // Adds the length of straight lines between known positions.
  void AddPath(const std::vector<At>& rows) {
    MaybePoint last;
    double path_m = 0.0;
    for (const At& at : rows) {
      const MaybePoint& pelvis = at.places.front();
      if (!pelvis) continue;
      if (last) path_m += (*pelvis - *last).norm();
      last = pelvis;
      table_.rows[at.row].values.back() = path_m;
    }
  }

  void WriteNotes() {
    const Skeleton& skeleton = tracks_.header.skeleton;
    const auto has = [&](const std::string& name) {
      return std::find(table_.angles.begin(), table_.angles.end(), name) !=
             table_.angles.end();
    };
    const std::string whose = "the skeleton " + skeleton.name();
    if (!up_.has_value()) {
      table_.notes.emplace_back(
          "the upward direction is unknown (the people's bodies do not "
          "determine it): no lean of the trunk, and no obliquity, speed or "
          "path of the pelvis (--up=z)");
    }
    if (table_.angles.empty()) {
      table_.notes.push_back(whose +
                             " has none of the joints that angles need");
    } else if (!has("l_ankle_dorsiflexion") && !has("r_ankle_dorsiflexion")) {
      table_.notes.push_back(
          whose + " lacks joints of feet or lower legs: no ankle angles");
    }
    if (mass_.empty()) {
      table_.notes.push_back(whose +
                             " lacks joints of the limbs: no centre of mass");
    }
    if (!intervals_) {
      table_.notes.emplace_back("the tracks have no covariances: no intervals");
    }
    if (frame_time_ == 0) {
      table_.notes.emplace_back(
          "the tracks have no times: no speeds or paths (--frame_rate=HZ)");
    }
  }

  const TrackSequence& tracks_;
  const bool observed_only_;
  const std::optional<Vector3d> up_;
  const std::vector<JointAngle> angles_;
  const MassWeights mass_;
  const std::vector<MovingPoint> points_;
  const TimeNs frame_time_;
  const bool intervals_;
  KinematicsTable table_;
  std::map<TrackId, std::vector<At>> rows_of_;
};

}  // namespace

int KinematicsTable::IndexOf(const std::string& column) const {
  const auto at = std::find(columns.begin(), columns.end(), column);
  return at == columns.end() ? -1 : static_cast<int>(at - columns.begin());
}

KinematicsTable MeasureKinematics(const TrackSequence& tracks,
                                  const KinematicsOptions& options) {
  return Measurement(tracks, options).Run();
}

}  // namespace kinegraph
