#include "core/evaluation/parity.h"

#include <map>
#include <set>

#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

// Which identities of the one stood for which of the other.
class IdentityMap {
 public:
  void Add(TrackId a, TrackId b) {
    b_of_a_[a].insert(b);
    a_of_b_[b].insert(a);
  }
  bool OneToOne() const { return Unique(b_of_a_) && Unique(a_of_b_); }

 private:
  using Map = std::map<TrackId, std::set<TrackId>>;
  static bool Unique(const Map& map) {
    for (const auto& [id, others] : map) {
      if (others.size() > 1) return false;
    }
    return true;
  }
  Map b_of_a_;
  Map a_of_b_;
};

// Adds the joints of a pair of people; nullptr stands for nobody.
void AddJoints(int64_t frame, const PersonPose* reference,
               const PersonPose* person, const JointPairs& joints,
               const ParityOptions& options, ParityResult* result) {
  for (const JointPair& pair : joints) {
    const bool expected = reference && reference->joints[pair.a].present();
    const bool found = person && person->joints[pair.b].present();
    if (!expected && !found) continue;
    if (expected && !found) ++result->joints_missing;
    if (found && !expected) ++result->joints_extra;
    if (!expected || !found) {
      result->near.Add(false);
      result->very_near.Add(false);
      continue;
    }
    const double distance_m = (reference->joints[pair.a].position_m -
                               person->joints[pair.b].position_m)
                                  .norm();
    result->near.Add(distance_m <= options.near_m);
    result->very_near.Add(distance_m <= options.very_near_m);
    if (distance_m > result->worst.distance_m) {
      result->worst = {distance_m, frame, reference->id, pair.a};
    }
  }
}

void CompareFrame(const TrackFrame& reference, const TrackFrame& tracks,
                  const JointPairs& joints, const ParityOptions& options,
                  IdentityMap* identities, ParityResult* result) {
  std::vector<bool> reference_paired(reference.people.size());
  std::vector<bool> person_paired(tracks.people.size());
  for (const CostPair& pair : MatchOneToOne(
           PersonDistances(reference.people, tracks.people, joints), kNoGate)) {
    const PersonPose& expected = reference.people[pair.row];
    const PersonPose& found = tracks.people[pair.column];
    reference_paired[pair.row] = true;
    person_paired[pair.column] = true;
    ++result->paired_person_frames;
    identities->Add(expected.id, found.id);
    AddJoints(reference.frame, &expected, &found, joints, options, result);
  }
  for (size_t i = 0; i < reference.people.size(); ++i) {
    if (reference_paired[i]) continue;
    AddJoints(reference.frame, &reference.people[i], nullptr, joints, options,
              result);
  }
  for (size_t i = 0; i < tracks.people.size(); ++i) {
    if (person_paired[i]) continue;
    AddJoints(tracks.frame, nullptr, &tracks.people[i], joints, options,
              result);
  }
}

struct Census {
  int64_t identities = 0;
  int64_t person_frames = 0;
};

Census CountPeople(const TrackSequence& tracks,
                   const std::vector<FrameRange>& ranges) {
  std::set<TrackId> ids;
  Census census;
  for (const TrackFrame& frame : tracks.frames) {
    if (!ContainsFrame(ranges, frame.frame)) continue;
    for (const PersonPose& person : frame.people) {
      ids.insert(person.id);
      ++census.person_frames;
    }
  }
  census.identities = static_cast<int64_t>(ids.size());
  return census;
}

}  // namespace

ParityResult EvaluateParity(const TrackSequence& reference,
                            const TrackSequence& tracks,
                            const ParityOptions& options) {
  const JointPairs joints =
      CommonJoints(reference.header.skeleton, tracks.header.skeleton);
  ParityResult result;
  IdentityMap identities;
  std::set<int64_t> frames;
  for (const TrackSequence* sequence : {&reference, &tracks}) {
    for (const TrackFrame& frame : sequence->frames) frames.insert(frame.frame);
  }
  const TrackFrame nobody;
  for (const int64_t frame : frames) {
    if (!ContainsFrame(options.frames, frame)) continue;
    const TrackFrame* expected = FindFrame(reference, frame);
    const TrackFrame* found = FindFrame(tracks, frame);
    CompareFrame(expected ? *expected : nobody, found ? *found : nobody, joints,
                 options, &identities, &result);
  }
  result.identities_one_to_one = identities.OneToOne();
  const Census expected = CountPeople(reference, options.frames);
  const Census found = CountPeople(tracks, options.frames);
  result.reference_identities = expected.identities;
  result.reference_person_frames = expected.person_frames;
  result.identities = found.identities;
  result.person_frames = found.person_frames;
  return result;
}

}  // namespace kinegraph
