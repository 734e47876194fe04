#include "core/evaluation/pcp.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>
#include <tuple>

#include "core/base/error.h"
#include "core/base/time.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

// ---- Heads ------------------------------------------------------------------

// See HeadConversion: the first two for k4d, the last for kVoxelposeShelf.
constexpr double kFaceForwardM = 0.125;
constexpr double kFaceUpM = 0.145;
constexpr double kMvposeShare = 0.75;

// The joints from which a head is computed.
enum HeadSource {
  kNose,
  kLeftEar,
  kRightEar,
  kLeftShoulder,
  kRightShoulder,
  kLeftHip,
  kRightHip,
  kNeck,
  kMidHip
};
const Skeleton& HeadSources() {
  static const Skeleton kSources(
      "head",
      {"nose", "l_ear", "r_ear", "l_shoulder", "r_shoulder", "l_hip", "r_hip",
       "neck", "mid_hip"},
      {});
  return kSources;
}

JointStatus Worst(std::initializer_list<const Joint3d*> joints) {
  JointStatus worst = JointStatus::kObserved;
  for (const Joint3d* joint : joints) worst = std::min(worst, joint->status);
  return worst;
}

const Joint3d& At(const Pose3d& pose, int joint) {
  static const Joint3d kMissing;
  return joint < 0 ? kMissing : pose[joint];
}

// m + (n - m) * (x, y, z), axis by axis.
Vector3d Towards(const Vector3d& m, const Vector3d& n, double x, double y,
                 double z) {
  return m + (n - m).cwiseProduct(Vector3d(x, y, z));
}

// ---- Parts ------------------------------------------------------------------

// Index of the mid-hip, appended to the joints of Tum14.
constexpr int kTorsoEnd = 14;

struct PartDefinition {
  const char* name;
  PcpGroup group;
  int first;  // joints of Tum14, or kTorsoEnd
  int second;
};

constexpr std::array<PartDefinition, kPcpPartCount> kParts = {{
    {"r_lower_leg", PcpGroup::kLowerLegs, 0, 1},
    {"r_upper_leg", PcpGroup::kUpperLegs, 1, 2},
    {"l_upper_leg", PcpGroup::kUpperLegs, 4, 3},
    {"l_lower_leg", PcpGroup::kLowerLegs, 5, 4},
    {"r_lower_arm", PcpGroup::kLowerArms, 6, 7},
    {"r_upper_arm", PcpGroup::kUpperArms, 7, 8},
    {"l_upper_arm", PcpGroup::kUpperArms, 10, 9},
    {"l_lower_arm", PcpGroup::kLowerArms, 11, 10},
    {"head", PcpGroup::kHead, 12, 13},
    {"torso", PcpGroup::kTorso, kTorsoEnd, 12},
}};

// The 14 joints and the mid-hip.
class PcpPoseMaker {
 public:
  PcpPoseMaker(const Skeleton& from, const PcpProtocol& protocol)
      : to_tum14_(from, protocol.head) {
    if (protocol.mid_hip_is_a_joint) mid_hip_ = from.IndexOf("mid_hip");
  }

  Pose3d operator()(const Pose3d& pose) const {
    static const int kRight = Tum14().IndexOf("r_hip");
    static const int kLeft = Tum14().IndexOf("l_hip");
    Pose3d converted = to_tum14_(pose);
    converted.push_back(mid_hip_ >= 0
                            ? pose[mid_hip_]
                            : Middle(converted[kRight], converted[kLeft]));
    return converted;
  }

 private:
  Tum14Converter to_tum14_;
  int mid_hip_ = -1;
};

std::vector<PersonPose> ConvertPeople(const std::vector<PersonPose>& people,
                                      const PcpPoseMaker& make_pose) {
  std::vector<PersonPose> converted(people.size());
  for (size_t i = 0; i < people.size(); ++i) {
    converted[i].id = people[i].id;
    converted[i].joints = make_pose(people[i].joints);
  }
  return converted;
}

// The joints by which people are matched.
JointPairs MatchingJoints(const PcpProtocol& protocol) {
  return SameJoints(protocol.mid_hip_is_a_joint ? kTorsoEnd + 1 : kTorsoEnd);
}

