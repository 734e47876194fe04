#include "core/evaluation/markers/marker_sets.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Names = std::vector<std::string>;

// Distance of a joint's centre from a marker [m]. Ankle and knee: the radius of
// a marker, 7 mm, plus half the joint's width, about 70 mm and 100 mm in
// adults. A shoulder's centre lies about 45 mm below the acromion.
constexpr double kAnkleM = 0.042;
constexpr double kKneeM = 0.057;
constexpr double kShoulderM = 0.045;

// "Anna:L.ASIS_study" -> "lasis".
std::string Squeezed(const std::string& label) {
  std::string squeezed;
  for (size_t i = label.find_last_of(':') + 1; i < label.size(); ++i) {
    const auto byte = static_cast<unsigned char>(label[i]);
    // Kept, because two names may differ only in letters beyond ASCII.
    if (byte >= 0x80) {
      squeezed += label[i];
    } else if (std::isalnum(byte) != 0) {
      squeezed += static_cast<char>(std::tolower(byte));
    }
  }
  const std::string study = "study";  // of OpenCap's augmented markers
  if (EndsIn(squeezed, study)) squeezed.resize(squeezed.size() - study.size());
  return squeezed;
}

// The common prefix of more than three quarters of the labels, such as "Anna_"
// or "Q_": the name of a subject or a set. Not a side, "L_".
std::string PrefixOf(const Names& labels) {
  if (labels.empty()) return "";
  const std::string& first = labels.front();
  const std::string prefix = first.substr(0, first.find('_') + 1);
  if (prefix.size() < 2 || Squeezed(prefix) == "l" || Squeezed(prefix) == "r") {
    return "";
  }
  const auto count = std::count_if(
      labels.begin(), labels.end(), [&](const std::string& label) {
        return label.compare(0, prefix.size(), prefix) == 0;
      });
  return 4 * static_cast<size_t>(count) > 3 * labels.size() ? prefix : "";
}

// ---- The sets ---------------------------------------------------------------

// "*" in a name is replaced by the side.
std::string Sided(std::string name, char side) {
  std::replace(name.begin(), name.end(), '*', side);
  return name;
}

JointRule Centre(const std::string& joint, const Names& markers) {
  JointRule rule;
  rule.joint = joint;
  rule.markers = markers;
  rule.is_centre = true;
  return rule;
}

JointRule Near(const std::string& joint, const Names& markers,
               const Names& along = {}, double by_m = 0.0) {
  JointRule rule = Centre(joint, markers);
  rule.is_centre = false;
  rule.along = along;
  rule.by_m = by_m;
  return rule;
}

JointRule Hip(const Names& asis, const Names& psis) {
  JointRule rule = Near("*_hip", {});
  rule.hip = HipRule::kHarrington;
  rule.asis = asis;
  rule.psis = psis;
  return rule;
}

// Expands rules of one side to both.
MarkerSet BothSides(const std::string& name,
                    const std::vector<JointRule>& rules) {
  MarkerSet set{name, {}};
  for (const char side : {'l', 'r'}) {
    for (JointRule rule : rules) {
      rule.joint = Sided(rule.joint, side);
      for (Names* names :
           {&rule.markers, &rule.along, &rule.asis, &rule.psis}) {
        for (std::string& text : *names) text = Sided(text, side);
      }
      // From lasi to rasi is inwards for joints of the left side only.
      if (side == 'r' && rule.along == Names{"lasi", "rasi"}) {
        rule.along = {"rasi", "lasi"};
      }
      set.rules.push_back(std::move(rule));
    }
  }
  return set;
}

MarkerSet TheiaSegments() {
  return BothSides(
      "Theia3D segments",
      {Centre("*_hip", {"*_thigh"}), Centre("*_knee", {"*_shank"}),
       Centre("*_ankle", {"*_foot"}), Near("*_big_toe", {"*_toes"}),
       Centre("*_shoulder", {"*_uarm"}), Centre("*_elbow", {"*_larm"}),
       Centre("*_wrist", {"*_hand"})});
}

