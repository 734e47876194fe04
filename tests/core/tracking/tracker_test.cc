#include "core/tracking/tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/tracking/association_policy.h"
#include "solvers/filters/causal_gaussian.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

constexpr double kFrameRate = 25.0;

class TrackerTest : public ::testing::Test {
 protected:
  // A person walking along y at 1 m/s, and one standing still.
  static Pose3d Walker(int frame) {
    return testing::StandingPerson(-0.8, -1.0 + frame / kFrameRate);
  }
  static Pose3d Stander() { return testing::StandingPerson(1.0, 0.2); }

  SceneModel Scene() const {
    return {cameras_, Coco17(), rate_hz_, KeptMatches::kDetections};
  }
  static std::unique_ptr<Estimator> Unsmoothed(const SceneModel& scene) {
    CausalGaussianOptions options;
    options.smooth = false;
    return MakeCausalGaussian(scene, options);
  }

  // A new tracker; clears frames_.
  std::unique_ptr<Tracker> Make(const TrackerOptions& options = {}) {
    frames_.clear();
    return std::make_unique<Tracker>(Scene(), Coco17(), options, Unsmoothed);
  }

  static TrackerOptions By(AssociationRules rules) {
    TrackerOptions options;
    options.rules = rules;
    options.association.alpha_2d_px_per_frame = 20.0;
    return options;
  }

  DetectionFrame See(int frame, const std::vector<Pose3d>& people) const {
    return testing::FrameSeenBy(cameras_, frame, people, rate_hz_);
  }

  // Passes the views of these people in frames begin .. end - 1.
  void Show(Tracker* tracker, int begin, int end,
            const std::vector<Pose3d>& people) {
    for (int f = begin; f < end; ++f) {
      tracker->Process(See(f, people), &frames_);
    }
  }

  CameraRig cameras_ = testing::RingOfCameras(5);
  double rate_hz_ = kFrameRate;
  std::vector<TrackFrame> frames_;
};

TEST_F(TrackerTest, ATrackSurvivesNineMissedFramesNotTen) {
  for (const int missed : {9, 10}) {
    const auto tracker = Make();
    Show(tracker.get(), 0, 5, {Stander()});
    Show(tracker.get(), 5, 5 + missed, {});
    Show(tracker.get(), 5 + missed, 6 + missed, {Stander()});
    EXPECT_EQ(tracker->people_so_far(), missed == 9 ? 1 : 2);
  }
}

TEST_F(TrackerTest, GapsLongerThanTheMaximumAgeEndEveryTrack) {
  // After missing frames, a track of age 10 may still be matched; an older
  // track may not, because its gate could cover the whole image.
  for (const int age : {10, 11, 200}) {
    const auto tracker = Make();
    Show(tracker.get(), 0, 5, {Stander()});
    const Pose3d elsewhere = testing::StandingPerson(-1.0, -0.8);
    tracker->Process(See(4 + age, {age == 10 ? Stander() : elsewhere}),
                     &frames_);
    tracker->Finish(&frames_);
    ASSERT_EQ(frames_.size(), 6u);
    EXPECT_EQ(tracker->people_so_far(), age == 10 ? 1 : 2) << "age " << age;
    EXPECT_EQ(frames_[4].people.size(), 1u);
    // A new person is not confirmed yet.
    EXPECT_EQ(frames_[5].people.size(), age == 10 ? 1u : 0u) << "age " << age;
  }
}

TEST_F(TrackerTest, AMatchedDetectionStartsNobodyEvenIfTheUpdateFails) {
  TrackerOptions options;
  options.reconstruction.alpha_epi_px = 2.0;
  // Two views that contradict each other by more than the threshold of updates
  // and less than that of initialisation.
  const auto contradiction = [&](int frame) {
    DetectionFrame seen = See(frame, {Stander()});
    for (size_t v = 2; v < seen.views.size(); ++v) {
      seen.views[v].detections.clear();
    }
    for (Keypoint& joint : seen.views[1].detections[0].joints) {
      joint.px.y() += 15.0;
    }
    return seen;
  };
  const auto nobody_known = Make(options);
  nobody_known->Process(contradiction(8), &frames_);
  EXPECT_EQ(nobody_known->people_so_far(), 1)
      << "the two views can start a track";

  const auto tracker = Make(options);
  Show(tracker.get(), 0, 5, {Stander()});
  Show(tracker.get(), 5, 8, {});
  tracker->Process(contradiction(8), &frames_);
  tracker->Finish(&frames_);
  EXPECT_TRUE(frames_[8].people.empty()) << "the update failed";
  EXPECT_EQ(tracker->people_so_far(), 1);
}

