#include "core/tracking/track.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "tests/support/rig.h"

namespace kinegraph {
namespace {

const FrameClock kClock(25.0);
constexpr TimeNs kFrame = 40'000'000;

TrackLife Born(const TrackLifeOptions& options = {}) {
  return TrackLife(options, kClock, 0);
}

TEST(TrackLifeTest, ConfirmedAtTheThirdHit) {
  TrackLife life = Born();
  life.Step(1 * kFrame, true, true);
  life.Step(2 * kFrame, true, false);  // matched, but the update failed
  EXPECT_EQ(life.state(), TrackState::kTentative);
  life.Step(3 * kFrame, true, true);  // the failure does not reset the hits
  EXPECT_EQ(life.state(), TrackState::kConfirmed);
}

TEST(TrackLifeTest, ATentativeTrackWithoutAMatchIsDeletedAtOnce) {
  TrackLife life = Born();
  life.Step(1 * kFrame, false, false);
  EXPECT_EQ(life.state(), TrackState::kDeleted);
}

// The times of frames may deviate by a third of a frame.
TEST(TrackLifeTest, DeletedExactlyTenFramesAfterTheLastUpdate) {
  for (const TimeNs jitter : {-kFrame / 3, TimeNs{0}, kFrame / 3}) {
    TrackLife life = Born();
    life.Step(1 * kFrame, true, true);
    life.Step(2 * kFrame, true, true);
    for (int frame = 1; frame <= 10; ++frame) {
      EXPECT_NE(life.state(), TrackState::kDeleted) << frame;
      life.Step((2 + frame) * kFrame + jitter, false, false);
    }
    EXPECT_EQ(life.state(), TrackState::kDeleted);
    // After missing frames, the track is deleted at the beginning of a frame in
    // which its age is eleven frames or more.
    life = Born();
    life.BeginFrame(10 * kFrame + jitter);
    EXPECT_NE(life.state(), TrackState::kDeleted) << "may still be matched";
    life.BeginFrame(11 * kFrame + jitter);
    EXPECT_EQ(life.state(), TrackState::kDeleted);
  }
}

TEST(TrackLifeTest, TracksEndBeforeIndependentFrames) {
  TrackLifeOptions options;
  options.independent_frames = true;
  TrackLife life = Born(LifeInFrames(options, 25.0));
  EXPECT_EQ(life.state(), TrackState::kConfirmed);
  life.BeginFrame(1 * kFrame);
  EXPECT_EQ(life.state(), TrackState::kDeleted);
}

TrackLifeOptions InSeconds(double frame_rate_hz) {
  TrackLifeOptions options;
  options.in_seconds = true;
  options.max_gap_s = 0.4;
  return LifeInFrames(options, frame_rate_hz);
}

TEST(TrackLifeTest, RareDetectorFramesConfirmByRepresentedTime) {
  TrackLife life = Born(InSeconds(120.0));  // confirm_hits is 11
  life.Step(6 * kFrame, true, true, 6.0);
  EXPECT_EQ(life.state(), TrackState::kTentative);
  life.Step(12 * kFrame, true, true, 6.0);
  EXPECT_EQ(life.state(), TrackState::kConfirmed);
  // The birth alone does not suffice, whatever number of frames a failed update
  // represents.
  TrackLife once = Born();
  EXPECT_EQ(once.state(), TrackState::kTentative);
  once.Step(1 * kFrame, true, false, 100.0);
  EXPECT_EQ(once.state(), TrackState::kTentative);
}

TEST(TrackLifeTest, MayBeMatchedUntilTheNextDetectorFrameIsDue) {
  TrackLife life = Born();
  life.BeginFrame(14 * kFrame, 5.0);
  EXPECT_NE(life.state(), TrackState::kDeleted);
  life.BeginFrame(15 * kFrame, 5.0);
  EXPECT_EQ(life.state(), TrackState::kDeleted);
}

TEST(LifeInFramesTest, SecondsScaleWithTheRateAndPaperModeCountsFrames) {
  struct Case {
    TrackLifeOptions life;
    int64_t confirm_hits;
    double max_age_frames, max_gap_frames;
  };
  for (const Case& one :
       {Case{LifeInFrames({}, 120.0), 3, 10.0, 0.0},  // paper mode
        {InSeconds(25.0), 3, 10.0, 10.0},             // as in the paper
        // confirm_s, 0.08 s, is 9.6 frames: 10 hits after the birth.
        {InSeconds(120.0), 11, 48.0, 48.0},
        // Below 12.5 Hz ages and gaps are longer than 0.4 s: 5 frames down to
        // 2.5 Hz, 2 s below that.
        {InSeconds(10.0), 2, 5.0, 5.0},
        {InSeconds(2.0), 2, 4.0, 4.0},
        // The first missed frame deletes a track, so its birth already confirms
        // it.
        {InSeconds(0.5), 1, 1.0, 1.0}}) {
    EXPECT_EQ(one.life.confirm_hits, one.confirm_hits);
    EXPECT_DOUBLE_EQ(one.life.max_age_frames, one.max_age_frames);
    EXPECT_DOUBLE_EQ(one.life.max_gap_frames, one.max_gap_frames);
  }
}

// Steps a WriteGate through the life of a track, from its birth: 'u' is an
// update, 'm' a match without update, '.' neither. Returns for each frame,
// birth included, whether it is written ('w'), not written ('-') or undecided
// ('?').
std::string Write(const TrackLifeOptions& options, const std::string& story) {
  TrackLife life(options, kClock, 0);
  WriteGate gate(options, kClock);
  gate.Step(0, life.state(), true);
  TimeNs time = 0;
  for (const char c : story) {
    time += kFrame;
    life.Step(time, c != '.', c == 'u');
    gate.Step(time, life.state(), c == 'u');
    if (life.state() == TrackState::kDeleted) {
      gate.Close();
      break;
    }
  }
  std::string written;
  bool write = false;
  while (gate.Pop(&write)) written += write ? 'w' : '-';
  while (written.size() < story.size() + 1) written += '?';
  return written;
}

TEST(WriteGateTest, PaperModeWritesConfirmedAndUpdatedFrames) {
  EXPECT_EQ(Write({}, "uuu.muu"), "--ww--ww");
}

TEST(WriteGateTest, BackfillWaitsForConfirmation) {
  TrackLifeOptions options;
  options.backfill = true;
  EXPECT_EQ(Write(options, "u"), "??");
  EXPECT_EQ(Write(options, "umuu"), "ww-ww");
  // Deleted before it was confirmed: nothing is written.
  EXPECT_EQ(Write(options, "u."), "---");
}

TEST(WriteGateTest, GapsAreBridgedUpToTheLimit) {
  TrackLifeOptions options;
  options.max_gap_frames = 3.0;
  EXPECT_EQ(Write(options, "uuu..."), "--ww???");
  EXPECT_EQ(Write(options, "uuu...u"), "--wwwwww");
  EXPECT_EQ(Write(options, "uuu....u"), "--ww----w");
  // The end of a track is not a gap.
  EXPECT_EQ(Write(options, "uuu.........."), "--ww----------");
}

// The view and the frame of a detection.
struct Sighting {
  int view;
  int64_t frame;
};

// Index in `stored`, view and frame of each entry of a memory in which `stored`
// were stored in order.
using Entries = std::vector<std::array<int64_t, 3>>;
Entries Remembered(int depth, const std::vector<Sighting>& stored) {
  const CameraRig cameras = testing::RingOfCameras(3);
  ViewMemory memory(depth);
  int index = 0;
  for (const Sighting& one : stored) {
    memory.Store(testing::Observe(testing::StandingPerson(0, 0), cameras,
                                  one.view, index++),
                 one.frame * kFrame);
  }
  Entries entries;
  for (const ViewMemory::Entry& entry : memory.entries()) {
    entries.push_back({entry.observation.detection_idx,
                       entry.observation.view_idx, entry.frame_time / kFrame});
  }
  return entries;
}

TEST(ViewMemoryTest, ViewsStayInOrderOfFirstStoreEachWithItsNewestPoseFirst) {
  EXPECT_EQ(Remembered(1, {{2, 0}, {0, 0}, {1, 1}, {2, 9}}),
            (Entries{{3, 2, 9}, {1, 0, 0}, {2, 1, 1}}));
  EXPECT_EQ(Remembered(2, {{1, 0}, {0, 0}, {1, 1}, {1, 2}, {0, 2}}),
            (Entries{{3, 1, 2}, {2, 1, 1}, {4, 0, 2}, {1, 0, 0}}));
}

constexpr double kCameraRate = 25.0;

// A look is a frame on which the detector ran.
class LookRhythmTest : public ::testing::Test {
 protected:
  // The next frame, with or without a detection in one of two views.
  bool See(bool somebody) {
    DetectionFrame frame;
    frame.frame = next_;
    frame.time = FrameClock(kCameraRate).TimeOf(next_++);
    frame.views.resize(2);
    if (somebody) frame.views[1].detections.emplace_back();
    return rhythm_.IsLook(frame);
  }

