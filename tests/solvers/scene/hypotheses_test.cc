// Tests individual hypotheses on exact detections. For complete diagnoses of
// noisy scenes, see doctor_test.cc.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "solvers/scene/hypothesis.h"
#include "tests/support/moving_people.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr int kAskedFrames = 50;

DoctorInput MoversOf(const CameraRig& cameras) {
  DoctorInput input;
  input.cameras = cameras;
  input.detections = testing::SeenBy(cameras, kAskedFrames, [](int frame) {
    return std::vector<Pose3d>{testing::MovingPerson(0, frame),
                               testing::MovingPerson(1, frame)};
  });
  return input;
}

const Hypothesis& HypothesisOf(const std::string& name) {
  for (const Hypothesis& one : Hypotheses()) {
    if (one.name == name) return one;
  }
  throw std::out_of_range(name);
}

// The hypothesis's answer; empty if it has none.
Answer AnswerOf(const std::string& name, const SetUp& set_up) {
  return HypothesisOf(name).ask(set_up).value_or(Answer());
}

Answer AnswerFor(const std::string& name, const DoctorInput& input) {
  const DoctorOptions options;
  SetUp set_up(input, options);
  set_up.Look();
  return AnswerOf(name, set_up);
}

TEST(Hypotheses, HaveUniqueNamesAndAscendingStages) {
  std::set<std::string> names;
  Stage last = Stage::kFiles;
  for (const Hypothesis& one : Hypotheses()) {
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
    EXPECT_NE(one.ask, nullptr);
    EXPECT_GE(one.most, 1);
    EXPECT_GE(one.stage, last);
    last = one.stage;
  }
}

// ---- Files ----

TEST(Hypotheses, LongGapsBetweenFramesAreReported) {
  for (const double gap_s : {0.04, 0.39, 0.41, 1.01}) {
    DoctorInput input = MoversOf(testing::RingOfCameras(2));
    for (DetectionFrame& frame : input.detections.frames) {
      frame.time = FromSeconds(gap_s * static_cast<double>(frame.frame));
    }
    const Answer answer = AnswerFor("gaps between frames", input);
    ASSERT_EQ(answer.findings.size(), gap_s > 0.4 ? 1u : 0u) << gap_s;
    if (gap_s < 0.4) continue;
    // Gaps of less than a second may have other causes.
    EXPECT_EQ(answer.findings[0].confidence > 0.5, gap_s > 1.0) << gap_s;
    EXPECT_EQ(answer.findings[0].kind, "frame_rate");
    EXPECT_EQ(answer.findings[0].fix, "--set=input.independent_frames=true");
    input.independent_frames = true;
    EXPECT_THAT(AnswerFor("gaps between frames", input).findings, IsEmpty());
    input.independent_frames = false;
    input.detections.frames.resize(1);
    EXPECT_THAT(AnswerFor("gaps between frames", input).findings, IsEmpty());
  }
}

// One or two of the 49 frames after the first equal their predecessors.
TEST(Hypotheses, RepeatedImagesAreCountedByView) {
  DoctorInput input = MoversOf(testing::RingOfCameras(3));
  auto& frames = input.detections.frames;
  EXPECT_THAT(AnswerFor("repeated pictures", input).findings, IsEmpty());
  for (const auto& [k, share] : {std::pair{10u, "1 of 49 images repeats"},
                                 {30u, "2 of 49 images repeat"}}) {
    frames[k].views[1] = frames[k - 1].views[1];
    const Answer answer = AnswerFor("repeated pictures", input);
    ASSERT_EQ(answer.findings.size(), 1u);
    EXPECT_EQ(answer.findings[0].camera, "cam1");
    EXPECT_THAT(answer.findings[0].evidence,
                StartsWith(std::string(share) +
                           " the previous one, the first in frame 10"));
  }
  // People at rest are not reported as repeated images.
  for (DetectionFrame& frame : frames) frame.views = frames[0].views;
  EXPECT_THAT(AnswerFor("repeated pictures", input).findings, IsEmpty());
}

// The frame numbers of the third view are too high by 30: it begins after the
// others have ended.
TEST(Hypotheses, ViewsWithoutACommonFrameAreAligned) {
  DoctorInput input = MoversOf(testing::RingOfCameras(3));
  EXPECT_THAT(AnswerFor("frame ranges", input).findings, IsEmpty());
  const DetectionSequence right = input.detections;
  auto& frames = input.detections.frames;
  for (size_t k = 0; k < frames.size(); ++k) {
    for (const size_t v : {0u, 1u}) {
      if (k >= 20) frames[k].views[v].detections.clear();
    }
    if (k < 30) frames[k].views[2].detections.clear();
    if (k >= 30) frames[k].views[2] = right.frames[k - 30].views[2];
  }
  const Answer answer = AnswerFor("frame ranges", input);
  ASSERT_EQ(answer.findings.size(), 1u);
  EXPECT_EQ(answer.findings[0].camera, "cam2");
  EXPECT_EQ(answer.findings[0].fix, "'--set=input.view_frame_offset.cam2=30'");
  EXPECT_THAT(answer.findings[0].evidence, HasSubstr("cam2 30..49 against"));
  ASSERT_TRUE(answer.detections.has_value());
  ASSERT_EQ(answer.detections->frames.size(), 20u);
  for (size_t k = 0; k < 20; ++k) {
    for (size_t v = 0; v < 3; ++v) {
      const auto& found = answer.detections->frames[k].views[v].detections;
      ASSERT_EQ(found.size(), 2u);
      EXPECT_EQ(found[1].joints[9].px,
                right.frames[k].views[v].detections[1].joints[9].px);
    }
  }
}