TEST_F(TrackerTest, OneViewSufficesWhileOlderViewsCount) {
  const auto tracker = Make();
  Show(tracker.get(), 0, 5, {Stander()});
  // Only one view sees the person in four frames: from the third on, older
  // views are too old and the update fails.
  for (int f = 5; f < 9; ++f) {
    DetectionFrame seen = See(f, {Stander()});
    for (size_t v = 1; v < seen.views.size(); ++v) {
      seen.views[v].detections.clear();
    }
    tracker->Process(seen, &frames_);
  }
  tracker->Finish(&frames_);
  EXPECT_EQ(tracker->people_so_far(), 1);
  // Ages 0..2 count: frames 5 and 6 still find older views.
  EXPECT_EQ(frames_[5].people.size(), 1u);
  EXPECT_EQ(frames_[6].people.size(), 1u);
  EXPECT_EQ(frames_[7].people.size(), 0u);
  for (const Joint3d& joint : frames_[5].people[0].joints) {
    EXPECT_EQ(joint.status, JointStatus::kInferred)
        << "kObserved requires two views of the frame";
  }
}

// A sprint start, 10 m/s^2 up to 7.6 m/s: at the end each frame is 0.3 m from
// the previous one and 0.05 m from the prediction by the mean velocity of five
// frame intervals; 20 px are 0.1 m at 5 m.
TEST_F(TrackerTest, RunnersArePredictedAhead) {
  for (const double prediction_s : {0.0, 0.2}) {
    TrackerOptions options;
    options.life.in_seconds = true;
    options.association.alpha_2d_px_per_frame = 20.0;
    options.association.prediction_s = prediction_s;
    const auto tracker = Make(options);
    for (int f = 0; f < 20; ++f) {
      const double time_s = f / kFrameRate;
      const Pose3d runner =
          testing::StandingPerson(-1.5 + 5.0 * time_s * time_s, 0.0);
      tracker->Process(See(f, {runner}), &frames_);
    }
    if (prediction_s > 0.0) {
      EXPECT_EQ(tracker->people_so_far(), 1);
    } else {
      EXPECT_GT(tracker->people_so_far(), 2);  // each lives for a frame or two
    }
  }
}

// A displacement of 0.15 m from one frame to the next is beyond the gate of the
// views from the side. The other views follow it; in graph mode no new person
// appears.
TEST_F(TrackerTest, ViewsThatLoseAPersonStartNoDuplicate) {
  for (const AssociationRules rules :
       {AssociationRules::kPaper, AssociationRules::kGraph}) {
    const auto tracker = Make(By(rules));
    Show(tracker.get(), 0, 5, {testing::StandingPerson(0.0, 0.0)});
    Show(tracker.get(), 5, 10, {testing::StandingPerson(0.15, 0.05)});
    EXPECT_EQ(tracker->people_so_far(),
              rules == AssociationRules::kPaper ? 2 : 1);
  }
}