const PersonPose* Nearest(const PersonPose& truth,
                          const std::vector<PersonPose>& found,
                          const JointPairs& joints) {
  const PersonPose* nearest = nullptr;
  double least = kNoGate;
  for (const PersonPose& candidate : found) {
    const std::optional<double> distance =
        MeanSquaredDistance(truth.joints, candidate.joints, joints);
    if (!distance || *distance >= least) continue;
    least = *distance;
    nearest = &candidate;
  }
  return nearest;
}

// The prediction for each true person, or nullptr.
std::vector<const PersonPose*> MatchPeople(const std::vector<PersonPose>& truth,
                                           const std::vector<PersonPose>& found,
                                           const PcpProtocol& protocol) {
  const JointPairs joints = MatchingJoints(protocol);
  std::vector<const PersonPose*> matches(truth.size(), nullptr);
  if (protocol.matching == PersonMatching::kNearest) {
    for (size_t i = 0; i < truth.size(); ++i) {
      matches[i] = Nearest(truth[i], found, joints);
    }
    return matches;
  }
  for (const CostPair& pair :
       MatchOneToOne(PersonDistances(truth, found, joints), protocol.gate_m)) {
    matches[pair.row] = &found[pair.column];
  }
  return matches;
}

std::optional<double> JointError(const Pose3d& truth, const Pose3d* found,
                                 int joint) {
  if (found == nullptr || !(*found)[joint].present()) return std::nullopt;
  return (truth[joint].position_m - (*found)[joint].position_m).norm();
}

bool Within(double error_m, double length_m, const PcpProtocol& protocol) {
  const double limit_m = protocol.tolerance * length_m;
  return protocol.strictly_less ? error_m < limit_m : error_m <= limit_m;
}

bool IsRight(const std::optional<double>& first_error_m,
             const std::optional<double>& second_error_m, double length_m,
             const PcpProtocol& protocol) {
  if (!first_error_m || !second_error_m) return false;
  if (protocol.endpoints == EndpointRule::kMean) {
    return Within(0.5 * (*first_error_m + *second_error_m), length_m, protocol);
  }
  return Within(*first_error_m, length_m, protocol) &&
         Within(*second_error_m, length_m, protocol);
}

// Scores the parts of one person; lost ones are appended to `lost`.
PcpPersonFrame ScorePerson(int64_t frame, const PersonPose& truth,
                           const PersonPose* found, const PcpProtocol& protocol,
                           std::vector<LostPart>* lost) {
  PcpPersonFrame scored;
  scored.frame = frame;
  scored.actor = truth.id.value();
  const Pose3d* pose = found == nullptr ? nullptr : &found->joints;
  LostPart part;  // buffer, overwritten by each part
  part.frame = frame;
  part.actor = scored.actor;
  if (found != nullptr) {
    scored.predicted = part.predicted = found->id;
    part.person_distance_m =
        MeanDistance(truth.joints, *pose, MatchingJoints(protocol));
  }
  for (part.part = 0; part.part < kPcpPartCount; ++part.part) {
    const int first = kParts[part.part].first;
    const int second = kParts[part.part].second;
    if (!truth.joints[first].present() || !truth.joints[second].present()) {
      continue;
    }
    part.length_m =
        (truth.joints[first].position_m - truth.joints[second].position_m)
            .norm();
    part.first_error_m = JointError(truth.joints, pose, first);
    part.second_error_m = JointError(truth.joints, pose, second);
    const bool is_right = IsRight(part.first_error_m, part.second_error_m,
                                  part.length_m, protocol);
    scored.parts[part.part] =
        is_right ? PartVerdict::kRight : PartVerdict::kWrong;
    if (!is_right) lost->push_back(part);
  }
  return scored;
}

// The frame of the tracks nearest in time to the frame of that number, the
// earlier on a tie; nullptr if none is near enough. Times follow from frame
// numbers, because the ground truth may have no times.
const TrackFrame* NearestInTime(const TrackSequence& tracks, int64_t number,
                                const FrameClock& clock,
                                double max_time_gap_s) {
  const TrackFrame* nearest = nullptr;
  TimeNs least_gap = FromSeconds(max_time_gap_s) + 1;
  for (const TrackFrame& frame : tracks.frames) {
    const TimeNs gap = clock.TimeOf(std::abs(frame.frame - number));
    if (gap >= least_gap) continue;
    nearest = &frame;
    least_gap = gap;
  }
  return nearest;
}

