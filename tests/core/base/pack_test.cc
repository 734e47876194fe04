#include "core/base/pack.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/instruction_set.h"

namespace kinegraph {
namespace {

template <typename P>
class PackTest : public ::testing::Test {};
using Widths =
    ::testing::Types<Pack<2, BaselineTarget>, Pack<4, BaselineTarget>,
                     Pack<8, BaselineTarget>>;
TYPED_TEST_SUITE(PackTest, Widths);

// Lane i of the packs a and b is kA[i] and kB[i].
constexpr double kA[] = {1.5, -2.0, 0.1, 7.0, 1e-9, -0.0, 3.0, 1e300};
constexpr double kB[] = {3.0, 0.3, -7.0, 7.0, 1e9, 0.0, -1.0, 1e300};

TYPED_TEST(PackTest, LanesMatchScalarArithmetic) {
  const TypeParam a = TypeParam::Load(kA);
  const TypeParam b = TypeParam::Load(kB);
  const TypeParam root = Sqrt(Abs(a));
  const TypeParam chosen = Select(a < b, a * 2.0, 1.0 - b);
  for (int i = 0; i < TypeParam::kLanes; ++i) {
    const double x = kA[i];
    const double y = kB[i];
    EXPECT_EQ((a + b)[i], x + y);
    EXPECT_EQ((a - b)[i], x - y);
    EXPECT_EQ((a * b)[i], x * y);
    EXPECT_EQ(std::signbit((-a)[i]), !std::signbit(x));
    EXPECT_EQ(root[i], std::sqrt(std::abs(x)));
    EXPECT_EQ(chosen[i], x < y ? x * 2.0 : 1.0 - y);
    EXPECT_EQ(Max(a, b)[i], Max(x, y));
    if (y != 0.0) {
      EXPECT_EQ((a / b)[i], x / y);
    }
  }
}

TYPED_TEST(PackTest, MasksCombineAndReduceLanes) {
  const TypeParam a = TypeParam::Load(kA);
  const auto all = a == a;
  const auto first = a == TypeParam(1.5);
  EXPECT_TRUE(All(all));
  EXPECT_TRUE(Any(first));
  EXPECT_FALSE(All(first));
  EXPECT_FALSE(Any(And(first, Not(first))));
  EXPECT_TRUE(All(Or(first, Not(first))));
}

TYPED_TEST(PackTest, ComparisonsWithNaNAreFalse) {
  const TypeParam nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Any(nan < TypeParam(1.0)));
  EXPECT_FALSE(Any(nan >= TypeParam(1.0)));
  EXPECT_FALSE(Any(nan == nan));
}

TEST(InstructionSet, FallsBackToBestSupportedSet) {
  UseInstructionSet(InstructionSet::kBaseline);
  EXPECT_EQ(CurrentInstructionSet(), InstructionSet::kBaseline);
  UseInstructionSet(InstructionSet::kAvx512);
  EXPECT_EQ(CurrentInstructionSet(), BestInstructionSet());
}

TEST(PaddedLanes, RoundsUp) {
  EXPECT_EQ(PaddedLanes(0), 0);
  EXPECT_EQ(PaddedLanes(1), kLaneMultiple);
  EXPECT_EQ(PaddedLanes(17), 24);
}

}  // namespace
}  // namespace kinegraph
