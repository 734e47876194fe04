// Readers of detections on the real data, counted against what its READMEs
// state, and on small files whose content is known.
#include "core/io/detections/source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>  // mkfifo

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "core/io/detections/writer.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::TemporaryFolder;

struct Counts {
  int people = 0;
  int missing_joints = 0;
  std::vector<int> people_of_view;
};

Counts Count(const DetectionSequence& sequence) {
  Counts counts;
  counts.people_of_view.resize(sequence.header.view_names.size());
  for (const DetectionFrame& frame : sequence.frames) {
    EXPECT_EQ(frame.views.size(), counts.people_of_view.size());
    for (size_t v = 0; v < frame.views.size(); ++v) {
      for (const Detection& detection : frame.views[v].detections) {
        ++counts.people;
        ++counts.people_of_view[v];
        counts.missing_joints +=
            sequence.header.skeleton.joint_count() - CountFound(detection);
      }
    }
  }
  return counts;
}

int CountMissing(const DetectionSequence& sequence, const std::string& joint) {
  const int index = sequence.header.skeleton.IndexOf(joint);
  int missing = 0;
  for (const DetectionFrame& frame : sequence.frames) {
    for (const ViewDetections& view : frame.views) {
      for (const Detection& detection : view.detections) {
        missing += detection.joints[index].found ? 0 : 1;
      }
    }
  }
  return missing;
}

// Everything but a NaN equals itself.
void ExpectSame(const DetectionSequence& a, const DetectionSequence& b) {
  EXPECT_TRUE(a.header.skeleton == b.header.skeleton);
  EXPECT_EQ(a.header.view_names, b.header.view_names);
  EXPECT_EQ(a.header.frame_rate_hz, b.header.frame_rate_hz);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (size_t f = 0; f < a.frames.size(); ++f) {
    EXPECT_EQ(a.frames[f].frame, b.frames[f].frame);
    EXPECT_EQ(a.frames[f].time, b.frames[f].time);
    ASSERT_EQ(a.frames[f].views.size(), b.frames[f].views.size());
    for (size_t v = 0; v < a.frames[f].views.size(); ++v) {
      const ViewDetections& view_a = a.frames[f].views[v];
      const ViewDetections& view_b = b.frames[f].views[v];
      EXPECT_EQ(view_a.capture_time, view_b.capture_time);
      ASSERT_EQ(view_a.detections.size(), view_b.detections.size());
      for (size_t d = 0; d < view_a.detections.size(); ++d) {
        const auto& joints_a = view_a.detections[d].joints;
        const auto& joints_b = view_b.detections[d].joints;
        EXPECT_EQ(view_a.detections[d].index_in_file,
                  view_b.detections[d].index_in_file);
        ASSERT_EQ(joints_a.size(), joints_b.size());
        for (size_t j = 0; j < joints_a.size(); ++j) {
          ASSERT_EQ(joints_a[j].found, joints_b[j].found);
          if (!joints_a[j].found) continue;
          ASSERT_EQ(joints_a[j].px, joints_b[j].px);
          ASSERT_EQ(joints_a[j].confidence, joints_b[j].confidence);
        }
      }
    }
  }
}

TEST(ReadDetections, ShelfOpenPose) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/detections/openpose");
  const auto source = OpenDetections(path);
  EXPECT_EQ(source->frame_count(), 301);
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_TRUE(sequence.header.skeleton == Body25());
  EXPECT_THAT(sequence.header.view_names,
              ElementsAre("cam0", "cam1", "cam2", "cam3", "cam4"));
  EXPECT_EQ(sequence.header.frame_rate_hz, 0.0);  // no file tells it
  ASSERT_EQ(sequence.frames.size(), 301u);
  EXPECT_EQ(sequence.frames.front().frame, 300);
  EXPECT_EQ(sequence.frames.back().frame, 600);
  const Counts counts = Count(sequence);
  EXPECT_EQ(counts.people, 4507);
  // Counted with a separate script over the same files.
  EXPECT_EQ(counts.missing_joints, 27178);
  EXPECT_EQ(CountMissing(sequence, "r_wrist"), 1640);
  EXPECT_EQ(CountMissing(sequence, "l_wrist"), 1290);
  size_t fewest = 99;
  size_t most = 0;
  for (const DetectionFrame& frame : sequence.frames) {
    for (const ViewDetections& view : frame.views) {
      fewest = std::min(fewest, view.detections.size());
      most = std::max(most, view.detections.size());
    }
  }
  EXPECT_EQ(fewest, 1u);  // 24 images; the README rounds to 2..6
  EXPECT_EQ(most, 7u);    // one image
}

