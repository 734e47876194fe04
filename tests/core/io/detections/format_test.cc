#include "core/io/detections/format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "core/base/random.h"
#include "core/io/detections/writer.h"
#include "core/io/file_kind.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/detections/detection_files.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using testing::ExpectInputError;
using testing::ExpectSameDetections;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::SequenceSource;
using testing::TemporaryFolder;

LostFields Write(const std::string& format, const std::string& path,
                 const DetectionSequence& sequence,
                 const DetectionWriteOptions& options = {}) {
  SequenceSource source(sequence);
  LostFields lost_fields;
  FindDetectionFormat(format)->write(path, options, &source, &lost_fields);
  return lost_fields;
}

DetectionSequence RandomSequence(const Skeleton& skeleton) {
  Random random(11);
  DetectionSequence sequence;
  sequence.header.skeleton = skeleton;
  sequence.header.view_names = {"cam2", "cam10"};
  for (int64_t f : {3, 4, 7, 120}) {
    DetectionFrame frame;
    frame.frame = f;
    frame.views.resize(2);
    for (ViewDetections& view : frame.views) {
      const auto people = static_cast<size_t>(random.Index(4));
      for (size_t p = 0; p < people || (p == 0 && &view == &frame.views[0]);
           ++p) {
        Detection detection;
        detection.index_in_file = static_cast<int>(p);
        for (int j = 0; j < skeleton.joint_count(); ++j) {
          Keypoint joint;
          joint.found = random.Chance(0.7);
          if (joint.found) {
            joint.px = {1000.0 * random.Normal(), random.Normal() / 3.0};
            joint.confidence = random.Uniform(0.01, 1.2);
          }
          detection.joints.push_back(joint);
        }
        view.detections.push_back(detection);
      }
    }
    sequence.frames.push_back(frame);
  }
  return sequence;
}

TEST(DetectionExport, OpenPoseKeepsFramesWithoutPeople) {
  DetectionSequence sequence = RandomSequence(Body25());
  for (ViewDetections& view : sequence.frames[2].views) view.detections.clear();
  const TemporaryFolder folder;
  const std::string path = folder.path() / "result";
  Write("openpose", path, sequence);
  ExpectSameDetections(sequence, ReadDetections(path));
  EXPECT_TRUE(fs::exists(path + "/cam10/cam10_000000000007_keypoints.json"));
}

// The sequence with the times that longcw's files require.
DetectionSequence Timed(DetectionSequence sequence) {
  sequence.header.frame_rate_hz = 25.0;
  for (DetectionFrame& frame : sequence.frames) {
    frame.time = FrameClock(25.0).TimeOf(frame.frame);
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
  }
  return sequence;
}

TEST(DetectionExport, LongcwRefusesWhatItCannotExpress) {
  const TemporaryFolder folder;
  DetectionSequence sequence = Timed(RandomSequence(Tum14()));
  const auto expect = [&](const char* said, ImageSize size = {640, 480}) {
    ExpectInputError(
        [&] { Write("longcw", folder.path() / "a.json", sequence, {size}); },
        said);
  };
  expect("--image_size", {});
  sequence.frames[1].views[0].capture_time += 600'000'000;
  expect("read as another one");
  sequence.header.frame_rate_hz = 0.0;
  expect("--frame_rate");
  EXPECT_THAT(ListFolder(folder.path().string()), IsEmpty());
}

TEST(DetectionExport, CocoScoreAndBoxUseOnlyFoundJoints) {
  DetectionSequence sequence;
  sequence.header = {Skeleton("three", {"a", "b", "c"}, {}), {"v"}, 25.0};
  DetectionFrame frame;
  frame.frame = 5;
  frame.time = 200'000'000;
  frame.views.resize(1);
  frame.views[0].capture_time = frame.time;
  Detection detection;
  detection.joints = {{{10.0, 40.5}, 0.5, true},
                      {{0.0, 0.0}, 0.0, false},
                      {{-2.0, 50.0}, 1.0, true}};
  frame.views[0].detections = {detection};
  sequence.frames = {frame};
  frame.frame = 6;
  frame.time = frame.views[0].capture_time = 240'000'000;
  frame.views[0].detections.clear();
  sequence.frames.push_back(frame);
  const TemporaryFolder folder;
  const std::string path = folder.path() / "result";
  const LostFields lost_fields = Write("coco", path, sequence);
  EXPECT_EQ(ReadTextFile(path + "/v.json"),
            "[\n{\"image_id\": 5, \"category_id\": 1, \"keypoints\": [10, "
            "40.5, 0.5, 0, 0, 0, -2, 50, 1], \"score\": 0.75, \"bbox\": [-2, "
            "40.5, 12, 9.5]}\n]\n");
  EXPECT_THAT(lost_fields,
              Contains(HasSubstr("1 frame without any detection is not kept")));
  EXPECT_THAT(lost_fields, Contains(HasSubstr("the skeleton 'three'")));
  EXPECT_THAT(lost_fields, Contains(HasSubstr("frame rate is not kept")));
  EXPECT_EQ(lost_fields.size(), 3u) << "the times follow from the frames";
}

TEST(DetectionExport, ReportsLostFields) {
  DetectionSequence sequence = RandomSequence(Body25B());
  sequence.header.view_names = {"cam10", "cam2"};
  sequence.frames[0].views[1].capture_time = 5;
  sequence.frames[0].views[0].detections[0].joints[0] = {{1, 2}, 0.0, true};
  const TemporaryFolder folder;
  sequence.frames[3].views[0].detections[0].index_in_file = 100;
  const LostFields lost_fields =
      Write("openpose", folder.path() / "a", sequence);
  for (const char* said :
       {"times other than", "the skeleton 'body25b'",
        "1 joint with confidence 0 is", "order of their names",
        "1 detection gets another index"}) {
    EXPECT_THAT(lost_fields, Contains(HasSubstr(said)));
  }
}

