#include "solvers/cameras/camera_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "solvers/cameras/camera_change.h"
#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

constexpr double kSigmaM = 0.01;  // pixel noise, as a length at the joint

struct Setting {
  FaultyScene scene;
  Eigen::Vector3d point;
  DetectionFrame seen;
  TrackFrame frame;
};

// One person with a single joint, at the true position of the scene's first
// joint, who is detected in all five views.
Setting MakeSetting() {
  Setting setting{MakeFaultyScene({5, 5, 1, 0.2}), {}, {}, {}};
  const TrackSequence truth = TruthOf(setting.scene.scene);
  setting.point = truth.frames[0].people[0].joints[0].position_m;
  PersonPose person;
  person.joints.resize(1);
  person.joints[0] = {setting.point, JointStatus::kObserved};
  person.covariances = {Eigen::Matrix3d::Zero()};
  setting.seen.views.resize(5);
  for (int v = 0; v < 5; ++v) {
    Detection detection;
    detection.joints.resize(1);
    detection.joints[0].found = true;
    detection.joints[0].confidence = 1.0;
    setting.seen.views[static_cast<size_t>(v)].detections = {detection};
    person.matches.push_back({v, 0, {1.0}});
  }
  setting.frame.people = {person};
  return setting;
}

// Hand-computed information about a joint and the rotations of all cameras.
Eigen::MatrixXd InformationOf(const Setting& setting, double prior_rad) {
  const Eigen::Index size = 3 + 3 * 5;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index v = 0; v < 5; ++v) {
    const Camera& camera = setting.scene.scene.cameras[static_cast<size_t>(v)];
    Matrix23d by_point;
    Eigen::Matrix<double, 2, kChangeSize> by_change;
    EXPECT_TRUE(ProjectChanged(camera, CameraChange::Zero(), setting.point,
                               &by_point, &by_change));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, size);
    J.leftCols<3>() = by_point;
    J.middleCols(3 + 3 * v, 3) = by_change.middleCols<3>(kRotationAt);
    const double sigma_px =
        kSigmaM * camera.focal_px() / camera.Depth(setting.point);
    information += J.transpose() * J / (sigma_px * sigma_px);
  }
  for (Eigen::Index i = 3; i < size; ++i) {
    information(i, i) += 1.0 / (prior_rad * prior_rad);
  }
  return information;
}

CameraUncertainty Uncertain(const Setting& setting,
                            const Eigen::MatrixXd& covariance,
                            const std::vector<int>& joints = {0}) {
  return CameraUncertainty(
      setting.scene.scene.cameras,
      std::vector<std::vector<int>>(
          5, {kRotationAt, kRotationAt + 1, kRotationAt + 2}),
      covariance, joints, 0.0);
}

// The result must equal the joint's block of the inverse of the whole
// information.
TEST(CameraUncertainty, MatchesTheMarginalCovariance) {
  Setting setting = MakeSetting();
  const Eigen::MatrixXd information = InformationOf(setting, 0.002);
  const Eigen::MatrixXd whole = information.inverse();
  const Eigen::Matrix3d given_cameras =
      information.topLeftCorner<3, 3>().inverse();
  setting.frame.people[0].covariances = {given_cameras};
  Uncertain(setting, whole.bottomRightCorner(15, 15))
      .AddTo(setting.seen, &setting.frame);
  const Eigen::Matrix3d expected = whole.topLeftCorner<3, 3>();
  // The contribution of the cameras matters: 2 mrad at 6 m are 12 mm.
  ASSERT_GT(expected.trace(), 1.5 * given_cameras.trace());
  // The tolerance covers the thousandth of the mean information that is added
  // for the case of parallel rays.
  EXPECT_LT((*setting.frame.people[0].covariances[0] - expected).norm(),
            0.005 * expected.norm());
}

TEST(CameraUncertainty, RejectedViewsDoNotContribute) {
  Setting setting = MakeSetting();
  setting.frame.people[0].matches[4].weights[0] = 0.0;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(15, 15);
  covariance.bottomRightCorner<3, 3>().setIdentity();
  Uncertain(setting, covariance).AddTo(setting.seen, &setting.frame);
  EXPECT_EQ(setting.frame.people[0].covariances[0]->norm(), 0.0);
  setting.frame.people[0].matches[4].weights[0] = 1.0;
  Uncertain(setting, covariance).AddTo(setting.seen, &setting.frame);
  EXPECT_GT(setting.frame.people[0].covariances[0]->norm(), 0.0);
}

// A joint without a detection receives the mean effect on the person's other
// joints; a joint without a covariance is skipped.
TEST(CameraUncertainty, UnseenJointsReceiveTheMeanAddition) {
  Setting setting = MakeSetting();
  PersonPose& person = setting.frame.people[0];
  person.joints.resize(3, person.joints[0]);
  person.covariances = {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(),
                        std::nullopt};
  for (ViewMatch& match : person.matches) {
    match.weights = {1.0, std::nullopt, std::nullopt};
  }
  const Eigen::MatrixXd covariance = 1e-6 * Eigen::MatrixXd::Identity(15, 15);
  Uncertain(setting, covariance, {0, -1, -1})
      .AddTo(setting.seen, &setting.frame);
  EXPECT_GT(person.covariances[0]->trace(), 0.0);
  EXPECT_EQ(*person.covariances[1], *person.covariances[0]);
  EXPECT_FALSE(person.covariances[2].has_value());
}

}  // namespace
}  // namespace kinegraph
