#include "core/tracking/second_pass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <set>
#include <vector>

#include "core/base/random.h"
#include "core/tracking/estimator.h"
#include "solvers/filters/causal_gaussian.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

constexpr double kRateHz = 25.0;

TimeNs TimeOf(int64_t frame) { return FrameClock(kRateHz).TimeOf(frame); }

class SecondPassTest : public ::testing::Test {
 protected:
  SecondPass Make() const {
    return SecondPass(scene_, Coco17(), TrackerOptions(),
                      [](const SceneModel& scene) {
                        CausalGaussianOptions options;
                        options.smooth = false;
                        return MakeCausalGaussian(scene, options);
                      });
  }

  DetectionFrame See(int frame) const {
    return testing::FrameSeenBy(scene_.cameras, frame, people_);
  }

  // A possible result of the first pass: each joint is some centimetres off.
  TrackFrame FirstPass(int frame) {
    TrackFrame written;
    written.frame = frame;
    written.time = TimeOf(frame);
    for (size_t p = 0; p < people_.size(); ++p) {
      PersonPose& person = written.people.emplace_back();
      person.id = TrackId(static_cast<int64_t>(10 + p));
      person.joints = people_[p];
      for (Joint3d& joint : person.joints) {
        joint.position_m +=
            0.03 * Eigen::Vector3d(random_.Normal(), random_.Normal(),
                                   random_.Normal());
      }
    }
    return written;
  }

  SceneModel scene_ = {testing::RingOfCameras(4), Coco17(), kRateHz,
                       KeptMatches::kDetections};
  std::vector<Pose3d> people_ = {testing::StandingPerson(-0.8, 0.0),
                                 testing::StandingPerson(0.9, 0.4)};
  Random random_{3};
};

TEST_F(SecondPassTest, EstimatesAgainAndKeepsIdentities) {
  SecondPass pass = Make();
  for (int f = 5; f < 9; ++f) pass.Process(See(f), FirstPass(f));
  const std::vector<TrackFrame> frames = pass.Finish(2);
  ASSERT_EQ(frames.size(), 4u);
  for (size_t f = 0; f < frames.size(); ++f) {
    EXPECT_EQ(frames[f].frame, 5 + static_cast<int64_t>(f));
    ASSERT_EQ(frames[f].people.size(), 2u);
    for (size_t p = 0; p < 2; ++p) {
      EXPECT_EQ(frames[f].people[p].id, TrackId(static_cast<int64_t>(10 + p)));
      for (int j = 0; j < 17; ++j) {
        EXPECT_LT((frames[f].people[p].joints[j].position_m -
                   people_[p][j].position_m)
                      .norm(),
                  1e-9)
            << "triangulated again";
      }
    }
  }
}

TEST_F(SecondPassTest, UnobservedPeopleKeepThePoseOfTheFirstPass) {
  SecondPass pass = Make();
  DetectionFrame blind = See(5);
  for (ViewDetections& view : blind.views) view.detections.clear();
  const TrackFrame first = FirstPass(5);
  pass.Process(blind, first);
  pass.Process(See(6), {6, TimeOf(6), {}});
  const std::vector<TrackFrame> frames = pass.Finish(1);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_TRUE(frames[1].people.empty());
  ASSERT_EQ(frames[0].people.size(), 2u);
  EXPECT_EQ(frames[0].people[0].joints[3].position_m,
            first.people[0].joints[3].position_m);
}

// Finds no joints in frames before `from`; from then on, returns the initial
// poses, without joint `but`.
class LateEstimator final : public Estimator {
 public:
  explicit LateEstimator(int64_t from, int but = -1) : from_(from), but_(but) {}
  void Add(const EstimatorFrame& frame) override {
    FinalPose& pose = finals_.emplace_back();
    pose.frame = frame.frame;
    if (frame.frame < from_) return;
    pose.person.joints = frame.initial;
    pose.person.covariances.assign(frame.initial.size(),
                                   Eigen::Matrix3d::Identity());
    if (but_ < 0) return;
    const auto but = static_cast<size_t>(but_);
    pose.person.joints[but] = Joint3d();
    pose.person.covariances[but].reset();
  }
  const Pose3d& Last() const override { return none_; }
  TimeNs LastTime() const override { return 0; }
  void Predict(TimeNs, Pose3d* pose) const override { pose->clear(); }
  void ExtractFinals(std::vector<FinalPose>* finals) override {
    MoveFinals(&finals_, finals);
  }
  void Finish() override {}

 private:
  const int64_t from_;
  const int but_;
  const Pose3d none_;
  std::vector<FinalPose> finals_;
};

