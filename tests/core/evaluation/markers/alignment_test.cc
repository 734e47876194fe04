#include "core/evaluation/markers/alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/error.h"
#include "tests/core/evaluation/markers/moving_person.h"

namespace kinegraph::testing {
namespace {

using ::testing::HasSubstr;

const std::vector<bool> kAll(14, true);

void Move(const Eigen::Isometry3d& motion, TrackSequence* tracks) {
  for (TrackFrame& frame : tracks->frames) {
    for (Joint3d& joint : frame.people.front().joints) {
      joint.position_m = motion * joint.position_m;
    }
  }
}

Eigen::Isometry3d Turned(double deg, const Eigen::Vector3d& axis) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() =
      Eigen::AngleAxisd(deg * 3.14159265358979 / 180.0, axis.normalized())
          .toRotationMatrix();
  motion.translation() = Eigen::Vector3d(1.0, -2.0, 0.3);
  return motion;
}

Alignment Aligned(const TrackSequence& truth, const TrackSequence& tracks,
                  Align align = Align::kBoth, bool with_drift = false) {
  return AlignRecordings(truth, kAll, tracks, {align, with_drift, {}});
}

std::string ErrorOf(const TrackSequence& truth, const TrackSequence& tracks,
                    Align align = Align::kBoth) {
  try {
    Aligned(truth, tracks, align);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

double Same(double t) { return t; }

// Two frame rates, a clock with an offset of 137 ms and a drift of 100 ppm, and
// gaps in a fifth of the frames of each joint.
TEST(Alignment, FindsClockAndDriftAcrossRatesAndGaps) {
  TrackSequence truth = Recorded(200.0, 60.0, Same);
  TrackSequence tracks = Recorded(
      60.0, 59.0, [](double t) { return t + 0.137 + 100e-6 * (t - 29.5); });
  LeaveOut(0.2, &truth);
  LeaveOut(0.2, &tracks);
  const Alignment found = Aligned(truth, tracks, Align::kBoth, true);
  // The tolerances bound interpolation errors: 0.2 ms is about one per cent of
  // a frame at 60 Hz.
  EXPECT_NEAR(found.clock.offset_s, 0.137, 2e-4);
  EXPECT_NEAR(found.clock.drift, 100e-6, 10e-6);
  EXPECT_LT(found.median_both_m, 5e-4);
  const Alignment without = Aligned(truth, tracks);
  // The neglected drift shifts the clock by up to 3 ms at the ends, by 0 in the
  // middle.
  EXPECT_NEAR(without.clock.offset_s, 0.137, 2e-3);
  EXPECT_EQ(without.clock.drift, 0.0);
}

TEST(Alignment, FindsRotationAboutAnyAxis) {
  const TrackSequence truth = Recorded(100.0, 5.0, Same);
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0),
        Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, -2, 0.5)}) {
    TrackSequence tracks = truth;
    const Eigen::Isometry3d motion = Turned(40.0, axis);
    Move(motion, &tracks);
    const Alignment found = Aligned(truth, tracks);
    EXPECT_NEAR(found.world.rotation_deg(), 40.0, 1e-6);
    EXPECT_TRUE((found.world.truth_from_tracks * motion)
                    .isApprox(Eigen::Isometry3d::Identity(), 1e-6));
    EXPECT_NEAR(found.clock.offset_s, 0.0, 1e-6);
    EXPECT_GT(found.median_none_m, 0.5);
    EXPECT_LT(found.median_both_m, 1e-6);
  }
}

TEST(Alignment, AlignsOnlyWhatIsSelected) {
  const TrackSequence truth = Recorded(100.0, 5.0, Same);
  TrackSequence tracks = Recorded(100.0, 5.0, [](double t) { return t + 0.1; });
  Move(Turned(10.0, {0, 0, 1}), &tracks);
  const Alignment none = Aligned(truth, tracks, Align::kNone);
  EXPECT_EQ(none.clock.offset_s, 0.0);
  EXPECT_EQ(none.world.rotation_deg(), 0.0);
  EXPECT_LT(none.median_both_m, 1e-3);  // reported, not removed
  const Alignment clock = Aligned(truth, tracks, Align::kClock);
  EXPECT_NEAR(clock.clock.offset_s, 0.1, 1e-4);
  EXPECT_EQ(clock.world.rotation_deg(), 0.0);
}

