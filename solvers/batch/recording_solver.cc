#include "solvers/batch/recording_solver.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"
#include "solvers/graph/schedule.h"

namespace kinegraph {
namespace {

std::vector<int> AllJoints(const PersonProblem& problem) {
  std::vector<int> all(problem.joints.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// What a solve found in a chunk's own frames.
struct ChunkSolution {
  std::vector<JointOutcome> joints;
  bool bones_dropped = false;  // they could not be solved
};

// Of a chunk's own frames, [joint][frame]; a joint has none where it is not
// known.
template <typename Matrix>
using ChunkCovariances = std::vector<std::vector<Matrix>>;

std::vector<std::vector<Eigen::Matrix3d>> Positions(
    const std::vector<std::vector<Matrix6d>>& covariances) {
  std::vector<std::vector<Eigen::Matrix3d>> positions(covariances.size());
  for (size_t j = 0; j < covariances.size(); ++j) {
    positions[j].reserve(covariances[j].size());
    for (const Matrix6d& covariance : covariances[j]) {
      positions[j].push_back(covariance.topLeftCorner<3, 3>());
    }
  }
  return positions;
}

}  // namespace

RecordingSolver::RecordingSolver(const GraphOptions& options)
    : options_(options), whole_(options) {}

void RecordingSolver::FreeWorkSpace() {
  whole_.FreeWorkSpace();
  idle_.clear();
}

std::unique_ptr<PersonSolver> RecordingSolver::AcquireIdle() {
  const std::lock_guard<std::mutex> lock(taking_);
  if (idle_.empty()) return std::make_unique<PersonSolver>(options_);
  std::unique_ptr<PersonSolver> solver = std::move(idle_.back());
  idle_.pop_back();
  return solver;
}

void RecordingSolver::GiveBack(std::unique_ptr<PersonSolver> solver) {
  const std::lock_guard<std::mutex> lock(taking_);
  whole_.AddCounts(solver->ExtractCounts());
  idle_.push_back(std::move(solver));
}

template <typename Outcome, typename Compute, typename Adopt>
void RecordingSolver::ForEachChunk(const PersonRecording& recording,
                                   const std::vector<Chunk>& chunks,
                                   const Compute& compute,
                                   const Adopt& take_over) {
  ParallelFor(AllowedThreads(), static_cast<int>(chunks.size()), [&](int i) {
    PersonProblem part = CutOut(recording, chunks[i]);
    if (!without_bones_.empty() && without_bones_[i]) part.bones.clear();
    std::unique_ptr<PersonSolver> solver = AcquireIdle();
    Outcome outcome = compute(solver.get(), chunks[i], &part);
    GiveBack(std::move(solver));
    take_over(i, std::move(outcome));
  });
}

std::vector<char> RecordingSolver::Solve(const std::vector<Chunk>& chunks,
                                         const Work& work,
                                         PersonRecording* recording) {
  // All are cut out before any is put back: they overlap.
  std::vector<ChunkSolution> solutions(chunks.size());
  ForEachChunk<ChunkSolution>(
      *recording, chunks,
      [&](PersonSolver* solver, const Chunk& chunk, PersonProblem* part) {
        const bool with_bones = !part->bones.empty();
        work(solver, part);
        return ChunkSolution{OutcomesOf(*part, chunk),
                             with_bones && part->bones.empty()};
      },
      [&](int i, ChunkSolution&& solution) {
        solutions[i] = std::move(solution);
      });
  std::vector<char> without_bones;
  for (size_t i = 0; i < chunks.size(); ++i) {
    Paste(solutions[i].joints, chunks[i], recording);
    without_bones.push_back(solutions[i].bones_dropped);
    solutions[i] = {};
  }
  return without_bones;
}

void RecordingSolver::SolveJoints(const SolveSchedule& schedule,
                                  PersonRecording* recording) {
  Solve(
      MakeChunks(recording->graph, options_.chunk_s),
      [&](PersonSolver* solver, PersonProblem* part) {
        solver->SolveJoints(schedule, AllJoints(*part), part);
      },
      recording);
}

void RecordingSolver::SolveTogether(PersonRecording* recording) {
  FreeWorkSpace();
  without_bones_.clear();
  without_bones_ = Solve(
      MakeChunks(recording->graph, options_.chunk_s),
      [](PersonSolver* solver, PersonProblem* part) {
        solver->SolveBones(part);
        solver->Refine(part);
      },
      recording);
  // Then the recording has none.
  const bool as_a_whole = without_bones_.size() == 1;
  if (as_a_whole && without_bones_[0]) recording->graph.bones.clear();
}

bool RecordingSolver::SolveAnew(const std::vector<Chunk>& chunks,
                                PersonRecording* recording) {
  const std::vector<char> without_bones = Solve(
      chunks,
      [&](PersonSolver* solver, PersonProblem* part) {
        solver->SolveJoints(schedule(), AllJoints(*part), part);
        solver->SolveBones(part);
        solver->Refine(part);
      },
      recording);
  return std::count(without_bones.begin(), without_bones.end(), 0) ==
         static_cast<std::ptrdiff_t>(without_bones.size());
}

bool RecordingSolver::KeptBones() const {
  return std::find(without_bones_.begin(), without_bones_.end(), 1) ==
         without_bones_.end();
}

template <typename Matrix, typename Of>
std::vector<std::vector<Matrix>> RecordingSolver::InChunks(
    const PersonRecording& recording, const Of& of) {
  FreeWorkSpace();
  const std::vector<Chunk> chunks =
      MakeChunks(recording.graph, options_.chunk_s);
  // Each chunk writes its own frames. A joint that one chunk knows nothing of
  // has none.
  std::vector<std::vector<Matrix>> whole(
      recording.graph.joints.size(),
      std::vector<Matrix>(recording.frame_count()));
  std::vector<std::vector<char>> known(
      chunks.size(), std::vector<char>(recording.graph.joints.size(), 0));
  ForEachChunk<ChunkCovariances<Matrix>>(
      recording, chunks,
      [&](PersonSolver* solver, const Chunk& chunk, PersonProblem* part) {
        const size_t end = chunk.own_end - chunk.begin;
        ChunkCovariances<Matrix> covariances = of(solver, *part, end);
        for (std::vector<Matrix>& of_joint : covariances) {
          if (of_joint.size() < end) of_joint.clear();
          if (of_joint.empty()) continue;
          of_joint.resize(end);
          const size_t before = chunk.own_begin - chunk.begin;
          of_joint.erase(
              of_joint.begin(),
              of_joint.begin() + static_cast<std::ptrdiff_t>(before));
        }
        return covariances;
      },
      [&](int i, ChunkCovariances<Matrix>&& covariances) {
        for (size_t j = 0; j < whole.size(); ++j) {
          std::copy(covariances[j].begin(), covariances[j].end(),
                    whole[j].begin() + chunks[i].own_begin);
          known[i][j] = !covariances[j].empty();
        }
      });
  for (const std::vector<char>& of_chunk : known) {
    for (size_t j = 0; j < whole.size(); ++j) {
      if (!of_chunk[j]) whole[j] = {};
    }
  }
  return whole;
}

std::vector<std::vector<Matrix6d>> RecordingSolver::StateCovariances(
    const PersonRecording& recording, double correction) {
  return InChunks<Matrix6d>(
      recording,
      [&](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return solver->JointCovariances(part, correction, end);
      });
}

std::vector<std::vector<Eigen::Matrix3d>> RecordingSolver::JointCovariances(
    const PersonRecording& recording) {
  return InChunks<Eigen::Matrix3d>(recording, [](PersonSolver* solver,
                                                 const PersonProblem& part,
                                                 size_t end) {
    return Positions(solver->JointCovariances(part, solver->correction(), end));
  });
}

std::vector<std::vector<Eigen::Matrix3d>> RecordingSolver::Covariances(
    const PersonRecording& recording) {
  return InChunks<Eigen::Matrix3d>(
      recording,
      [](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return Positions(part.coupled() ? solver->BoneCovariances(part, end)
                                        : solver->JointCovariances(
                                              part, solver->correction(), end));
      });
}

}  // namespace kinegraph