// Five boxes at 4 Hz, 0.6 m apart, walk past each other at 1.2 m/s: in every
// view they pass in front of each other.
TEST_F(TrackerTest, BoxesAreFollowedThroughACrowd) {
  rate_hz_ = 4.0;
  constexpr int kPeople = 5;
  constexpr int kFrames = 13;
  const auto boxes = [](int frame) {
    std::vector<Pose3d> people;
    for (int k = 0; k < kPeople; ++k) {
      const double y_m = (k % 2 == 0 ? 0.3 : -0.3) * (frame - kFrames / 2);
      const double x_m = 0.6 * (k - kPeople / 2);
      people.push_back({{{x_m, y_m, 1.7}, JointStatus::kObserved},
                        {{x_m, y_m, 0.0}, JointStatus::kObserved}});
    }
    return people;
  };
  const Skeleton box("box", {"top", "bottom"}, {{0, 1}});
  TrackerOptions options;
  options.rules = AssociationRules::kGraph;
  options.life.in_seconds = true;
  options.life.backfill = true;
  options.gates.units = GateUnits::kMetres;
  Tracker tracker({cameras_, box, rate_hz_, KeptMatches::kDetections}, box,
                  options, Unsmoothed);
  for (int f = 0; f < kFrames; ++f) {
    tracker.Process(See(f, boxes(f)), &frames_);
  }
  tracker.Finish(&frames_);
  EXPECT_EQ(tracker.people_so_far(), kPeople);
  ASSERT_EQ(frames_.size(), static_cast<size_t>(kFrames));
  for (int f = 0; f < kFrames; ++f) {
    ASSERT_EQ(frames_[f].people.size(), static_cast<size_t>(kPeople));
    for (int k = 0; k < kPeople; ++k) {
      EXPECT_NEAR(frames_[f].people[k].joints[0].position_m.x(),
                  frames_[0].people[k].joints[0].position_m.x(), 0.1)
          << "frame " << f;
    }
  }
}

TEST(SeenAtOnePlaceTest, ComparesObservedJointsOnly) {
  const Pose3d here = testing::StandingPerson(0.0, 0.0);
  Pose3d there = testing::StandingPerson(0.19, 0.0);
  EXPECT_TRUE(SeenAtOnePlace(here, there, 0.2));
  EXPECT_FALSE(SeenAtOnePlace(here, there, 0.18));
  for (size_t j = 0; j < 8; ++j) there[j].position_m.z() += 2.0;
  EXPECT_TRUE(SeenAtOnePlace(here, there, 0.2));  // nine of 17
  there[8].position_m.z() += 2.0;
  EXPECT_FALSE(SeenAtOnePlace(here, there, 0.2));
  there = testing::StandingPerson(0.19, 0.0);
  for (size_t j = 3; j < there.size(); ++j) {
    there[j].status = JointStatus::kInferred;
    there[j].position_m.x() += 1.0;
  }
  EXPECT_TRUE(SeenAtOnePlace(here, there, 0.2));
  EXPECT_TRUE(SeenAtOnePlace(there, here, 0.2));
  there[2].status = JointStatus::kInferred;  // two joints are no body
  EXPECT_FALSE(SeenAtOnePlace(here, there, 0.2));
  const auto box = [](double x_m) {
    return Pose3d{{{x_m, 0.0, 1.7}, JointStatus::kObserved},
                  {{x_m, 0.0, 0.0}, JointStatus::kObserved}};
  };
  EXPECT_TRUE(SeenAtOnePlace(box(0.0), box(0.19), 0.2));
  EXPECT_FALSE(SeenAtOnePlace(box(0.0), box(0.21), 0.2));
}

// Keeps the detections of the first `views` views and adds `strays` copies to
// the first two views, moved by multiples of 60 px down in one and up in the
// other, so that no two agree.
DetectionFrame AmongStrays(DetectionFrame seen, size_t views, int strays) {
  for (size_t v = 0; v < seen.views.size(); ++v) {
    std::vector<Detection>& detections = seen.views[v].detections;
    for (int i = 1; v < 2 && i <= strays; ++i) {
      Detection stray = detections[0];
      stray.index_in_file = i;
      for (Keypoint& joint : stray.joints) {
        joint.px.y() += (v == 0 ? 60.0 : -60.0) * i;
      }
      detections.push_back(stray);
    }
    if (v >= views) detections.clear();
  }
  return seen;
}

