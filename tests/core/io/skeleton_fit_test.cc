#include "core/io/skeleton_fit.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/detection_source.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

std::vector<Detection> PeopleIn(const Skeleton& skeleton) {
  SceneOptions options;
  options.seed = 3;
  options.people = 2;
  options.duration_s = 1.0;
  const DetectionSequence seen =
      Observe(MakeScene(options, skeleton), NoiseOptions(), nullptr);
  std::vector<Detection> people;
  for (const DetectionFrame& frame : seen.frames) {
    for (const ViewDetections& view : frame.views) {
      people.insert(people.end(), view.detections.begin(),
                    view.detections.end());
    }
  }
  return people;
}

// BODY_25B itself is told by real files below; of synthetic bodies the two
// layouts have shares that are too alike.
TEST(SkeletonFitTest, Body25StaysBody25) {
  SkeletonFit fit({&Body25(), &Body25B()});
  for (const Detection& person : PeopleIn(Body25())) fit.See(person);
  ASSERT_GT(fit.people(), 50u);
  EXPECT_EQ(fit.Best(), 0u);
  EXPECT_LT(fit.MedianShare(0), SkeletonFit::kImplausible);
}

// The right layout of every detector looks plausible, so that a warning about
// the skeleton means something.
TEST(SkeletonFitTest, NoBuiltInLayoutLooksImplausible) {
  for (const Skeleton* truth : {&Coco17(), &Coco18(), &Body25(), &Body25B(),
                                &Halpe26(), &MediaPipe33(), &WholeBody133()}) {
    SkeletonFit fit({truth});
    for (const Detection& person : PeopleIn(*truth)) fit.See(person);
    ASSERT_GT(fit.people(), 50u);
    EXPECT_LT(fit.MedianShare(0), SkeletonFit::kImplausible) << truth->name();
  }
}

TEST(SkeletonFitTest, TooFewPeopleLeaveTheFirstCandidate) {
  SkeletonFit fit({&Body25(), &Body25B()});
  const std::vector<Detection> people = PeopleIn(Body25B());
  for (size_t i = 0; i + 1 < SkeletonFit::kEnoughPeople; ++i) {
    fit.See(people[i]);
  }
  EXPECT_EQ(fit.Best(), 0u);
}

TEST(SkeletonFitTest, RecognisesBody25InRealFiles) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/detections/openpose");
  EXPECT_TRUE(OpenDetections(path)->header().skeleton == Body25());
}

TEST(SkeletonFitTest, RecognisesBody25BInRealFiles) {
  KINEGRAPH_DATA_OR_SKIP(path, "pose2sim");
  for (const std::string trial : {"single", "multi"}) {
    const auto source = OpenDetections(path + "/" + trial + "/pose");
    EXPECT_TRUE(source->header().skeleton == Body25B()) << trial;
  }
}

}  // namespace
}  // namespace kinegraph
