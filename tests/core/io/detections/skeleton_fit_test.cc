#include "core/io/detections/skeleton_fit.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"

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

// The fit of candidate layouts to people with the joints of `truth`.
SkeletonFit FitTo(const Skeleton& truth,
                  std::vector<const Skeleton*> candidates) {
  SkeletonFit fit(std::move(candidates));
  for (const Detection& person : PeopleIn(truth)) fit.See(person);
  EXPECT_GT(fit.people(), 50u);
  return fit;
}

TEST(SkeletonFitTest, DistinguishesBody25FromBody25B) {
  // The bones of these people have about the same lengths in both layouts
  // (within 15 %), but left and right are equal only in the correct layout.
  const SkeletonFit fit = FitTo(Body25B(), {&Body25(), &Body25B()});
  EXPECT_EQ(fit.Best(), 1u);
  EXPECT_LT(fit.SideDifference(1), 0.1);
  EXPECT_GT(fit.SideDifference(0), 0.25);
}

TEST(SkeletonFitTest, SideDifferenceIsMeanOverLimbs) {
  const Skeleton legs("legs",
                      {"l_hip", "l_knee", "l_ankle", "r_hip", "r_knee",
                       "r_ankle", "neck", "nose"},
                      {});
  Detection person;
  person.joints.resize(8);
  for (size_t j = 0; j < 8; ++j) {
    person.joints[j].px = {10.0 * static_cast<double>(j), 0.0};
    person.joints[j].found = true;
  }
  // Thighs of 3 and 4 px differ by 1 / 7 of their sum, shanks of 5 px do not.
  person.joints[1].px = {0.0, 3.0};
  person.joints[2].px = {0.0, 8.0};
  person.joints[4].px = {30.0, 4.0};
  person.joints[5].px = {30.0, 9.0};
  SkeletonFit fit({&legs});
  fit.See(person);
  EXPECT_DOUBLE_EQ(fit.SideDifference(0), 0.5 / 7.0);
}

TEST(SkeletonFitTest, Body25IsKept) {
  const SkeletonFit fit = FitTo(Body25(), {&Body25(), &Body25B()});
  EXPECT_EQ(fit.Best(), 0u);
  EXPECT_FALSE(fit.Implausible(0));
}

// The correct layout of every detector is plausible, so there are no false
// warnings.
TEST(SkeletonFitTest, NoBuiltInLayoutLooksImplausible) {
  for (const Skeleton* truth : {&Coco17(), &Coco18(), &Body25(), &Body25B(),
                                &Halpe26(), &MediaPipe33(), &WholeBody133()}) {
    EXPECT_FALSE(FitTo(*truth, {truth}).Implausible(0)) << truth->name();
  }
}

// The box around a body without knees and ankles is small, so that bones look
// long; people of whom no ankle is seen do not count.
TEST(SkeletonFitTest, HalfABodyIsPlausible) {
  SkeletonFit fit({&Coco17()});
  for (Detection person : PeopleIn(Coco17())) {
    for (const char* name : {"l_knee", "r_knee", "l_ankle", "r_ankle"}) {
      person.joints[static_cast<size_t>(Coco17().IndexOf(name))].found = false;
    }
    fit.See(person);
  }
  EXPECT_GT(fit.MedianShare(0), SkeletonFit::kImplausible);
  EXPECT_FALSE(fit.Implausible(0));
}

TEST(SkeletonFitTest, ShuffledJointsAreImplausible) {
  SkeletonFit fit({&Coco17()});
  for (Detection person : PeopleIn(Coco17())) {
    // Joint j gets the position of joint 7 j mod 17: the ends of a bone come
    // from different parts of the body.
    const std::vector<Keypoint> joints = person.joints;
    for (size_t j = 0; j < joints.size(); ++j) {
      person.joints[j] = joints[7 * j % joints.size()];
    }
    fit.See(person);
  }
  EXPECT_TRUE(fit.Implausible(0));
}

TEST(SkeletonFitTest, FirstCandidateIsKeptForTooFewPeople) {
  SkeletonFit fit({&Body25(), &Body25B()});
  const std::vector<Detection> people = PeopleIn(Body25B());
  for (size_t i = 0; i + 1 < SkeletonFit::kEnoughPeople; ++i) {
    fit.See(people[i]);
  }
  EXPECT_EQ(fit.Best(), 0u);
}

}  // namespace
}  // namespace kinegraph
