// Tests the whole pipeline in graph mode on random scenes: tracks must not
// depend on the world's heading and horizontal position, the order of cameras
// and detections, duplicate detections or a camera without detections.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/session/ground.h"
#include "tests/solvers/session/recordings.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

// The recording of a random scene.
Recording RecordingOf(int64_t seed, int people, int cameras) {
  NoiseOptions noise;
  noise.seed = seed;
  noise.joints.missing_rate = 0.05;
  return Record(MakeScene(Staying(seed, people, cameras, 2.0)), noise);
}

TrackSequence TracksOf(const Recording& recording) {
  return Track(recording,
               ReadRunOptions(ProjectFile("configs/default.toml").string(),
                              "graph.solver=sweeps", ""));
}

using MovePoint = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;
Eigen::Vector3d Stays(const Eigen::Vector3d& point) { return point; }

// Describes the first difference; empty if there is none. Each person of `a`
// must correspond to a person of `b` at the position given by `move`, the same
// person in all frames.
std::string Difference(const TrackSequence& a, const TrackSequence& b,
                       const MovePoint& move) {
  // Much less than the minimum distance of two people in the scene, 0.55 m.
  constexpr double kSamePlaceMetres = 0.15;
  std::map<TrackId, TrackId> partner;
  std::map<TrackId, TrackId> back;
  if (a.frames.size() != b.frames.size()) return "other frame count";
  for (size_t f = 0; f < a.frames.size(); ++f) {
    const std::string at = "frame " + std::to_string(a.frames[f].frame) + ": ";
    if (a.frames[f].people.size() != b.frames[f].people.size()) {
      return at + std::to_string(a.frames[f].people.size()) + " and " +
             std::to_string(b.frames[f].people.size()) + " people";
    }
    for (const PersonPose& person : a.frames[f].people) {
      const Eigen::Vector3d place = move(*MeanPosition(person.joints));
      const auto same =
          std::find_if(b.frames[f].people.begin(), b.frames[f].people.end(),
                       [&](const PersonPose& other) {
                         return (*MeanPosition(other.joints) - place).norm() <
                                kSamePlaceMetres;
                       });
      if (same == b.frames[f].people.end()) return at + "a person is missing";
      const TrackId theirs = partner.emplace(person.id, same->id).first->second;
      const TrackId ours = back.emplace(same->id, person.id).first->second;
      if (theirs != same->id || ours != person.id) return at + "other identity";
    }
  }
  return "";
}

// A change to a recording, which returns how it displaces the people.
struct Change {
  const char* name;
  MovePoint (*apply)(Recording*);
};

MovePoint MoveWorld(Recording* recording) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d shift(4.0, -7.0, 0.0);
  CameraRig& cameras = recording->request.cameras;
  cameras = OnGround(cameras, {turn, shift});
  return [=](const Eigen::Vector3d& point) {
    return Eigen::Vector3d(turn * point + shift);
  };
}

MovePoint ReverseDetections(Recording* recording) {
  for (DetectionFrame& frame : recording->detections.frames) {
    for (ViewDetections& view : frame.views) {
      std::reverse(view.detections.begin(), view.detections.end());
      for (size_t d = 0; d < view.detections.size(); ++d) {
        view.detections[d].index_in_file = static_cast<int>(d);
      }
    }
  }
  return Stays;
}

MovePoint ReverseCameras(Recording* recording) {
  std::reverse(recording->request.cameras.begin(),
               recording->request.cameras.end());
  auto& names = recording->detections.header.view_names;
  std::reverse(names.begin(), names.end());
  for (DetectionFrame& frame : recording->detections.frames) {
    std::reverse(frame.views.begin(), frame.views.end());
  }
  return Stays;
}

MovePoint AddEmptyCamera(Recording* recording) {
  CameraRig& cameras = recording->request.cameras;
  cameras.push_back(Edited(cameras.front(), [](CameraParameters* camera) {
    camera->name = "blind";
  }));
  recording->detections.header.view_names.emplace_back("blind");
  for (DetectionFrame& frame : recording->detections.frames) {
    frame.views.emplace_back();
    frame.views.back().capture_time = frame.views.front().capture_time;
  }
  return Stays;
}

// Duplicates detections, as detectors with overlapping boxes do.
MovePoint DuplicateDetectionsInOneView(Recording* recording) {
  for (DetectionFrame& frame : recording->detections.frames) {
    std::vector<Detection>& detections = frame.views.front().detections;
    const size_t count = detections.size();
    for (size_t d = 0; d < count; ++d) {
      Detection again = detections[d];
      again.index_in_file = static_cast<int>(count + d);
      for (Keypoint& joint : again.joints) {
        joint.px += Eigen::Vector2d(1.0, -1.0);
      }
      detections.push_back(again);
    }
  }
  return Stays;
}

constexpr Change kChanges[] = {
    {"everybody found twice in one view", DuplicateDetectionsInOneView},
    {"a moved world", MoveWorld},
    {"detections in another order", ReverseDetections},
    {"cameras in another order", ReverseCameras},
    {"a camera that sees nobody", AddEmptyCamera}};

TEST(PipelineDifference, IsDetected) {
  const TrackSequence tracks = TracksOf(RecordingOf(2, 1, 3));
  ASSERT_FALSE(tracks.frames.back().people.empty());
  EXPECT_EQ(Difference(tracks, tracks, Stays), "");
  TrackSequence fewer = tracks;
  fewer.frames.back().people.pop_back();
  EXPECT_NE(Difference(tracks, fewer, Stays), "");
  TrackSequence renamed = tracks;
  renamed.frames.back().people.back().id = TrackId(77);
  EXPECT_NE(Difference(tracks, renamed, Stays), "");
  const MovePoint away = [](const Eigen::Vector3d& point) {
    return Eigen::Vector3d(point + Eigen::Vector3d(0.3, 0.0, 0.0));
  };
  EXPECT_NE(Difference(tracks, tracks, away), "");
}

class PipelineProperties : public ::testing::TestWithParam<int64_t> {};

TEST_P(PipelineProperties, AreInvariantToChanges) {
  Random random(static_cast<uint64_t>(GetParam()));
  const int people = static_cast<int>(1 + random.Index(4));
  const int cameras = static_cast<int>(3 + random.Index(3));
  const Recording recording = RecordingOf(GetParam(), people, cameras);
  const TrackSequence tracks = TracksOf(recording);
  EXPECT_GT(PoseCount(tracks), 0u);
  for (const Change& change : kChanges) {
    Recording changed = recording;
    const MovePoint move = change.apply(&changed);
    EXPECT_EQ(Difference(tracks, TracksOf(changed), move), "")
        << change.name << ", " << people << " people, " << cameras
        << " cameras";
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, PipelineProperties,
                         ::testing::Range<int64_t>(1, 9));

}  // namespace
}  // namespace kinegraph::testing
