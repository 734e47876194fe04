#include "core/evaluation/parity.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

// For each identity of one result, the identities of the other matched with it.
using IdentityMap = std::map<TrackId, std::set<TrackId>>;

bool IsUnique(const IdentityMap& map) {
  return std::all_of(map.begin(), map.end(), [](const auto& entry) {
    return entry.second.size() == 1;
  });
}

// Adds the joints of a pair of people; nullptr: no person.
void AddJoints(int64_t frame, const PersonPose* reference,
               const PersonPose* person, const JointPairs& joints,
               const ParityOptions& options, ParityResult* result) {
  for (const JointPair& pair : joints) {
    const bool expected = reference && reference->joints[pair.a].present();
    const bool found = person && person->joints[pair.b].present();
    if (!expected && !found) continue;
    if (!found) ++result->joints_missing;
    if (!expected) ++result->joints_extra;
    const bool both = expected && found;
    const double distance_m = both ? (reference->joints[pair.a].position_m -
                                      person->joints[pair.b].position_m)
                                         .norm()
                                   : kNoGate;
    result->near.Add(distance_m <= options.near_m);
    result->very_near.Add(distance_m <= options.very_near_m);
    if (both && distance_m > result->worst.distance_m) {
      result->worst = {distance_m, frame, reference->id, pair.a};
    }
  }
}

}  // namespace

ParityResult EvaluateParity(const TrackSequence& reference,
                            const TrackSequence& tracks,
                            const ParityOptions& options) {
  const JointPairs joints =
      CommonJoints(reference.header.skeleton, tracks.header.skeleton);
  ParityResult result;
  IdentityMap found_of, expected_of;
  std::set<TrackId> identities, reference_identities;
  for (const FramePair& both :
       PairFrames(reference, tracks, options.frames).pairs) {
    const std::vector<PersonPose>& expected = PeopleOf(both.truth);
    const std::vector<PersonPose>& found = PeopleOf(both.tracks);
    std::vector<const PersonPose*> match(expected.size(), nullptr);
    std::vector<bool> is_paired(found.size());
    for (const CostPair& pair :
         MatchOneToOne(PersonDistances(expected, found, joints), kNoGate)) {
      match[pair.row] = &found[pair.column];
      is_paired[pair.column] = true;
      ++result.paired_person_frames;
      found_of[expected[pair.row].id].insert(found[pair.column].id);
      expected_of[found[pair.column].id].insert(expected[pair.row].id);
    }
    for (size_t i = 0; i < expected.size(); ++i) {
      AddJoints(both.frame, &expected[i], match[i], joints, options, &result);
      reference_identities.insert(expected[i].id);
      ++result.reference_person_frames;
    }
    for (size_t i = 0; i < found.size(); ++i) {
      if (!is_paired[i]) {
        AddJoints(both.frame, nullptr, &found[i], joints, options, &result);
      }
      identities.insert(found[i].id);
      ++result.person_frames;
    }
  }
  result.identities_one_to_one = IsUnique(found_of) && IsUnique(expected_of);
  result.reference_identities =
      static_cast<int64_t>(reference_identities.size());
  result.identities = static_cast<int64_t>(identities.size());
  return result;
}

}  // namespace kinegraph
