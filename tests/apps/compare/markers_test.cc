// compare --markers: optical markers as the truth, with another clock and
// another world frame.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "apps/common/synthesis.h"
#include "core/io/text/json.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;

class CompareWithMarkers : public testing::CommandTest {
 protected:
  CompareWithMarkers()
      : recording_(MakeRecording(
            ProjectConfig("synthetic/correlated_25hz.toml"),
            "scene.people=1;scene.duration=6;noise.correlation_time=0;"
            "noise.sigma=6")) {
    WriteRecording(recording_, Path("take"));
  }

  std::string Flags(const std::string& truth) const {
    return "--cameras='" + Path("take/cameras.json") + "' --detections='" +
           Path("take/detections.jsonl") + "' " + truth + " --config='" +
           ProjectConfig("synthetic/track_paper.toml") +
           "' --strategies=raw_dlt,batch --noplots --out='" + Path("out") + "'";
  }
  // MPJPE [mm] of raw_dlt and batch, which follow the default baseline.
  std::pair<double, double> Run(const std::string& truth) const {
    std::filesystem::remove_all(Path("out"));
    testing::Done("compare", Flags(truth));
    const Json strategies =
        Json::parse(testing::ContentOf(Path("out/compare.json")))["strategies"];
    const auto figure = [&](size_t s) {
      return strategies[s]["measures"]["mpjpe_mm"]["value"].get<double>();
    };
    return {figure(1), figure(2)};
  }

  // Two markers at each knee, ankle, elbow and wrist, 40 mm to either side,
  // recorded 137 ms late in another world frame.
  std::string Markers() const {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -1.0).normalized())
            .toRotationMatrix();
    motion.translation() = Eigen::Vector3d(3.0, -1.0, 0.5);
    return Write("markers.jsonl", motion, 0.137);
  }

  std::string Write(const std::string& name, const Eigen::Isometry3d& motion,
                    double late_s) const {
    const std::vector<std::pair<std::string, std::string>> joints = {
        {"knee", "Knee"},
        {"elbow", "Elbow"},
        {"wrist", "Wrist"},
        {"ankle", "Ankle"}};
    const Skeleton& skeleton = recording_.truth.header.skeleton;
    TrackSequence markers;
    markers.header.frame_rate_hz = recording_.truth.header.frame_rate_hz;
    std::vector<std::string> labels;
    for (const TrackFrame& frame : recording_.truth.frames) {
      TrackFrame& seen = markers.frames.emplace_back(frame);
      seen.time += FromSeconds(late_s);
      for (PersonPose& person : seen.people) {
        const Pose3d truth = std::move(person.joints);
        const TrackId id = person.id;
        person = PersonPose();
        person.id = id;
        labels.clear();
        for (const std::string side : {"l_", "r_"}) {
          for (const auto& [joint, label] : joints) {
            const Joint3d& centre =
                truth[static_cast<size_t>(skeleton.IndexOf(side + joint))];
            for (const double sign : {-1.0, 1.0}) {
              Joint3d& marker = person.joints.emplace_back(centre);
              marker.position_m =
                  motion *
                  (centre.position_m + Eigen::Vector3d(0.0, 0.04 * sign, 0.0));
              labels.push_back((side == "l_" ? "L" : "R") + label +
                               (sign < 0.0 ? "In" : "Out"));
            }
          }
        }
      }
    }
    markers.header.skeleton = Skeleton("markers", labels, {});
    WriteTracks(Path(name), markers);
    return Path(name);
  }

  const SyntheticRecording recording_;
};

TEST_F(CompareWithMarkers, ErrorsAreIndependentOfTheMarkersClockAndWorld) {
  const auto [dlt_mm, batch_mm] = Run("--markers='" + Markers() + "'");
  EXPECT_LT(batch_mm, dlt_mm);
  // The same markers on the cameras' clock and in their world frame: results
  // differ only by the noise that the alignment fits, which is small over 150
  // frames.
  const auto [same_dlt_mm, same_batch_mm] =
      Run("--markers='" +
          Write("same.jsonl", Eigen::Isometry3d::Identity(), 0.0) + "'");
  EXPECT_NEAR(same_dlt_mm, dlt_mm, 0.2);
  EXPECT_NEAR(same_batch_mm, batch_mm, 0.2);
  // The synthetic truth has more joints than the markers, so the errors are
  // only similar.
  EXPECT_NEAR(
      Run("--ground_truth='" + Path("take/truth.jsonl") + "' --protocol=mpjpe")
          .first,
      dlt_mm, 0.2 * dlt_mm);
}

TEST_F(CompareWithMarkers, InvalidFlagsAndFilesAreRefused) {
  EXPECT_THAT(testing::Refusal("compare", Flags("--joints=x.toml")),
              HasSubstr("requires --markers"));
  EXPECT_THAT(
      testing::Refusal("compare",
                       Flags("--markers='" + Path("take/cameras.json") + "'")),
      HasSubstr("cameras.json"));
}

}  // namespace
}  // namespace kinegraph
