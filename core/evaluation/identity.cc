#include "core/evaluation/identity.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/assignment/hungarian.h"
#include "core/base/constants.h"

namespace kinegraph {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// State of a true person while frames are processed.
struct PersonState {
  TrackId last_match;
  bool ever_matched = false;
  bool holds_match = false;  // no other person has had that identity since
  bool lost_since = false;   // without a match after having had one
};

// Matches of one frame: first the pairs that persist, then the rest.
std::vector<CostPair> MatchFrame(const std::vector<PersonPose>& truth,
                                 const std::vector<PersonPose>& found,
                                 const MatrixXd& distances,
                                 const std::map<TrackId, PersonState>& states) {
  std::vector<CostPair> pairs;
  MatrixXd open = distances;
  for (int i = 0; i < open.rows(); ++i) {
    const auto state = states.find(truth[i].id);
    if (state == states.end() || !state->second.holds_match) continue;
    for (int k = 0; k < open.cols(); ++k) {
      if (found[k].id != state->second.last_match ||
          !(open(i, k) <= kPersonGateM)) {
        continue;
      }
      pairs.push_back({i, k, open(i, k)});
      open.row(i).setConstant(kNan);
      open.col(k).setConstant(kNan);
    }
  }
  for (const CostPair& pair : MatchOneToOne(open, kPersonGateM)) {
    pairs.push_back(pair);
  }
  return pairs;
}

// Updates the true people of a frame; counts switches and fragments.
void FollowPeople(const std::vector<PersonPose>& truth,
                  const std::vector<PersonPose>& found,
                  const std::vector<CostPair>& pairs,
                  std::map<TrackId, PersonState>* states,
                  IdentityResult* result) {
  std::vector<bool> matched(truth.size(), false);
  for (const CostPair& pair : pairs) {
    matched[pair.row] = true;
    PersonState& state = (*states)[truth[pair.row].id];
    const TrackId id = found[pair.column].id;
    if (state.ever_matched && state.last_match != id) ++result->switches;
    if (state.lost_since) ++result->fragments;
    state = {id, true, true, false};
    for (auto& [other, its] : *states) {
      if (other != truth[pair.row].id && its.last_match == id) {
        its.holds_match = false;
      }
    }
  }
  for (size_t i = 0; i < truth.size(); ++i) {
    PersonState& state = (*states)[truth[i].id];
    if (!matched[i] && state.ever_matched) state.lost_since = true;
  }
}

bool IsHidden(const PersonPose& person) {
  return std::none_of(person.joints.begin(), person.joints.end(),
                      [](const Joint3d& joint) {
                        return joint.status == JointStatus::kObserved;
                      });
}

// Indices of the found people who are scored, ascending: all but those without
// a match at the position of a hidden person or, where the truth is incomplete,
// far from all annotated people.
std::vector<int> CountedPeople(const std::vector<PersonPose>& hidden,
                               const std::vector<PersonPose>& found,
                               const std::vector<CostPair>& pairs,
                               const MatrixXd& distances,
                               const JointPairs& joints, Annotated annotated,
                               IdentityResult* result) {
  std::vector<bool> is_open(found.size(), true);
  for (const CostPair& pair : pairs) is_open[pair.column] = false;
  std::vector<int> open;
  for (int k = 0; k < distances.cols(); ++k) {
    if (is_open[k]) open.push_back(k);
  }
  std::vector<bool> counts(found.size(), true);
  const MatrixXd to_hidden =
      PersonDistances(hidden, found, joints)(Eigen::all, open);
  for (const CostPair& pair : MatchOneToOne(to_hidden, kPersonGateM)) {
    counts[open[pair.column]] = false;
    ++result->on_hidden_people;
  }
  std::vector<int> counted;
  for (int k = 0; k < distances.cols(); ++k) {
    if (annotated == Annotated::kSome && is_open[k] && counts[k] &&
        !(distances.col(k).array() <= kPersonGateM).any()) {
      counts[k] = false;
      ++result->beside_annotations;
    }
    if (counts[k]) counted.push_back(k);
  }
  return counted;
}

// Scores that need the whole recording: IDF1's choice of identities, and HOTA,
// which prefers pairs of people that are similar over the recording.
class WholeRecording {
 public:
  // `distances`: from true people (rows) to found ones (columns).
  void Add(const std::vector<PersonPose>& truth,
           const std::vector<PersonPose>& found,
           const std::vector<int>& counted, const MatrixXd& distances) {
    Similarities& similarities = frames_.emplace_back();
    for (const PersonPose& person : truth) {
      similarities.truth.push_back(IndexOf(person.id, &truth_index_));
    }
    for (const int k : counted) {
      similarities.found.push_back(IndexOf(found[k].id, &found_index_));
    }
    const MatrixXd kept = distances(Eigen::all, counted);
    similarities.are_near = kept.array() <= kPersonGateM;
    similarities.values = kept.unaryExpr([](double distance_m) {
      const double similarity = 1.0 - distance_m / (2.0 * kPersonGateM);
      return similarity > 0.0 ? similarity : 0.0;  // NaN included
    });
  }
  int64_t true_people() const {
    return static_cast<int64_t>(truth_index_.size());
  }
  int64_t identities() const {
    return static_cast<int64_t>(found_index_.size());
  }