TEST(ReadDetections, TimesFollowTheFrameRate) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/detections/openpose");
  DetectionReadOptions options;
  options.frame_rate_hz = 25.0;
  const auto source = OpenDetections(path, options);
  DetectionFrame frame;
  ASSERT_TRUE(source->Next(&frame));
  EXPECT_EQ(frame.time, 12'000'000'000);
  EXPECT_EQ(frame.views[4].capture_time, 12'000'000'000);
  ASSERT_TRUE(source->Next(&frame));
  EXPECT_EQ(frame.time, 12'040'000'000);
}

TEST(ReadDetections, Body25BIsKnownByPlausibilityAndFromTheOptions) {
  KINEGRAPH_DATA_OR_SKIP(path, "pose2sim/single/pose");
  DetectionReadOptions options;
  EXPECT_TRUE(OpenDetections(path)->header().skeleton == Body25B());
  options.skeleton_name = "body25";
  EXPECT_TRUE(OpenDetections(path, options)->header().skeleton == Body25());
  options.skeleton_name = "body25b";
  const DetectionSequence sequence = ReadDetections(path, options);
  EXPECT_TRUE(sequence.header.skeleton == Body25B());
  EXPECT_EQ(sequence.frames.size(), 100u);
  EXPECT_EQ(sequence.frames.front().frame, 0);
  EXPECT_EQ(sequence.frames.back().frame, 99);
  EXPECT_THAT(Count(sequence).people_of_view, ElementsAre(201, 200, 100, 100));
  EXPECT_EQ(Count(sequence).missing_joints, 815);
}

TEST(ReadDetections, PersonWithoutKeypointsKeepsItsPlace) {
  KINEGRAPH_DATA_OR_SKIP(path, "pose2sim/multi/pose");
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_THAT(Count(sequence).people_of_view, ElementsAre(299, 300, 200, 200));
  const auto& detections = sequence.frames[1].views[0].detections;
  std::vector<int> places;
  for (const Detection& detection : detections) {
    places.push_back(detection.index_in_file);
  }
  // cam01.0001.json holds three people, one of them empty.
  EXPECT_EQ(detections.size(), 2u);
  EXPECT_TRUE(std::is_sorted(places.begin(), places.end()));
  EXPECT_NE(places, (std::vector<int>{0, 1}));
}

TEST(ReadDetections, CocoResultsOfShelf) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/reference/filled_coco17");
  DetectionSequence sequence = ReadDetections(path);
  EXPECT_TRUE(sequence.header.skeleton == Coco17());
  EXPECT_EQ(sequence.frames.size(), 301u);
  EXPECT_THAT(Count(sequence).people_of_view,
              ElementsAre(831, 755, 879, 778, 777));
  EXPECT_EQ(Count(sequence).missing_joints, 2913 + 2478 + 2806 + 2297 + 2350);
  for (const DetectionFrame& frame : sequence.frames) {
    const bool empty = frame.views[3].detections.empty();
    EXPECT_EQ(empty, frame.frame >= 411 && frame.frame <= 413) << frame.frame;
  }
  DetectionReadOptions options;
  options.zero_confidence = ZeroConfidence::kPosition;
  sequence = ReadDetections(path, options);
  EXPECT_EQ(Count(sequence).missing_joints, 0);
  // The first person's right eye was filled with the place of the nose.
  const Keypoint& filled = sequence.frames[0].views[0].detections[0].joints[2];
  EXPECT_EQ(filled.confidence, 0.0);
  EXPECT_EQ(filled.px, Eigen::Vector2d(658.4368, 162.1114));
}

TEST(ReadDetections, ModelledCampusHasFramesThatNoViewHas) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/detections_modelled/typical");
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_THAT(sequence.header.view_names, ElementsAre("cam0", "cam1", "cam2"));
  EXPECT_THAT(Count(sequence).people_of_view, ElementsAre(719, 638, 636));
  EXPECT_EQ(sequence.frames.size(), 392u);  // of 340..760
  EXPECT_EQ(Count(sequence).missing_joints, 2879 + 2721 + 2673);
}

