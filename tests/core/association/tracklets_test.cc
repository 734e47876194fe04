#include "core/association/tracklets.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/skeleton/skeleton.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// The view of one camera, with people at the given positions along x.
class TrackletsTest : public ::testing::Test {
 protected:
  void See(const std::vector<double>& places_m) {
    observations_.clear();
    for (const double x_m : places_m) {
      observations_.push_back(
          testing::Observe(testing::StandingPerson(x_m, 0.0), cameras_, kView));
    }
    tracklets_.Follow(observations_, FromSeconds(frame_s_ * frame_),
                      1.5 * frame_s_);
    ++frame_;
  }

  // Ten frames of two people matched with tracks 1 and 2: 0.36 s at 25 Hz.
  void SeeTwo(double one_m, double other_m) {
    for (int k = 0; k < 10; ++k) {
      See({one_m, other_m});
      tracklets_.Claim(0, TrackId(1));
      tracklets_.Claim(1, TrackId(2));
    }
  }

  static constexpr int kView = 1;  // of four, looks perpendicular to x
  CameraRig cameras_ = testing::RingOfCameras(4);
  ViewTracklets tracklets_{Coco17().association_joints()};
  std::vector<Observation> observations_;
  double frame_s_ = 0.04;
  int frame_ = 0;
};

TEST_F(TrackletsTest, OwnerKeepsContinuedTracklet) {
  SeeTwo(-0.8, 0.8);
  See({0.8, -0.8});  // order in the file is irrelevant
  EXPECT_EQ(tracklets_.OwnerOf(0), TrackId(2));
  EXPECT_EQ(tracklets_.OwnerOf(1), TrackId(1));
}

TEST_F(TrackletsTest, OwnershipSurvivesShortDetectionGaps) {
  SeeTwo(-0.8, 0.8);
  for (int k = 0; k < 4; ++k) See({0.8});
  See({-0.8, 0.8});  // the first person was not seen for 0.2 s
  EXPECT_EQ(tracklets_.OwnerOf(0), TrackId(1));
  for (int k = 0; k < 5; ++k) See({0.8});
  See({-0.8, 0.8});  // for 0.24 s
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
  EXPECT_EQ(tracklets_.OwnerOf(1), TrackId(2));
}

TEST_F(TrackletsTest, OwnershipSurvivesALowRate) {
  frame_s_ = 0.25;
  SeeTwo(-0.8, 0.8);
  See({-0.8, 0.8});
  EXPECT_EQ(tracklets_.OwnerOf(0), TrackId(1));
  EXPECT_EQ(tracklets_.OwnerOf(1), TrackId(2));
  See({0.8});
  See({-0.8, 0.8});  // not seen for 0.5 s, more than 1.5 intervals
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
}

TEST_F(TrackletsTest, OwnershipRequiresMinimumDuration) {
  // 0.16 s, less than the 0.2 s needed for ownership.
  for (int k = 0; k < 5; ++k) {
    See({0.0});
    tracklets_.Claim(0, TrackId(1));
  }
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
  See({0.0});
  tracklets_.Claim(0, TrackId(1));
  EXPECT_EQ(tracklets_.OwnerOf(0), TrackId(1));
  // A second track that is matched with the tracklet must wait 0.2 s, too.
  tracklets_.Claim(0, TrackId(2));
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
}

// One of two people side by side is not detected. The detection of the other
// lies between their last positions, so it is ambiguous.
TEST_F(TrackletsTest, AmbiguousDetectionsHaveNoOwner) {
  SeeTwo(-0.05, 0.05);
  See({0.0});
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
  for (int k = 0; k < 3; ++k) See({0.0});
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
}

TEST_F(TrackletsTest, ImplausibleJumpsEndOwnership) {
  SeeTwo(-0.8, 0.8);
  See({1.6, -0.8});  // 0.8 m in 0.04 s
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
  EXPECT_EQ(tracklets_.OwnerOf(1), TrackId(1));
}

TEST_F(TrackletsTest, OwnershipExpiresWithoutClaims) {
  SeeTwo(-0.8, 0.8);  // claims until 0.36 s; ownership lapses 2 s later
  while (frame_ * frame_s_ < 2.3) See({-0.8, 0.8});
  EXPECT_EQ(tracklets_.OwnerOf(0), TrackId(1));
  while (frame_ * frame_s_ < 2.5) See({-0.8, 0.8});
  EXPECT_EQ(tracklets_.OwnerOf(0), std::nullopt);
}

}  // namespace
}  // namespace kinegraph
