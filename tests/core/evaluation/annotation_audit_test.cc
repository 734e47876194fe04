#include "core/evaluation/annotation_audit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "tests/core/evaluation/people.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using testing::Frame;
using testing::Person;
using testing::StandingTum14;
using testing::Tracks;

constexpr int kWrist = 6;
constexpr int kRightLowerArm = 4;

// Four cameras around one person. The lower arm is 0.25 m long and hangs; a
// `Raised` one stands up from the elbow, so that the wrist is 0.5 m off.
class AnnotationAuditTest : public ::testing::Test {
 protected:
  AnnotationAuditTest() {
    protocol_.headline_actors = {};
    detections_.header.skeleton = Tum14();
    DetectionFrame& frame = detections_.frames.emplace_back();
    for (const Camera& camera : cameras_) {
      detections_.header.view_names.push_back(camera.name());
      frame.views.emplace_back().detections = {
          testing::Project(StandingTum14(), camera)};
    }
  }

  static Pose3d Raised() {
    Pose3d pose = StandingTum14();
    pose[kWrist].position_m.z() += 0.5;
    return pose;
  }

  // What a view saw of a joint.
  Keypoint& Seen(int view, int joint) {
    return detections_.frames[0].views[view].detections[0].joints[joint];
  }
  // Lets a view see the raised wrist.
  void SeeRaised(int view) {
    Seen(view, kWrist).px =
        *cameras_[view].Project(Raised()[kWrist].position_m);
  }

  AuditInput Input(std::vector<PersonPose> annotated,
                   std::vector<PersonPose> estimated) {
    truth_ = Tracks({Frame(0, std::move(annotated))});
    tracks_ = Tracks({Frame(0, std::move(estimated))});
    pcp_ = EvaluatePcp(truth_, tracks_, protocol_);
    AuditInput input;
    input.truth = &truth_;
    input.tracks = &tracks_;
    input.pcp = &pcp_;
    input.detections = &detections_;
    input.cameras = &cameras_;
    return input;
  }

  AuditResult Audit(const Pose3d& annotation, const Pose3d& estimate,
                    const std::vector<TrackSequence>& held_out = {}) {
    AuditInput input = Input({Person(0, annotation)}, {Person(3, estimate)});
    for (const TrackSequence& run : held_out) input.held_out.push_back(&run);
    return AuditAnnotation(input, options_);
  }

  CameraRig cameras_ = testing::RingOfCameras(4);
  AuditOptions options_;
  PcpProtocol protocol_;
  DetectionSequence detections_;
  TrackSequence truth_;
  TrackSequence tracks_;
  PcpResult pcp_;
};

TEST_F(AnnotationAuditTest, ViewsContradictAWrongAnnotation) {
  const AuditResult result = Audit(Raised(), StandingTum14());
  ASSERT_EQ(result.cases.size(), 1u);
  const AuditCase& one = result.cases[0];
  EXPECT_EQ(one.lost.part, kRightLowerArm);
  EXPECT_EQ(one.verdict, AuditVerdict::kContradicted);
  EXPECT_TRUE(one.refuted_by_views);
  EXPECT_FALSE(one.held_out_confirmed);  // no runs were given
  ASSERT_EQ(one.views.size(), 4u);
  for (const ViewEvidence& view : one.views) {
    EXPECT_EQ(view.verdict, ViewVerdict::kEstimate);
    EXPECT_NEAR(view.estimate_m, 0.0, 1e-9);
    EXPECT_NEAR(view.estimate_mean_px, 0.0, 1e-6);
    EXPECT_GT(view.annotation_mean_px, 20.0);
  }
  // Camera 0 stands at (5, 0, 2), the wrist is seen at (0.25, 0, 1): the raised
  // one is 0.5 m above, of which the ray leaves 4.75 / sqrt(4.75^2 + 1); the
  // elbow is right, so the mean is half of that.
  EXPECT_NEAR(one.views[0].annotation_m,
              0.5 * 0.5 * 4.75 / std::sqrt(4.75 * 4.75 + 1.0), 1e-9);
  // One of eight annotated limbs; all eight are seen by every view.
  EXPECT_EQ(result.limbs, 8);
  EXPECT_EQ(result.limbs_seen, 8);
  EXPECT_EQ(result.limbs_agreed, 8);
  EXPECT_EQ(result.refuted_by_views.size(), 1u);
  EXPECT_EQ(result.refuted_by_three_views.size(), 1u);
}

TEST_F(AnnotationAuditTest, TwoViewsRefuteButAreNotThree) {
  for (const int view : {0, 1}) Seen(view, kWrist).found = false;
  const AuditResult result = Audit(Raised(), StandingTum14());
  EXPECT_EQ(result.refuted_by_views.size(), 1u);
  EXPECT_TRUE(result.refuted_by_three_views.empty());
}

TEST_F(AnnotationAuditTest, ViewsConfirmARightAnnotation) {
  const AuditResult result = Audit(StandingTum14(), Raised());
  ASSERT_EQ(result.cases.size(), 1u);
  EXPECT_EQ(result.cases[0].verdict, AuditVerdict::kEstimateWrong);
  EXPECT_TRUE(result.refuted_by_views.empty());
}