MarkerSet QualisysSports() {
  return BothSides(
      "Qualisys Sports",
      {Centre("*_knee", {"*KneeOut", "*KneeIn"}),
       Centre("*_elbow", {"*ElbowOut", "*ElbowIn"}),
       Centre("*_wrist", {"*WristOut", "*WristIn"}),
       Centre("*_ankle", {"*AnkleOut", "*AnkleIn"}),
       Near("*_ankle", {"*AnkleOut"}, {"*KneeOut", "*KneeIn"}, kAnkleM),
       Hip({"WaistLFront", "WaistRFront"}, {"WaistBack"}),
       Hip({"WaistLFront", "WaistRFront"}, {"WaistLBack", "WaistRBack"}),
       Near("*_shoulder", {"*ShoulderTop"}, {"*ShoulderTop", "*_elbow"},
            kShoulderM),
       Near("*_heel", {"*HeelBack"}), Near("*_big_toe", {"*Forefoot2"}),
       Near("*_small_toe", {"*Forefoot5"})});
}

// The model's own centres exist in the file if the model was run.
MarkerSet PlugInGait() {
  return BothSides(
      "Plug-in Gait",
      {Centre("*_hip", {"*FEP"}),
       Centre("*_knee", {"*FEO"}),
       Centre("*_ankle", {"*TIO"}),
       Centre("*_shoulder", {"*CLO"}),
       Centre("*_elbow", {"*HUO"}),
       Centre("*_wrist", {"*RAO"}),
       Hip({"LASI", "RASI"}, {"LPSI", "RPSI"}),
       Hip({"LASI", "RASI"}, {"SACR"}),
       Centre("*_knee", {"*KNE", "*KNM"}),
       Centre("*_knee", {"*KNE", "*KNEM"}),
       Centre("*_knee", {"*KNE", "*MKNE"}),
       Near("*_knee", {"*KNE"}, {"lasi", "rasi"}, kKneeM),
       Centre("*_ankle", {"*ANK", "*MED"}),
       Centre("*_ankle", {"*ANK", "*ANKM"}),
       Centre("*_ankle", {"*ANK", "*MANK"}),
       Near("*_ankle", {"*ANK"}, {"lasi", "rasi"}, kAnkleM),
       Centre("*_wrist", {"*WRA", "*WRB"}),
       Centre("*_elbow", {"*ELB", "*ELBM"}),
       Near("*_elbow", {"*ELB"}),
       Near("*_shoulder", {"*SHO"}, {"*SHO", "*_elbow"}, kShoulderM),
       Near("*_heel", {"*HEE"}),
       Near("*_big_toe", {"*TOE"})});
}

MarkerSet Cast() {
  return BothSides(
      "CAST", {Hip({"L_IAS", "R_IAS"}, {"L_IPS", "R_IPS"}),
               Centre("*_knee", {"*_FLE", "*_FME"}),
               Centre("*_ankle", {"*_FAL", "*_TAM"}),
               Centre("*_elbow", {"*_HLE", "*_HME"}),
               Centre("*_wrist", {"*_RSP", "*_USP"}),
               Near("*_shoulder", {"*_SAE"}, {"*_SAE", "*_elbow"}, kShoulderM),
               Near("*_heel", {"*_FCC"}), Near("*_big_toe", {"*_FM2"}),
               Near("*_big_toe", {"*_FM1"}), Near("*_small_toe", {"*_FM5"})});
}

MarkerSet OpenCap() {
  return BothSides(
      "OpenCap",
      {Centre("*_hip", {"*HJC"}),
       Hip({"L.ASIS", "r.ASIS"}, {"L.PSIS", "r.PSIS"}),
       Centre("*_knee", {"*_knee", "*_mknee"}),
       Centre("*_ankle", {"*_ankle", "*_mankle"}),
       Centre("*_elbow", {"*_lelbow", "*_melbow"}),
       Centre("*_wrist", {"*_lwrist", "*_mwrist"}),
       Near("*_shoulder", {"*_shoulder"}, {"*_shoulder", "*_elbow"},
            kShoulderM),
       Near("*_heel", {"*_calc"}), Near("*_big_toe", {"*_toe"}),
       Near("*_big_toe", {"*_big_toe"}), Near("*_small_toe", {"*_5meta"})});
}

// ---- Applying rules ---------------------------------------------------------

