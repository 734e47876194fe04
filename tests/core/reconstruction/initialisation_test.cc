#include "core/reconstruction/initialisation.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/rig.h"

namespace kinegraph {
namespace {

class InitialisationTest : public ::testing::Test {
 protected:
  // Observations of the given people in the first `views` views, in an order
  // that varies between the views.
  std::vector<ObservationGroup> See(const std::vector<Pose3d>& people,
                                    size_t views = 4) {
    seen_.clear();
    seen_.reserve(people.size() * views);
    std::vector<ObservationGroup> unmatched(cameras_.size());
    for (size_t v = 0; v < views; ++v) {
      for (size_t p = 0; p < people.size(); ++p) {
        const size_t person = (p + v) % people.size();
        seen_.push_back(testing::Observe(people[person], cameras_,
                                         static_cast<int>(v),
                                         static_cast<int>(person)));
        unmatched[v].push_back(&seen_.back());
      }
    }
    return unmatched;
  }

  std::vector<NewPerson> Run(const InitialisationOptions& options,
                             const std::vector<ObservationGroup>& unmatched) {
    Initialiser initialiser(options, epipolar_, &reconstructor_,
                            Coco17().association_joints());
    std::vector<NewPerson> people;
    initialiser.Run(unmatched, &people);
    return people;
  }

  static InitialisationOptions AuthorsCode() {
    InitialisationOptions options;
    options.rule = InitialisationRule::kWeightedDistance;
    options.alpha_filter_px = 30.0;
    options.min_confidence = 0.5;
    options.min_joints = 17.0;
    return options;
  }

  CameraRig cameras_ = testing::RingOfCameras(4);
  EpipolarGeometry epipolar_{cameras_};
  Reconstructor reconstructor_{cameras_, epipolar_, ReconstructionOptions(),
                               Coco17()};
  Pose3d ann_ = testing::StandingPerson(-0.9, 0.3);
  Pose3d bob_ = testing::StandingPerson(0.8, -0.7);
  std::vector<Observation> seen_;
};

TEST_F(InitialisationTest, BothRulesFindBothPeople) {
  for (const InitialisationOptions& options :
       {InitialisationOptions(), AuthorsCode()}) {
    const auto people = Run(options, See({ann_, bob_}));
    ASSERT_EQ(people.size(), 2u);
    for (const NewPerson& person : people) {
      ASSERT_EQ(person.members.size(), 4u);
      const int who = person.members[0]->detection_idx;
      for (const Observation* member : person.members) {
        EXPECT_EQ(member->detection_idx, who);
      }
      const Pose3d& truth = who == 0 ? ann_ : bob_;
      for (int j = 0; j < 17; ++j) {
        EXPECT_LT(
            (person.reconstruction.pose[j].position_m - truth[j].position_m)
                .norm(),
            1e-9);
      }
    }
  }
}

TEST_F(InitialisationTest, SingleViewsAndUncertainDetectionsStartNobody) {
  auto unmatched = See({ann_});
  for (Observation& observation : seen_) observation.mean_confidence = 0.5;
  EXPECT_TRUE(Run(AuthorsCode(), unmatched).empty()) << "not above 0.5";
  unmatched = See({ann_}, 1);
  EXPECT_TRUE(Run(InitialisationOptions(), unmatched).empty());
  EXPECT_TRUE(Run(AuthorsCode(), unmatched).empty());
}

TEST_F(InitialisationTest, EpipolarContradictionIsNotJoined) {
  // Only two views, which contradict each other: their affinity (E in the
  // paper, section 3.3) is negative.
  const auto unmatched = See({ann_}, 2);
  for (Eigen::Vector2d& px : seen_[1].ideal_px) px.y() -= 200.0;
  InitialisationOptions options;
  options.alpha_filter_px = 1e6;  // the joints filter must not decide this
  EXPECT_TRUE(Run(options, unmatched).empty());
  options.alpha_group_px = 1e6;
  EXPECT_EQ(Run(options, unmatched).size(), 1u)
      << "nothing else separates them";
}

TEST_F(InitialisationTest, RequiresEnoughCommonJoints) {
  const auto unmatched = See({ann_}, 2);
  InitialisationOptions options;
  options.min_common_joints = 10.0;
  options.min_joints = 9.0;
  for (int j = 0; j < 7; ++j) seen_[1].joints[j].found = false;  // ten remain
  EXPECT_EQ(Run(options, unmatched).size(), 1u);
  seen_[1].joints[7].found = false;  // nine remain
  EXPECT_TRUE(Run(options, unmatched).empty());
}

TEST_F(InitialisationTest, ANewPersonNeedsEnoughTriangulatedJoints) {
  auto unmatched = See({ann_});
  // The authors' code drops a group when any of 17 joints has fewer than two
  // views: here an ear is hidden in all but one view.
  for (int v = 1; v < 4; ++v) seen_[v].joints[3].found = false;
  EXPECT_TRUE(Run(AuthorsCode(), unmatched).empty());
  EXPECT_EQ(Run(InitialisationOptions(), unmatched).size(), 1u);
}

class WeightedDistanceTest : public InitialisationTest {
 protected:
  // Epipolar lines are not image rows here, so the expected cost is computed.
  double Cost(const Observation& a, const Observation& b) const {
    double sum = 0.0;
    for (int j = 0; j < 17; ++j) {
      sum += epipolar_.WeightedDistance(a.view_idx, a.ideal_px[j],
                                        a.joints[j].confidence, b.view_idx,
                                        b.ideal_px[j], b.joints[j].confidence);
    }
    return sum / 17.0 / 60.0;  // the mean of 17 joints / alpha_group_px
  }

