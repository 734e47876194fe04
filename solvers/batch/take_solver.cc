#include "solvers/batch/take_solver.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"
#include "core/system/memory.h"

namespace kinegraph {
namespace {

// What chunks used and freed lies scattered; with a small share of the time it
// takes to solve them it is returned so often.
constexpr int kChunksATidying = 32;

std::vector<int> AllJoints(const PersonProblem& problem) {
  std::vector<int> all(problem.joints.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

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

TakeSolver::TakeSolver(const GraphOptions& options)
    : options_(options), whole_(options) {}

void TakeSolver::FreeWorkSpace() {
  whole_.FreeWorkSpace();
  idle_.clear();
  ReturnFreeMemory();
}

std::unique_ptr<PersonSolver> TakeSolver::TakeIdle() {
  const std::lock_guard<std::mutex> lock(taking_);
  if (idle_.empty()) return std::make_unique<PersonSolver>(options_);
  std::unique_ptr<PersonSolver> solver = std::move(idle_.back());
  idle_.pop_back();
  return solver;
}

void TakeSolver::GiveBack(std::unique_ptr<PersonSolver> solver) {
  const std::lock_guard<std::mutex> lock(taking_);
  whole_.TakeCounts(solver.get());
  idle_.push_back(std::move(solver));
}

void TakeSolver::ForEachChunk(
    const PersonTake& take, const std::vector<Chunk>& chunks,
    const std::function<void(PersonSolver*, int, PersonProblem*)>& work) {
  ParallelFor(AllowedThreads(), static_cast<int>(chunks.size()), [&](int i) {
    PersonProblem part = CutOut(take, chunks[i]);
    std::unique_ptr<PersonSolver> solver = TakeIdle();
    work(solver.get(), i, &part);
    GiveBack(std::move(solver));
    if (i % kChunksATidying == kChunksATidying - 1) ReturnFreeMemory();
  });
}

void TakeSolver::Solve(
    PersonTake* take,
    const std::function<void(PersonSolver*, int, PersonProblem*)>& work) {
  const std::vector<Chunk> chunks = MakeChunks(take->graph, options_.chunk_s);
  if (chunks.size() == 1) {
    PersonProblem all = CutOut(*take, chunks.front());
    work(&whole_, 0, &all);
    Paste(OutcomesOf(all, chunks.front()), chunks.front(), take);
    take->graph.bones = std::move(all.bones);
    return;
  }
  // All are cut out before any is put back: they overlap.
  std::vector<std::vector<JointOutcome>> outcomes(chunks.size());
  ForEachChunk(*take, chunks,
               [&](PersonSolver* solver, int i, PersonProblem* part) {
                 work(solver, i, part);
                 outcomes[i] = OutcomesOf(*part, chunks[i]);
               });
  for (size_t i = 0; i < chunks.size(); ++i) {
    Paste(outcomes[i], chunks[i], take);
    outcomes[i] = {};
  }
}

void TakeSolver::SolveJoints(const SolveSchedule& schedule, PersonTake* take) {
  Solve(take, [&](PersonSolver* solver, int, PersonProblem* part) {
    solver->SolveJoints(schedule, AllJoints(*part), part);
  });
}

void TakeSolver::SolveJointsWithRivals(const SolveSchedule& schedule,
                                       PersonTake* take) {
  Solve(take, [&](PersonSolver* solver, int, PersonProblem* part) {
    solver->SolveJointsWithRivals(schedule, AllJoints(*part), part);
  });
}

void TakeSolver::SolveTogether(PersonTake* take) {
  FreeWorkSpace();
  const bool with_bones = !take->graph.bones.empty();
  without_bones_.assign(MakeChunks(take->graph, options_.chunk_s).size(), 0);
  Solve(take, [&](PersonSolver* solver, int i, PersonProblem* part) {
    solver->SolveBones(part);
    without_bones_[i] = with_bones && part->bones.empty();
    solver->Refine(part);
  });
}

template <typename Matrix, typename Of>
std::vector<std::vector<Matrix>> TakeSolver::InChunks(const PersonTake& take,
                                                      const Of& of) {
  FreeWorkSpace();
  const std::vector<Chunk> chunks = MakeChunks(take.graph, options_.chunk_s);
  if (chunks.size() == 1) {
    return of(&whole_, CutOut(take, chunks.front()), take.frame_count());
  }
  // Each chunk writes its own frames. A joint that one chunk knows nothing of
  // has none.
  std::vector<std::vector<Matrix>> whole(
      take.graph.joints.size(), std::vector<Matrix>(take.frame_count()));
  std::vector<std::vector<char>> known(
      chunks.size(), std::vector<char>(take.graph.joints.size(), 0));
  ForEachChunk(
      take, chunks, [&](PersonSolver* solver, int i, PersonProblem* part) {
        if (!part->bones.empty() && without_bones_[i]) part->bones.clear();
        const Chunk& chunk = chunks[i];
        const size_t begin = chunk.own_begin - chunk.begin;
        const size_t end = chunk.own_end - chunk.begin;
        const auto of_part = of(solver, *part, end);
        for (size_t j = 0; j < whole.size(); ++j) {
          if (of_part[j].size() < end) continue;
          std::copy(of_part[j].begin() + begin, of_part[j].begin() + end,
                    whole[j].begin() + chunk.own_begin);
          known[i][j] = 1;
        }
      });
  for (const std::vector<char>& of_chunk : known) {
    for (size_t j = 0; j < whole.size(); ++j) {
      if (!of_chunk[j]) whole[j] = {};
    }
  }
  return whole;
}

std::vector<std::vector<Matrix6d>> TakeSolver::StateCovariances(
    const PersonTake& take, double correction) {
  return InChunks<Matrix6d>(
      take, [&](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return solver->JointCovariances(part, correction, end);
      });
}

std::vector<std::vector<Eigen::Matrix3d>> TakeSolver::JointCovariances(
    const PersonTake& take) {
  return InChunks<Eigen::Matrix3d>(
      take, [&](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return Positions(
            solver->JointCovariances(part, solver->correction(), end));
      });
}

std::vector<std::vector<Eigen::Matrix3d>> TakeSolver::Covariances(
    const PersonTake& take) {
  return InChunks<Eigen::Matrix3d>(
      take, [&](PersonSolver* solver, const PersonProblem& part, size_t end) {
        return Positions(part.coupled() ? solver->BoneCovariances(part, end)
                                        : solver->JointCovariances(
                                              part, solver->correction(), end));
      });
}

}  // namespace kinegraph
