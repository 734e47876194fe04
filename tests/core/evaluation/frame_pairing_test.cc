#include "core/evaluation/frame_pairing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/identity.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/panoptic.h"
#include "core/evaluation/parity.h"
#include "core/evaluation/pcp.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kSpeed = 1.5;  // m/s, a walk

// Position at a time of a person walking to and fro at constant speed.
double Place(double time_s) {
  return kSpeed * std::abs(std::remainder(time_s, 8.0));
}

struct Recording {
  double rate_hz = 25.0;
  int frames = 100;
  int64_t first_frame = 0;
  double start_s = 0.0;    // time of the first frame
  double digits_s = 1e-9;  // times are rounded to multiples of this
  double late_s = 0.0;     // positions lag by this much
};

TrackSequence Walk(const Recording& recording) {
  TrackSequence tracks = Tracks({});
  tracks.header.frame_rate_hz = recording.rate_hz;
  for (int k = 0; k < recording.frames; ++k) {
    const double time_s = recording.start_s + k / recording.rate_hz;
    const double stated_s =
        std::round(time_s / recording.digits_s) * recording.digits_s;
    tracks.frames.push_back(
        {recording.first_frame + k,
         FromSeconds(stated_s),
         {Person(0, StandingTum14(Place(time_s - recording.late_s)))}});
  }
  return tracks;
}

TrackSequence WithoutTimes(TrackSequence tracks) {
  tracks.header.frame_rate_hz = 0.0;
  for (TrackFrame& frame : tracks.frames) frame.time = 0;
  return tracks;
}

int64_t CountPaired(const FramePairing& pairing) {
  int64_t count = 0;
  for (const FramePair& pair : pairing.pairs) {
    count += pair.truth != nullptr && pair.tracks != nullptr ? 1 : 0;
  }
  return count;
}

TEST(PairFramesTest, OneClockPairsEqualNumbersWithoutNotes) {
  TrackSequence truth = Walk({});
  TrackSequence tracks = truth;
  tracks.frames.erase(tracks.frames.begin() + 10);
  truth.frames.erase(truth.frames.begin() + 20);
  for (const bool has_times : {true, false}) {
    if (!has_times) tracks = WithoutTimes(tracks);
    const FramePairing pairing = PairFrames(truth, tracks);
    EXPECT_EQ(pairing.is_by_time, has_times);
    ASSERT_EQ(pairing.pairs.size(), 100u);
    for (int64_t k = 0; k < 100; ++k) {
      const FramePair& pair = pairing.pairs[static_cast<size_t>(k)];
      EXPECT_EQ(pair.frame, k);
      EXPECT_EQ(pair.truth, FindFrame(truth, k));
      EXPECT_EQ(pair.tracks, FindFrame(tracks, k));
    }
    EXPECT_EQ(pairing.truth_frames, 99);
    EXPECT_THAT(pairing.notes, IsEmpty());
    EXPECT_EQ(PairFrames(truth, tracks, {{5, 8}}).pairs.size(), 3u);
  }
}

// For each of these measures and ratios of rates: people are compared at equal
// times only, and frames between the common instants are not misses.
TEST(PairFramesTest, MeasuresDoNotDependOnFrameRates) {
  struct Rates {
    double truth_hz;
    double tracks_hz;
    double common_hz;
  };
  for (const Rates& rates :
       {Rates{50, 25, 25}, Rates{25, 50, 25}, Rates{100, 30, 10},
        Rates{24, 60, 12}, Rates{29.97, 59.94, 29.97}}) {
    SCOPED_TRACE(rates.truth_hz);
    const double instants = std::floor(8.0 * rates.common_hz);
    const auto of = [&](double rate_hz) {
      return Walk({rate_hz, static_cast<int>(std::lround(instants * rate_hz /
                                                         rates.common_hz))});
    };
    const TrackSequence truth = of(rates.truth_hz);
    const TrackSequence tracks = of(rates.tracks_hz);
    const FramePairing pairing = PairFrames(truth, tracks);
    EXPECT_EQ(static_cast<double>(CountPaired(pairing)), instants);
    ASSERT_EQ(pairing.notes.size(), 1u);
    EXPECT_THAT(pairing.notes[0], HasSubstr("paired by time"));

    const MpjpeResult mpjpe = EvaluateMpjpe(truth, tracks);
    // Times are whole nanoseconds.
    EXPECT_LT(mpjpe.raw_m, 1e-6);
    EXPECT_EQ(mpjpe.found.count, mpjpe.found.total);
    const IdentityResult identity = EvaluateIdentity(truth, tracks);
    EXPECT_EQ(identity.Mota(), 1.0);
    EXPECT_EQ(identity.Idf1(), 1.0);
    const ParityResult parity = EvaluateParity(truth, tracks);
    EXPECT_EQ(parity.near.count, parity.near.total);
    EXPECT_EQ(parity.paired_person_frames, CountPaired(pairing));
    const Share covered = EvaluateCoverage(truth, tracks);
    EXPECT_EQ(covered.count, covered.total);
    PcpProtocol protocol = ShelfProtocol();
    protocol.frames.clear();
    const Share parts =
        PooledParts(EvaluatePcp(truth, tracks, protocol), PcpGroup::kTotal);
    EXPECT_EQ(parts.count, parts.total);
    EXPECT_EQ(parts.total, 10 * CountPaired(pairing));
    EXPECT_LT(EvaluatePanoptic(truth, tracks).mpjpe_m, 1e-6);
  }
}

