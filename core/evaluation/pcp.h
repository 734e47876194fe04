// Percentage of correct parts (PCP) on Campus and Shelf.
//
// The published tables differ in the head conversion, in the criterion for a
// correct part and in how people are matched; a protocol value specifies all of
// these.
#ifndef KINEGRAPH_CORE_EVALUATION_PCP_H_
#define KINEGRAPH_CORE_EVALUATION_PCP_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/frame_range.h"
#include "core/base/ids.h"
#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/statistics.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Conversions of the head from any skeleton to the 14 joints of the Campus and
// Shelf ground truth. Detectors report nose and ears, the annotation has the
// bottom and the top of the head. Publications differ in the conversion, and
// the choice alone can change a PCP by a percentage point, so a protocol
// specifies it. With m = middle of the shoulders, n = nose, e = middle of the
// ears; products are taken axis by axis in the world (z up), as in the
// publications.
enum class HeadConversion {
  // top = m + (n - m) * (0.78, 0.5, 1.5),
  // bottom = m + (n - m) * (0.3, 0.4, 0.6)
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

// By the value of the flag --head: chu, mvpose, voxelpose, 4d, raw. "voxelpose"
// selects the Campus form if `campus`, else the Shelf form. nullopt for another
// name.
std::optional<HeadConversion> HeadConversionByName(const std::string& name,
                                                   bool campus);

// Converts poses of one skeleton to Tum14. Joints are selected by name; the two
// of the head are computed unless the skeleton has both (which makes it a
// ground truth). A joint without a source, in the skeleton or in the pose, is
// missing. A computed joint is observed only if all its sources are.
class Tum14Converter {
 public:
  Tum14Converter(const Skeleton& from, HeadConversion conversion);
  Pose3d operator()(const Pose3d& pose) const;

 private:
  // Bottom and top.
  std::pair<Joint3d, Joint3d> Head(const Pose3d& pose) const;

  HeadConversion conversion_;
  std::vector<int> source_;       // for each joint of Tum14, or -1
  std::vector<int> head_source_;  // for each source of a head, or -1
};

// The middle of two joints: missing if one of them is.
Joint3d Middle(const Joint3d& a, const Joint3d& b);

// The ten parts; names and groups below.
inline constexpr int kPcpPartCount = 10;
const char* PcpPartName(int part);  // "r_lower_leg", ..., "head", "torso"

enum class PcpGroup {
  kHead,
  kTorso,
  kUpperArms,
  kLowerArms,
  kUpperLegs,
  kLowerLegs,
  kTotal,
};
inline constexpr std::array<PcpGroup, 7> kPcpGroups = {
    PcpGroup::kHead,      PcpGroup::kTorso,     PcpGroup::kUpperArms,
    PcpGroup::kLowerArms, PcpGroup::kUpperLegs, PcpGroup::kLowerLegs,
    PcpGroup::kTotal};
const char* ToString(PcpGroup group);  // "head", "upper arms", ..., "total"
PcpGroup PcpGroupOf(int part);         // never kTotal

enum class EndpointRule {
  kMean,  // the mean error of both ends decides
  kEach,  // both ends must be correct
};
enum class PersonMatching {
  // Each true person takes the nearest prediction (least mean squared distance
  // over the joints that both have), at any distance, even if another true
  // person takes it too.
  kNearest,
  // One-to-one by mean distance, up to the gate.
  kOneToOne,
};

const char* ToString(EndpointRule rule);        // "mean", "each"
const char* ToString(PersonMatching matching);  // "nearest", "one_to_one"

struct PcpProtocol {
  std::string name;
  std::vector<FrameRange> frames;  // of the tracks; empty: all
  // If the tracks have no frame at the instant of a true frame, their frame
  // nearest in time replaces it, at most this far away [s]. Otherwise, or if 0,
  // nobody is found in the true frame.
  double max_time_gap_s = 0.0;
  HeadConversion head = HeadConversion::kChu;
  EndpointRule endpoints = EndpointRule::kMean;
  double tolerance = 0.5;  // share of the true length
  // Whether an error equal to the tolerance is incorrect.
  bool strictly_less = false;
  PersonMatching matching = PersonMatching::kNearest;
  double gate_m = kPersonGateM;  // for kOneToOne
  // 4D association's own program: the mid-hip is a separate joint, in the
  // matching and as the torso's lower end; a true person for whom no prediction
  // is left is not counted; zeros stored for joints that were not found are
  // treated as positions (StoredZeros::kKeep of the reader).
  bool mid_hip_is_a_joint = false;
  bool skip_unmatched = false;
  bool stored_zeros_are_positions = false;
  // Actors (true people, numbered from zero) whose mean is the headline, i.e.
  // the score that is quoted; empty: all.
  std::vector<int64_t> headline_actors = {0, 1, 2};
};

// Frames 300..600, chu head, mean rule, nearest.
PcpProtocol ShelfProtocol();
// Frames 350..470 and 650..750; a missing frame is replaced by the nearest in
// time, at most 0.1 s away.
PcpProtocol CampusProtocol();
// As CampusProtocol, but frames 350..750.
PcpProtocol CampusExtendedProtocol();
// Shelf by the rules of 4D association's own program (Zhang et al. 2020).
PcpProtocol FourDAssociationProtocol();

// "shelf", "campus", "campus_extended", "4d_association"; nullopt for another
// name.
std::optional<PcpProtocol> PcpProtocolByName(const std::string& name);

enum class PartVerdict : uint8_t {
  kNotCounted,  // the ground truth lacks an end
  kWrong,
  kRight,
};

// One true person in one frame.
struct PcpPersonFrame {
  int64_t frame = 0;  // the truth's number
  int64_t actor = 0;
  std::optional<TrackId> predicted;  // nullopt: none
  std::array<PartVerdict, kPcpPartCount> parts{};

