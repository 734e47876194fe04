// Triangulation of several joints in SIMD lanes against one joint at a time.
#include "core/geometry/dlt_lanes.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/instruction_set.h"
#include "core/base/pack.h"
#include "core/base/random.h"
#include "core/geometry/epipolar.h"
#include "core/geometry/triangulation.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

constexpr int kJoints = 37;

struct Views {
  CameraRig cameras;
  std::vector<double> x_px, y_px, present;
  std::vector<LaneView> lanes;
};

// Noisy pixels of random points; a third of them missing. The last view is an
// old one with little weight.
Views RandomViews(int view_count, Random* random) {
  Views views;
  views.cameras = testing::RingOfCameras(view_count);
  const int lanes = PaddedLanes(kJoints);
  views.x_px.assign(view_count * lanes, 0.0);
  views.y_px = views.present = views.x_px;
  for (int j = 0; j < kJoints; ++j) {
    const Eigen::Vector3d point(random->Normal(), random->Normal(),
                                1.0 + 0.3 * random->Normal());
    for (int v = 0; v < view_count; ++v) {
      const auto px = views.cameras[v].Project(point);
      if (!px.has_value() || random->Uniform(0.0, 1.0) < 0.33) continue;
      views.x_px[v * lanes + j] = px->x() + 3.0 * random->Normal();
      views.y_px[v * lanes + j] = px->y() + 3.0 * random->Normal();
      views.present[v * lanes + j] = 1.0;
    }
  }
  for (int v = 0; v < view_count; ++v) {
    const double weight = v + 1 == view_count ? 3e-4 : 1.0;
    views.lanes.push_back({views.cameras[v].P().data(),
                           views.cameras[v].centre().data(),
                           &views.x_px[v * lanes], &views.y_px[v * lanes],
                           &views.present[v * lanes], weight});
  }
  return views;
}

struct Points {
  std::vector<double> x = std::vector<double>(PaddedLanes(kJoints));
  std::vector<double> y = x, z = x, found = x;
};

Points InLanes(const Views& views, InstructionSet set) {
  UseInstructionSet(set);
  Points points;
  TriangulateLanes(
      views.lanes.data(), static_cast<int>(views.lanes.size()),
      PaddedLanes(kJoints), TriangulationOptions(),
      {points.x.data(), points.y.data(), points.z.data(), points.found.data()});
  UseInstructionSet(InstructionSet::kAvx512);
  return points;
}

TriangulationResult Alone(const Views& views, int joint) {
  std::vector<PointMeasurement> measurements;
  for (size_t v = 0; v < views.lanes.size(); ++v) {
    if (views.lanes[v].present[joint] == 0.0) continue;
    measurements.push_back(
        {&views.cameras[v],
         {views.lanes[v].x_px[joint], views.lanes[v].y_px[joint]},
         views.lanes[v].weight});
  }
  return TriangulateDlt(measurements);
}

class DltLanes : public ::testing::TestWithParam<InstructionSet> {};
INSTANTIATE_TEST_SUITE_P(Sets, DltLanes,
                         ::testing::Values(InstructionSet::kBaseline,
                                           InstructionSet::kAvx2,
                                           InstructionSet::kAvx512));

// Points are about 5 m away, pixels about 1e3. A joint measured by all views
// gets the same bits as from TriangulateDlt. If views lack it, rows of zeros
// change the rounding of the reflections: 1e-9 m is far above such rounding and
// far below any relevant error.
void ExpectSame(const Points& points, int joint, bool exact,
                const TriangulationResult& alone) {
  if (exact) {
    EXPECT_EQ(points.x[joint], alone.point_m.x());
    EXPECT_EQ(points.y[joint], alone.point_m.y());
    EXPECT_EQ(points.z[joint], alone.point_m.z());
  }
  const Eigen::Vector3d point(points.x[joint], points.y[joint],
                              points.z[joint]);
  EXPECT_LT((point - alone.point_m).norm(), 1e-9);
}

TEST_P(DltLanes, EqualTriangulateDlt) {
  Random random(5);
  int settled = 0;
  int exact = 0;
  int found = 0;
  for (int recording = 0; recording < 20; ++recording) {
    // 31 views have more rows than are kept, so they are reduced in portions.
    const Views views = RandomViews(recording == 0 ? 31 : 5, &random);
    const Points points = InLanes(views, GetParam());
    for (int j = 0; j < kJoints; ++j) {
      if (points.found[j] < 0.0) continue;  // left to TriangulateDlt
      ++settled;
      const TriangulationResult alone = Alone(views, j);
      ASSERT_EQ(points.found[j] > 0.0, alone.ok())
          << static_cast<int>(alone.status);
      if (!alone.ok()) continue;
      ++found;
      const bool complete =
          std::all_of(views.lanes.begin(), views.lanes.end(),
                      [&](const LaneView& v) { return v.present[j] != 0.0; });
      exact += complete;
      ExpectSame(points, j, complete, alone);
    }
  }
  EXPECT_GT(settled, 19 * kJoints);  // of 20: nearly all converge
  EXPECT_GT(found, 10 * kJoints);
  EXPECT_GT(exact, kJoints);
}

TEST_P(DltLanes, AreBitIdenticalOnEveryInstructionSet) {
  Random random(9);
  const Views views = RandomViews(5, &random);
  const Points points = InLanes(views, GetParam());
  const Points baseline = InLanes(views, InstructionSet::kBaseline);
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_EQ(points.found[j], baseline.found[j]);
    if (points.found[j] <= 0.0) continue;
    EXPECT_EQ(points.x[j], baseline.x[j]);
    EXPECT_EQ(points.y[j], baseline.y[j]);
    EXPECT_EQ(points.z[j], baseline.z[j]);
  }
}

TEST_P(DltLanes, NaNPixelsAreLeftToTriangulateDlt) {
  Random random(7);
  Views views = RandomViews(4, &random);
  for (size_t v = 0; v < 4; ++v) {
    views.present[v * PaddedLanes(kJoints)] = 1.0;
  }
  views.x_px[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_LT(InLanes(views, GetParam()).found[0], 0.0);
}

TEST_P(DltLanes, ConflictsMatchEpipolarDistances) {
  Random random(8);
  const Views views = RandomViews(4, &random);
  const EpipolarGeometry epipolar(views.cameras);
  constexpr double kAlpha = 3.0;  // px; near the noise: both results occur
  UseInstructionSet(GetParam());
  int conflicts = 0;
  for (int a = 0; a < 4; ++a) {
    for (int b = a + 1; b < 4; ++b) {
      std::vector<double> conflict(PaddedLanes(kJoints), 0.0);
      MarkConflicts(views.lanes[a], views.lanes[b], epipolar.fundamental(a, b),
                    kAlpha, PaddedLanes(kJoints), conflict.data());
      for (int j = 0; j < kJoints; ++j) {
        const LaneView& va = views.lanes[a];
        const LaneView& vb = views.lanes[b];
        const bool both = va.present[j] * vb.present[j] != 0.0;
        const double distance = epipolar.Distance(a, {va.x_px[j], va.y_px[j]},
                                                  b, {vb.x_px[j], vb.y_px[j]});
        EXPECT_EQ(conflict[j] != 0.0, both && 1.0 - distance / kAlpha < 0.0);
        conflicts += conflict[j] != 0.0;
      }
    }
  }
  UseInstructionSet(InstructionSet::kAvx512);
  EXPECT_GT(conflicts, 10);
}

}  // namespace
}  // namespace kinegraph