// kinegraph's format keeps times and the order of views.
TEST(DetectionExport, OwnFormatReportsJointsAndIndices) {
  DetectionSequence sequence = RandomSequence(Coco17());
  sequence.header.frame_rate_hz = 25.0;
  sequence.header.view_names = {"cam10", "cam2"};
  sequence.frames[0].views[0].detections[0].joints[0] = {{1, 2}, 0.0, true};
  sequence.frames[3].views[0].detections[0].index_in_file = 100;
  const TemporaryFolder folder;
  const LostFields lost_fields =
      Write("kinegraph", folder.path() / "a.jsonl", sequence);
  for (const char* said :
       {"1 joint with confidence 0 is", "1 detection gets another index"}) {
    EXPECT_THAT(lost_fields, Contains(HasSubstr(said)));
  }
  EXPECT_EQ(lost_fields.size(), 2u);
}

TEST(DetectionExport, MediaPipeTablesQuoteNamesOfJoints) {
  const TemporaryFolder folder;
  DetectionSequence sequence = Timed(
      RandomSequence(Skeleton("odd", {"paw, left", "=tail", "l_ear"}, {})));
  const std::string path = folder.path() / "a";
  Write("mediapipe", path, sequence);
  const DetectionSequence read = ReadDetections(path);
  EXPECT_EQ(read.header.skeleton.joints(), sequence.header.skeleton.joints());
  EXPECT_EQ(read.frames.size(), sequence.frames.size());
  sequence = RandomSequence(Skeleton("two", {"l_eye", "left_eye"}, {}));
  ExpectInputError([&] { Write("mediapipe", folder.path() / "b", sequence); },
                   "joint 'left_eye': two joints have the name 'left_eye'");
  EXPECT_FALSE(fs::exists(folder.path() / "b"));
}

// A file in a format is recognised only by this format, and preserves all data
// that the format can represent, for joint layouts that can be recognised from
// its files.
TEST(DetectionExport, EveryFormatReadsBackBitForBit) {
  int formats = 0;
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.write == nullptr) continue;
    ++formats;
    std::vector<const Skeleton*> skeletons = {&Coco17(), &Halpe26(),
                                              &MediaPipe33(), &WholeBody133()};
    if (format.name == "longcw") skeletons = {&Tum14()};
    // Recognised by content, with and without the format's own extension.
    std::set<std::string> names = {"take"};
    if (format.files == DetectionFormat::Files::kOne) {
      names.insert("take" + format.extension);
    }
    for (const Skeleton* skeleton : skeletons) {
      const DetectionSequence sequence = Timed(RandomSequence(*skeleton));
      for (const std::string& name : names) {
        SCOPED_TRACE(format.name + " " + skeleton->name() + " " + name);
        const TemporaryFolder folder;
        const std::string path = folder.path() / name;
        Write(format.name, path, sequence, {{640, 480}});
        const DetectionHead head = LookAtDetections(path);
        for (const DetectionFormat& other : DetectionFormats()) {
          if (other.recognise == nullptr) continue;  // recognised by an adapter
          EXPECT_EQ(other.recognise(head), &other == &format) << other.name;
        }
        ExpectSameDetections(sequence, ReadDetections(path));
        DetectionReadOptions forced;
        forced.format = format.name;
        ExpectSameDetections(sequence, ReadDetections(path, forced));
        EXPECT_EQ(RecogniseKind(path), FileKind::kDetections);
      }
    }
  }
  EXPECT_GE(formats, 6);
}

// A gap in the frame numbers of a format that keeps frames without people means
// that frames are missing.
TEST(DetectionExport, FramesWithoutPeopleAreKeptUnlessTheFormatLeavesThemOut) {
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.write == nullptr) continue;
    SCOPED_TRACE(format.name);
    DetectionSequence sequence =
        Timed(RandomSequence(format.name == "longcw" ? Tum14() : Coco17()));
    for (ViewDetections& view : sequence.frames[2].views) {
      view.detections.clear();
    }
    const TemporaryFolder folder;
    const std::string path = folder.path() / "take";
    const LostFields lost_fields =
        Write(format.name, path, sequence, {{640, 480}});
    EXPECT_EQ(LeavesOutEmptyFrames(path, {}), format.leaves_out_empty);
    if (format.leaves_out_empty) {
      sequence.frames.erase(sequence.frames.begin() + 2);
      EXPECT_THAT(lost_fields, Contains(HasSubstr("1 frame without any "
                                                  "detection is not kept")));
    }
    ExpectSameDetections(sequence, ReadDetections(path));
  }
}

TEST(DetectionExport, RefusesViewNamesThatAreInvalidFileNames) {
  const TemporaryFolder folder;
  for (const char* name : {"", "../up", ".hidden", "a/b", "line\nbreak"}) {
    DetectionSequence sequence = RandomSequence(Coco17());
    sequence.header.view_names[1] = name;
    for (const char* format : {"openpose", "coco"}) {
      ExpectInputError(
          [&] { Write(format, folder.path() / "result", sequence); },
          "cannot be the name of a file");
    }
  }
  EXPECT_THAT(ListFolder(folder.path().string()), IsEmpty());
}

}  // namespace
}  // namespace kinegraph