  LookRhythm rhythm_{FrameClock(kCameraRate)};
  int next_ = 0;
};

TEST_F(LookRhythmTest, EmptyFrameIsAMissIfTheDetectorRunsOnEveryFrame) {
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(See(true));
  EXPECT_TRUE(See(false));
  EXPECT_EQ(rhythm_.usual_frames(), 1.0);
}

TEST_F(LookRhythmTest, FramesWithoutDetectorAreNoMisses) {
  for (int k = 0; k < 20; ++k) {
    EXPECT_TRUE(See(true));
    EXPECT_FALSE(See(false));
    EXPECT_FALSE(See(false));
  }
  EXPECT_EQ(rhythm_.usual_frames(), 3.0);
  EXPECT_EQ(rhythm_.newest_frames(), 3.0);
  EXPECT_TRUE(See(false)) << "everybody has left";
}

TEST_F(LookRhythmTest, GapInTheRecordingDoesNotChangeTheRhythm) {
  for (int k = 0; k < 20; ++k) See(true);
  next_ += 1000;
  EXPECT_TRUE(See(true));
  EXPECT_EQ(rhythm_.usual_frames(), 1.0);
  EXPECT_EQ(rhythm_.newest_frames(), 1.0) << "one frame is no evidence of 1000";
}

TEST_F(LookRhythmTest, NothingIsMissedBeforeARhythmIsKnown) {
  EXPECT_FALSE(See(false));
  EXPECT_TRUE(See(true));
  EXPECT_FALSE(See(false));
}

}  // namespace
}  // namespace kinegraph