// With six unmatched detections in each of two views, 0.05 * 6 * 6 = 1.8 pairs
// of them are expected to agree by chance. Three more cameras face the position
// and do not detect a person there, so the two views start no track; in paper
// mode they do.
TEST_F(TrackerTest, TwoOfFiveViewsAmongStraysStartNobody) {
  const auto count = [&](AssociationRules rules, size_t views, int strays) {
    TrackerOptions options;
    options.rules = rules;
    const auto tracker = Make(options);
    tracker->Process(AmongStrays(See(0, {Stander()}), views, strays), &frames_);
    return tracker->track_count();
  };
  EXPECT_EQ(count(AssociationRules::kGraph, 2, 0), 1u);
  EXPECT_EQ(count(AssociationRules::kGraph, 2, 5), 0u);
  EXPECT_EQ(count(AssociationRules::kGraph, 5, 5), 1u);
  EXPECT_EQ(count(AssociationRules::kPaper, 2, 5), 1u);
}

// Two views have six joints of a person in common, which start a track after a
// second; with ten joints one frame is sufficient. In paper mode six joints do
// not suffice in two seconds.
TEST_F(TrackerTest, PeopleWithFewJointsStartAfterASecond) {
  const auto people_after = [&](AssociationRules rules, int frames,
                                size_t joints) {
    const auto tracker = Make(By(rules));
    for (int f = 0; f < frames; ++f) {
      DetectionFrame seen = See(f, {Stander()});
      for (size_t v = 2; v < seen.views.size(); ++v) {
        seen.views[v].detections.clear();
      }
      std::vector<Keypoint>& few = seen.views[1].detections[0].joints;
      std::fill(few.begin() + static_cast<long>(joints), few.end(), Keypoint());
      tracker->Process(seen, &frames_);
    }
    return tracker->people_so_far();
  };
  EXPECT_EQ(people_after(AssociationRules::kGraph, 1, 10), 1);
  EXPECT_EQ(people_after(AssociationRules::kGraph, 20, 6), 0);
  EXPECT_EQ(people_after(AssociationRules::kGraph, 30, 6), 1);
  EXPECT_EQ(people_after(AssociationRules::kPaper, 50, 6), 0);
}

// Agreement for 0.4 s in each second does not accumulate.
TEST_F(TrackerTest, IntermittentFewJointsStartNobody) {
  const auto tracker = Make(By(AssociationRules::kGraph));
  for (int f = 0; f < 100; ++f) {
    DetectionFrame seen = See(f, {Stander()});
    for (size_t v = 2; v < seen.views.size(); ++v) {
      seen.views[v].detections.clear();
    }
    std::vector<Keypoint>& few = seen.views[1].detections[0].joints;
    std::fill(few.begin() + 6, few.end(), Keypoint());
    if (f % 25 >= 10) seen.views[1].detections.clear();
    tracker->Process(seen, &frames_);
  }
  EXPECT_EQ(tracker->people_so_far(), 0);
}

// The second of the two remaining views sees half of a person. This keeps the
// track alive, but not among strays, where the match may be chance: there two
// thirds of the joints must be seen by both views.
TEST_F(TrackerTest, HalfVisiblePersonAmongStraysIsLost) {
  const auto lives = [&](AssociationRules rules, size_t joints, int strays) {
    TrackerOptions options = By(rules);
    options.life.in_seconds = true;
    const auto tracker = Make(options);
    Show(tracker.get(), 0, 5, {Stander()});
    for (int f = 5; f < 20; ++f) {
      DetectionFrame seen = AmongStrays(See(f, {Stander()}), 2, strays);
      std::vector<Keypoint>& half = seen.views[1].detections[0].joints;
      std::fill(half.begin() + static_cast<long>(joints), half.end(),
                Keypoint());
      tracker->Process(seen, &frames_);
    }
    EXPECT_EQ(tracker->people_so_far(), 1);
    return tracker->track_count();
  };
  EXPECT_EQ(lives(AssociationRules::kGraph, 9, 0), 1u);
  EXPECT_EQ(lives(AssociationRules::kGraph, 9, 5), 0u);
  EXPECT_EQ(lives(AssociationRules::kGraph, 17, 5), 1u);
  EXPECT_EQ(lives(AssociationRules::kPaper, 9, 0), 1u);
}

