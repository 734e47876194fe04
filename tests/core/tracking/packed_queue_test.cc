#include "core/tracking/packed_queue.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

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
    view.verdicts.assign(17, FilterVerdict::kKept);  // not kept
    for (Keypoint& joint : view.joints) {
      joint.found = random->Chance(0.8);
      if (!joint.found) continue;  // nothing else has a meaning
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

template <typename Vector>
bool SameBits(const Vector& a, const Vector& b) {
  return std::memcmp(a.data(), b.data(), sizeof(Vector)) == 0;
}

void ExpectSame(const EstimatorFrame& a, const EstimatorFrame& b) {
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.has_initial, b.has_initial);
  EXPECT_EQ(a.triangulated, b.triangulated);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (size_t v = 0; v < a.views.size(); ++v) {
    EXPECT_EQ(a.views[v].view_idx, b.views[v].view_idx);
    EXPECT_EQ(a.views[v].capture_time, b.views[v].capture_time);
    EXPECT_EQ(a.views[v].detection_idx, b.views[v].detection_idx);
    ASSERT_EQ(a.views[v].joints.size(), b.views[v].joints.size());
    for (size_t j = 0; j < a.views[v].joints.size(); ++j) {
      const Keypoint& one = a.views[v].joints[j];
      const Keypoint& other = b.views[v].joints[j];
      EXPECT_EQ(one.found, other.found);
      EXPECT_TRUE(SameBits(one.px, other.px));
      EXPECT_EQ(one.confidence, other.confidence);
    }
  }
  ASSERT_EQ(a.initial.size(), b.initial.size());
  for (size_t j = 0; j < a.initial.size(); ++j) {
    EXPECT_EQ(a.initial[j].status, b.initial[j].status);
    EXPECT_TRUE(SameBits(a.initial[j].position_m, b.initial[j].position_m));
  }
}

// More than a block of 256 KB holds, also while the queue is read.
TEST(PackedQueue, GivesFramesBackBitByBitInOrder) {
  for (const size_t waiting : {size_t{1}, size_t{7}, size_t{500}}) {
    Random random(5);
    Random again(5);
    PackedFrames frames;
    int64_t popped = 0;
    for (int64_t k = 0; k < 1000; ++k) {
      frames.Push(SomeFrame(k, &random));
      if (frames.size() < waiting) continue;
      ExpectSame(frames.Pop(), SomeFrame(popped++, &again));
    }
    while (!frames.empty()) {
      ExpectSame(frames.Pop(), SomeFrame(popped++, &again));
    }
    EXPECT_EQ(popped, 1000);
  }
}

TEST(PackedQueue, KeepsAllOfAPoseButItsIdentity) {
  PersonPose pose;
  pose.id = TrackId(7);
  pose.score = 0.1 + 0.2;  // no decimal fraction
  pose.joints.resize(3);
  pose.joints[1] = {{1.0, 2.0, 3.0}, JointStatus::kObserved};
  pose.inlier_views = {0, 5, 300};
  Eigen::Matrix3d symmetric;
  symmetric << 1.1, 0.2, 0.3, 0.2, 2.2, 0.4, 0.3, 0.4, 3.3;
  Eigen::Matrix3d rounded = symmetric;
  rounded(2, 1) += 1e-16;  // by one bit
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
