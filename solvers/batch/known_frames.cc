#include "solvers/batch/known_frames.h"

#include <algorithm>
#include <utility>

namespace kinegraph {
namespace {

// Of the frames: of more the noise has to be learnt again, and with it all is
// solved again.
constexpr double kMostChanged = 0.0025;

bool SameViews(const FrameRecord& a, const FrameRecord& b) {
  return a.frame == b.frame &&
         std::equal(a.views.begin(), a.views.end(), b.views.begin(),
                    b.views.end(),
                    [](const FrameRecord::View& x, const FrameRecord::View& y) {
                      return x.view_idx == y.view_idx &&
                             x.detection_idx == y.detection_idx;
                    });
}

// Whether as many measurements were taken from the views.
bool SameCounts(const PersonProblem& graph, size_t k,
                const SolvedPerson& person, size_t l) {
  for (size_t j = 0; j < graph.joints.size(); ++j) {
    const std::vector<int32_t>& ours = graph.joints[j].first;
    const std::vector<int32_t>& theirs = person.joints[j].first;
    if (ours[k + 1] - ours[k] != theirs[l + 1] - theirs[l]) return false;
  }
  return true;
}

std::optional<KnownFrames> Compare(std::shared_ptr<const SolvedPerson> person,
                                   const std::vector<FrameRecord>& records,
                                   const PersonProblem& graph) {
  const std::vector<FrameRecord>& before = person->records;
  const double frames =
      static_cast<double>(std::max(records.size(), before.size()));
  const double most_changed = kMostChanged * frames;
  double changed = frames - static_cast<double>(records.size());
  KnownFrames known;
  size_t l = 0;
  for (size_t k = 0; k < records.size() && changed <= most_changed; ++k) {
    while (l + 1 < before.size() && before[l].frame < records[k].frame) ++l;
    known.frame_of.push_back(l);
    known.same.push_back(SameViews(records[k], before[l]) &&
                         SameCounts(graph, k, *person, l));
    changed += known.same.back() ? 0.0 : 1.0;
  }
  if (changed > most_changed) return std::nullopt;
  known.person = std::move(person);
  return known;
}

}  // namespace

std::optional<KnownFrames> FindKnownFrames(
    const std::vector<std::shared_ptr<const SolvedPerson>>& people,
    const std::vector<FrameRecord>& records, const PersonProblem& graph) {
  for (const auto& person : people) {
    std::optional<KnownFrames> known = Compare(person, records, graph);
    if (known.has_value()) return known;
  }
  return std::nullopt;
}

std::vector<Chunk> ChangedChunks(const PersonProblem& problem,
                                 const std::vector<char>& same) {
  std::vector<Chunk> chunks;
  size_t k = 0;
  while (k < same.size()) {
    if (same[k]) {
      ++k;
      continue;
    }
    // Up to the next frame that has so many behind it that are the same.
    const size_t begin = k;
    size_t end = k + 1;
    for (size_t next = end; next < same.size(); ++next) {
      if (ToSeconds(problem.times[next] - problem.times[end - 1]) >
          2.0 * kOverlap_s) {
        break;
      }
      if (!same[next]) end = next + 1;
    }
    chunks.push_back(ChunkAround(problem, begin, end));
    k = end;
  }
  return chunks;
}

void PasteKnown(const KnownFrames& known, PersonRecording* recording) {
  size_t k = 0;
  while (k < known.same.size()) {
    if (!known.same[k]) {
      ++k;
      continue;
    }
    const size_t begin = k;
    const size_t from = known.frame_of[begin];
    while (k < known.same.size() && known.same[k] &&
           known.frame_of[k] == from + (k - begin)) {
      ++k;
    }
    Chunk run;
    run.own_begin = begin;
    run.own_end = k;
    std::vector<JointOutcome> outcomes;
    for (const SolvedPerson::Joint& joint : known.person->joints) {
      const auto to = static_cast<std::ptrdiff_t>(from + (k - begin));
      const auto at = static_cast<std::ptrdiff_t>(from);
      const JointOutcome& all = joint.outcome;
      const int32_t first = joint.first[from];
      const int32_t end = joint.first[from + (k - begin)];
      outcomes.push_back(
          {StateChain(all.states.begin() + at, all.states.begin() + to),
           {all.weights.begin() + first, all.weights.begin() + end},
           {all.gated.begin() + first, all.gated.begin() + end}});
    }
    Paste(outcomes, run, recording);
  }
}

}  // namespace kinegraph