// Elbows, wrists, knees and ankles jump by 2 m. Two views see only the joints
// that did not move, and follow them; the other views, which see all joints, no
// longer fit. The track's arms and legs remain where they were only as a
// prediction, so there is no new person. After a loss of 0.16 s the detections
// may be of another person, so the track ends and all views start a new one. In
// paper mode the other views start a second track.
TEST_F(TrackerTest, ViewsOfOnePersonAreNotSharedByTwo) {
  const auto leaps = [](size_t j) { return j > 6 && j != 11 && j != 12; };
  Pose3d leaper = Stander();
  for (size_t j = 0; j < leaper.size(); ++j) {
    if (leaps(j)) leaper[j].position_m.x() -= 2.0;
  }
  for (const AssociationRules rules :
       {AssociationRules::kPaper, AssociationRules::kGraph}) {
    for (const auto& [lost, rate_hz] :
         {std::pair{0, 25.0}, {0, 5.0}, {4, 25.0}}) {
      rate_hz_ = rate_hz;
      const auto tracker = Make(By(rules));
      Show(tracker.get(), 0, 5, {Stander()});
      Show(tracker.get(), 5, 5 + lost, {});
      for (int f = 5 + lost; f < 15; ++f) {
        DetectionFrame seen = See(f, {leaper});
        for (size_t v = 0; v < 2; ++v) {
          std::vector<Keypoint>& joints = seen.views[v].detections[0].joints;
          for (size_t j = 0; j < joints.size(); ++j) {
            if (leaps(j)) joints[j] = Keypoint();
          }
        }
        tracker->Process(seen, &frames_);
      }
      const bool kept = rules == AssociationRules::kPaper;
      EXPECT_EQ(tracker->track_count(), kept ? 2u : 1u);
      EXPECT_EQ(tracker->people_so_far(), kept || lost > 0 ? 2 : 1);
      tracker->Finish(&frames_);
      if (kept || lost == 0) continue;
      for (const TrackFrame& frame : frames_) {
        const bool written = frame.frame >= 2 && frame.frame < 5;
        const bool anew = frame.frame >= 11;  // at the third hit
        ASSERT_EQ(frame.people.size(), written || anew ? 1u : 0u)
            << frame.frame;
        if (frame.people.empty()) continue;
        const PersonPose& person = frame.people[0];
        EXPECT_EQ(person.id, TrackId(anew ? 1 : 0));
        EXPECT_EQ(person.inlier_views[0], 5);
        EXPECT_EQ(person.inlier_views[16], anew ? 3 : 5);
      }
    }
  }
}

// The second of two cameras sees two people one behind the other. The first
// camera and the tracker lose the person behind; then the second camera misses
// the person in front and still shows the person behind, within the gate. The
// track of the person in front must not be matched with the person behind.
TEST_F(TrackerTest, TrackIsNotMatchedWithALostPerson) {
  cameras_ = testing::RingOfCameras(4);
  cameras_ = {cameras_[0], cameras_[1]};
  const Pose3d hind = testing::StandingPerson(0.0, -0.4);
  const Pose3d front = testing::StandingPerson(0.0, 0.4);
  for (const AssociationRules rules :
       {AssociationRules::kPaper, AssociationRules::kGraph}) {
    TrackerOptions options;
    options.rules = rules;
    const auto tracker = Make(options);
    for (int f = 0; f < 50; ++f) {
      DetectionFrame seen = See(f, {hind, front});
      auto& first = seen.views[0].detections;
      auto& second = seen.views[1].detections;
      if (f >= 20) first.erase(first.begin());
      if (f >= 35 && f < 40) second.erase(second.begin() + 1);
      tracker->Process(seen, &frames_);
    }
    tracker->Finish(&frames_);
    int taken = 0;
    for (const TrackFrame& frame : frames_) {
      for (const PersonPose& person : frame.people) {
        if (person.id != TrackId(1)) continue;
        for (const ViewMatch& match : person.matches) {
          taken += match.view_idx == 1 && match.detection_idx == 0;
        }
      }
    }
    EXPECT_EQ(tracker->people_so_far(), 2);
    // In paper mode it is matched, so the scene does provoke the wrong match.
    EXPECT_EQ(taken > 0, rules == AssociationRules::kPaper);
  }
}