  const GroupingRule rule_{AuthorsCode(), epipolar_,
                           Coco17().association_joints()};
};

TEST_F(WeightedDistanceTest, GainIsMinusTheMeanCostOverTheGroup) {
  See({ann_});
  for (Eigen::Vector2d& px : seen_[2].ideal_px) px += Eigen::Vector2d(8, 25);
  for (Keypoint& joint : seen_[0].joints) joint.confidence = 0.6;
  const double expected =
      -0.5 * (Cost(seen_[0], seen_[2]) + Cost(seen_[1], seen_[2]));
  EXPECT_LT(expected, -0.01);
  EXPECT_NEAR(rule_.Gain({&seen_[0], &seen_[1]}, seen_[2]), expected, 1e-12);
}

TEST_F(WeightedDistanceTest, VetoAppliesOnlyToConfidentDetections) {
  See({ann_});
  for (Eigen::Vector2d& px : seen_[2].ideal_px) px.y() += 400.0;
  const ObservationGroup group = {&seen_[0], &seen_[1]};
  ASSERT_GT(std::max(Cost(seen_[0], seen_[2]), Cost(seen_[1], seen_[2])), 1.0);
  seen_[2].mean_confidence = 0.51;
  EXPECT_FALSE(rule_.Accept(group, seen_[2]));
  seen_[2].mean_confidence = 0.5;
  EXPECT_TRUE(rule_.Accept(group, seen_[2])) << "not above 0.5";
}

TEST_F(WeightedDistanceTest, VetoSeparatesAnAssignedPair) {
  // View 0 sees Ann; view 1 sees one person 400 px off. The assignment has no
  // other choice than to pair these two; only the veto separates them.
  const auto unmatched = See({ann_}, 2);
  for (Eigen::Vector2d& px : seen_[1].ideal_px) px.y() += 400.0;
  InitialisationOptions options = AuthorsCode();
  options.alpha_filter_px = 1e6;  // the joints filter must not decide this
  options.min_joints = 1.0;
  EXPECT_TRUE(Run(options, unmatched).empty());
  options.veto_confidence = 2.0;  // no detection reaches it
  EXPECT_EQ(Run(options, unmatched).size(), 1u);
}

}  // namespace
}  // namespace kinegraph
