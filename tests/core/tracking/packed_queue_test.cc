#include "core/tracking/packed_queue.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/base/random.h"

namespace kinegraph {
namespace {

EstimatorFrame SomeFrame(int64_t number, Random* random) {
  EstimatorFrame frame;
  frame.frame = number;
  frame.time = 33'333'333 * number;
  frame.views.resize(static_cast<size_t>(random->Index(6)));
  for (FreshView& view : frame.views) {
    view.view_idx = static_cast<int>(random->Index(9));
    view.capture_time = frame.time - 500;
    view.detection_idx = view.view_idx + 3;
    view.joints.resize(17);
    view.verdicts.assign(17, FilterVerdict::kKept);  // not stored
    for (Keypoint& joint : view.joints) {
      joint.found = random->Chance(0.8);
      if (!joint.found) continue;  // the other fields are meaningless
      joint.px = {random->Uniform(-10.0, 2000.0),
                  std::numeric_limits<double>::quiet_NaN()};
      joint.confidence = random->Uniform(0.0, 1.2);
    }
  }
  frame.has_initial = random->Chance(0.9);
  frame.initial.resize(frame.has_initial ? 17 : 0);
  for (Joint3d& joint : frame.initial) {
    joint.status = static_cast<JointStatus>(random->Index(3));
    if (joint.present()) joint.position_m = {random->Normal(), 1.0 / 3.0, -0.0};
    frame.triangulated.push_back(random->Chance(0.5) ? 1 : 0);
  }
  return frame;
}

// All preserved data as bytes.
std::string BitsOf(const EstimatorFrame& frame) {
  std::string bits;
  const auto add = [&bits](const auto& value) {
    bits.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  add(frame.frame);
  add(frame.time);
  for (const FreshView& view : frame.views) {
    add(view.view_idx);
    add(view.capture_time);
    add(view.detection_idx);
    for (const Keypoint& joint : view.joints) {
      add(joint.found);
      add(joint.px.x());
      add(joint.px.y());
      add(joint.confidence);
    }
  }
  add(frame.has_initial);
  for (const Joint3d& joint : frame.initial) {
    add(joint.status);
    for (const double coordinate : joint.position_m) add(coordinate);
  }
  for (const char triangulated : frame.triangulated) add(triangulated);
  return bits;
}

// Pushes more than a block of 256 KB holds, also while the queue is read.
TEST(PackedQueue, ReturnsFramesBitIdenticalAndInOrder) {
  for (const size_t waiting : {size_t{1}, size_t{7}, size_t{500}}) {
    Random random(5);
    Random again(5);
    PackedFrames frames;
    int64_t popped = 0;
    for (int64_t k = 0; k < 1000; ++k) {
      frames.Push(SomeFrame(k, &random));
      if (frames.size() < waiting) continue;
      EXPECT_EQ(BitsOf(frames.Pop()), BitsOf(SomeFrame(popped++, &again)));
    }
    while (!frames.empty()) {
      EXPECT_EQ(BitsOf(frames.Pop()), BitsOf(SomeFrame(popped++, &again)));
    }
    EXPECT_EQ(popped, 1000);
  }
}

TEST(PackedQueue, KeepsAllOfAPoseExceptTheIdentity) {
  PersonPose pose;
  pose.id = TrackId(7);
  pose.score = 0.1 + 0.2;  // not the double nearest to 0.3
  pose.joints.resize(3);
  pose.joints[1] = {{1.0, 2.0, 3.0}, JointStatus::kObserved};
  pose.inlier_views = {0, 5, 300};
  Eigen::Matrix3d symmetric;
  symmetric << 1.1, 0.2, 0.3, 0.2, 2.2, 0.4, 0.3, 0.4, 3.3;
  Eigen::Matrix3d rounded = symmetric;
  rounded(2, 1) += 1e-16;  // in the last bits
  pose.covariances = {symmetric, std::nullopt, rounded};
  pose.matches = {{2, 11, {}}, {0, 4, {0.3, std::nullopt, 1.0}}};
  PackedPoses packed;
  packed.Push(pose);
  packed.Push(PersonPose());
  const PersonPose got = packed.Pop();
  EXPECT_EQ(got.id, TrackId());
  EXPECT_EQ(got.score, pose.score);
  ASSERT_EQ(got.joints.size(), 3u);
  EXPECT_EQ(got.joints[1].position_m, pose.joints[1].position_m);
  EXPECT_EQ(got.joints[1].status, JointStatus::kObserved);
  EXPECT_EQ(got.inlier_views, pose.inlier_views);
  EXPECT_EQ(got.covariances, pose.covariances);
  ASSERT_EQ(got.matches.size(), 2u);
  EXPECT_EQ(got.matches[1].view_idx, 0);
  EXPECT_EQ(got.matches[1].detection_idx, 4);
  EXPECT_EQ(got.matches[1].weights, pose.matches[1].weights);
  EXPECT_TRUE(packed.Pop().joints.empty());
  EXPECT_TRUE(packed.empty());
}

}  // namespace
}  // namespace kinegraph
