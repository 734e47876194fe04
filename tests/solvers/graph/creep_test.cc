#include "solvers/graph/creep.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

PersonStates Step(double x, double y) {
  PersonStates step(1, StateChain(2, State::Zero()));
  step[0][0][0] = x;
  step[0][1][4] = y;
  return step;
}

TEST(Creep, AGeometricSeriesIsSummed) {
  // Each step is 0.8 of the one before: 0.8 + 0.64 + ... = 4 of the last.
  EXPECT_DOUBLE_EQ(StepsToCome(Step(1.0, 2.0), Step(0.8, 1.6)), 4.0);
}

TEST(Creep, OnlyWhatLooksLikeOne) {
  EXPECT_EQ(StepsToCome(Step(1.0, 0.0), Step(0.0, 0.8)), 0.0);   // turns
  EXPECT_EQ(StepsToCome(Step(1.0, 0.0), Step(-0.8, 0.0)), 0.0);  // goes back
  EXPECT_EQ(StepsToCome(Step(1.0, 0.0), Step(0.1, 0.0)), 0.0);   // is quick
  EXPECT_EQ(StepsToCome(Step(0.0, 0.0), Step(0.1, 0.0)), 0.0);
}

TEST(Creep, NeverGuessesFar) {
  EXPECT_NEAR(StepsToCome(Step(1.0, 0.0), Step(0.999, 0.0)), 19.0, 1e-9);
  EXPECT_NEAR(StepsToCome(Step(1.0, 0.0), Step(1.5, 0.0)), 19.0, 1e-9);
}

}  // namespace
}  // namespace kinegraph
