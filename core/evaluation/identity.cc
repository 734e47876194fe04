#include "core/evaluation/identity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace kinegraph {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// What is known of a true person while the frames go by.
struct PersonState {
  TrackId last_match;
  bool ever_matched = false;
  bool lost_since = false;  // true people without a match after one
};

// Matches of one frame: people that stay together first, then the rest.
class FrameMatcher {
 public:
  FrameMatcher(const std::vector<PersonPose>& truth,
               const std::vector<PersonPose>& found, const JointPairs& joints,
               double gate_m)
      : truth_(truth),
        found_(found),
        distances_(PersonDistances(truth, found, joints)),
        gate_m_(gate_m) {}

  const Eigen::MatrixXd& distances() const { return distances_; }

  std::vector<CostPair> Match(const std::map<TrackId, PersonState>& states) {
    std::vector<CostPair> pairs;
    Eigen::MatrixXd open = distances_;
    for (size_t i = 0; i < truth_.size(); ++i) {
      const auto state = states.find(truth_[i].id);
      if (state == states.end() || !state->second.ever_matched) continue;
      for (size_t k = 0; k < found_.size(); ++k) {
        if (found_[k].id != state->second.last_match ||
            !(open(i, k) <= gate_m_)) {
          continue;
        }
        pairs.push_back({static_cast<int>(i), static_cast<int>(k), open(i, k)});
        open.row(i).setConstant(kNaN);
        open.col(k).setConstant(kNaN);
      }
    }
    for (const CostPair& pair : MatchOneToOne(open, gate_m_)) {
      pairs.push_back(pair);
    }
    return pairs;
  }

 private:
  const std::vector<PersonPose>& truth_;
  const std::vector<PersonPose>& found_;
  Eigen::MatrixXd distances_;
  double gate_m_;
};

// How many frames each true person and each identity were together.
class TogetherCounter {
 public:
  void Add(TrackId truth, TrackId found) { ++counts_[{truth, found}]; }

  // The most frames a one-to-one choice of identities explains.
  int64_t Best() const {
    std::map<TrackId, int> rows;
    std::map<TrackId, int> columns;
    for (const auto& [ids, count] : counts_) {
      rows.emplace(ids.first, static_cast<int>(rows.size()));
      columns.emplace(ids.second, static_cast<int>(columns.size()));
    }
    // The gain as a negative cost. A pair that was never together gains 0 and
    // may be chosen, so that the number of pairs does not matter.
    Eigen::MatrixXd cost = Eigen::MatrixXd::Zero(rows.size(), columns.size());
    for (const auto& [ids, count] : counts_) {
      cost(rows[ids.first], columns[ids.second]) = -static_cast<double>(count);
    }
    double best = 0.0;
    for (const CostPair& pair : MatchOneToOne(cost, kNoGate)) {
      best -= pair.cost;
    }
    return std::llround(best);
  }

 private:
  std::map<std::pair<TrackId, TrackId>, int64_t> counts_;
};

void CountTogether(const std::vector<PersonPose>& truth,
                   const std::vector<PersonPose>& found,
                   const Eigen::MatrixXd& distances, double gate_m,
                   TogetherCounter* together) {
  for (size_t i = 0; i < truth.size(); ++i) {
    for (size_t k = 0; k < found.size(); ++k) {
      if (distances(i, k) <= gate_m) together->Add(truth[i].id, found[k].id);
    }
  }
}

void AddFrame(const std::vector<PersonPose>& truth,
              const std::vector<PersonPose>& found,
              const std::vector<CostPair>& pairs,
              std::map<TrackId, PersonState>* states, IdentityResult* result) {
  result->true_person_frames += static_cast<int64_t>(truth.size());
  result->found_person_frames += static_cast<int64_t>(found.size());
  result->matches += static_cast<int64_t>(pairs.size());
  std::vector<bool> matched(truth.size(), false);
  for (const CostPair& pair : pairs) {
    matched[pair.row] = true;
    PersonState& state = (*states)[truth[pair.row].id];
    const TrackId id = found[pair.column].id;
    if (state.ever_matched && state.last_match != id) ++result->switches;
    if (state.lost_since) ++result->fragments;
    state = {id, true, false};
  }
  for (size_t i = 0; i < truth.size(); ++i) {
    PersonState& state = (*states)[truth[i].id];
    if (!matched[i] && state.ever_matched) state.lost_since = true;
  }
}

std::set<int64_t> AllFrames(const TrackSequence& a, const TrackSequence& b,
                            const std::vector<FrameRange>& ranges) {
  std::set<int64_t> frames;
  for (const TrackSequence* sequence : {&a, &b}) {
    for (const TrackFrame& frame : sequence->frames) {
      if (ContainsFrame(ranges, frame.frame)) frames.insert(frame.frame);
    }
  }
  return frames;
}

}  // namespace

double IdentityResult::Mota() const {
  if (true_person_frames == 0) return kNaN;
  return 1.0 - static_cast<double>(misses + false_positives + switches) /
                   static_cast<double>(true_person_frames);
}

double IdentityResult::Idf1() const {
  const int64_t people = true_person_frames + found_person_frames;
  if (people == 0) return kNaN;
  return 2.0 * static_cast<double>(identity_true_positives) /
         static_cast<double>(people);
}

IdentityResult EvaluateIdentity(const TrackSequence& truth,
                                const TrackSequence& tracks,
                                const IdentityOptions& options) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  IdentityResult result;
  std::map<TrackId, PersonState> states;
  std::set<TrackId> identities;
  TogetherCounter together;
  const std::vector<PersonPose> nobody;
  for (const int64_t frame : AllFrames(truth, tracks, options.frames)) {
    const TrackFrame* true_frame = FindFrame(truth, frame);
    const TrackFrame* found_frame = FindFrame(tracks, frame);
    const auto& true_people = true_frame ? true_frame->people : nobody;
    const auto& found_people = found_frame ? found_frame->people : nobody;
    FrameMatcher matcher(true_people, found_people, joints, options.gate_m);
    AddFrame(true_people, found_people, matcher.Match(states), &states,
             &result);
    CountTogether(true_people, found_people, matcher.distances(),
                  options.gate_m, &together);
    for (const PersonPose& person : found_people) identities.insert(person.id);
  }
  result.true_people = static_cast<int64_t>(states.size());
  result.identities = static_cast<int64_t>(identities.size());
  result.misses = result.true_person_frames - result.matches;
  result.false_positives = result.found_person_frames - result.matches;
  result.identity_true_positives = together.Best();
  return result;
}

}  // namespace kinegraph