TEST_F(SecondPassTest, FirstPassIsKeptCompletelyWhereNobodyIsFound) {
  SecondPass pass(scene_, Coco17(), TrackerOptions(), [](const SceneModel&) {
    return std::make_unique<LateEstimator>(6);
  });
  TrackFrame first = FirstPass(5);
  for (PersonPose& person : first.people) {
    person.score = 0.7;
    person.inlier_views.assign(17, 3);
    person.covariances.assign(17, Eigen::Matrix3d::Identity());
    person.matches.push_back({2, static_cast<int>(person.id.value()), {}});
  }
  pass.Process(See(5), first);
  first.frame = 6;
  pass.Process(See(6), first);
  const std::vector<TrackFrame> frames = pass.Finish(1);
  ASSERT_EQ(frames[0].people.size(), 2u);
  for (size_t p = 0; p < 2; ++p) {
    const PersonPose& kept = frames[0].people[p];
    EXPECT_EQ(kept.joints[3].position_m, first.people[p].joints[3].position_m);
    EXPECT_EQ(kept.score, 0.7);
    EXPECT_EQ(kept.inlier_views, first.people[p].inlier_views);
    EXPECT_EQ(kept.covariances, first.people[p].covariances);
    ASSERT_EQ(kept.matches.size(), 1u);
    EXPECT_EQ(kept.matches[0].detection_idx, 10 + static_cast<int>(p));
    EXPECT_TRUE(frames[1].people[p].matches.empty()) << "estimated again";
  }
}

TEST_F(SecondPassTest, JointsWithoutAnEstimateAreOfTheFirstPass) {
  SecondPass pass(scene_, Coco17(), TrackerOptions(), [](const SceneModel&) {
    return std::make_unique<LateEstimator>(5, /*but=*/3);
  });
  TrackFrame first = FirstPass(5);
  const Eigen::Matrix3d covariance = 4.0 * Eigen::Matrix3d::Identity();
  for (PersonPose& person : first.people) {
    person.covariances.assign(17, covariance);
  }
  pass.Process(See(5), first);
  const std::vector<TrackFrame> frames = pass.Finish(1);
  ASSERT_EQ(frames[0].people.size(), 2u);
  for (size_t p = 0; p < 2; ++p) {
    const PersonPose& person = frames[0].people[p];
    EXPECT_EQ(person.joints[3].position_m,
              first.people[p].joints[3].position_m);
    EXPECT_EQ(person.joints[3].status, JointStatus::kInferred);
    EXPECT_EQ(person.covariances[3], covariance);
    EXPECT_EQ(person.covariances[4], Eigen::Matrix3d::Identity().eval());
    EXPECT_NE(person.joints[4].position_m, first.people[p].joints[4].position_m)
        << "estimated again";
  }
}

// One of two people is tracked in some frames only and seen in more.
class ExtendEndsTest : public SecondPassTest {
 protected:
  static constexpr int kFrames = 20;
  static constexpr int64_t kOther = 11;

  // The frames in which the second person is written. The first pass has this
  // person in the frames `tracked`; the first views_[f] views see the person in
  // frame f. Tracks of the people in `but` are not extended.
  std::vector<int> Run(const std::vector<int>& tracked,
                       const std::set<TrackId>& but = {}) {
    SecondPass pass = Make();
    std::vector<TrackFrame> first_pass;
    for (int f = 0; f < kFrames; ++f) {
      first_pass.push_back(FirstPass(f));
      if (!std::count(tracked.begin(), tracked.end(), f)) {
        first_pass.back().people.pop_back();
      }
    }
    pass.ExtendEnds(first_pass, but);
    for (int f = 0; f < kFrames; ++f) {
      DetectionFrame seen = See(f);
      for (size_t v = views_[f]; v < seen.views.size(); ++v) {
        seen.views[v].detections.pop_back();
      }
      pass.Process(seen, first_pass[static_cast<size_t>(f)]);
    }
    std::vector<int> frames;
    for (const TrackFrame& frame : pass.Finish(1)) {
      EXPECT_EQ(frame.people.front().id, TrackId(kOther - 1));
      for (const PersonPose& person : frame.people) {
        if (person.id != TrackId(kOther)) continue;
        frames.push_back(static_cast<int>(frame.frame));
        EXPECT_LT(
            (person.joints[5].position_m - people_[1][5].position_m).norm(),
            0.1);
      }
    }
    return frames;
  }

  static std::vector<int> From(int begin, int end) {
    std::vector<int> frames(static_cast<size_t>(end - begin));
    std::iota(frames.begin(), frames.end(), begin);
    return frames;
  }

  std::vector<size_t> views_ = std::vector<size_t>(kFrames, 4);
};

TEST_F(ExtendEndsTest, ExtendsTracksBeyondBothEnds) {
  EXPECT_EQ(Run(From(8, 12)), From(0, kFrames));
  // A gap in one person's track is closed.
  std::vector<int> with_gap = From(0, 5);
  for (int f = 9; f < kFrames; ++f) with_gap.push_back(f);
  EXPECT_EQ(Run(with_gap), From(0, kFrames));
}