// A series per actor, with one RatioUnit per person-frame.
std::vector<RatioSeries> Series(const PcpResult& result,
                                const std::vector<int64_t>& actors,
                                PcpGroup group) {
  std::vector<RatioSeries> series(actors.size());
  for (const PcpPersonFrame& person : result.person_frames) {
    const auto at = std::find(actors.begin(), actors.end(), person.actor);
    if (at == actors.end()) continue;
    const Share share = person.Count(group);
    series[at - actors.begin()].push_back(
        {100.0 * static_cast<double>(share.count),
         static_cast<double>(share.total)});
  }
  return series;
}

}  // namespace

const char* ToString(HeadConversion conversion) {
  static constexpr const char* kNames[] = {
      "chu", "mvpose", "voxelpose_campus", "voxelpose_shelf", "4d", "raw"};
  return kNames[static_cast<size_t>(conversion)];
}

std::optional<HeadConversion> HeadConversionByName(const std::string& name,
                                                   bool campus) {
  if (name == "voxelpose") {
    return campus ? HeadConversion::kVoxelposeCampus
                  : HeadConversion::kVoxelposeShelf;
  }
  for (const HeadConversion conversion :
       {HeadConversion::kChu, HeadConversion::kMvpose, HeadConversion::k4d,
        HeadConversion::kRaw}) {
    if (name == ToString(conversion)) return conversion;
  }
  return std::nullopt;
}

Joint3d Middle(const Joint3d& a, const Joint3d& b) {
  return {0.5 * (a.position_m + b.position_m), Worst({&a, &b})};
}

Tum14Converter::Tum14Converter(const Skeleton& from, HeadConversion conversion)
    : conversion_(conversion),
      source_(MapByName(from, Tum14())),
      head_source_(MapByName(from, HeadSources())) {}

Pose3d Tum14Converter::operator()(const Pose3d& pose) const {
  static const int kBottom = Tum14().IndexOf("head_bottom");
  static const int kTop = Tum14().IndexOf("head_top");
  Pose3d converted;
  converted.reserve(source_.size());
  for (const int joint : source_) converted.push_back(At(pose, joint));
  if (source_[kBottom] < 0 || source_[kTop] < 0) {
    std::tie(converted[kBottom], converted[kTop]) = Head(pose);
  }
  return converted;
}

std::pair<Joint3d, Joint3d> Tum14Converter::Head(const Pose3d& pose) const {
  const auto at = [&](HeadSource source) -> const Joint3d& {
    return At(pose, head_source_[source]);
  };
  const Joint3d& l_shoulder = at(kLeftShoulder);
  const Joint3d& r_shoulder = at(kRightShoulder);
  const Joint3d shoulders = Middle(l_shoulder, r_shoulder);
  const Joint3d ears = Middle(at(kLeftEar), at(kRightEar));
  const Joint3d& nose = at(kNose);
  const Vector3d& m = shoulders.position_m;
  const Vector3d& n = nose.position_m;
  const Vector3d& e = ears.position_m;
  const JointStatus by_nose = Worst({&shoulders, &nose});
  const JointStatus by_ears = Worst({&shoulders, &ears});

  const Vector3d by_ears_m = 0.5 * (m + e);
  switch (conversion_) {
    case HeadConversion::kChu:
      return {{Towards(m, n, 0.3, 0.4, 0.6), by_nose},
              {Towards(m, n, 0.78, 0.5, 1.5), by_nose}};
    case HeadConversion::kMvpose:
      return {{Towards(m, n, 0.5, 0.5, 0.5), by_nose},
              {Towards(m, n, 0.75, 0.75, 1.5), by_nose}};
    case HeadConversion::kVoxelposeCampus:
      return {{by_ears_m, by_ears}, {2.0 * e - by_ears_m, by_ears}};
    case HeadConversion::kVoxelposeShelf: {
      const Vector3d top = 2.0 * e - by_ears_m;
      const JointStatus status = Worst({&shoulders, &nose, &ears});
      return {{kMvposeShare * Towards(m, n, 0.5, 0.5, 0.5) +
                   (1.0 - kMvposeShare) * by_ears_m,
               status},
              {kMvposeShare * Towards(m, n, 0.75, 0.75, 1.5) +
                   (1.0 - kMvposeShare) * top,
               status}};
    }
    case HeadConversion::k4d: {
      const Joint3d neck = at(kNeck).present() ? at(kNeck) : shoulders;
      const Joint3d hips = at(kMidHip).present()
                               ? at(kMidHip)
                               : Middle(at(kLeftHip), at(kRightHip));
      const Vector3d face =
          (neck.position_m - hips.position_m)
              .cross(r_shoulder.position_m - l_shoulder.position_m)
              .normalized();
      return {{by_ears_m, by_ears},
              {by_ears_m + kFaceForwardM * face + kFaceUpM * Vector3d::UnitZ(),
               Worst({&shoulders, &ears, &neck, &hips})}};
    }
    case HeadConversion::kRaw:
      break;
  }
  return {{m, shoulders.status}, {n, nose.status}};
}