TEST(ReadDetections, OneCocoFileIsOneView) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/detections_modelled/clean/cam1.json");
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_THAT(sequence.header.view_names, ElementsAre("cam1"));
  EXPECT_EQ(Count(sequence).people, 565);
  EXPECT_EQ(sequence.frames.size(), 390u);
}

TEST(ReadDetections, LongcwAnnotation) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/annotation_2d.json");
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_TRUE(sequence.header.skeleton == Tum14());
  EXPECT_EQ(sequence.header.frame_rate_hz, 25.0);
  EXPECT_THAT(sequence.header.view_names,
              ElementsAre("Camera0", "Camera1", "Camera2"));
  ASSERT_EQ(sequence.frames.size(), 2000u);
  EXPECT_EQ(sequence.frames.back().frame, 1999);
  EXPECT_EQ(sequence.frames.back().time, 79'960'000'000);
  // "Every person is annotated in all three views": 2175 poses in each.
  EXPECT_THAT(Count(sequence).people_of_view, ElementsAre(2175, 2175, 2175));
  EXPECT_EQ(Count(sequence).missing_joints, 0);
  const DetectionFrame* first = nullptr;
  for (const DetectionFrame& frame : sequence.frames) {
    if (first == nullptr && !frame.views[0].detections.empty()) first = &frame;
  }
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->views[0].detections[0].joints[0].px,
            Eigen::Vector2d(153.0, 204.0));
}

TEST(ReadDetections, SmapOutput) {
  KINEGRAPH_DATA_OR_SKIP(path, "panoptic/detections");
  DetectionReadOptions options;
  options.first_frame = 10600;
  const DetectionSequence sequence = ReadDetections(path, options);
  EXPECT_TRUE(sequence.header.skeleton == Panoptic15());
  EXPECT_THAT(sequence.header.view_names,
              ElementsAre("_0", "_1", "_3", "_7", "_16"));
  ASSERT_EQ(sequence.frames.size(), 1u);
  EXPECT_EQ(sequence.frames[0].frame, 10600);
  EXPECT_THAT(Count(sequence).people_of_view, ElementsAre(3, 4, 5, 5, 4));
  EXPECT_EQ(Count(sequence).missing_joints, 10 + 0 + 6 + 13 + 0);
  // pixel = (x * 1920 / 832, (y - 22) * 1920 / 832), from the README.
  const Keypoint& neck = sequence.frames[0].views[0].detections[0].joints[0];
  EXPECT_NEAR(neck.px.x(), 686.5302734375 * 1920 / 832, 1e-9);
  EXPECT_NEAR(neck.px.y(), (241.8433837890625 - 22) * 1920 / 832, 1e-9);
  double best = 0.0;
  for (const ViewDetections& view : sequence.frames[0].views) {
    for (const Detection& detection : view.detections) {
      for (const Keypoint& joint : detection.joints) {
        best = std::max(best, joint.confidence);
      }
    }
  }
  EXPECT_NEAR(best, 4.637, 5e-4);
}

// Two views whose clocks differ, -0.0, tiny and huge numbers, a missing joint.
DetectionSequence OddSequence() {
  DetectionSequence sequence;
  sequence.header.skeleton = Skeleton("pair", {"a \"b\"", "c"}, {{0, 1}});
  sequence.header.view_names = {"left\n", "right"};
  for (const int64_t number : {0, 7}) {
    DetectionFrame frame;
    frame.frame = number;
    frame.time = number * 1'000'000'007;
    frame.views.resize(2);
    frame.views[0].capture_time = frame.time;
    frame.views[1].capture_time = frame.time - 3;
    Detection detection;
    detection.joints.resize(2);
    detection.joints[0] = {{-0.0, 1e-310}, 5.5, true};
    frame.views[1].detections.push_back(detection);
    detection.joints[0] = {{-1e300, 0.1 + 0.2}, 1e-5, true};
    detection.index_in_file = 1;
    frame.views[1].detections.push_back(detection);
    sequence.frames.push_back(frame);
  }
  return sequence;
}

