#include "core/tracking/second_pass.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.h"
#include "solvers/filters/causal_gaussian.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

constexpr double kFrameRate = 25.0;

class SecondPassTest : public ::testing::Test {
 protected:
  SecondPassTest() {
    people_ = {testing::StandingPerson(-0.8, 0.0),
               testing::StandingPerson(0.9, 0.4)};
  }

  SecondPass Make() const {
    CausalGaussianOptions gaussian;
    gaussian.smooth = false;
    return SecondPass({cameras_, Coco17(), kFrameRate, false}, Coco17(),
                      TrackerOptions(), [gaussian](const SceneModel& scene) {
                        return MakeCausalGaussian(scene, gaussian);
                      });
  }

  DetectionFrame See(int frame) const {
    DetectionFrame seen;
    seen.frame = frame;
    seen.time = FrameClock(kFrameRate).TimeOf(frame);
    for (const Camera& camera : cameras_) {
      ViewDetections& view = seen.views.emplace_back();
      for (const Pose3d& person : people_) {
        view.detections.push_back(testing::Project(person, camera));
      }
    }
    return seen;
  }

  // What a first pass might have written: each joint some centimetres off.
  TrackFrame FirstPass(int frame) {
    TrackFrame written;
    written.frame = frame;
    for (size_t p = 0; p < people_.size(); ++p) {
      PersonPose& person = written.people.emplace_back();
      person.id = TrackId(static_cast<int64_t>(10 + p));
      person.joints = people_[p];
      for (Joint3d& joint : person.joints) {
        joint.position_m +=
            0.03 * Eigen::Vector3d(random_.Normal(), random_.Normal(),
                                   random_.Normal());
      }
    }
    return written;
  }

  CameraRig cameras_ = testing::RingOfCameras(4);
  std::vector<Pose3d> people_;
  Random random_{3};
};

TEST_F(SecondPassTest, EstimatesAnewAndKeepsIdentities) {
  SecondPass pass = Make();
  for (int f = 5; f < 9; ++f) pass.Process(See(f), FirstPass(f));
  const std::vector<TrackFrame> frames = pass.Finish(2);
  ASSERT_EQ(frames.size(), 4u);
  for (size_t f = 0; f < frames.size(); ++f) {
    EXPECT_EQ(frames[f].frame, 5 + static_cast<int64_t>(f));
    ASSERT_EQ(frames[f].people.size(), 2u);
    for (size_t p = 0; p < 2; ++p) {
      EXPECT_EQ(frames[f].people[p].id, TrackId(static_cast<int64_t>(10 + p)));
      for (int j = 0; j < 17; ++j) {
        EXPECT_LT((frames[f].people[p].joints[j].position_m -
                   people_[p][j].position_m)
                      .norm(),
                  1e-9)
            << "triangulated anew";
      }
    }
  }
}

TEST_F(SecondPassTest, APersonWhomNobodySeesKeepsTheirPose) {
  SecondPass pass = Make();
  DetectionFrame blind = See(5);
  for (ViewDetections& view : blind.views) view.detections.clear();
  const TrackFrame first = FirstPass(5);
  pass.Process(blind, first);
  const std::vector<TrackFrame> frames = pass.Finish(1);
  ASSERT_EQ(frames[0].people.size(), 2u);
  EXPECT_EQ(frames[0].people[0].joints[3].position_m,
            first.people[0].joints[3].position_m);
}

TEST_F(SecondPassTest, FramesWithoutPeopleAreWrittenEmpty) {
  SecondPass pass = Make();
  TrackFrame nobody;
  nobody.frame = 5;
  pass.Process(See(5), nobody);
  const std::vector<TrackFrame> frames = pass.Finish(1);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_TRUE(frames[0].people.empty());
}

}  // namespace
}  // namespace kinegraph