// View 1 alone follows a person whose track ends, so that its detections belong
// to the lost track. When the other views see the person again, they start a
// new track, with which view 1 is then matched by its own pixels.
TEST_F(TrackerTest, SecondMatchingUsesThePixelsOfTheView) {
  for (const AffinityKind affinity :
       {AffinityKind::kPart, AffinityKind::kCrossView}) {
    TrackerOptions options = By(AssociationRules::kGraph);
    options.association.affinity = affinity;
    const auto tracker = Make(options);
    for (int f = 0; f < 40; ++f) {
      DetectionFrame seen = See(f, {Stander()});
      for (size_t v = 0; v < seen.views.size(); ++v) {
        const bool misses = v == 1 ? f == 30 : f >= 10 && f < 30;
        if (misses) seen.views[v].detections.clear();
      }
      tracker->Process(seen, &frames_);
    }
    tracker->Finish(&frames_);
    EXPECT_EQ(tracker->people_so_far(), 2);
    ASSERT_EQ(frames_[35].people.size(), 1u);
    const std::vector<ViewMatch>& matches = frames_[35].people[0].matches;
    EXPECT_EQ(matches.size(), 5u);
    EXPECT_TRUE(std::any_of(
        matches.begin(), matches.end(),
        [](const ViewMatch& match) { return match.view_idx == 1; }));
  }
}

// A body that moves at 6 m/s is predicted 0.6 m further on after 0.1 s, and
// 1.2 m after 0.2 s, where it is expected to stay.
TEST_F(TrackerTest, PredictionStopsAfterTheGivenTime) {
  const auto estimator = Unsmoothed(Scene());
  const FrameClock clock(kFrameRate);
  for (int f = 0; f < 5; ++f) {
    EstimatorFrame frame;
    frame.frame = f;
    frame.time = clock.TimeOf(f);
    frame.has_initial = true;
    frame.initial = testing::StandingPerson(0.24 * f, 0.0);  // 6 m/s
    frame.initial[9].position_m.z() += 0.3 * f;  // a hand moves independently
    frame.triangulated.assign(frame.initial.size(), 1);
    estimator->Add(frame);
  }
  for (const auto& [elapsed_s, moved_m] :
       {std::pair{0.1, 0.6}, {0.2, 1.2}, {0.3, 1.2}}) {
    Pose3d expected;
    ExpectBody(*estimator, estimator->LastTime() + FromSeconds(elapsed_s), 0.2,
               &expected);
    ASSERT_EQ(expected.size(), estimator->Last().size());
    for (size_t j = 0; j < expected.size(); ++j) {
      const Eigen::Vector3d displacement_m =
          expected[j].position_m - estimator->Last()[j].position_m;
      // Times are whole nanoseconds: 6 m/s * 1 ns.
      EXPECT_LT((displacement_m - Eigen::Vector3d(moved_m, 0.0, 0.0)).norm(),
                1e-8);
    }
  }
}

TEST_F(TrackerTest, FragmentsStartNobody) {
  const auto tracker = Make();
  DetectionFrame seen = See(0, {Stander()});
  for (ViewDetections& view : seen.views) {
    for (size_t j = 4; j < 17; ++j) view.detections[0].joints[j].found = false;
  }
  tracker->Process(seen, &frames_);
  EXPECT_EQ(tracker->people_so_far(), 0);
}

