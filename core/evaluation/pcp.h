// Percentage of correct parts (PCP) on Campus and Shelf.
//
// The published tables differ in the head conversion, in what makes a part
// correct and in how people are matched; a protocol is a value that says all
// of it.
#ifndef KINEGRAPH_CORE_EVALUATION_PCP_H_
#define KINEGRAPH_CORE_EVALUATION_PCP_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/base/ids.h"
#include "core/data/pose.h"
#include "core/evaluation/bootstrap.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/head_conversion.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

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
  kMean,  // the mean of the errors of both ends counts
  kEach,  // each end counts
};
enum class PersonMatching {
  // Each true person takes the nearest prediction (least mean squared distance
  // over the joints that both have), however far, and also one that another
  // true person took.
  kNearest,
  // One-to-one by mean distance, up to the gate.
  kOneToOne,
};

const char* ToString(EndpointRule rule);        // "mean", "each"
const char* ToString(PersonMatching matching);  // "nearest", "one_to_one"

struct PcpProtocol {
  std::string name;
  std::vector<FrameRange> frames;  // of the ground truth; none: all
  // Where the result has no frame of this number: the frame nearest in time
  // stands for it, at most this far away [s]. 0: nobody was found.
  double max_time_gap_s = 0.0;
  HeadConversion head = HeadConversion::kChu;
  EndpointRule endpoints = EndpointRule::kMean;
  double tolerance = 0.5;  // share of the true length
  // An error must lie below the tolerance; else it may also equal it.
  bool strictly_less = false;
  PersonMatching matching = PersonMatching::kNearest;
  double gate_m = kPersonGateM;  // of kOneToOne
  // 4D association's own program: the middle of the hips is a joint of its
  // own, in the matching and as the torso's lower end; a true person for whom
  // no prediction is left is not counted; zeros stored for joints that were
  // not found are positions (StoredZeros::kKeep of the reader).
  bool mid_hip_is_a_joint = false;
  bool skip_unmatched = false;
  bool stored_zeros_are_positions = false;
  // Whose mean is the headline; none: all. Actors count from zero.
  std::vector<int64_t> headline_actors = {0, 1, 2};
};

// Frames 300..600, chu head, mean rule, nearest.
PcpProtocol ShelfProtocol();
// Frames 350..470 and 650..750; a frame that the result does not have is the
// nearest one in time, at most 0.1 s away.
PcpProtocol CampusProtocol();
// Frames 350..750.
PcpProtocol CampusExtendedProtocol();
// Shelf by the rules of 4D association's own program (Zhang et al. 2020).
PcpProtocol FourDAssociationProtocol();

// "shelf", "campus", "campus_extended", "4d_association"; nullopt for another.
std::optional<PcpProtocol> PcpProtocolByName(const std::string& name);

enum class PartVerdict : uint8_t {
  kNotCounted,  // the ground truth lacks an end
  kWrong,
  kRight,
};

// One true person in one frame.
struct PcpPersonFrame {
  int64_t frame = 0;
  int64_t actor = 0;
  std::optional<TrackId> predicted;  // nullopt: nobody
  std::array<PartVerdict, kPcpPartCount> parts{};

  Share Count(PcpGroup group) const;
};

// Why a part was counted wrong.
enum class LossReason {
  kNobody,     // no prediction in the frame
  kElsewhere,  // the nearest prediction is beyond kPersonGateM: another person
  kNoJoint,    // the prediction lacks an end
  kTooFar,     // an end, or both, too far off
};
inline constexpr int kLossReasonCount = 4;
const char* ToString(LossReason reason);  // "nobody", "elsewhere", ...

// A part that was counted wrong. An error is nullopt where there is no
// predicted joint.
struct LostPart {
  int64_t frame = 0;
  int64_t actor = 0;
  int part = 0;
  std::optional<TrackId> predicted;
  double length_m = 0.0;
  std::optional<double> first_error_m;  // farther from the trunk or lower
  std::optional<double> second_error_m;
  // Mean distance of the prediction over the joints that both have.
  std::optional<double> person_distance_m;

  LossReason reason() const;
};

struct PcpResult {
  PcpProtocol protocol;
  std::vector<PcpPersonFrame> person_frames;  // by actor, then by frame
  std::vector<LostPart> lost;                 // in that order

  std::vector<int64_t> Actors() const;  // ascending
  // The actors of the headline that the ground truth has.
  std::vector<int64_t> HeadlineActors() const;
};

// The frame of a result that is scored in a frame of the ground truth; nullptr:
// nobody was found.
const TrackFrame* FindPredictedFrame(const TrackSequence& tracks,
                                     const TrackFrame& true_frame,
                                     const PcpProtocol& protocol);

PcpResult EvaluatePcp(const TrackSequence& truth, const TrackSequence& tracks,
                      const PcpProtocol& protocol);

// Right and all parts of a group: of one actor, and of the headline's actors
// pooled.
Share CountParts(const PcpResult& result, int64_t actor, PcpGroup group);
Share PooledParts(const PcpResult& result, PcpGroup group);
// Plain mean over the headline's actors [%]; NaN when none was counted.
double MeanOfActors(const PcpResult& result, PcpGroup group);

// Intervals in percent, blocks drawn within each actor.
Interval ActorInterval(const PcpResult& result, int64_t actor, PcpGroup group,
                       const BootstrapOptions& options = {});
Interval MeanOfActorsInterval(const PcpResult& result, PcpGroup group,
                              const BootstrapOptions& options = {});
// Of MeanOfActors(a) - MeanOfActors(b), the same frames drawn of both. Throws
// OptionError when the two were not scored on the same person-frames.
Interval MeanOfActorsDifference(const PcpResult& a, const PcpResult& b,
                                PcpGroup group,
                                const BootstrapOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_PCP_H_