TEST_F(AnnotationAuditTest, OneViewIsNotEnough) {
  for (const int view : {0, 1, 2}) Seen(view, kWrist).confidence = 0.49;
  const AuditResult result = Audit(Raised(), StandingTum14());
  EXPECT_EQ(result.cases[0].verdict, AuditVerdict::kUndecided);
  EXPECT_EQ(result.cases[0].views[0].verdict, ViewVerdict::kUnsure);
  EXPECT_EQ(result.cases[0].views[3].verdict, ViewVerdict::kEstimate);
  EXPECT_TRUE(result.refuted_by_views.empty());
  EXPECT_EQ(result.limbs_seen, 7);
}

TEST_F(AnnotationAuditTest, ViewsOnBothSidesDispute) {
  SeeRaised(2);
  SeeRaised(3);
  const AuditResult result = Audit(Raised(), StandingTum14());
  EXPECT_EQ(result.cases[0].verdict, AuditVerdict::kDisputed);
  EXPECT_EQ(result.cases[0].views[2].verdict, ViewVerdict::kAnnotation);
  // Nor can the views agree on one limb.
  EXPECT_FALSE(result.cases[0].refuted_by_views);
  EXPECT_EQ(result.limbs_agreed, 7);
}

TEST_F(AnnotationAuditTest, TheEstimateDoesNotChooseItsWitness) {
  // A second detection that fits the estimate in every joint, but is 2 m away
  // from the annotated person: it is somebody else.
  Pose3d elsewhere = testing::Moved(StandingTum14(), 0.0, 2.0);
  for (int view = 0; view < 4; ++view) {
    auto& people = detections_.frames[0].views[view].detections;
    people.push_back(testing::Project(elsewhere, cameras_[view]));
    people.back().index_in_file = 1;
  }
  const AuditResult result = Audit(StandingTum14(), elsewhere);
  for (const AuditCase& one : result.cases) {
    for (const ViewEvidence& view : one.views) {
      EXPECT_EQ(view.detection_idx, 0);
    }
    EXPECT_NE(one.verdict, AuditVerdict::kContradicted);
  }
}

TEST_F(AnnotationAuditTest, ADetectionNearerToAnotherPersonIsTheirs) {
  const AuditInput input = Input(
      {Person(0, testing::Moved(Raised(), 0.125)), Person(1, StandingTum14())},
      {Person(0, testing::Moved(StandingTum14(), 0.125))});
  const AuditResult result = AuditAnnotation(input, options_);
  for (const AuditCase& one : result.cases) {
    if (one.lost.actor != 0) continue;
    for (const ViewEvidence& view : one.views) {
      EXPECT_EQ(view.verdict, ViewVerdict::kNoDetection);
    }
  }
}

TEST_F(AnnotationAuditTest, HeldOutEstimatesConfirmOrDoNot) {
  const TrackSequence right = Tracks({Frame(0, {Person(8, StandingTum14())})});
  const TrackSequence wrong = Tracks({Frame(0, {Person(8, Raised())})});
  AuditResult result =
      Audit(Raised(), StandingTum14(), {right, right, wrong, wrong});
  EXPECT_TRUE(result.cases[0].held_out_confirmed);
  EXPECT_NEAR(*result.cases[0].views[0].held_out_m, 0.0, 1e-9);
  EXPECT_NEAR(*result.cases[0].views[2].held_out_m,
              result.cases[0].views[2].annotation_m, 1e-12);
  EXPECT_EQ(result.HeldOutConfirmed().size(), 1u);
  result = Audit(Raised(), StandingTum14(), {right, wrong, wrong, wrong});
  EXPECT_EQ(result.cases[0].verdict, AuditVerdict::kContradicted);
  EXPECT_FALSE(result.cases[0].held_out_confirmed);
}

TEST_F(AnnotationAuditTest, WhatHasNoDetectedEndsIsNotAuditable) {
  Pose3d head = StandingTum14();
  head[12].position_m.z() -= 1.0;
  const AuditResult result = Audit(StandingTum14(), head);
  ASSERT_EQ(result.cases.size(), 2u);  // head and torso
  EXPECT_EQ(result.Count(AuditVerdict::kNotAuditable), 2);
}

TEST_F(AnnotationAuditTest, ViewsThatAreNoWitnessesAreLeftOut) {
  AuditInput input = Input({Person(0, Raised())}, {Person(0, StandingTum14())});
  input.without_views = {0, 1, 2};
  const AuditResult result = AuditAnnotation(input, options_);
  ASSERT_EQ(result.cases[0].views.size(), 1u);
  EXPECT_EQ(result.cases[0].verdict, AuditVerdict::kUndecided);
}

TEST_F(AnnotationAuditTest, PartsLeftOutAreNotCounted) {
  const AuditResult result = Audit(Raised(), StandingTum14());
  EXPECT_EQ(CountParts(pcp_, 0, PcpGroup::kTotal).count, 9);
  EXPECT_EQ(CountParts(pcp_, 0, PcpGroup::kTotal).total, 10);
  const PcpResult without = WithoutParts(pcp_, result.Contradicted());
  EXPECT_EQ(CountParts(without, 0, PcpGroup::kTotal).count, 9);
  EXPECT_EQ(CountParts(without, 0, PcpGroup::kTotal).total, 9);
  EXPECT_TRUE(without.lost.empty());
}

TEST_F(AnnotationAuditTest, OptionsOutOfRangeAreNamed) {
  options_.agree_share = 0.5;
  EXPECT_THROW(Audit(Raised(), StandingTum14()), OptionError);
  options_.agree_share = 0.2;
  options_.min_views = 1;
  EXPECT_THROW(Audit(Raised(), StandingTum14()), OptionError);
}

}  // namespace
}  // namespace kinegraph