TEST(FrameAssemblerTest, AFrameWaitsForEveryTrackAndOrderIsKept) {
  FrameAssembler assembler;
  std::vector<TrackFrame> frames;
  assembler.BeginFrame(0, 0);
  assembler.ExtractComplete(&frames);
  ASSERT_EQ(frames.size(), 1u) << "an empty frame leaves at once";
  const auto resolve = [&](int64_t frame, int64_t id) {
    PersonPose person;
    person.id = TrackId(id);
    assembler.Resolve(frame, id < 0 ? nullptr : &person);
    frames.clear();
    assembler.ExtractComplete(&frames);
  };
  assembler.BeginFrame(1, 0);
  assembler.Join();
  assembler.Join();
  assembler.BeginFrame(2, 40);
  assembler.Join();
  resolve(1, 5);
  resolve(2, -1);  // not written
  EXPECT_TRUE(frames.empty()) << "frame 1 still waits";
  resolve(1, 3);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].people[0].id, TrackId(3)) << "by ascending id";
  EXPECT_EQ(frames[0].people[1].id, TrackId(5));
  EXPECT_EQ(frames[1].time, 40);
  EXPECT_TRUE(frames[1].people.empty());
}

TEST_F(TrackerTest, ResultsDoNotDependOnThreads) {
  std::vector<std::vector<double>> results;
  for (const int threads : {1, 4}) {
    const auto tracker = Make();
    tracker->set_threads(threads);
    for (int f = 0; f < 20; ++f) {
      tracker->Process(See(f, {Walker(f), Stander()}), &frames_);
    }
    tracker->Finish(&frames_);
    std::vector<double>& numbers = results.emplace_back();
    for (const TrackFrame& frame : frames_) {
      numbers.push_back(static_cast<double>(frame.people.size()));
      for (const PersonPose& person : frame.people) {
        for (const Joint3d& joint : person.joints) {
          numbers.insert(numbers.end(), joint.position_m.begin(),
                         joint.position_m.end());
        }
      }
    }
  }
  EXPECT_GT(results[0].size(), 18u * 2u * 17u * 3u);
  EXPECT_EQ(results[0], results[1]);
}

// Counts final poses that have not been extracted.
class FinalsCounter final : public Estimator {
 public:
  FinalsCounter(std::unique_ptr<Estimator> inner, int* waiting)
      : inner_(std::move(inner)), waiting_(waiting) {}

  void Add(const EstimatorFrame& frame) override {
    inner_->Add(frame);
    ++*waiting_;
  }
  const Pose3d& Last() const override { return inner_->Last(); }
  TimeNs LastTime() const override { return inner_->LastTime(); }
  void Predict(TimeNs time, Pose3d* pose) const override {
    inner_->Predict(time, pose);
  }
  void ExtractFinals(std::vector<FinalPose>* finals) override {
    const size_t before = finals->size();
    inner_->ExtractFinals(finals);
    *waiting_ -= static_cast<int>(finals->size() - before);
  }
  void Finish() override { inner_->Finish(); }

 private:
  std::unique_ptr<Estimator> inner_;
  int* waiting_;
};

// A long recording must not need more memory than a short one.
TEST_F(TrackerTest, FinalPosesDoNotAccumulateInEitherRole) {
  int of_feedback = 0;
  int of_output = 0;
  const auto counted = [](int* waiting) {
    return [waiting](const SceneModel& scene) -> std::unique_ptr<Estimator> {
      return std::make_unique<FinalsCounter>(
          MakeCausalGaussian(scene, CausalGaussianOptions()), waiting);
    };
  };
  Tracker tracker(Scene(), Coco17(), TrackerOptions(), counted(&of_feedback),
                  counted(&of_output));
  std::vector<TrackFrame> frames;
  for (int f = 0; f < 20; ++f) {
    tracker.Process(See(f, {Walker(f), Stander()}), &frames);
    // A person's first frame waits for the next one.
    EXPECT_LE(of_feedback, 2) << f;
    EXPECT_LE(of_output, 2) << f;
  }
  tracker.Finish(&frames);
  EXPECT_EQ(of_output, 0);
  EXPECT_EQ(frames.back().people.size(), 2u);
}

