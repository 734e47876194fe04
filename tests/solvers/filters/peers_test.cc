// kinegraph's filters compared with Pose2Sim's on the same detections of one
// real person (data/shelf/peers).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/tracks/tracks.h"
#include "core/reconstruction/reconstruction.h"
#include "solvers/filters/classical.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/kalman.h"
#include "solvers/filters/smoothing_spline.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

constexpr int kFrames = 301;
constexpr int kFirst = 300;
constexpr double kRate_hz = 25.0;

// Positions [m] by joint, 301 x 3, NaN where there is none.
std::vector<Samples> ReadPeer(const std::string& folder,
                              const std::string& name) {
  std::vector<Samples> joints(17, Samples::Constant(kFrames, 3, NAN));
  for (const TrackFrame& frame :
       ReadTracks(folder + "/peers/" + name + ".json").frames) {
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < 17; ++j) {
        if (!person.joints[j].present()) continue;
        joints[j].row(frame.frame - kFirst) =
            person.joints[j].position_m.transpose();
      }
    }
  }
  return joints;
}

// Pose2Sim interpolates missing points linearly before filtering.
void Bridge(Samples* values) {
  Eigen::Index last = 0;
  for (Eigen::Index k = 1; k < values->rows(); ++k) {
    if (std::isnan((*values)(k, 0))) continue;
    for (Eigen::Index i = last + 1; i < k; ++i) {
      const double share =
          static_cast<double>(i - last) / static_cast<double>(k - last);
      values->row(i) =
          (1.0 - share) * values->row(last) + share * values->row(k);
    }
    last = k;
  }
}

// Pose2Sim's triangulated points, bridged and, as in Pose2Sim, filtered by a
// Hampel filter (window of seven frames, threshold of two standard deviations).
// Unlike kinegraph's, Pose2Sim's Hampel filter leaves the first and last three
// values unchanged.
std::vector<Samples> HampelPoints(const std::string& folder,
                                  const std::vector<double>& times_s) {
  std::vector<Samples> joints = ReadPeer(folder, "p2s_tri_raw");
  for (Samples& values : joints) {
    if (std::isnan(values(0, 0))) continue;  // eyes, ears: missing throughout
    Bridge(&values);
    // Pose2Sim rounds the normal quartile to 0.6745.
    const Samples filtered =
        HampelFilter(0.28, 2.0 / (0.6745 * 1.482602218505602),
                     WindowSide::kCentred, times_s, values);
    values.middleRows(3, kFrames - 6) = filtered.middleRows(3, kFrames - 6);
  }
  return joints;
}

class PeersTest : public ::testing::Test {
 protected:
  PeersTest() {
    for (int k = 0; k < kFrames; ++k) times_s_.push_back(k / kRate_hz);
  }

  // Sorted absolute differences [m] between the filtered points and
  // Pose2Sim's, over all joints and coordinates, without `trim` frames at
  // either end.
  template <typename Filter>
  std::vector<double> Differences(const std::string& folder,
                                  const std::string& peer, int trim,
                                  Filter filter) const {
    const auto points = HampelPoints(folder, times_s_);
    const auto theirs = ReadPeer(folder, peer);
    std::vector<double> differences;
    for (size_t j = 0; j < 17; ++j) {
      if (std::isnan(points[j](0, 0))) continue;
      const Samples difference = (filter(points[j]) - theirs[j]).cwiseAbs();
      for (int k = trim; k < kFrames - trim; ++k) {
        for (int c = 0; c < 3; ++c) differences.push_back(difference(k, c));
      }
    }
    std::sort(differences.begin(), differences.end());
    return differences;
  }

  std::vector<double> times_s_;
};

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share *
                                    static_cast<double>(sorted.size() - 1))];
}