Names NamesIn(const JointRule& rule) {
  Names names = rule.markers;
  for (const Names* more : {&rule.along, &rule.asis, &rule.psis}) {
    names.insert(names.end(), more->begin(), more->end());
  }
  return names;
}

// Indices in a pose that has the markers, followed by the joints that rules
// define.
class Places {
 public:
  explicit Places(const Names& labels) {
    const std::string prefix = PrefixOf(labels);
    for (size_t i = 0; i < labels.size(); ++i) {
      markers_.try_emplace(Squeezed(labels[i]), i);
      if (labels[i].compare(0, prefix.size(), prefix) == 0) {
        markers_.try_emplace(Squeezed(labels[i].substr(prefix.size())), i);
      }
    }
    count_ = labels.size();
  }
  std::optional<size_t> Of(const std::string& name) const {
    const auto joint = joints_.find(name);
    if (joint != joints_.end()) return joint->second;
    const auto marker = markers_.find(Squeezed(name));
    if (marker == markers_.end()) return std::nullopt;
    return marker->second;
  }
  bool Has(const JointRule& rule) const {
    const Names names = NamesIn(rule);
    return std::all_of(
        names.begin(), names.end(),
        [this](const std::string& name) { return Of(name).has_value(); });
  }
  void Define(const std::string& joint) { joints_[joint] = count_++; }
  bool IsDefined(const std::string& joint) const {
    return joints_.count(joint) > 0;
  }
  std::vector<size_t> Of(const Names& names) const {
    std::vector<size_t> places;
    for (const std::string& name : names) places.push_back(Of(name).value());
    return places;
  }

 private:
  std::map<std::string, size_t> markers_, joints_;
  size_t count_ = 0;
};

// A rule with the indices of its names.
struct Placed {
  const JointRule* rule;
  std::vector<size_t> markers, along, asis, psis;
  bool is_left = false;
  Vector3d in_pelvis_m = Vector3d::Zero();  // of a functional hip
};

std::optional<Vector3d> MeanOf(const std::vector<size_t>& places,
                               const Pose3d& points) {
  Vector3d sum = Vector3d::Zero();
  for (const size_t place : places) {
    if (!points[place].present()) return std::nullopt;
    sum += points[place].position_m;
  }
  return Vector3d(sum / static_cast<double>(places.size()));
}

// Axes forward, up and to the right, origin between the ASIS.
struct Pelvis {
  Vector3d origin_m;
  Matrix3d axes;  // columns
  double width_m = 0.0;
  double depth_m = 0.0;
};

std::optional<Pelvis> PelvisOf(const Placed& placed, const Pose3d& points) {
  const auto left = MeanOf({placed.asis[0]}, points);
  const auto right = MeanOf({placed.asis[1]}, points);
  const auto back = MeanOf(placed.psis, points);
  if (!left || !right || !back) return std::nullopt;
  Pelvis pelvis;
  pelvis.origin_m = 0.5 * (*left + *right);
  pelvis.width_m = (*right - *left).norm();
  pelvis.depth_m = (pelvis.origin_m - *back).norm();
  if (!(pelvis.width_m > 0.0 && pelvis.depth_m > 0.0)) return std::nullopt;
  const Vector3d rightwards = (*right - *left) / pelvis.width_m;
  const Vector3d up = rightwards.cross(pelvis.origin_m - *back).normalized();
  pelvis.axes << up.cross(rightwards), up, rightwards;
  return pelvis;
}

// The right hip in the pelvis' axes [m]; the left one is its mirror image.
Vector3d HipInPelvis(HipRule rule, const Pelvis& pelvis) {
  const double width_m = pelvis.width_m;
  if (rule == HipRule::kBell) {
    return {-0.19 * width_m, -0.30 * width_m, 0.36 * width_m};
  }
  return {-0.24 * pelvis.depth_m - 0.0099, -0.30 * width_m - 0.0109,
          0.33 * width_m + 0.0073};
}