TEST(PairFramesTest, AMissingFrameIsAMissAtDifferentRates) {
  const TrackSequence truth = Walk({50.0, 200});
  TrackSequence tracks = Walk({25.0, 100});
  tracks.frames.erase(tracks.frames.begin() + 10, tracks.frames.begin() + 30);
  tracks.frames.resize(70);  // the last ten, too
  const IdentityResult identity = EvaluateIdentity(truth, tracks);
  EXPECT_EQ(identity.true_person_frames, 100);
  EXPECT_EQ(identity.misses, 30);
}

TEST(PairFramesTest, LagIsFoundAtDifferentRates) {
  for (const auto& [truth_hz, tracks_hz] :
       {std::pair{50.0, 25.0}, {25.0, 50.0}, {100.0, 25.0}}) {
    TrackSequence truth = Walk({truth_hz, static_cast<int>(16 * truth_hz)});
    TrackSequence tracks =
        Walk({tracks_hz, static_cast<int>(16 * tracks_hz), 0, 0.0, 1e-9, 0.12});
    const auto lag_s = EstimateLag(truth, tracks, tracks_hz);
    ASSERT_TRUE(lag_s.has_value());
    // A parabola through samples 20 or 40 ms apart.
    EXPECT_NEAR(*lag_s, 0.12, 0.01);
  }
}

TEST(PairFramesTest, ErrorNamesRatesWithoutACommonInstant) {
  const TrackSequence truth = Walk({25.0, 100, 0, 0.004});
  const TrackSequence tracks = Walk({50.0, 200});
  for (int turn = 0; turn < 2; ++turn) {
    try {
      PairFrames(turn == 0 ? truth : tracks, turn == 0 ? tracks : truth);
      ADD_FAILURE() << "not refused";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("25 Hz"));
      EXPECT_THAT(error.what(), HasSubstr("50 Hz"));
    }
  }
  EXPECT_THROW(EvaluateMpjpe(truth, tracks), InputError);
  // The same holds for recordings that do not overlap.
  EXPECT_THROW(PairFrames(truth, Walk({50.0, 200, 5000, 100.0})), InputError);
}

TEST(PairFramesTest, TimesInMillisecondsAreTheSameInstants) {
  const TrackSequence truth = Walk({90.0, 360, 0, 0.0, 1e-3});
  const TrackSequence tracks = Walk({30.0, 120, 0, 0.0, 1e-3});
  EXPECT_EQ(CountPaired(PairFrames(truth, tracks)), 120);
}

TEST(PairFramesTest, FrameNumbersMayBeginDifferently) {
  // Some programs count frames from one, or cut a recording and renumber the
  // remaining frames.
  for (const int64_t first_frame : {1, 50}) {
    const TrackSequence truth = Walk({25.0, 100, first_frame});
    const TrackSequence tracks = Walk({});
    const FramePairing pairing = PairFrames(truth, tracks);
    // Times that begin at zero at frame 50 are those of a part cut from a
    // recording: its position follows from the numbers.
    const int64_t shift = first_frame == 1 ? 0 : 50;
    EXPECT_EQ(CountPaired(pairing), 100 - shift);
    for (const FramePair& pair : pairing.pairs) {
      if (pair.truth == nullptr) continue;
      EXPECT_EQ(pair.frame, pair.truth->frame - first_frame + shift);
    }
    EXPECT_EQ(pairing.notes.size(), first_frame == 1 ? 1u : 0u);
  }
  const FramePairing cut = PairFrames(Walk({25.0, 50, 0, 1.0}), Walk({}));
  EXPECT_EQ(CountPaired(cut), 50);
  ASSERT_EQ(cut.notes.size(), 1u);
  EXPECT_THAT(cut.notes[0],
              HasSubstr("frame 25 of the tracks has the time of frame 0"));
}

TEST(PairFramesTest, JitteringClocksPairByTheNearestTime) {
  TrackSequence tracks = Walk({});
  for (size_t k = 0; k < tracks.frames.size(); ++k) {
    tracks.frames[k].time += (k % 3 == 0 ? -1 : 1) * 7'000'000;  // 7 of 40 ms
  }
  const FramePairing pairing = PairFrames(Walk({}), tracks);
  EXPECT_EQ(CountPaired(pairing), 100);
  EXPECT_THAT(pairing.notes, IsEmpty());
  for (TrackFrame& frame : tracks.frames) frame.time += 5'000'000;
  const FramePairing late = PairFrames(Walk({}), tracks);
  ASSERT_EQ(late.notes.size(), 1u);
  EXPECT_THAT(late.notes[0], HasSubstr("by up to 12 ms"));
}

