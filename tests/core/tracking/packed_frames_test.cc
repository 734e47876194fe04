#include "core/tracking/packed_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/random.h"

namespace kinegraph {
namespace {

constexpr int kJoints = 17;  // no multiple of eight

Keypoint SomeKeypoint(Random* random) {
  Keypoint joint;
  joint.found = random->Uniform(0.0, 1.0) < 0.8;
  joint.px = {random->Uniform(-10.0, 2000.0), random->Uniform(0.0, 1000.0)};
  joint.confidence = random->Uniform(0.0, 1.2);
  return joint;
}

EstimatorFrame SomeFrame(int64_t number, Random* random) {
  EstimatorFrame frame;
  frame.frame = number;
  frame.time = 33'333'333 * number;
  const int views = static_cast<int>(random->Uniform(0.0, 6.0));
  for (int v = 0; v < views; ++v) {
    FreshView& view = frame.views.emplace_back();
    view.view_idx = 2 * v;
    view.capture_time = frame.time + 1000 * v - 500;
    view.detection_idx = v + 3;
    for (int j = 0; j < kJoints; ++j) {
      view.joints.push_back(SomeKeypoint(random));
      view.verdicts.push_back(FilterVerdict::kKept);
    }
  }
  frame.has_initial = random->Uniform(0.0, 1.0) < 0.9;
  for (int j = 0; j < kJoints && frame.has_initial; ++j) {
    Joint3d joint;
    joint.status = static_cast<JointStatus>(random->Uniform(0.0, 2.999));
    joint.position_m = {random->Uniform(-3.0, 3.0), 1.0 / 3.0, -0.0};
    frame.initial.push_back(joint);
    frame.triangulated.push_back(random->Uniform(0.0, 1.0) < 0.5 ? 1 : 0);
  }
  return frame;
}

template <typename Vector>
bool SameBits(const Vector& a, const Vector& b) {
  return std::memcmp(a.data(), b.data(), sizeof(Vector)) == 0;
}

void ExpectSame(const FreshView& a, const FreshView& b) {
  EXPECT_EQ(a.view_idx, b.view_idx);
  EXPECT_EQ(a.capture_time, b.capture_time);
  EXPECT_EQ(a.detection_idx, b.detection_idx);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (size_t j = 0; j < a.joints.size(); ++j) {
    ASSERT_EQ(a.joints[j].found, b.joints[j].found);
    if (!b.joints[j].found) continue;  // nothing else has a meaning
    EXPECT_TRUE(SameBits(a.joints[j].px, b.joints[j].px));
    EXPECT_EQ(a.joints[j].confidence, b.joints[j].confidence);
  }
}

void ExpectSame(const EstimatorFrame& a, const EstimatorFrame& b) {
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.time, b.time);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (size_t v = 0; v < a.views.size(); ++v) {
    ExpectSame(a.views[v], b.views[v]);
  }
  EXPECT_EQ(a.has_initial, b.has_initial);
  EXPECT_EQ(a.triangulated, b.triangulated);
  ASSERT_EQ(a.initial.size(), b.initial.size());
  for (size_t j = 0; j < a.initial.size(); ++j) {
    ASSERT_EQ(a.initial[j].status, b.initial[j].status);
    if (!b.initial[j].present()) continue;
    EXPECT_TRUE(SameBits(a.initial[j].position_m, b.initial[j].position_m));
  }
}

// More than a block of 256 KB holds.
TEST(PackedFrames, GiveBackEveryBitInOrder) {
  Random random(5);
  std::vector<EstimatorFrame> put;
  PackedFrames frames;
  for (int k = 0; k < 500; ++k) {
    put.push_back(SomeFrame(k, &random));
    frames.Push(put.back());
  }
  ASSERT_EQ(frames.size(), 500u);
  EstimatorFrame got = SomeFrame(1000, &random);  // nothing of it may stay
  for (const EstimatorFrame& frame : put) {
    frames.Pop(&got);
    ExpectSame(got, frame);
  }
  EXPECT_TRUE(frames.empty());
}

TEST(PackedFrames, GoOnAfterTheyWereRead) {
  Random random(6);
  PackedFrames frames;
  EstimatorFrame got;
  for (int k = 0; k < 40; ++k) {
    const EstimatorFrame one = SomeFrame(k, &random);
    const EstimatorFrame two = SomeFrame(k + 1, &random);
    frames.Push(one);
    frames.Pop(&got);
    ExpectSame(got, one);
    frames.Push(one);
    frames.Push(two);
    frames.Pop(&got);
    frames.Pop(&got);
    ExpectSame(got, two);
    ASSERT_TRUE(frames.empty());
  }
}

TEST(PackedFrames, KeepWhatIsNoNumber) {
  EstimatorFrame frame;
  frame.views.resize(1);
  Keypoint joint;
  joint.found = true;
  joint.px = {std::numeric_limits<double>::quiet_NaN(),
              std::numeric_limits<double>::infinity()};
  joint.confidence = std::numeric_limits<double>::quiet_NaN();
  frame.views[0].joints = {joint};
  PackedFrames frames;
  frames.Push(frame);
  EstimatorFrame got;
  frames.Pop(&got);
  ASSERT_EQ(got.views.size(), 1u);
  ASSERT_EQ(got.views[0].joints.size(), 1u);
  EXPECT_TRUE(SameBits(got.views[0].joints[0].px, joint.px));
  EXPECT_TRUE(std::isnan(got.views[0].joints[0].confidence));
}

}  // namespace
}  // namespace kinegraph