TEST_F(ExtendEndsTest, BridgesOnlyShortGapsWithoutAgreeingViews) {
  // No view sees the person in frame 2 and from frame 15 on, and only one view
  // does in frames 5 and 6. The gaps at 2, 5 and 6 are bridged.
  for (const int f : {2, 15, 16, 17, 18, 19}) views_[f] = 0;
  for (const int f : {5, 6}) views_[f] = 1;
  EXPECT_EQ(Run(From(8, 12)), From(0, 15));
  // After a gap longer than the life of a lost track (10 frames), the
  // detections may be of another person.
  for (int f = 0; f < kFrames; ++f) views_[f] = f < 3 || f > 13 ? 4 : 0;
  views_[14] = 4;
  EXPECT_EQ(Run(From(14, 17)), From(14, kFrames));
}

// The limit is 0.3 m: two people do not stay that close for long.
TEST_F(ExtendEndsTest, StopsWhereAnotherPersonStands) {
  people_[1] = testing::StandingPerson(-0.8 + 0.27, 0.0);
  EXPECT_EQ(Run(From(8, 12)), From(8, 12));
  people_[1] = testing::StandingPerson(-0.8 + 0.33, 0.0);
  EXPECT_EQ(Run(From(8, 12)), From(0, kFrames));
}

TEST_F(ExtendEndsTest, DoesNotExtendExcludedPeople) {
  EXPECT_EQ(Run(From(8, 12), {TrackId(kOther)}), From(8, 12));
}

TEST(FindRunsTest, RunsEndWhereAFrameLacksThePerson) {
  // Person 0 walks at 1 m/s and is missing in frame 4; person 1 has a single
  // frame.
  std::vector<TrackFrame> frames;
  for (int64_t f = 0; f < 10; ++f) {
    TrackFrame& frame = frames.emplace_back();
    frame.frame = f;
    frame.time = TimeOf(f);
    const auto add = [&](int64_t id, double x_m) {
      PersonPose& person = frame.people.emplace_back();
      person.id = TrackId(id);
      person.joints = testing::StandingPerson(x_m, 0.0);
    };
    if (f != 4) add(0, 0.04 * static_cast<double>(f));
    if (f == 7) add(1, 3.0);
  }
  const auto runs = FindRuns(frames);
  ASSERT_EQ(runs.at(TrackId(0)).size(), 2u);
  const TrackRun& first = runs.at(TrackId(0))[0];
  EXPECT_EQ(first.first, 0);
  EXPECT_EQ(first.last, 3);
  EXPECT_NEAR(first.first_velocity_mps.x(), 1.0, 1e-9);
  EXPECT_NEAR(first.last_velocity_mps.x(), 1.0, 1e-9);
  EXPECT_EQ(runs.at(TrackId(0))[1].first, 5);
  EXPECT_EQ(runs.at(TrackId(0))[1].last, 9);
  ASSERT_EQ(runs.at(TrackId(1)).size(), 1u);
  EXPECT_EQ(runs.at(TrackId(1))[0].last_velocity_mps.norm(), 0.0);
}

TEST(EndFollowerTest, ExtrapolatesWithFadingVelocityInBothDirections) {
  const Pose3d pose = testing::StandingPerson(0.0, 0.0);
  const EndFollower follower(pose, TimeOf(50), {1.0, 0.0, 0.0});
  const auto moved_m = [&](int64_t frame) {
    return follower.At(TimeOf(frame))[0].position_m.x() -
           pose[0].position_m.x();
  };
  // At 1 m/s, the path after t is 0.5 m (1 - exp(-t / 0.5 s)): never more than
  // 0.5 m.
  EXPECT_NEAR(moved_m(51), 0.5 * (1.0 - std::exp(-0.08)), 1e-9);
  EXPECT_NEAR(moved_m(49), -moved_m(51), 1e-12);
  EXPECT_NEAR(moved_m(5000), 0.5, 1e-9);
}

TEST(EndFollowerTest, LearnsFromAgreeingViews) {
  EndFollower follower(testing::StandingPerson(0.0, 0.0), TimeOf(0),
                       Eigen::Vector3d::Zero());
  for (int64_t f = 1; f <= 20; ++f) {
    follower.Agree(testing::StandingPerson(0.04 * static_cast<double>(f), 0.0),
                   TimeOf(f));
  }
  EXPECT_EQ(follower.agreed(), TimeOf(20));
  // The velocity is 1 m/s with a relative error of 0.7^20, and decays during
  // the frame.
  const double step_m = follower.At(TimeOf(21))[0].position_m.x() -
                        testing::StandingPerson(0.8, 0.0)[0].position_m.x();
  EXPECT_NEAR(step_m, 0.5 * (1.0 - std::exp(-0.08)), 1e-4);
}

}  // namespace
}  // namespace kinegraph