const char* PcpPartName(int part) { return kParts[part].name; }

PcpGroup PcpGroupOf(int part) { return kParts[part].group; }

const char* ToString(PcpGroup group) {
  static constexpr std::array<const char*, kPcpGroups.size()> kNames = {
      "head",       "torso",      "upper arms", "lower arms",
      "upper legs", "lower legs", "total"};
  return kNames[static_cast<size_t>(group)];
}

const char* ToString(EndpointRule rule) {
  return rule == EndpointRule::kMean ? "mean" : "each";
}

const char* ToString(PersonMatching matching) {
  return matching == PersonMatching::kNearest ? "nearest" : "one_to_one";
}

const char* ToString(LossReason reason) {
  static constexpr std::array<const char*, kLossReasonCount> kNames = {
      "nobody", "elsewhere", "no joint", "too far"};
  return kNames[static_cast<size_t>(reason)];
}

LossReason LostPart::reason() const {
  if (!predicted) return LossReason::kNoPose;
  if (!person_distance_m || *person_distance_m > kPersonGateM) {
    return LossReason::kElsewhere;
  }
  if (!first_error_m || !second_error_m) return LossReason::kNoJoint;
  return LossReason::kTooFar;
}

PcpProtocol ShelfProtocol() {
  PcpProtocol protocol;
  protocol.name = "shelf";
  protocol.frames = {{300, 601}};
  return protocol;
}

PcpProtocol CampusProtocol() {
  PcpProtocol protocol;
  protocol.name = "campus";
  protocol.frames = {{350, 471}, {650, 751}};
  protocol.max_time_gap_s = 0.1;
  return protocol;
}

PcpProtocol CampusExtendedProtocol() {
  PcpProtocol protocol = CampusProtocol();
  protocol.name = "campus_extended";
  protocol.frames = {{350, 751}};
  return protocol;
}

PcpProtocol FourDAssociationProtocol() {
  PcpProtocol protocol = ShelfProtocol();
  protocol.name = "4d_association";
  protocol.head = HeadConversion::k4d;
  protocol.strictly_less = true;
  protocol.matching = PersonMatching::kOneToOne;
  protocol.gate_m = kNoGate;
  protocol.mid_hip_is_a_joint = true;
  protocol.skip_unmatched = true;
  protocol.stored_zeros_are_positions = true;
  return protocol;
}

std::optional<PcpProtocol> PcpProtocolByName(const std::string& name) {
  for (PcpProtocol (*make)() :
       {ShelfProtocol, CampusProtocol, CampusExtendedProtocol,
        FourDAssociationProtocol}) {
    PcpProtocol protocol = make();
    if (protocol.name == name) return protocol;
  }
  return std::nullopt;
}

Share PcpPersonFrame::Count(PcpGroup group) const {
  Share share;
  for (int part = 0; part < kPcpPartCount; ++part) {
    const bool is_in = group == PcpGroup::kTotal || group == kParts[part].group;
    if (is_in && parts[part] != PartVerdict::kNotCounted) {
      share.Add(parts[part] == PartVerdict::kRight);
    }
  }
  return share;
}