TEST_F(PeersTest, ButterworthMatchesPose2Sim) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  // Pose2Sim's "order 4" counts both passes; its 6 Hz apply to each pass.
  ButterworthOptions options;
  options.order = 2;
  options.correct_cutoff = false;
  const auto same =
      Differences(folder, "p2s_hampel_butterworth", 0, [&](const Samples& x) {
        return ZeroPhaseButterworth(options, kRate_hz).filter(6.0, x);
      });
  EXPECT_EQ(same.size(), 13u * 301u * 3u);
  EXPECT_LT(same.back(), 1e-13);  // rounding of metres
  // kinegraph's default, the corrected cut-off, smooths less: 6 Hz after both
  // passes correspond to 6.9 Hz of each pass.
  options.correct_cutoff = true;
  const auto corrected =
      Differences(folder, "p2s_hampel_butterworth", 0, [&](const Samples& x) {
        return ZeroPhaseButterworth(options, kRate_hz).filter(6.0, x);
      });
  RecordProperty("corrected_median_mm",
                 std::to_string(1000.0 * Quantile(corrected, 0.5)));
  EXPECT_GT(Quantile(corrected, 0.5), 1e-4);   // 0.19 mm
  EXPECT_LT(Quantile(corrected, 0.95), 2e-3);  // 1.2 mm
}

TEST_F(PeersTest, GcvSplineMatchesPose2Sim) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  // Pose2Sim chooses lambda per coordinate, kinegraph per point.
  const auto same =
      Differences(folder, "p2s_hampel_gcv_spline", 0, [&](const Samples& x) {
        Samples smoothed(x.rows(), x.cols());
        for (int c = 0; c < 3; ++c) {
          const Samples column = x.col(c);
          smoothed.col(c) = SmoothingSpline(ChooseLambdaByGcv(times_s_, column),
                                            times_s_, column, times_s_);
        }
        return smoothed;
      });
  const auto together =
      Differences(folder, "p2s_hampel_gcv_spline", 0, [&](const Samples& x) {
        return SmoothingSpline(ChooseLambdaByGcv(times_s_, x), times_s_, x,
                               times_s_);
      });
  // Two searches for the same minimum.
  EXPECT_LT(same.back(), 1e-6);
  EXPECT_LT(Quantile(together, 0.5), 3e-4);   // 0.15 mm
  EXPECT_LT(Quantile(together, 0.95), 3e-3);  // 1.4 mm
}

TEST_F(PeersTest, RtsIsCloseToKalmanOfPose2Sim) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  // Pose2Sim's trust ratio of 500 [1/s^2] is the standard deviation of a step
  // of acceleration divided by that of a measurement, r. White noise on jerk
  // with the same variance per frame has the power (500 r)^2 / dt. Results with
  // the two kinds of noise differ by a few micrometres (median 3.5, at
  // most 170), and by 8 mm at the start, where Pose2Sim assumes a velocity in
  // metres per frame.
  const double sigma_m = 0.02;
  PointModel model;
  model.derivatives = 3;
  model.power = std::pow(500.0 * sigma_m, 2) * kRate_hz;
  const auto run = [&](const Samples& x) {
    JointSegment segment;
    segment.times_s = times_s_;
    segment.positions_m = x;
    segment.sampled.assign(kFrames, 1);
    segment.covariances_m2.assign(
        kFrames, sigma_m * sigma_m * Eigen::Matrix3d::Identity());
    return RtsSmoother(model, segment).positions_m;
  };
  const auto inside = Differences(folder, "p2s_hampel_kalman", 25, run);
  const auto all = Differences(folder, "p2s_hampel_kalman", 0, run);
  EXPECT_LT(Quantile(inside, 0.5), 1e-5);
  EXPECT_LT(inside.back(), 2e-4);
  EXPECT_LT(all.back(), 0.01);
}

TEST_F(PeersTest, ZeroPhaseOneEuroMatchesPose2Sim) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  // 4 Hz, beta 1.5, forwards and then backwards.
  const OneEuroOptions options = {4.0, 1.5, true};
  const auto same = Differences(
      folder, "p2s_hampel_one_euro", 0,
      [&](const Samples& x) { return OneEuro(options, times_s_, x); });
  EXPECT_LT(same.back(), 1e-12);
}

}  // namespace
}  // namespace kinegraph