// Missing joints must not reduce the correlation.
TEST(Alignment, OneJointSufficesForTheClock) {
  const TrackSequence truth = Recorded(100.0, 5.0, Same);
  TrackSequence tracks =
      Recorded(60.0, 4.0, [](double t) { return t + 0.137; });
  for (TrackFrame& frame : tracks.frames) {
    Pose3d& joints = frame.people.front().joints;
    for (size_t j = 0; j < joints.size(); ++j) {
      if (j != 6) joints[j] = Joint3d{};
    }
  }
  const Alignment clock = Aligned(truth, tracks, Align::kClock);
  // Interpolation of the truth is accurate to a tenth of a millimetre: 0.1 ms
  // at speeds of about 1 m/s.
  EXPECT_NEAR(clock.clock.offset_s, 0.137, 5e-4);
}

TEST(Alignment, ErrorsNameTheCause) {
  const TrackSequence truth = Recorded(100.0, 5.0, Same);
  TrackSequence still = Recorded(100.0, 5.0, [](double) { return 1.0; });
  EXPECT_THAT(ErrorOf(truth, still), HasSubstr("no motion to align"));
  TrackSequence other = truth;
  std::vector<std::string> names;
  for (int j = 0; j < 14; ++j) names.push_back("p" + std::to_string(j));
  other.header.skeleton = Skeleton("other", names, {});
  EXPECT_EQ(ErrorOf(truth, other), "has no joint in common with the tracks");
  TrackSequence later = truth;
  for (TrackFrame& frame : later.frames) frame.time += FromSeconds(100.0);
  EXPECT_THAT(ErrorOf(truth, later, Align::kNone),
              HasSubstr("times do not overlap"));
  EXPECT_EQ(ErrorOf(truth, later), "");
  TrackSequence large = truth;
  for (TrackFrame& frame : large.frames) {
    for (Joint3d& joint : frame.people.front().joints) {
      joint.position_m *= 1000.0;
    }
  }
  EXPECT_THAT(ErrorOf(truth, large), HasSubstr("units differ"));
  EXPECT_THAT(ErrorOf(truth, large), HasSubstr("1000 times"));
  TrackSequence mirrored = truth;
  for (TrackFrame& frame : mirrored.frames) {
    for (Joint3d& joint : frame.people.front().joints) {
      joint.position_m.x() = -joint.position_m.x();
    }
  }
  for (const Align align :
       {Align::kBoth, Align::kWorld, Align::kClock, Align::kNone}) {
    EXPECT_THAT(ErrorOf(truth, mirrored, align), HasSubstr("mirrored axes"));
  }
  TrackSequence one = truth;
  for (TrackFrame& frame : one.frames) {
    Pose3d& joints = frame.people.front().joints;
    for (size_t j = 0; j < joints.size(); ++j) {
      if (j != 6) joints[j] = Joint3d{};
      joints[j].position_m *= 0.1;
    }
  }
  EXPECT_THAT(ErrorOf(one, one, Align::kWorld),
              HasSubstr("too small a body to register"));
}

TEST(Alignment, ChoosesThePersonWithTheSameMotion) {
  const TrackSequence truth = Recorded(100.0, 5.0, Same);
  TrackSequence tracks = Recorded(100.0, 5.0, [](double t) { return t + 9.0; });
  for (size_t f = 0; f < tracks.frames.size(); ++f) {
    PersonPose other = truth.frames[f].people.front();
    other.id = TrackId(5);
    tracks.frames[f].people.push_back(std::move(other));
  }
  const Alignment found = AlignRecordings(truth, kAll, tracks, {});
  EXPECT_EQ(found.person, TrackId(5));
  EXPECT_THROW(
      AlignRecordings(truth, kAll, tracks, {Align::kBoth, false, TrackId(3)}),
      InputError);
}

}  // namespace
}  // namespace kinegraph::testing