std::vector<int64_t> PcpResult::Actors() const {
  std::set<int64_t> actors;
  for (const PcpPersonFrame& person : person_frames) {
    actors.insert(person.actor);
  }
  return {actors.begin(), actors.end()};
}

std::vector<int64_t> PcpResult::HeadlineActors() const {
  std::vector<int64_t> actors = Actors();
  const std::vector<int64_t>& wanted = protocol.headline_actors;
  if (wanted.empty()) return actors;
  const auto is_asked = [&](int64_t actor) {
    return std::find(wanted.begin(), wanted.end(), actor) != wanted.end();
  };
  actors.erase(std::stable_partition(actors.begin(), actors.end(), is_asked),
               actors.end());
  return actors;
}

PcpResult EvaluatePcp(const TrackSequence& truth, const TrackSequence& tracks,
                      const PcpProtocol& protocol) {
  const PcpPoseMaker make_true_pose(truth.header.skeleton, protocol);
  const PcpPoseMaker make_found_pose(tracks.header.skeleton, protocol);
  PcpResult result;
  result.protocol = protocol;
  const FramePairing pairing = PairFrames(truth, tracks, protocol.frames);
  constexpr double kCampusHz = 25.0;  // if the rate of the tracks is unknown
  const FrameClock clock(pairing.tracks_rate_hz > 0.0 ? pairing.tracks_rate_hz
                                                      : kCampusHz);
  for (const FramePair& both : pairing.pairs) {
    if (both.truth == nullptr) continue;
    const TrackFrame& true_frame = *both.truth;
    const std::vector<PersonPose> true_people =
        ConvertPeople(true_frame.people, make_true_pose);
    const TrackFrame* frame = both.tracks;
    if (frame == nullptr && protocol.max_time_gap_s > 0.0) {
      frame = NearestInTime(tracks, both.frame, clock, protocol.max_time_gap_s);
    }
    const std::vector<PersonPose> found_people =
        ConvertPeople(PeopleOf(frame), make_found_pose);
    const std::vector<const PersonPose*> matches =
        MatchPeople(true_people, found_people, protocol);
    for (size_t i = 0; i < true_people.size(); ++i) {
      if (matches[i] == nullptr && protocol.skip_unmatched) continue;
      result.person_frames.push_back(ScorePerson(true_frame.frame,
                                                 true_people[i], matches[i],
                                                 protocol, &result.lost));
    }
  }
  SortByActorAndFrame(&result.person_frames);
  SortByActorAndFrame(&result.lost);
  return result;
}

Share CountParts(const PcpResult& result, int64_t actor, PcpGroup group) {
  Share share;
  for (const PcpPersonFrame& person : result.person_frames) {
    if (person.actor == actor) share += person.Count(group);
  }
  return share;
}

Share PooledParts(const PcpResult& result, PcpGroup group) {
  Share share;
  for (const int64_t actor : result.HeadlineActors()) {
    share += CountParts(result, actor, group);
  }
  return share;
}

double MeanOfActors(const PcpResult& result, PcpGroup group) {
  return MeanOfRatios(Series(result, result.HeadlineActors(), group));
}

Interval ActorInterval(const PcpResult& result, int64_t actor, PcpGroup group,
                       const BootstrapOptions& options) {
  return RatioInterval(MeanOfRatios, Series(result, {actor}, group), options);
}

Interval MeanOfActorsInterval(const PcpResult& result, PcpGroup group,
                              const BootstrapOptions& options) {
  return RatioInterval(MeanOfRatios,
                       Series(result, result.HeadlineActors(), group), options);
}

Interval MeanOfActorsDifference(const PcpResult& a, const PcpResult& b,
                                PcpGroup group,
                                const BootstrapOptions& options) {
  const auto same_person_frame = [](const PcpPersonFrame& one,
                                    const PcpPersonFrame& other) {
    return one.actor == other.actor && one.frame == other.frame;
  };
  if (!std::equal(a.person_frames.begin(), a.person_frames.end(),
                  b.person_frames.begin(), b.person_frames.end(),
                  same_person_frame)) {
    throw OptionError("paired difference",
                      "the two results were not scored on the same frames");
  }
  return PairedInterval(MeanOfRatios, Series(a, a.HeadlineActors(), group),
                        Series(b, b.HeadlineActors(), group), options);
}

}  // namespace kinegraph
