#include "solvers/batch/chunks.h"

#include <algorithm>

namespace kinegraph {
namespace {

constexpr double kMostOverlap = 5.5;  // s

double Seconds(const PersonProblem& problem, size_t from, size_t to) {
  return ToSeconds(problem.times[to] - problem.times[from]);
}

// Whether some joint is measured in fewer than `wanted` of the frames
// begin .. end - 1.
bool LacksFrames(const PersonProblem& problem, size_t begin, size_t end,
                 size_t wanted) {
  for (const JointChain& chain : problem.joints) {
    size_t measured = 0;
    for (size_t k = begin; k < end; ++k) {
      measured += chain.first[k] < chain.first[k + 1] ? 1 : 0;
    }
    if (measured < wanted) return true;
  }
  return false;
}

// Where a chunk that owns frames from `own` on begins. Across a gap of a joint
// it goes on until the other side holds the joint as well.
size_t ExtendBack(const PersonProblem& problem, size_t own) {
  size_t begin = own;
  while (begin > 0 && Seconds(problem, begin - 1, own) <= kOverlap_s) --begin;
  const size_t wanted = (own - begin) / 2;
  while (begin > 0 && Seconds(problem, begin - 1, own) <= kMostOverlap &&
         LacksFrames(problem, begin, own, wanted)) {
    --begin;
  }
  return begin;
}

// Where a chunk that owns frames before `own` ends.
size_t ExtendForth(const PersonProblem& problem, size_t own) {
  const size_t count = problem.times.size();
  size_t end = own;
  while (end < count && Seconds(problem, own - 1, end) <= kOverlap_s) ++end;
  const size_t wanted = (end - own) / 2;
  while (end < count && Seconds(problem, own - 1, end) <= kMostOverlap &&
         LacksFrames(problem, own, end, wanted)) {
    ++end;
  }
  return end;
}

}  // namespace

std::vector<Chunk> MakeChunks(const PersonProblem& problem, double chunk_s) {
  const size_t count = problem.times.size();
  std::vector<Chunk> chunks;
  if (count == 0) return chunks;
  const double length_s = Seconds(problem, 0, count - 1);
  const int pieces =
      chunk_s > 0.0 ? std::max(1, static_cast<int>(length_s / chunk_s)) : 1;
  size_t begin = 0;
  for (int i = 0; i < pieces && begin < count; ++i) {
    // Equal spans of time; all frames up to and including the next limit.
    size_t end = begin;
    const double limit_s = length_s * (i + 1) / pieces;
    while (end < count &&
           (i + 1 == pieces || Seconds(problem, 0, end) <= limit_s)) {
      ++end;
    }
    if (end == begin) continue;  // a gap in the recording
    Chunk chunk;
    chunk.own_begin = begin;
    chunk.own_end = end;
    chunk.begin = ExtendBack(problem, begin);
    chunk.end = ExtendForth(problem, end);
    chunks.push_back(chunk);
    begin = end;
  }
  return chunks;
}

Chunk ChunkAround(const PersonProblem& problem, size_t begin, size_t end) {
  Chunk chunk;
  chunk.own_begin = begin;
  while (chunk.own_begin > 0 &&
         Seconds(problem, chunk.own_begin - 1, begin) <= kOverlap_s) {
    --chunk.own_begin;
  }
  chunk.own_end = end;
  while (chunk.own_end < problem.times.size() &&
         Seconds(problem, end - 1, chunk.own_end) <= kOverlap_s) {
    ++chunk.own_end;
  }
  chunk.begin = ExtendBack(problem, chunk.own_begin);
  chunk.end = ExtendForth(problem, chunk.own_end);
  return chunk;
}

PersonProblem CutOut(const PersonRecording& recording, const Chunk& chunk) {
  PersonProblem part = recording.Part(chunk.begin, chunk.end);
  // A birth like any other: so weak that the frames of the overlap outweigh it.
  constexpr double kPositionSigma = 1.0;  // m
  constexpr double kVelocitySigma = 3.0;  // m/s
  for (JointChain& chain : part.joints) {
    if (chunk.begin == 0) break;
    chain.prior = BirthPrior(chain.states.front().head<3>(), kPositionSigma,
                             kVelocitySigma);
  }
  const PersonProblem& problem = recording.graph;
  part.bones = problem.bones;
  if (chunk.begin == 0) part.prior = problem.prior;
  for (const PlacedFactor& placed : problem.user) {
    if (placed.first_frame() < chunk.begin ||
        placed.last_frame() >= chunk.end) {
      continue;
    }
    part.user.push_back(placed);
    for (StateKey& key : part.user.back().keys) {
      key.frame -= static_cast<int>(chunk.begin);
    }
  }
  return part;
}

std::vector<JointOutcome> OutcomesOf(const PersonProblem& part,
                                     const Chunk& chunk) {
  const size_t begin = chunk.own_begin - chunk.begin;
  const size_t end = chunk.own_end - chunk.begin;
  std::vector<JointOutcome> outcomes;
  for (const JointChain& chain : part.joints) {
    JointOutcome& outcome = outcomes.emplace_back();
    outcome.states.assign(chain.states.begin() + begin,
                          chain.states.begin() + end);
    const int32_t count = chain.first[end] - chain.first[begin];
    outcome.weights.reserve(static_cast<size_t>(count));
    outcome.gated.reserve(static_cast<size_t>(count));
    for (int32_t m = chain.first[begin]; m < chain.first[end]; ++m) {
      outcome.weights.push_back(chain.measurements[m].weight);
      outcome.gated.push_back(chain.measurements[m].gated);
    }
  }
  return outcomes;
}

void Paste(const std::vector<JointOutcome>& outcomes, const Chunk& chunk,
           PersonRecording* recording) {
  for (size_t j = 0; j < outcomes.size(); ++j) {
    const JointOutcome& outcome = outcomes[j];
    std::copy(outcome.states.begin(), outcome.states.end(),
              recording->graph.joints[j].states.begin() +
                  static_cast<std::ptrdiff_t>(chunk.own_begin));
    recording->measurements.ExtractWeights(j, chunk.own_begin, chunk.own_end,
                                           outcome.weights, outcome.gated);
  }
}

}  // namespace kinegraph
