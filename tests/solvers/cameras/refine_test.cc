#include "solvers/cameras/refine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kinegraph {
namespace {

// Four views; the clocks of all but the first are free, with a standard
// deviation of 1 ms.
BundleResult FitOf(const std::vector<double>& offsets_s) {
  BundleResult fit;
  fit.usable = true;
  fit.changes.assign(offsets_s.size(), CameraChange::Zero());
  fit.places.assign(offsets_s.size(), {kOffsetAt});
  fit.places.front().clear();
  for (size_t v = 0; v < offsets_s.size(); ++v) {
    fit.changes[v][kOffsetAt] = offsets_s[v];
  }
  const auto free = static_cast<Eigen::Index>(offsets_s.size()) - 1;
  fit.covariance = 1e-6 * Eigen::MatrixXd::Identity(free, free);
  return fit;
}

constexpr double kFrameS = 0.04;  // 0.15 frames are 6 ms
constexpr double kRecordingS = 10.0;

TEST(LateClocks, ExceedFrameFractionAndSigmasButNotHalfASegment) {
  const struct {
    double offset_s;
    double frame_s;
    bool is_late;
  } kCases[] = {{0.0059, kFrameS, false},
                {0.0061, kFrameS, true},
                // With frames of 10 ms, 3.9 ms are more than 0.15 of a frame
                // but within four sigmas.
                {0.0039, 0.01, false},
                {0.0041, 0.01, true},
                // Offsets of more than half of a segment's length are
                // attributed to noise.
                {0.101, kFrameS, false}};
  for (const auto& one : kCases) {
    EXPECT_EQ(AnyIsLate(FitOf({0.0, 0.0, one.offset_s, 0.0}), one.frame_s,
                        kRecordingS),
              one.is_late)
        << one.offset_s;
  }
}

TEST(LateClocks, FirstViewIsLateIfAllOthersAgree) {
  const BundleResult fit = FitOf({0.0, 0.02, 0.02, 0.02});
  EXPECT_TRUE(IsLate(fit, 0, kOffsetAt, kFrameS, kRecordingS));
  EXPECT_FALSE(IsLate(fit, 1, kOffsetAt, kFrameS, kRecordingS));
}

TEST(LateClocks, DriftThatWasNotEstimatedIsIgnored) {
  BundleResult fit = FitOf({0.0, 0.0, 0.0, 0.0});
  fit.changes[2][kDriftAt] = 1e-3;
  EXPECT_FALSE(AnyIsLate(fit, kFrameS, kRecordingS));
}

// A joint in two views, five frames of each.
MotionSegment SegmentAt(double middle_s, int joint) {
  MotionSegment segment;
  segment.joint = joint;
  segment.middle_s = middle_s;
  for (int view = 0; view < 2; ++view) {
    for (int k = 0; k < 5; ++k) {
      segment.measurements.emplace_back();
      segment.measurements.back().view_idx = view;
    }
  }
  return segment;
}

TEST(LastingErrors, JointCountsOncePerViewAndSecond) {
  SceneSegments segments;
  // Two segments of joint 0 in the first second and one in the next, and one of
  // joint 1: 40 samples, of which 6 are independent.
  segments.segments = {SegmentAt(-1.0, 0), SegmentAt(-0.8, 0),
                       SegmentAt(-0.5, 1), SegmentAt(0.1, 0)};
  BundleOptions options;
  const BundleOptions lasting = WithLastingErrors(options, segments);
  EXPECT_DOUBLE_EQ(lasting.samples_at_once, 40.0 / 6.0);
}

}  // namespace
}  // namespace kinegraph