TEST_F(TrackerTest, RefusesInvalidOptionsScenesAndFrames) {
  TrackerOptions wrong;
  wrong.reconstruction.tau_frames = -1.0;
  EXPECT_THROW(Make(wrong), OptionError);
  SceneModel no_rate = Scene();
  no_rate.frame_rate_hz = 0.0;
  EXPECT_THROW(Tracker(no_rate, Coco17(), {}, Unsmoothed), OptionError);
  const auto tracker = Make();
  DetectionFrame frame = See(1, {});
  frame.views.pop_back();
  EXPECT_THROW(tracker->Process(frame, &frames_), OptionError);
}

TEST_F(TrackerTest, RefusesFramesAndTimesThatDoNotAscend) {
  const auto tracker = Make();
  tracker->Process(See(5, {Stander()}), &frames_);
  EXPECT_THROW(tracker->Process(See(5, {}), &frames_), InputError);
  DetectionFrame same_time = See(6, {Stander()});
  same_time.time = FrameClock(kFrameRate).TimeOf(5);
  EXPECT_THROW(tracker->Process(same_time, &frames_), InputError);
  EXPECT_NO_THROW(tracker->Process(See(6, {Stander()}), &frames_));
}

TrackerOptions ChenOptions() {
  TrackerOptions options;
  options.association.affinity = AffinityKind::kCrossView;
  options.association.alpha_2d_px_per_frame = 60.0;
  options.association.lambda_a_per_frame = 5.0;
  options.reconstruction.newest = NewestRule::kJoint;
  options.reconstruction.incremental = true;
  options.reconstruction.lambda_t_per_frame = 10.0;
  options.reconstruction.joints_filter = false;
  options.reconstruction.max_lost_share = 1.0;
  return options;
}

TEST_F(TrackerTest, TheFrontEndOfChenFollowsExactDetections) {
  const auto tracker = Make(ChenOptions());
  for (int f = 0; f < 40; ++f) {
    tracker->Process(See(f, {Walker(f), Stander()}), &frames_);
  }
  tracker->Finish(&frames_);
  ASSERT_EQ(frames_.size(), 40u);
  EXPECT_EQ(tracker->people_so_far(), 2);
  for (int f = 2; f < 40; ++f) {
    ASSERT_EQ(frames_[f].people.size(), 2u) << "frame " << f;
    for (const PersonPose& person : frames_[f].people) {
      const bool walks = person.joints[0].position_m.x() < 0.0;
      const Pose3d truth = walks ? Walker(f) : Stander();
      for (int j = 0; j < 17; ++j) {
        EXPECT_LT((person.joints[j].position_m - truth[j].position_m).norm(),
                  1e-9);
      }
    }
  }
}

// A person jumps 0.3 m sideways as seen by view 0, and view 2, opposite, sees
// them for the first time: it has no 2D joint to compare with, and 0.3 m from
// the ray is twice alpha_3d. View 0 remembers a 2D joint and is matched
// nevertheless; once its measurement is in the expected pose, view 2 is
// matched, too. Views 1 and 3 look along the jump.
TEST_F(TrackerTest, IncrementalUpdatesHelpLaterViews) {
  cameras_ = testing::RingOfCameras(4);
  const Eigen::Vector3d aside = 0.3 * cameras_[0].R().row(0).transpose();
  for (const bool incremental : {false, true}) {
    TrackerOptions options = ChenOptions();
    options.reconstruction.incremental = incremental;
    options.association.alpha_2d_px_per_frame = 600.0;
    options.association.weight_3d = 0.1;
    const auto tracker = Make(options);
    for (int f = 0; f < 5; ++f) {
      DetectionFrame seen = See(f, {testing::StandingPerson(0.0, 0.0)});
      seen.views[2].detections.clear();
      tracker->Process(seen, &frames_);
    }
    tracker->Process(See(5, {testing::StandingPerson(aside.x(), aside.y())}),
                     &frames_);
    tracker->Finish(&frames_);
    ASSERT_EQ(frames_.back().people.size(), 1u);
    EXPECT_EQ(frames_.back().people[0].inlier_views[0], incremental ? 4 : 3);
  }
}

}  // namespace
}  // namespace kinegraph