TEST(DetectionWriter, KeepsEveryBit) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "odd.jsonl";
  const DetectionSequence sequence = OddSequence();
  WriteDetections(path, sequence);
  const DetectionSequence read = ReadDetections(path);
  ExpectSame(sequence, read);
  EXPECT_EQ(OpenDetections(path)->frame_count(), 2);
  EXPECT_TRUE(
      std::signbit(read.frames[0].views[1].detections[0].joints[0].px.x()));
}

TEST(DetectionWriter, LeavesNothingWithoutCommit) {
  const TemporaryFolder folder;
  const DetectionSequence sequence = OddSequence();
  {
    DetectionWriter writer(folder.path() / "odd.jsonl", sequence.header);
    writer.Write(sequence.frames[0]);
    EXPECT_THROW(writer.Write(sequence.frames[0]), std::logic_error);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(DetectionWriter, RefusesNumbersThatAreNotFinite) {
  const TemporaryFolder folder;
  DetectionSequence sequence = OddSequence();
  sequence.frames[0].views[1].detections[0].joints[0].px.x() = NAN;
  EXPECT_THROW(WriteDetections(folder.path() / "nan.jsonl", sequence),
               std::logic_error);
}

TEST(ReadDetections, OpenPoseLayoutsByTheirJointCount) {
  const auto person = [](int numbers) {
    std::string text = "{\"people\": [{\"pose_keypoints_2d\": [0";
    for (int n = 1; n < numbers; ++n) text += ", " + std::to_string(n);
    return text + "]}]}";
  };
  const TemporaryFolder folder;
  folder.Write("coco/c1/x_000000000007_keypoints.json", person(54));
  folder.Write("body/c1/x_7_keypoints.json", person(75));
  folder.Write("flat/x_7_keypoints.json", person(51));
  folder.Write("whole/c1/7.json", person(3 * 133));
  const auto skeleton = [&](const char* name) {
    return OpenDetections(folder.path() / name)->header().skeleton;
  };
  EXPECT_TRUE(skeleton("coco") == Coco18());
  EXPECT_TRUE(skeleton("body") == Body25());
  EXPECT_TRUE(skeleton("flat") == Coco17());
  EXPECT_THAT(OpenDetections(folder.path() / "flat")->header().view_names,
              ElementsAre("flat"));
  EXPECT_TRUE(skeleton("whole") == WholeBody133());
  std::vector<std::string> joints;
  for (int j = 0; j < 133; ++j) joints.push_back("j" + std::to_string(j));
  DetectionReadOptions options;
  options.skeleton = Skeleton("mine", joints, {});
  const auto sequence = ReadDetections(folder.path() / "whole", options);
  ASSERT_EQ(sequence.frames.size(), 1u);
  EXPECT_EQ(sequence.frames[0].frame, 7);
  EXPECT_EQ(sequence.frames[0].views[0].detections[0].joints[132].px,
            Eigen::Vector2d(396.0, 397.0));
}

TEST(ReadDetections, OpenPoseViewsMayMissFrames) {
  const std::string nobody = "{\"people\": []}";
  const TemporaryFolder folder;
  folder.Write("cam2/a_3_keypoints.json", nobody);
  folder.Write("cam10/a_1_keypoints.json", nobody);
  folder.Write("cam10/a_3_keypoints.json", nobody);
  const DetectionSequence sequence = ReadDetections(folder.path());
  EXPECT_THAT(sequence.header.view_names, ElementsAre("cam2", "cam10"));
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.frames[0].frame, 1);
  EXPECT_EQ(sequence.frames[1].frame, 3);
}

TEST(ReadDetections, OursFromAPipe) {
  const TemporaryFolder folder;
  const std::string ours = folder.path() / "ours.jsonl";
  const std::string pipe = folder.path() / "pipe";
  WriteDetections(ours, OddSequence());
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] {
    std::ofstream(pipe, std::ios::binary)
        << std::ifstream(ours, std::ios::binary).rdbuf();
  });
  ExpectSame(OddSequence(), ReadDetections(pipe));
  writer.join();
}

}  // namespace
}  // namespace kinegraph