  Share Count(PcpGroup group) const;
};

// The reason why a part is incorrect.
enum class LossReason {
  kNoPose,     // no prediction is matched with the person
  kElsewhere,  // the matched prediction is beyond kPersonGateM, or no joint can
               // be compared: another person
  kNoJoint,    // the prediction lacks an end
  kTooFar,     // the errors exceed the tolerance, by the EndpointRule
};
inline constexpr int kLossReasonCount = 4;
const char* ToString(LossReason reason);  // "nobody", "elsewhere", ...

// An incorrect part. An error is nullopt where there is no predicted joint.
struct LostPart {
  int64_t frame = 0;
  int64_t actor = 0;
  int part = 0;
  std::optional<TrackId> predicted;
  double length_m = 0.0;
  std::optional<double> first_error_m;  // the distal end, or the lower one
  std::optional<double> second_error_m;
  // Mean distance of the prediction from the true person, over the joints that
  // both have.
  std::optional<double> person_distance_m;

  LossReason reason() const;
};

struct PcpResult {
  PcpProtocol protocol;
  std::vector<PcpPersonFrame> person_frames;  // by actor, then by frame
  std::vector<LostPart> lost;                 // in the same order

  std::vector<int64_t> Actors() const;  // ascending
  // The actors of the headline among those scored.
  std::vector<int64_t> HeadlineActors() const;
};

PcpResult EvaluatePcp(const TrackSequence& truth, const TrackSequence& tracks,
                      const PcpProtocol& protocol);

// Correct parts and all parts of a group: of one actor, and of the headline's
// actors pooled.
Share CountParts(const PcpResult& result, int64_t actor, PcpGroup group);
Share PooledParts(const PcpResult& result, PcpGroup group);
// Unweighted mean over the headline's actors [%]; NaN if none was counted.
double MeanOfActors(const PcpResult& result, PcpGroup group);

// Intervals in percent, blocks drawn within each actor.
Interval ActorInterval(const PcpResult& result, int64_t actor, PcpGroup group,
                       const BootstrapOptions& options = {});
Interval MeanOfActorsInterval(const PcpResult& result, PcpGroup group,
                              const BootstrapOptions& options = {});
// For MeanOfActors(a) - MeanOfActors(b), with the same frames drawn for both.
// Throws OptionError when the two were not scored on the same person-frames.
Interval MeanOfActorsDifference(const PcpResult& a, const PcpResult& b,
                                PcpGroup group,
                                const BootstrapOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_PCP_H_