std::optional<Vector3d> JointAt(const Placed& placed, const Pose3d& points) {
  const JointRule& rule = *placed.rule;
  if (rule.hip != HipRule::kNone) {
    const auto pelvis = PelvisOf(placed, points);
    if (!pelvis) return std::nullopt;
    Vector3d hip_m = placed.in_pelvis_m;
    if (rule.hip != HipRule::kFunctional) {
      hip_m = HipInPelvis(rule.hip, *pelvis);
      if (placed.is_left) hip_m.z() = -hip_m.z();
    }
    return Vector3d(pelvis->origin_m + pelvis->axes * hip_m);
  }
  auto at_m = MeanOf(placed.markers, points);
  if (!at_m || placed.along.empty()) return at_m;
  const auto from = MeanOf({placed.along[0]}, points);
  const auto to = MeanOf({placed.along[1]}, points);
  if (!from || !to || *from == *to) return std::nullopt;
  return Vector3d(*at_m + rule.by_m * (*to - *from).normalized());
}

// The point of the pelvis at constant distance from each of the thigh's
// markers: least squares in the squared distances, in which it is linear
// (Gamage and Lasenby 2002).
Vector3d FunctionalHip(const Placed& placed, const std::vector<Pose3d>& poses) {
  Matrix3d information = Matrix3d::Zero();
  Vector3d right_side = Vector3d::Zero();
  double count = 0.0;
  for (const size_t marker : placed.markers) {
    std::vector<Vector3d> points;
    for (const Pose3d& pose : poses) {
      const auto pelvis = PelvisOf(placed, pose);
      if (!pelvis || !pose[marker].present()) continue;
      points.push_back(pelvis->axes.transpose() *
                       (pose[marker].position_m - pelvis->origin_m));
    }
    Vector3d mean = Vector3d::Zero();
    double mean_squared = 0.0;
    for (const Vector3d& point : points) {
      mean += point / static_cast<double>(points.size());
      mean_squared += point.squaredNorm() / static_cast<double>(points.size());
    }
    for (const Vector3d& point : points) {
      const Vector3d from_mean = point - mean;
      information += 2.0 * from_mean * from_mean.transpose();
      right_side += from_mean * (point.squaredNorm() - mean_squared);
    }
    count += static_cast<double>(points.size());
  }
  // In the direction of least movement the markers must still move by more than
  // skin moves over bone.
  constexpr double kLeastM = 0.008;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> spread(information / 2.0);
  if (!(count > 0.0) ||
      !(spread.eigenvalues()[0] > count * kLeastM * kLeastM)) {
    throw InputError("joint '" + Printable(placed.rule->joint) +
                     "': the thigh rotates too little about the hip for a "
                     "functional centre, expected circles with flexion and "
                     "abduction; regression = \"harrington\" needs no motion");
  }
  return information.ldlt().solve(right_side);
}

// With two subjects, "Anna:LKNE" and "Ben:LKNE", the subject is ambiguous.
void RequireOneSubject(const Names& labels) {
  std::map<std::string, std::string> seen;
  for (const std::string& label : labels) {
    const auto [other, is_new] = seen.try_emplace(Squeezed(label), label);
    const auto subject = [](const std::string& text) {
      return text.substr(0, text.find_last_of(':') + 1);
    };
    if (is_new || subject(other->second) == subject(label)) continue;
    throw InputError("has markers of several people, " +
                     Printable(other->second) + " and " + Printable(label) +
                     ", expected one person's");
  }
}

// The rules that apply, in their order; `lacking` receives the joints without
// such a rule, each with one missing marker.
std::vector<Placed> Place(const MarkerSet& set, const Names& labels,
                          Names* lacking) {
  Places places(labels);
  std::vector<Placed> placed;
  std::map<std::string, std::string> missing;
  for (const JointRule& rule : set.rules) {
    if (places.IsDefined(rule.joint)) continue;
    if (!places.Has(rule)) {
      for (const std::string& name : NamesIn(rule)) {
        if (!places.Of(name)) missing.try_emplace(rule.joint, name);
      }
      continue;
    }
    placed.push_back({&rule, places.Of(rule.markers), places.Of(rule.along),
                      places.Of(rule.asis), places.Of(rule.psis),
                      rule.joint.rfind("l_", 0) == 0});
    places.Define(rule.joint);
  }
  for (const auto& [joint, name] : missing) {
    if (!places.IsDefined(joint)) lacking->push_back(joint + " (" + name + ")");
  }
  return placed;
}