  // The greatest number of person-frames that a one-to-one choice of identities
  // explains.
  int64_t IdentityTruePositives() const {
    // The gain as a negative cost. A pair that never coincided gains 0 and may
    // be chosen, so that the number of pairs is irrelevant.
    MatrixXd cost = MatrixXd::Zero(truth_index_.size(), found_index_.size());
    for (const Similarities& frame : frames_) {
      for (size_t i = 0; i < frame.truth.size(); ++i) {
        for (size_t k = 0; k < frame.found.size(); ++k) {
          if (frame.are_near(i, k)) cost(frame.truth[i], frame.found[k]) -= 1.0;
        }
      }
    }
    double best = 0.0;
    for (const CostPair& pair : MatchOneToOne(cost, kNoGate)) best -= pair.cost;
    return std::llround(best);
  }

  std::array<HotaScores, kHotaThresholdCount> Hota() const {
    const Totals totals = Count();
    std::array<std::vector<double>, kHotaThresholdCount> matched;
    std::array<MatrixXd, kHotaThresholdCount> together;
    together.fill(MatrixXd::Zero(truth_index_.size(), found_index_.size()));
    HungarianSolver solver;
    std::vector<int> column_of_row;
    for (const Similarities& frame : frames_) {
      Match(frame, totals.alignment, &solver, &column_of_row);
      for (size_t i = 0; i < column_of_row.size(); ++i) {
        if (column_of_row[i] < 0) continue;
        const double similarity = frame.values(i, column_of_row[i]);
        for (int t = 0; t < kHotaThresholdCount; ++t) {
          if (similarity < Threshold(t) - kRounding) break;
          matched[t].push_back(similarity);
          together[t](frame.truth[i], frame.found[column_of_row[i]]) += 1.0;
        }
      }
    }
    std::array<HotaScores, kHotaThresholdCount> scores;
    for (int t = 0; t < kHotaThresholdCount; ++t) {
      scores[t] = ScoresAt(totals, matched[t], together[t]);
    }
    return scores;
  }

 private:
  // Tolerance for rounding, so that a similarity equal to a threshold passes.
  static constexpr double kRounding = 1e-9;
  static double Threshold(int t) { return 0.05 * (t + 1); }

  struct Similarities {
    std::vector<int> truth;
    std::vector<int> found;
    Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> are_near;
    MatrixXd values;
  };
  struct Totals {
    VectorXd truth;      // person-frames of each true person
    VectorXd found;      // and of each identity
    MatrixXd alignment;  // how strongly they correspond
  };

  static int IndexOf(TrackId id, std::map<TrackId, int>* index) {
    return index->emplace(id, static_cast<int>(index->size())).first->second;
  }

  Totals Count() const {
    Totals totals;
    totals.truth = VectorXd::Zero(truth_index_.size());
    totals.found = VectorXd::Zero(found_index_.size());
    totals.alignment = MatrixXd::Zero(truth_index_.size(), found_index_.size());
    for (const Similarities& frame : frames_) {
      for (const int i : frame.truth) totals.truth(i) += 1.0;
      for (const int k : frame.found) totals.found(k) += 1.0;
      // Without people on one side Eigen's sums would read invalid memory.
      if (frame.values.size() == 0) continue;
      const VectorXd rows = frame.values.rowwise().sum();
      const Eigen::RowVectorXd columns = frame.values.colwise().sum();
      for (int i = 0; i < frame.values.rows(); ++i) {
        for (int k = 0; k < frame.values.cols(); ++k) {
          const double value = frame.values(i, k);
          if (value <= 0.0) continue;
          totals.alignment(frame.truth[i], frame.found[k]) +=
              value / (rows(i) + columns(k) - value);
        }
      }
    }
    for (int i = 0; i < totals.alignment.rows(); ++i) {
      for (int k = 0; k < totals.alignment.cols(); ++k) {
        double& value = totals.alignment(i, k);
        value /= totals.truth(i) + totals.found(k) - value;
      }
    }
    return totals;
  }