// The third view's numbers are too high by 30. Its frame 12 and frame 8 of the
// other views are missing.
TEST(Hypotheses, MissingFramesRemainEmptyIfViewsAreAligned) {
  DoctorInput input = MoversOf(testing::RingOfCameras(3));
  const DetectionSequence right = input.detections;
  auto& frames = input.detections.frames;
  for (size_t k = 0; k < frames.size(); ++k) {
    for (size_t v = 0; v < 3; ++v) {
      auto& own = frames[k].views[v].detections;
      own.clear();
      if (v < 2 && k < 20) own = right.frames[k].views[v].detections;
      if (v == 2 && k >= 30) own = right.frames[k - 30].views[2].detections;
    }
  }
  frames.erase(frames.begin() + 42);
  frames.erase(frames.begin() + 8);
  const Answer answer = AnswerFor("frame ranges", input);
  ASSERT_TRUE(answer.detections.has_value());
  ASSERT_EQ(answer.detections->frames.size(), 20u);
  for (size_t k = 0; k < 20; ++k) {
    const DetectionFrame& frame = answer.detections->frames[k];
    EXPECT_EQ(frame.frame, static_cast<int64_t>(k));
    for (size_t v = 0; v < 3; ++v) {
      EXPECT_EQ(frame.views[v].detections.empty(), k == (v < 2 ? 8u : 12u));
    }
  }
}

// ---- One calibration twice ----

// Two views have the same calibration. It is wrong for the view that agrees
// less with the other views.
TEST(Hypotheses, DuplicateCalibrationIsReportedForTheViewThatFitsItWorse) {
  DoctorInput input = MoversOf(testing::RingOfCameras(4));
  EXPECT_THAT(AnswerFor("one calibration twice", input).findings, IsEmpty());
  for (const auto& [right, wrong] :
       std::vector<std::pair<size_t, size_t>>{{0, 3}, {3, 0}}) {
    DoctorInput twice = input;
    twice.cameras[wrong] =
        Edited(input.cameras[right], [&](CameraParameters* camera) {
          camera->name = input.cameras[wrong].name();
        });
    const Answer answer = AnswerFor("one calibration twice", twice);
    ASSERT_EQ(answer.findings.size(), 1u);
    EXPECT_EQ(answer.findings[0].camera, input.cameras[wrong].name());
    EXPECT_THAT(answer.strangers, ElementsAre(wrong));
  }
}

// ---- The unit ----

DoctorInput StandersIn(double units_per_metre) {
  const CameraRig cameras = testing::RingOfCameras(3);
  DoctorInput input = MoversOf(cameras);
  input.detections = testing::SeenBy(cameras, 20, [](int frame) {
    return std::vector<Pose3d>{testing::StandingPerson(0.02 * frame, 0.0)};
  });
  input.cameras = Rescaled(cameras, units_per_metre);
  return input;
}

// Lengths in millimetres or centimetres that are read as metres make people
// giants.
TEST(Hypotheses, UnitFollowsFromPlausibleStature) {
  const std::vector<std::pair<double, std::string>> units = {{100.0, "cm"},
                                                             {1000.0, "mm"}};
  for (const auto& [per_metre, name] : units) {
    const DoctorInput input = StandersIn(per_metre);
    const Answer answer = AnswerFor("unit", input);
    ASSERT_EQ(answer.findings.size(), 1u);
    EXPECT_EQ(answer.findings[0].fix, "--set=cameras.unit=" + name);
    ASSERT_TRUE(answer.cameras.has_value());
    for (size_t v = 0; v < 3; ++v) {
      // Rounding of scaling metres back and forth.
      EXPECT_LT(((*answer.cameras)[v].centre() -
                 testing::RingOfCameras(3)[v].centre())
                    .norm(),
                1e-12);
    }
    DoctorInput fixed = input;
    fixed.unit_can_be_set = false;
    EXPECT_EQ(AnswerFor("unit", fixed).findings[0].fix, kUseCorrected);
  }
}