std::vector<Bone> BonesOf(const Skeleton& joints) {
  std::vector<Bone> bones;
  const auto add = [&](const std::string& a, const std::string& b) {
    const int at_a = joints.IndexOf(a), at_b = joints.IndexOf(b);
    if (at_a >= 0 && at_b >= 0) bones.push_back({at_a, at_b});
  };
  add("l_shoulder", "r_shoulder");
  add("l_hip", "r_hip");
  for (const std::string side : {"l_", "r_"}) {
    for (const auto& [a, b] : {std::pair{"shoulder", "elbow"},
                               {"elbow", "wrist"},
                               {"shoulder", "hip"},
                               {"hip", "knee"},
                               {"knee", "ankle"},
                               {"ankle", "heel"},
                               {"ankle", "big_toe"},
                               {"ankle", "small_toe"}}) {
      add(side + a, side + b);
    }
  }
  return bones;
}

}  // namespace

const std::vector<MarkerSet>& MarkerSets() {
  static const std::vector<MarkerSet> kSets = {
      TheiaSegments(), QualisysSports(), PlugInGait(), Cast(), OpenCap()};
  return kSets;
}

const MarkerSet* RecogniseMarkerSet(const std::vector<std::string>& labels) {
  constexpr size_t kLeastMarkers = 4;
  const Places places(labels);
  const MarkerSet* best = nullptr;
  size_t most = kLeastMarkers - 1;
  for (const MarkerSet& set : MarkerSets()) {
    std::set<std::string> markers;
    std::set<std::string> joints;
    for (const JointRule& rule : set.rules) joints.insert(Squeezed(rule.joint));
    for (const JointRule& rule : set.rules) {
      for (const std::string& name : NamesIn(rule)) {
        const std::string squeezed = Squeezed(name);
        if (joints.count(squeezed) == 0 && places.Of(name)) {
          markers.insert(squeezed);
        }
      }
    }
    if (markers.size() <= most) continue;
    most = markers.size();
    best = &set;
  }
  return best;
}

MarkerJoints JointsOfMarkers(const TrackSequence& markers,
                             const MarkerSet& set) {
  const Names& labels = markers.header.skeleton.joints();
  RequireOneSubject(labels);
  MarkerJoints result;
  std::vector<Placed> placed = Place(set, labels, &result.lacking);
  if (placed.empty()) {
    throw InputError("no joint of '" + Printable(set.name) +
                     "' has all its markers: found " +
                     Printable(labels.front(), 30) + " and " +
                     std::to_string(labels.size() - 1) + " others");
  }
  Names joints;
  for (const Placed& one : placed) {
    joints.push_back(one.rule->joint);
    result.is_centre.push_back(one.rule->is_centre);
  }
  result.tracks.header = markers.header;
  result.tracks.header.skeleton =
      Skeleton(set.name, joints, BonesOf(Skeleton(set.name, joints, {})));
  // Markers, followed by the joints defined so far.
  std::vector<Pose3d> poses;
  for (const TrackFrame& frame : markers.frames) {
    for (const PersonPose& person : frame.people) {
      poses.push_back(person.joints);
    }
  }
  for (Placed& one : placed) {
    if (one.rule->hip == HipRule::kFunctional) {
      one.in_pelvis_m = FunctionalHip(one, poses);
    }
    for (Pose3d& pose : poses) {
      const auto at_m = JointAt(one, pose);
      pose.push_back(at_m ? Joint3d{*at_m, JointStatus::kObserved} : Joint3d{});
    }
  }
  size_t next = 0;
  for (const TrackFrame& frame : markers.frames) {
    TrackFrame& made = result.tracks.frames.emplace_back();
    made.frame = frame.frame;
    made.time = frame.time;
    for (const PersonPose& person : frame.people) {
      const Pose3d& pose = poses[next++];
      PersonPose joints_of;
      joints_of.id = person.id;
      joints_of.joints.assign(
          pose.begin() + static_cast<std::ptrdiff_t>(labels.size()),
          pose.end());
      made.people.push_back(std::move(joints_of));
    }
  }
  return result;
}

}  // namespace kinegraph
