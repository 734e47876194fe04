#include "core/evaluation/consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/base/random.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph {
namespace {

using testing::Frame;
using testing::Person;
using testing::StandingTum14;
using testing::Tracks;

// Errors drawn from a covariance; the tracks claim `claim` times as much.
Consistency Claimed(double claim) {
  Random random(4);
  Eigen::Matrix3d covariance;
  covariance << 4e-4, 1e-4, 0, 1e-4, 2e-4, 0, 0, 0, 9e-4;
  const Eigen::Matrix3d root = covariance.llt().matrixL();
  std::vector<TrackFrame> truth, found;
  for (int k = 0; k < 300; ++k) {
    truth.push_back(Frame(k, {Person(1, StandingTum14())}));
    PersonPose person = Person(5, StandingTum14());
    for (Joint3d& joint : person.joints) {
      joint.position_m +=
          root *
          Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
      person.covariances.emplace_back(claim * covariance);
    }
    found.push_back(Frame(k, {person}));
  }
  return CovariancesAgainstTruth(Tracks(truth), Tracks(found));
}

TEST(Consistency, OfATrueCovarianceIsOneAndCovers95Percent) {
  const Consistency right = Claimed(1.0);
  EXPECT_EQ(right.covered.total, 300 * 14);
  // 4200 joints: standard errors 0.0034 and sqrt(2 / 3 / 4200) = 0.0126.
  EXPECT_NEAR(right.covered.fraction(), 0.95, 3 * 0.0034);
  EXPECT_NEAR(right.nees_per_dof, 1.0, 3 * 0.0126);
}

TEST(Consistency, ShowsWhoIsTooSure) {
  const Consistency sure = Claimed(0.25);
  EXPECT_NEAR(sure.nees_per_dof, 4.0, 4 * 3 * 0.0126);
  EXPECT_LT(sure.covered.fraction(), 0.65);
}

TEST(Consistency, IsUndefinedWithoutCovariances) {
  const TrackSequence tracks = Tracks({Frame(0, {Person(1, StandingTum14())})});
  const Consistency none = CovariancesAgainstTruth(tracks, tracks);
  EXPECT_EQ(none.covered.total, 0);
  EXPECT_TRUE(std::isnan(none.nees_per_dof));
}

}  // namespace
}  // namespace kinegraph
