#include "core/evaluation/markers/agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/core/evaluation/markers/moving_person.h"

namespace kinegraph::testing {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

PairedMotion Paired(const std::vector<Pose3d>& truth,
                    const std::vector<Pose3d>& found) {
  PairedMotion motion;
  motion.truth = Tracks({});
  motion.tracks = Tracks({});
  for (size_t f = 0; f < truth.size(); ++f) {
    const auto number = static_cast<int64_t>(f);
    motion.truth.frames.push_back(Frame(number, {Person(0, truth[f])}));
    motion.tracks.frames.push_back(Frame(number, {Person(0, found[f])}));
  }
  motion.is_centre.assign(truth.front().size(), true);
  return motion;
}

TEST(Agreement, BiasAndLimitsMatchHandComputedValues) {
  // Errors of 10 and 30 mm to the right and 4 mm forward: bias 20 and 4,
  // standard deviations 10 and 0, limits 19.6 and 0. Each half has the offset
  // of the other subtracted: 20 mm remain in both.
  const Pose3d truth = StandingTum14();
  const MotionAgreement found = CompareMotion(
      Paired({truth, truth},
             {Moved(truth, 0.010, 0.004), Moved(truth, 0.030, 0.004)}),
      Vector3d::UnitZ(), 1.0);
  ASSERT_EQ(found.joints.size(), 14u);
  const JointAgreement& joint = found.joints.front();
  EXPECT_EQ(joint.count, 2);
  EXPECT_TRUE(joint.bias_m.isApprox(Vector3d(0.020, 0.004, 0.0), 1e-9));
  EXPECT_NEAR(joint.limits_m.x(), 0.0195996, 1e-6);
  EXPECT_NEAR(joint.limits_m.y(), 0.0, 1e-9);
  EXPECT_NEAR(joint.after_offset_median_m, 0.020, 1e-9);
  const double first = std::hypot(0.010, 0.004);
  const double second = std::hypot(0.030, 0.004);
  EXPECT_NEAR(joint.median_m, 0.5 * (first + second), 1e-9);
  EXPECT_NEAR(joint.rms_m, std::sqrt(0.5 * (first * first + second * second)),
              1e-9);
  EXPECT_NEAR(found.pooled.bias_m.x(), 0.020, 1e-9);
  EXPECT_EQ(found.pooled.count, 28);
  EXPECT_NEAR(found.mean_of_medians_m, joint.median_m, 1e-9);
}

TEST(Agreement, DerivativesIgnoreGaps) {
  // The error is 20 mm, and after a second without frames -20 mm.
  const Pose3d truth = StandingTum14();
  PairedMotion motion =
      Paired(std::vector<Pose3d>(6, truth),
             {Moved(truth, 0.02, 0.0), Moved(truth, 0.02, 0.0),
              Moved(truth, 0.02, 0.0), Moved(truth, -0.02, 0.0),
              Moved(truth, -0.02, 0.0), Moved(truth, -0.02, 0.0)});
  for (size_t f = 3; f < 6; ++f) {
    motion.truth.frames[f].time += FromSeconds(1.0);
    motion.tracks.frames[f].time += FromSeconds(1.0);
  }
  const JointAgreement pooled =
      CompareMotion(motion, Vector3d::UnitZ(), 1.0).pooled;
  EXPECT_NEAR(pooled.velocity_rms_m_s, 0.0, 1e-9);
  EXPECT_NEAR(pooled.acceleration_rms_m_s2, 0.0, 1e-9);
}

TEST(Agreement, DerivativesFollowTimes) {
  // The error alternates between 10 and -10 mm every 0.12 s: second differences
  // of 40 mm, whatever the numbers of the frames and the rate.
  const Pose3d truth = StandingTum14();
  std::vector<Pose3d> found;
  for (int f = 0; f < 20; ++f) {
    found.push_back(Moved(truth, f % 2 == 0 ? 0.01 : -0.01, 0.0));
  }
  PairedMotion motion = Paired(std::vector<Pose3d>(20, truth), found);
  for (TrackSequence* tracks : {&motion.truth, &motion.tracks}) {
    for (TrackFrame& frame : tracks->frames) {
      frame.frame *= 3;
      frame.time *= 3;
    }
  }
  const JointAgreement pooled =
      CompareMotion(motion, Vector3d::UnitZ(), 1.0).pooled;
  EXPECT_NEAR(pooled.velocity_rms_m_s, 0.0, 1e-9);
  EXPECT_NEAR(pooled.acceleration_rms_m_s2, 0.04 / (0.12 * 0.12), 1e-6);
}

TEST(Agreement, OnlyCentresArePooled) {
  const Pose3d truth = StandingTum14();
  Pose3d found = truth;
  found[0].position_m.x() += 1.0;
  PairedMotion motion = Paired({truth}, {found});
  motion.is_centre[0] = false;
  const MotionAgreement result = CompareMotion(motion, Vector3d::UnitZ(), 1.0);
  EXPECT_EQ(result.pooled.count, 13);
  EXPECT_NEAR(result.pooled.mean_m, 0.0, 1e-12);
}

TEST(Agreement, CalibrationMatchesHandComputedValues) {
  const Matrix3d covariance = 1e-6 * Matrix3d::Identity();  // 1 mm
  Calibration calibration;
  calibration.Add(Vector3d::Zero(), covariance);
  // All ellipsoids contain an error of zero, so the calibration error is the
  // mean of 1 - level.
  EXPECT_NEAR(calibration.ExpectedCalibrationError(), 0.5, 1e-12);
  // -log of the density at the middle, in mm: 1.5 log(2 pi).
  EXPECT_NEAR(calibration.LogScore(), 2.756816, 1e-6);
  EXPECT_NEAR(calibration.StatedRms(), std::sqrt(3.0) * 1e-3, 1e-12);
  // Quantiles of chi-square with three degrees of freedom (tables).
  for (const auto& [level, quantile] :
       {std::pair{0.50, 2.36597}, {0.95, 7.81473}}) {
    for (const double off : {-1e-4, 1e-4}) {
      Calibration at;
      at.Add({1e-3 * std::sqrt(quantile + off), 0.0, 0.0}, covariance);
      EXPECT_EQ(at.Covered(level), off < 0.0 ? 1.0 : 0.0);
    }
  }
  // The second error, of 1 m, lies outside every ellipsoid, so the coverage is
  // a half at each level. The mean of |0.5 - level| over 0.05 .. 0.95 is
  // 4.5 / 19.
  calibration.Add(Vector3d(1.0, 0.0, 0.0), covariance);
  EXPECT_EQ(calibration.Covered(0.50), 0.5);
  EXPECT_EQ(calibration.Covered(0.95), 0.5);
  EXPECT_NEAR(calibration.ExpectedCalibrationError(), 4.5 / 19.0, 1e-12);
}

TEST(Agreement, CorrectCovariancesAreCalibrated) {
  // With 20000 normal errors the standard error of a coverage is at most
  // 0.0035, of one of 80 % 0.0028; the tolerance is five times that.
  Random random(3);
  Calibration calibration;
  const Matrix3d root = Vector3d(0.001, 0.003, 0.010).asDiagonal();
  for (int i = 0; i < 20000; ++i) {
    const Vector3d error =
        root * Vector3d(random.Normal(), random.Normal(), random.Normal());
    calibration.Add(error, root * root.transpose());
  }
  EXPECT_NEAR(calibration.Covered(0.80), 0.80, 0.015);
  EXPECT_LT(calibration.ExpectedCalibrationError(), 0.01);
}

TEST(Agreement, PckAndAucMatchHandComputedValues) {
  // Without hips nothing is shifted. 100 mm: within 100, 105, ..., 150 mm, 11
  // of 31 thresholds; 200 mm within none.
  PairedMotion motion;
  const Skeleton two("two", {"l_wrist", "r_wrist"}, {});
  const Pose3d truth = {Observed(0, 0, 0), Observed(1, 0, 0)};
  Pose3d found = truth;
  found[0].position_m.z() += 0.100 - 1e-12;
  found[1].position_m.z() += 0.200;
  motion.truth = Tracks({Frame(0, {Person(0, truth)})}, two);
  motion.tracks = Tracks({Frame(0, {Person(0, found)})}, two);
  motion.is_centre = {true, true};
  const MotionAgreement result = CompareMotion(motion, Vector3d::UnitZ(), 1.0);
  EXPECT_FALSE(result.root_aligned);
  EXPECT_EQ(result.pck_150.count, 1);
  EXPECT_EQ(result.pck_150.total, 2);
  EXPECT_NEAR(result.auc, 11.0 / 62.0, 1e-9);
}

TEST(Agreement, ProcrustesMatchesHandComputedValues) {
  // A square against a rhombus with half-diagonals 1 and 3: no rotation, scale
  // (1 + 3) / (1 + 9) = 0.4, so two corners are 0.6 and two 0.2 away: 0.4 in
  // the mean.
  const auto corners = [](double long_m, double z) {
    return Pose3d{Observed(1, 0, z), Observed(-1, 0, z), Observed(0, long_m, z),
                  Observed(0, -long_m, z)};
  };
  PairedMotion motion = Paired({corners(1.0, 0.0)}, {corners(3.0, 5.0)});
  const Skeleton four("four", {"a", "b", "c", "d"}, {});
  motion.truth.header.skeleton = motion.tracks.header.skeleton = four;
  const auto pa_mpjpe_m = [&] {
    return CompareMotion(motion, Vector3d::UnitZ(), 1.0).pa_mpjpe_m;
  };
  EXPECT_NEAR(pa_mpjpe_m(), 0.4, 1e-9);
  for (size_t j : {0, 1}) motion.tracks.frames[0].people[0].joints[j] = {};
  EXPECT_TRUE(std::isnan(pa_mpjpe_m())) << "two points";
}

TEST(Agreement, ValuesAndIntervalsMatchHandComputedValues) {
  // Differences 1, 1, 3, 3: bias 2, standard deviation 1. Without the offset of
  // the other half, -2, -2, 2, 2 remain. Intervals of +- 2 contain the truth
  // for the first two values, and after removal of the offset for all four.
  std::vector<PairedValue> values;
  for (const double difference : {1.0, 1.0, 3.0, 3.0}) {
    values.push_back(
        {10.0, 10.0 + difference, 8.0 + difference, 12.0 + difference});
  }
  const ValueAgreement result = CompareValues(values, 0.0);
  EXPECT_EQ(result.count, 4);
  EXPECT_NEAR(result.bias, 2.0, 1e-12);
  EXPECT_NEAR(result.limits, 1.959964, 1e-6);
  EXPECT_NEAR(result.rms, std::sqrt(5.0), 1e-12);
  EXPECT_NEAR(result.after_offset_rms, 2.0, 1e-12);
  EXPECT_EQ(result.covered.count, 2);
  EXPECT_EQ(result.covered_after_offset.count, 4);
  // 179 and -179 degrees are 2 apart.
  EXPECT_NEAR(CompareValues({{179.0, -179.0, NAN, NAN}}, 360.0).bias, 2.0,
              1e-12);
}

}  // namespace
}  // namespace kinegraph::testing
