// A window of full length allocates no memory except within Ceres.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <new>
#include <string>

#include "solvers/person/person_solver.h"
#include "tests/support/sanitized.h"
#include "tests/support/solver_problem.h"

namespace {
std::atomic<int64_t> allocations{0};
}  // namespace

// Counts every `new` of this program. Eigen allocates with malloc, which is not
// counted, but no matrix that a window holds changes its size. Not inlined: the
// compiler would report free() as a mismatched deallocation.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* const memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace kinegraph {
namespace {

using testing::SimulatedNoise;

class AllocationsTest : public testing::SolverProblemTest {};

TEST_F(AllocationsTest, ASteadyWindowAllocatesNothingBesidesCeres) {
  if (testing::kSanitized) GTEST_SKIP() << "a sanitizer has its own allocator";
  SimulatedNoise noise;
  noise.missing = 0.2;
  Make({4, 11, 71, false, 0}, noise);
  PersonSolver solver(options_);
  const auto solve = [&](int64_t* basin, int64_t* minimum) {
    // Learnt process noise changes from frame to frame.
    for (JointChain& chain : problem_.joints) {
      for (double& q : chain.process_noise) q *= 1.01;
    }
    const int64_t before = allocations;
    solver.SolveJoints(solver.schedule(), &problem_);
    *basin += allocations - before;
    const int64_t between = allocations;
    solver.Refine(&problem_);
    *minimum += allocations - between;
  };
  int64_t basin = 0;
  int64_t minimum = 0;
  for (int i = 0; i < 10; ++i) solve(&basin, &minimum);  // allocates work space
  basin = minimum = 0;
  constexpr int kFrames = 100;
  for (int i = 0; i < kFrames; ++i) solve(&basin, &minimum);
  EXPECT_EQ(basin, 0);
  // Ceres creates its program, evaluator and Jacobian in every solve, with a
  // dozen allocations for each block of states and some others. Adding all
  // residual blocks again would cost hundreds more: about four for each of 66
  // blocks (one per state for its views, 30 motions, 3 priors).
  const int64_t per_solve = minimum / kFrames;
  RecordProperty("ceres_allocations_per_solve", std::to_string(per_solve));
  const auto states =
      static_cast<int64_t>(problem_.joints.size() * problem_.times.size());
  EXPECT_LT(per_solve, 100 + 12 * states);
  EXPECT_EQ(minimum % kFrames, 0);  // the same in every frame
  std::cout << "Ceres allocates " << per_solve << " times per solve, "
            << static_cast<double>(per_solve) / static_cast<double>(states)
            << " per state\n";
}

}  // namespace
}  // namespace kinegraph
