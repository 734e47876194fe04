#include "solvers/batch/recording_solver.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"
#include "solvers/graph/assembler.h"

namespace kinegraph {
namespace {

std::vector<int> AllJoints(const PersonProblem& problem) {
  std::vector<int> all(problem.joints.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
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

template <typename Visit>
void RecordingSolver::ForEachChunk(const PersonProblem& recording,
                                   const std::vector<Chunk>& chunks,
                                   const Visit& visit) {
  ParallelFor(AllowedThreads(), static_cast<int>(chunks.size()), [&](int i) {
    PersonProblem part = CutOut(recording, chunks[i]);
    if (!without_bones_.empty() && without_bones_[i]) part.bones.clear();
    std::unique_ptr<PersonSolver> solver = AcquireIdle();
    visit(i, solver.get(), &part);
    GiveBack(std::move(solver));
  });
}

std::vector<char> RecordingSolver::Solve(const std::vector<Chunk>& chunks,
                                         const Work& work,
                                         PersonProblem* recording) {
  // All are cut out before any is put back: they overlap.
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
        solver->SolveJoints(schedule, AllJoints(*part), part);
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
  // Then the recording has none.
  const bool as_a_whole = without_bones_.size() == 1;
  if (as_a_whole && without_bones_[0]) recording->bones.clear();
}

bool RecordingSolver::SolveAnew(const std::vector<Chunk>& chunks,
                                PersonProblem* recording) {
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
    const PersonProblem& recording, const Of& of) {
  FreeWorkSpace();
  const std::vector<Chunk> chunks = MakeChunks(recording, options_.chunk_s);
  // Each chunk writes its own frames. A joint that one chunk knows nothing of
  // has none.
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
