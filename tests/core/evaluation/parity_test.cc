#include "core/evaluation/parity.h"

#include <gtest/gtest.h>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

TEST(ParityTest, AResultEqualsItself) {
  const TrackSequence tracks = Standing("0@0 1@3");
  const ParityResult result = EvaluateParity(tracks, tracks);
  EXPECT_EQ(result.near.count, 28);
  EXPECT_EQ(result.very_near.count, 28);
  EXPECT_EQ(result.near.total, 28);
  EXPECT_EQ(result.worst.distance_m, 0.0);
  EXPECT_TRUE(result.identities_one_to_one);
  EXPECT_EQ(result.paired_person_frames, 2);
}

TEST(ParityTest, JointsAreCountedByDistance) {
  const TrackSequence reference =
      Tracks({Frame(4, {Person(9, StandingTum14())})});
  Pose3d pose = StandingTum14();
  pose[3].position_m.y() += 5e-4;
  pose[7].position_m.y() += 0.5;
  const ParityResult result =
      EvaluateParity(reference, Tracks({Frame(4, {Person(2, pose)})}));
  EXPECT_EQ(result.near.count, 13);
  EXPECT_EQ(result.very_near.count, 12);
  EXPECT_EQ(result.worst.distance_m, 0.5);
  EXPECT_EQ(result.worst.joint, 7);
  EXPECT_EQ(result.worst.frame, 4);
  EXPECT_EQ(result.worst.id, TrackId(9));
}

TEST(ParityTest, JointsAndPeopleOfOneResultOnlyEnterTheTotal) {
  TrackSequence tracks = Standing("0@0 | | 0@0");
  tracks.frames.erase(tracks.frames.begin() + 1);
  tracks.frames[0].people[0].joints[0] = Joint3d{};
  const ParityResult result = EvaluateParity(Standing("0@0 1@3 | 0@0"), tracks);
  EXPECT_EQ(result.near.count, 13);
  EXPECT_EQ(result.near.total, 4 * 14);
  EXPECT_EQ(result.joints_missing, 1 + 14 + 14);
  EXPECT_EQ(result.joints_extra, 14);
  EXPECT_EQ(result.reference_person_frames, 3);
  EXPECT_EQ(result.person_frames, 2);
  EXPECT_EQ(result.paired_person_frames, 1);
}

TEST(ParityTest, IdentitiesMustMapOneToOne) {
  const TrackSequence reference = Standing("0@0 | 0@0");
  const TrackSequence broken = Standing("5@0 | 6@0");
  EXPECT_TRUE(
      EvaluateParity(reference, Standing("5@0 | 5@0")).identities_one_to_one);
  EXPECT_FALSE(EvaluateParity(reference, broken).identities_one_to_one);
  EXPECT_FALSE(EvaluateParity(broken, reference).identities_one_to_one);
  EXPECT_EQ(EvaluateParity(reference, broken).identities, 2);
}

TEST(ParityTest, ComparesOnlyTheGivenFrames) {
  const TrackSequence tracks = Alone(StandingTum14(), 0, 2);
  ParityOptions options;
  options.frames = {{1, 2}};
  EXPECT_EQ(EvaluateParity(tracks, tracks, options).near.total, 14);
  const ParityResult nothing = EvaluateParity(Tracks({}), Tracks({}));
  EXPECT_EQ(nothing.near.total, 0);
  EXPECT_TRUE(nothing.identities_one_to_one);
}

}  // namespace
}  // namespace kinegraph::testing