  static void Match(const Similarities& frame, const MatrixXd& alignment,
                    HungarianSolver* solver, std::vector<int>* column_of_row) {
    std::vector<double> gains;
    for (size_t i = 0; i < frame.truth.size(); ++i) {
      for (size_t k = 0; k < frame.found.size(); ++k) {
        gains.push_back(alignment(frame.truth[i], frame.found[k]) *
                        frame.values(i, k));
      }
    }
    solver->Maximise(gains, static_cast<int>(frame.truth.size()),
                     static_cast<int>(frame.found.size()), column_of_row);
  }

  static HotaScores ScoresAt(const Totals& totals,
                             const std::vector<double>& matched,
                             const MatrixXd& together) {
    const double pairs = static_cast<double>(matched.size());
    const double people = totals.truth.sum() + totals.found.sum() - pairs;
    if (people == 0.0) return {kNan, kNan, kNan, kNan};
    HotaScores scores;
    scores.detection = pairs / people;
    double sum = 0.0;
    for (const double similarity : matched) sum += similarity;
    // Without a match there is no localisation error.
    scores.localisation = pairs > 0.0 ? sum / pairs : 1.0;
    for (int i = 0; i < together.rows(); ++i) {
      for (int k = 0; k < together.cols(); ++k) {
        const double both = together(i, k);
        if (both == 0.0) continue;
        scores.association +=
            both * both / (totals.truth(i) + totals.found(k) - both);
      }
    }
    if (pairs > 0.0) scores.association /= pairs;
    scores.hota = std::sqrt(scores.detection * scores.association);
    return scores;
  }

  std::map<TrackId, int> truth_index_;
  std::map<TrackId, int> found_index_;
  std::vector<Similarities> frames_;
};

}  // namespace

double IdentityResult::Mota() const {
  if (true_person_frames == 0) return kNan;
  return 1.0 - static_cast<double>(misses + false_positives + switches) /
                   static_cast<double>(true_person_frames);
}

double IdentityResult::Idf1() const {
  const int64_t people = true_person_frames + found_person_frames;
  if (people == 0) return kNan;
  return 2.0 * static_cast<double>(identity_true_positives) /
         static_cast<double>(people);
}

HotaScores IdentityResult::Hota() const {
  HotaScores sum;
  for (const HotaScores& at : hota_at) {
    sum.hota += at.hota;
    sum.detection += at.detection;
    sum.association += at.association;
    sum.localisation += at.localisation;
  }
  constexpr double kCount = kHotaThresholdCount;
  return {sum.hota / kCount, sum.detection / kCount, sum.association / kCount,
          sum.localisation / kCount};
}

IdentityResult EvaluateIdentity(const TrackSequence& truth,
                                const TrackSequence& tracks,
                                const IdentityOptions& options) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  IdentityResult result;
  std::map<TrackId, PersonState> states;
  WholeRecording recording;
  for (const FramePair& both :
       PairFrames(truth, tracks, options.frames).pairs) {
    if (both.truth == nullptr) continue;
    std::vector<PersonPose> people, hidden;
    for (const PersonPose& person : both.truth->people) {
      (IsHidden(person) ? hidden : people).push_back(person);
    }
    const std::vector<PersonPose>& found = PeopleOf(both.tracks);
    const MatrixXd distances = PersonDistances(people, found, joints);
    const std::vector<CostPair> pairs =
        MatchFrame(people, found, distances, states);
    const std::vector<int> counted = CountedPeople(
        hidden, found, pairs, distances, joints, options.annotated, &result);
    result.hidden_person_frames += static_cast<int64_t>(hidden.size());
    result.true_person_frames += static_cast<int64_t>(people.size());
    result.found_person_frames += static_cast<int64_t>(counted.size());
    result.matches += static_cast<int64_t>(pairs.size());
    FollowPeople(people, found, pairs, &states, &result);
    recording.Add(people, found, counted, distances);
  }
  result.true_people = recording.true_people();
  result.identities = recording.identities();
  result.misses = result.true_person_frames - result.matches;
  result.false_positives = result.found_person_frames - result.matches;
  result.identity_true_positives = recording.IdentityTruePositives();
  result.hota_at = recording.Hota();
  return result;
}

}  // namespace kinegraph
