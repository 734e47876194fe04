#include "solvers/batch/recording_solver.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

#include "core/base/parallel.h"
#include "solvers/graph/assembler.h"

namespace kinegraph {
namespace {

// Distance in time over which a change in one frame affects others.
constexpr double kOverlapS = 1.1;
// Limit of the overlap where a joint is rarely measured.
constexpr double kMostOverlapS = 5.5;

double Seconds(const PersonProblem& problem, size_t from, size_t to) {
  return ToSeconds(problem.times[to] - problem.times[from]);
}

// Whether some joint has fewer than `wanted` frames among begin .. end - 1 in
// which a view measures it.
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

// The first frame at most `most_s` before frame `k`.
size_t FirstWithin(const PersonProblem& problem, size_t k, double most_s) {
  size_t first = k;
  while (first > 0 && Seconds(problem, first - 1, k) <= most_s) --first;
  return first;
}

// The end of the frames at most `most_s` after frame `k`.
size_t EndWithin(const PersonProblem& problem, size_t k, double most_s) {
  size_t end = k + 1;
  while (end < problem.times.size() && Seconds(problem, k, end) <= most_s) {
    ++end;
  }
  return end;
}

// The chunk that owns frames begin .. end - 1. Each overlap is extended, up to
// kMostOverlapS, until every joint is measured in at least half as many of its
// frames as the overlap had originally.
Chunk ChunkOf(const PersonProblem& problem, size_t begin, size_t end) {
  Chunk chunk = {FirstWithin(problem, begin, kOverlapS),
                 EndWithin(problem, end - 1, kOverlapS), begin, end};
  const Chunk most = {FirstWithin(problem, begin, kMostOverlapS),
                      EndWithin(problem, end - 1, kMostOverlapS), begin, end};
  const size_t wanted_before = (begin - chunk.begin) / 2;
  while (chunk.begin > most.begin &&
         LacksFrames(problem, chunk.begin, begin, wanted_before)) {
    --chunk.begin;
  }
  const size_t wanted_behind = (chunk.end - end) / 2;
  while (chunk.end < most.end &&
         LacksFrames(problem, end, chunk.end, wanted_behind)) {
    ++chunk.end;
  }
  return chunk;
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
    // Equal spans of time; each takes all frames up to and including its limit.
    size_t end = begin;
    const double limit_s = length_s * (i + 1) / pieces;
    while (end < count &&
           (i + 1 == pieces || Seconds(problem, 0, end) <= limit_s)) {
      ++end;
    }
    if (end == begin) continue;  // a gap in the recording
    chunks.push_back(ChunkOf(problem, begin, end));
    begin = end;
  }
  return chunks;
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

namespace {

// Fraction of frames. If more have changed, noise is learnt and everything is
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

// Whether every joint has the same number of measurements in both frames.
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
  size_t begin = 0;
  while (begin < same.size()) {
    size_t end = begin + 1;
    if (!same[begin]) {
      // Extends over all changes up to two overlaps apart: their chunks
      // would touch.
      for (size_t next = end; next < same.size(); ++next) {
        if (Seconds(problem, end - 1, next) > 2.0 * kOverlapS) break;
        if (!same[next]) end = next + 1;
      }
      chunks.push_back(ChunkOf(problem, FirstWithin(problem, begin, kOverlapS),
                               EndWithin(problem, end - 1, kOverlapS)));
    }
    begin = end;
  }
  return chunks;
}

void PasteKnown(const KnownFrames& known, PersonProblem* recording) {
  for (size_t k = 0; k < known.same.size(); ++k) {
    if (!known.same[k]) continue;
    const size_t before = known.frame_of[k];
    for (size_t j = 0; j < recording->joints.size(); ++j) {
      JointChain& chain = recording->joints[j];
      const SolvedPerson::Joint& joint = known.person->joints[j];
      chain.states[k] = joint.outcome.states[before];
      int32_t from = joint.first[before];
      for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m, ++from) {
        chain.measurements[m].weight = joint.outcome.weights[from];
        chain.measurements[m].gated = joint.outcome.gated[from] != 0;
      }
    }
  }
}

namespace {

// The chunk as a separate problem. If frames precede the chunk, its first
// states get a birth prior centred on their current positions instead of the
// recording's prior.
PersonProblem CutOut(const PersonProblem& recording, const Chunk& chunk) {
  const auto at = [](const auto& values, size_t k) {
    return values.begin() + k;
  };
  // The birth prior's defaults: weak enough that the frames of the overlap
  // outweigh it.
  constexpr double kPositionSigma = 1.0;  // m
  constexpr double kVelocitySigma = 3.0;  // m/s
  const size_t begin = chunk.begin;
  const size_t end = chunk.end;
  PersonProblem part;
  part.times.assign(at(recording.times, begin), at(recording.times, end));
  part.centres.assign(at(recording.centres, begin), at(recording.centres, end));
  for (const JointChain& whole : recording.joints) {
    JointChain& chain = part.joints.emplace_back();
    chain.states.assign(at(whole.states, begin), at(whole.states, end));
    chain.process_noise.assign(at(whole.process_noise, begin),
                               at(whole.process_noise, end - 1));
    chain.prior = begin == 0 ? whole.prior
                             : BirthPrior(chain.states.front().head<3>(),
                                          kPositionSigma, kVelocitySigma);
    chain.first.assign(at(whole.first, begin), at(whole.first, end + 1));
    chain.measurements.assign(
        at(whole.measurements, static_cast<size_t>(chain.first.front())),
        at(whole.measurements, static_cast<size_t>(chain.first.back())));
    const int32_t before = chain.first.front();
    for (int32_t& first : chain.first) first -= before;
  }
  part.bones = recording.bones;
  if (begin == 0) part.prior = recording.prior;
  for (const PlacedFactor& placed : recording.user) {
    if (placed.first_frame() < begin || placed.last_frame() >= end) continue;
    part.user.push_back(placed);
    for (StateKey& key : part.user.back().keys) key.frame -= begin;
  }
  return part;
}

// Copies the outcomes of all joints into the recording.
void Paste(const std::vector<JointOutcome>& outcomes, const Chunk& chunk,
           PersonProblem* recording) {
  for (size_t j = 0; j < outcomes.size(); ++j) {
    const JointOutcome& outcome = outcomes[j];
    JointChain& chain = recording->joints[j];
    std::copy(outcome.states.begin(), outcome.states.end(),
              chain.states.begin() + chunk.own_begin);
    PixelMeasurement* const first =
        chain.measurements.data() + chain.first[chunk.own_begin];
    for (size_t m = 0; m < outcome.weights.size(); ++m) {
      first[m].weight = outcome.weights[m];
      first[m].gated = outcome.gated[m] != 0;
    }
  }
}

}  // namespace

RecordingSolver::RecordingSolver(const GraphOptions& options)
    : options_(options), whole_(options) {}

void RecordingSolver::FreeWorkSpace() {
  whole_.FreeWorkSpace();
  idle_.clear();
}

template <typename Visit>
void RecordingSolver::ForEachChunk(const PersonProblem& recording,
                                   const std::vector<Chunk>& chunks,
                                   const Visit& visit) {
  ParallelFor(AllowedThreads(), static_cast<int>(chunks.size()), [&](int i) {
    PersonProblem part = CutOut(recording, chunks[i]);
    if (!without_bones_.empty() && without_bones_[i]) part.bones.clear();
    std::unique_lock<std::mutex> lock(taking_);
    if (idle_.empty()) {
      idle_.push_back(std::make_unique<PersonSolver>(options_));
    }
    std::unique_ptr<PersonSolver> solver = std::move(idle_.back());
    idle_.pop_back();
    lock.unlock();
    visit(i, solver.get(), &part);
    lock.lock();
    whole_.AddCounts(solver->ExtractCounts());
    idle_.push_back(std::move(solver));
  });
}

std::vector<char> RecordingSolver::Solve(const std::vector<Chunk>& chunks,
                                         const Work& work,
                                         PersonProblem* recording) {
  // All chunks are cut out before any is pasted, because they overlap.
  std::vector<std::vector<JointOutcome>> outcomes(chunks.size());
  std::vector<char> without_bones(chunks.size());
  ForEachChunk(*recording, chunks,
               [&](int i, PersonSolver* solver, PersonProblem* part) {
                 const bool with_bones = !part->bones.empty();
                 work(solver, part);
                 without_bones[i] = with_bones && part->bones.empty();
                 outcomes[i] = OutcomesOf(*part, chunks[i]);
               });
  for (size_t i = 0; i < chunks.size(); ++i) {
    Paste(outcomes[i], chunks[i], recording);
  }
  return without_bones;
}

void RecordingSolver::SolveJoints(const SolveSchedule& schedule,
                                  PersonProblem* recording) {
  Solve(
      MakeChunks(*recording, options_.chunk_s),
      [&](PersonSolver* solver, PersonProblem* part) {
        solver->SolveJoints(schedule, part);
      },
      recording);
}

void RecordingSolver::SolveTogether(PersonProblem* recording) {
  FreeWorkSpace();
  without_bones_.clear();
  without_bones_ = Solve(
      MakeChunks(*recording, options_.chunk_s),
      [](PersonSolver* solver, PersonProblem* part) {
        solver->SolveBones(part);
        solver->Refine(part);
      },
      recording);
  // A single chunk is the whole recording. If its solve dropped the bones, so
  // does the recording; with several chunks only KeptBones() reports it.
  const bool as_a_whole = without_bones_.size() == 1;
  if (as_a_whole && without_bones_[0]) recording->bones.clear();
}

bool RecordingSolver::SolveAnew(const std::vector<Chunk>& chunks,
                                PersonProblem* recording) {
  const std::vector<char> without_bones = Solve(
      chunks,
      [&](PersonSolver* solver, PersonProblem* part) {
        solver->SolveJoints(schedule(), part);
        solver->SolveBones(part);
        solver->Refine(part);
      },
      recording);
  return std::count(without_bones.begin(), without_bones.end(), 1) == 0;
}

bool RecordingSolver::KeptBones() const {
  return std::count(without_bones_.begin(), without_bones_.end(), 1) == 0;
}

template <typename Matrix, typename Of>
std::vector<std::vector<Matrix>> RecordingSolver::InChunks(
    const PersonProblem& recording, const Of& of) {
  FreeWorkSpace();
  const std::vector<Chunk> chunks = MakeChunks(recording, options_.chunk_s);
  // Each chunk writes its own frames. If the covariances of a joint are missing
  // in even one chunk, the joint gets none.
  const size_t joints = recording.joints.size();
  std::vector<std::vector<Matrix>> whole(
      joints, std::vector<Matrix>(recording.times.size()));
  std::vector<std::vector<char>> known(chunks.size(),
                                       std::vector<char>(joints, 0));
  ForEachChunk(
      recording, chunks, [&](int i, PersonSolver* solver, PersonProblem* part) {
        const Chunk& chunk = chunks[i];
        const size_t end = chunk.own_end - chunk.begin;
        const std::vector<std::vector<Matrix6d>> states =
            of(solver, *part, end);
        for (size_t j = 0; j < joints; ++j) {
          known[i][j] = states[j].size() >= end;
          for (size_t k = chunk.own_begin; known[i][j] && k < chunk.own_end;
               ++k) {
            whole[j][k] =
                states[j][k - chunk.begin]
                    .template topLeftCorner<Matrix::RowsAtCompileTime,
                                            Matrix::ColsAtCompileTime>();
          }
        }
      });
  for (const std::vector<char>& of_chunk : known) {
    for (size_t j = 0; j < joints; ++j) {
      if (!of_chunk[j]) whole[j] = {};
    }
  }
  return whole;
}

std::vector<std::vector<Matrix6d>> RecordingSolver::StateCovariances(
    const PersonProblem& recording, double correction) {
  return InChunks<Matrix6d>(
      recording,
      [&](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return solver->JointCovariances(part, correction, end);
      });
}

std::vector<std::vector<Eigen::Matrix3d>> RecordingSolver::JointCovariances(
    const PersonProblem& recording) {
  return InChunks<Eigen::Matrix3d>(
      recording,
      [](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return solver->JointCovariances(part, solver->correction(), end);
      });
}

std::vector<std::vector<Eigen::Matrix3d>> RecordingSolver::Covariances(
    const PersonProblem& recording) {
  return InChunks<Eigen::Matrix3d>(
      recording,
      [](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return part.coupled()
                   ? solver->BoneCovariances(part, end)
                   : solver->JointCovariances(part, solver->correction(), end);
      });
}

}  // namespace kinegraph
