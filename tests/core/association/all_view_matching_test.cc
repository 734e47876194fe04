#include "core/association/all_view_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/base/random.h"
#include "core/skeleton/skeleton.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using Matches = std::vector<std::vector<int>>;

Pose3d Box(double x_m, double y_m) {
  return {{{x_m, y_m, 1.7}, JointStatus::kObserved},
          {{x_m, y_m, 0.0}, JointStatus::kObserved}};
}

class AllViewMatcherTest : public ::testing::Test {
 protected:
  // Every camera observes these boxes, in this order.
  void See(const std::vector<Pose3d>& boxes) {
    observations_.assign(cameras_.size(), {});
    for (size_t v = 0; v < cameras_.size(); ++v) {
      for (size_t k = 0; k < boxes.size(); ++k) {
        observations_[v].push_back(testing::Observe(
            boxes[k], cameras_, static_cast<int>(v), static_cast<int>(k)));
      }
    }
  }
  Matches Match(const std::vector<Pose3d>& expected, double age_s) {
    return MatchBy(matcher_, expected, age_s);
  }
  Matches MatchBy(AllViewMatcher& matcher, const std::vector<Pose3d>& expected,
                  double age_s) {
    std::vector<ExpectedPerson> people;
    for (const Pose3d& pose : expected) {
      people.push_back({&pose, ExpectedSigma(age_s)});
    }
    std::vector<Span<Observation>> views;
    for (const auto& view : observations_) views.emplace_back(view);
    Matches matches;
    matcher.Match(people, views, barred_, &matches);
    return matches;
  }

  const CameraRig cameras_ = testing::RingOfCameras(4);
  AllViewMatcher matcher_{cameras_, {0, 1}, 6.0};
  std::vector<std::vector<Observation>> observations_;
  std::vector<std::vector<char>> barred_ =
      std::vector<std::vector<char>>(cameras_.size());
};

TEST_F(AllViewMatcherTest, AppliesToSkeletonsOfFewJoints) {
  EXPECT_TRUE(AllViewMatcher::AppliesTo(Skeleton("b", {"top", "bottom"}, {})));
  EXPECT_FALSE(AllViewMatcher::AppliesTo(Tum14()));
}

// Cameras 0 and 2, on the x axis, see the two people one behind the other. In
// these views each expected position is nearer to the other person's detection.
TEST_F(AllViewMatcherTest, ViewsTogetherResolveAnAmbiguity) {
  See({Box(0.7, 0.1), Box(-0.7, -0.1)});
  EXPECT_EQ(Match({Box(0.6, -0.1), Box(-0.6, 0.1)}, 0.25), Matches(4, {0, 1}));
}

TEST_F(AllViewMatcherTest, ToleratesAHiddenBottom) {
  See({Box(0.0, 0.0), Box(1.0, 1.0)});
  // The box of camera 1 ends at the knees of the first person.
  observations_[1][0] = testing::Observe(
      {Box(0.0, 0.0)[0], {{0.0, 0.0, 0.5}, JointStatus::kObserved}}, cameras_,
      1);
  EXPECT_EQ(Match({Box(0.1, 0.0), Box(1.0, 0.9)}, 0.25), Matches(4, {0, 1}));
}

// In camera 0 the box of the first person is 0.3 m to the side and ends at hip
// height. It is matched if somebody in front hides the legs, and not otherwise.
TEST_F(AllViewMatcherTest, HiddenJointsAreMisplacedMoreOften) {
  const std::vector<Pose3d> two = {Box(0.0, 0.0), Box(2.0, 0.0)};
  See(two);
  observations_[0][0] =
      testing::Observe({{{0.0, 0.3, 1.7}, JointStatus::kObserved},
                        {{0.0, 0.3, 0.9}, JointStatus::kObserved}},
                       cameras_, 0);
  EXPECT_EQ(Match(two, 0.25)[0], (std::vector<int>{0, 1}));
  EXPECT_EQ(Match({two[0], Box(-2.0, 0.0)}, 0.25)[0][0], -1);
}

// Crowds of ten whose detections have errors of 20 px; one to three of the ten
// are missing in each view.
TEST_F(AllViewMatcherTest, TheOrderOfViewsDoesNotMatter) {
  const CameraRig reversed(cameras_.rbegin(), cameras_.rend());
  AllViewMatcher of_reversed(reversed, {0, 1}, 6.0);
  Random random(1);
  for (int crowd = 0; crowd < 30; ++crowd) {
    std::vector<Pose3d> boxes;
    std::vector<Pose3d> expected;
    for (int p = 0; p < 10; ++p) {
      const Eigen::Vector2d at(random.Uniform(-1.5, 1.5),
                               random.Uniform(-1.5, 1.5));
      boxes.push_back(Box(at.x(), at.y()));
      expected.push_back(Box(at.x() + random.Normal(0.0, 0.2),
                             at.y() + random.Normal(0.0, 0.2)));
    }
    See(boxes);
    for (std::vector<Observation>& view : observations_) {
      for (Observation& one : view) {
        for (size_t j = 0; j < one.joints.size(); ++j) {
          const Eigen::Vector2d off(random.Normal(0.0, 20.0),
                                    random.Normal(0.0, 20.0));
          one.joints[j].px += off;
          one.ideal_px[j] += off;
        }
      }
      view.resize(7 + static_cast<size_t>(crowd % 3));
    }
    Matches matches = Match(expected, 0.25);
    std::reverse(observations_.begin(), observations_.end());
    EXPECT_EQ(MatchBy(of_reversed, expected, 0.25),
              Matches(matches.rbegin(), matches.rend()))
        << "crowd " << crowd;
  }
}

// The person is off by 0.8 m on each axis: five standard deviations of the
// position expected after 0.25 s, less than one after 2 s (ExpectedSigma).
TEST_F(AllViewMatcherTest, SearchRadiusGrowsWithAge) {
  See({Box(0.8, 0.8)});
  EXPECT_EQ(Match({Box(0.0, 0.0)}, 0.25), Matches(4, {-1}));
  EXPECT_EQ(Match({Box(0.0, 0.0)}, 2.0), Matches(4, {0}));
}

TEST_F(AllViewMatcherTest, BarredPairsDoNotMatch) {
  See({Box(0.0, 0.0)});
  barred_[2] = {1};
  EXPECT_EQ(Match({Box(0.0, 0.0)}, 0.25), (Matches{{0}, {0}, {-1}, {0}}));
}

TEST_F(AllViewMatcherTest, NothingMatchesWithoutDetectionsOrPeople) {
  See({});
  EXPECT_EQ(Match({Box(0.0, 0.0)}, 0.25), Matches(4, {-1}));
  See({Box(0.0, 0.0)});
  EXPECT_EQ(Match({}, 0.25), Matches(4));
}

}  // namespace
}  // namespace kinegraph