// 30000/1001 and 30 Hz are half a frame apart after 500 frames.
TEST(PairFramesTest, RatesThatDifferByRoundingPairByNumber) {
  const TrackSequence truth = Walk({30.0, 1800});
  const TrackSequence tracks = Walk({30000.0 / 1001.0, 1800});
  const FramePairing pairing = PairFrames(truth, tracks);
  ASSERT_EQ(pairing.pairs.size(), 1800u);
  for (const FramePair& pair : pairing.pairs) {
    ASSERT_NE(pair.truth, nullptr);
    ASSERT_NE(pair.tracks, nullptr);
    EXPECT_EQ(pair.truth->frame, pair.tracks->frame);
  }
  ASSERT_EQ(pairing.notes.size(), 1u);
  EXPECT_THAT(pairing.notes[0], AllOf(HasSubstr("30 Hz"), HasSubstr("29.97 Hz"),
                                      HasSubstr("paired by number")));
}

// With a pause that the numbers do not contain, frames are paired by time.
TEST(PairFramesTest, PausesArePairedByTime) {
  TrackSequence tracks = Walk({25.0, 60});
  for (size_t k = 30; k < tracks.frames.size(); ++k) {
    tracks.frames[k].time += FromSeconds(10 / 25.0);
  }
  const TrackSequence truth = Walk({25.0, 100});
  const FramePairing pairing = PairFrames(truth, tracks);
  for (const FramePair& pair : pairing.pairs) {
    if (pair.truth == nullptr || pair.tracks == nullptr) continue;
    EXPECT_EQ(pair.truth->time, pair.tracks->time);
  }
  EXPECT_EQ(CountPaired(pairing), 60);
}

TEST(PairFramesTest, ContradictingTimesAndNumbersAreNoted) {
  // Without times only the lengths in frames, 200 and 100, hint at different
  // rates.
  EXPECT_THAT(PairFrames(WithoutTimes(Walk({50.0, 200})), Walk({})).notes,
              ElementsAre(HasSubstr("no times of the ground truth")));
  EXPECT_THAT(PairFrames(Walk({}), WithoutTimes(Walk({50.0, 200}))).notes,
              ElementsAre(HasSubstr("no times of the tracks")));
  // A consistent part of a recording gives no note.
  EXPECT_THAT(
      PairFrames(WithoutTimes(Walk({25.0, 50, 25, 1.0})), Walk({})).notes,
      IsEmpty());
  // The same images, with a wrong rate in one of the files.
  EXPECT_THAT(PairFrames(Walk({50.0, 100}), Walk({})).notes,
              ElementsAre(HasSubstr("both have frames 0 to 99")));
  TrackSequence stated = Walk({50.0, 200});
  stated.header.frame_rate_hz = 25.0;
  EXPECT_THAT(
      PairFrames(stated, Walk({})).notes,
      ElementsAre(HasSubstr("states 25 Hz, but its times are those of 50"),
                  HasSubstr("100 of 200 true frames")));
  TrackSequence back = Walk({});
  back.frames[50].time = 0;
  const FramePairing pairing = PairFrames(Walk({}), back);
  EXPECT_FALSE(pairing.is_by_time);
  EXPECT_THAT(pairing.notes, ElementsAre(HasSubstr("do not always increase")));
  // No time in common, as with times since 1970.
  const FramePairing epoch = PairFrames(Walk({}), Walk({25.0, 100, 0, 1e9}));
  EXPECT_FALSE(epoch.is_by_time);
  EXPECT_EQ(CountPaired(epoch), 100);
  EXPECT_THAT(epoch.notes, ElementsAre(HasSubstr("no time in common")));
}

TEST(PairFramesTest, EmptyRecordingsPairNothingAndSingleFramesPair) {
  EXPECT_TRUE(PairFrames(Tracks({}), Tracks({})).pairs.empty());
  EXPECT_EQ(PairFrames(Walk({}), Tracks({})).truth_frames, 100);
  EXPECT_EQ(CountPaired(PairFrames(Walk({25.0, 1}), Walk({25.0, 1}))), 1);
}

TEST(NumberFramesLikeTest, KeepsOnlyTheInstantsOfTheReference) {
  const TrackSequence lead = Walk({25.0, 100, 7, 0.28});
  TrackSequence other = Walk({50.0, 250});
  const auto notes = NumberFramesLike(lead, {"b", "a"}, &other);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("b has 50 Hz, a 25 Hz")));
  ASSERT_EQ(other.frames.size(), 125u);
  for (const TrackFrame& frame : other.frames) {
    EXPECT_EQ(frame.time, FromSeconds(frame.frame / 25.0));
  }
  TrackSequence same = lead;
  EXPECT_THAT(NumberFramesLike(lead, {}, &same), IsEmpty());
  EXPECT_EQ(same.frames.size(), lead.frames.size());
  EXPECT_EQ(same.frames[3].frame, lead.frames[3].frame);
}

}  // namespace
}  // namespace kinegraph::testing