TEST(Hypotheses, NoUnitFindingForMetresOrForFewStatures) {
  DoctorInput input = StandersIn(1.0);
  const Answer sound = AnswerFor("unit", input);
  EXPECT_THAT(sound.findings, IsEmpty());
  EXPECT_GT(sound.stature_m, 1.5);
  // Three frames, two sides of the body and three pairs of views give 18
  // statures, fewer than required.
  input.detections.frames.resize(3);
  const Answer few = AnswerFor("unit", input);
  EXPECT_THAT(few.findings, IsEmpty());
  EXPECT_EQ(few.stature_m, 0.0);
  EXPECT_THAT(few.notes, ElementsAre(HasSubstr("too few")));
}

// ---- With matches ----

// The answer for `count` motion segments of a joint, all at one speed.
Answer AnswerAtSpeed(int count, const std::string& joint, double speed_mps) {
  const DoctorInput input = MoversOf(testing::RingOfCameras(2));
  const DoctorOptions options;
  SetUp set_up(input, options);
  MotionSegment segment;
  segment.joint = Coco17().IndexOf(joint);
  segment.state[3] = 0.6 * speed_mps;
  segment.state[4] = 0.8 * speed_mps;
  set_up.segments.segments.assign(count, segment);
  return AnswerOf("people too fast", set_up);
}

TEST(Hypotheses, HipsFasterThanASprinterAreReported) {
  const Answer fast = AnswerAtSpeed(20, "l_hip", 12.6);
  ASSERT_EQ(fast.findings.size(), 1u);
  EXPECT_EQ(fast.findings[0].kind, "frame_rate");
  EXPECT_EQ(AnswerAtSpeed(20, "r_hip", 12.6).findings.size(), 1u);
  EXPECT_THAT(AnswerAtSpeed(20, "l_hip", 12.4).findings, IsEmpty());
  EXPECT_THAT(AnswerAtSpeed(19, "l_hip", 12.6).findings, IsEmpty());
  EXPECT_THAT(AnswerAtSpeed(20, "l_wrist", 20.0).findings, IsEmpty());
}

// The limit is a fifth of the detections if there are many detections.
TEST(Hypotheses, ViewsWithHardlyAnyMatchesAreExcluded) {
  const DoctorInput input = MoversOf(testing::RingOfCameras(3));
  const DoctorOptions options;
  // Qualified, because testing::Test::SetUp() hides the name.
  kinegraph::SetUp set_up(input, options);
  set_up.segments.matched = {90, 21, 19};
  set_up.segments.matchable = {100, 100, 100};
  const Answer answer = AnswerOf("views that are hardly ever matched", set_up);
  EXPECT_THAT(answer.strangers, ElementsAre(2));
  ASSERT_EQ(answer.findings.size(), 1u);
  EXPECT_EQ(answer.findings[0].camera, "cam2");
  EXPECT_EQ(answer.findings[0].fix, "--without_cameras=cam2");
  EXPECT_THAT(answer.findings[0].evidence,
              StartsWith("its detections are matched in 19 of 100 cases"));
}

// ---- Helpers ----

TEST(Hypotheses, SharedLimitsAndDividesConfidence) {
  EXPECT_DOUBLE_EQ(Shared(1.0, 1), 0.95);
  EXPECT_DOUBLE_EQ(Shared(0.9, 2), 0.45);
}

TEST(Hypotheses, ExchangingSidesTwiceRestoresThem) {
  const DetectionSequence before =
      MoversOf(testing::RingOfCameras(2)).detections;
  DetectionSequence after = before;
  const auto joint = [](const DetectionSequence& seen, size_t view, int j) {
    return seen.frames[3].views[view].detections[1].joints[j].px;
  };
  ExchangeSides({0, 1}, &after);
  for (int j = 0; j < 17; ++j) {
    EXPECT_EQ(joint(after, 0, j), joint(before, 0, j));
    EXPECT_EQ(joint(after, 1, j), joint(before, 1, Coco17().mirror(j)));
  }
  ExchangeSides({0, 1}, &after);
  for (int j = 0; j < 17; ++j) {
    EXPECT_EQ(joint(after, 1, j), joint(before, 1, j));
  }
}

TEST(Hypotheses, ImageSizeFallsBackToTwiceThePrincipalPoint) {
  const Camera camera = testing::RingOfCameras(1).front();
  EXPECT_EQ(ImageWidth(camera), 1920.0);
  EXPECT_EQ(ImageHeight(camera), 1080.0);
  const Camera unknown = Edited(camera, [](CameraParameters* parameters) {
    parameters->width_px = parameters->height_px = 0;
    parameters->K(0, 2) = 700.0;
    parameters->K(1, 2) = 300.0;
  });
  EXPECT_EQ(ImageWidth(unknown), 1400.0);
  EXPECT_EQ(ImageHeight(unknown), 600.0);
}

}  // namespace
}  // namespace kinegraph
