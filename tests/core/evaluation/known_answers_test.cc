// Published and independently computed scores on the real data.
#include <gtest/gtest.h>

#include <array>
#include <set>
#include <string>
#include <vector>

#include "core/data/held_out.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/pcp.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/detections/source.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/tracks/tracks.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

// Published values have two decimals, some only one or none. The tolerance is
// half a unit of the last decimal, plus the rounding of a double.
constexpr double kTwoDecimals = 0.005 + 1e-9;
constexpr double kOneDecimal = 0.05 + 1e-9;

constexpr double kNone = -1.0;  // a cell that the table leaves empty

// Percentages of actors 0 to 3, the mean over actors 0 to 2, and this mean by
// the strict rule (EndpointRule::kEach).
struct Row {
  HeadConversion head;
  PcpGroup group;
  std::array<double, 4> actors;
  double mean;
  double strict_mean;
};

constexpr auto kChu = HeadConversion::kChu;
constexpr auto kMvpose = HeadConversion::kMvpose;
constexpr auto kVoxelpose = HeadConversion::kVoxelposeShelf;
constexpr auto kRaw = HeadConversion::kRaw;

// Scores from data/shelf/reference/README.md.
using G = PcpGroup;
constexpr Row kReferenceRows[] = {
    {kChu, G::kHead, {99.28, 100, 96.89, 84.85}, 98.73, kNone},
    {kChu, G::kTorso, {100, 100, 100, 87.88}, 100, kNone},
    {kChu, G::kUpperArms, {99.82, 100, 93.79, 86.36}, 97.87, kNone},
    {kChu, G::kLowerArms, {99.10, 71.62, 95.96, 66.67}, 88.90, kNone},
    {kChu, G::kUpperLegs, {100, 100, 100, 87.88}, 100, kNone},
    {kChu, G::kLowerLegs, {100, 100, 100, 81.82}, 100, kNone},
    {kChu, G::kTotal, {99.71, 94.32, 97.64, 81.82}, 97.23, 93.14},
    {kMvpose, G::kHead, {88.17, 91.89, 98.14, 81.82}, 92.73, kNone},
    {kMvpose, G::kTotal, {98.60, 93.51, 97.76, 81.52}, 96.63, 92.80},
    {kVoxelpose, G::kHead, {91.04, 89.19, 98.76, 75.76}, 93.00, kNone},
    {kVoxelpose, G::kTotal, {98.89, 93.24, 97.83, 80.91}, 96.65, 92.29},
    {kRaw, G::kHead, {6.09, 0.00, 11.18, 15.15}, 5.76, kNone},
    {kRaw, G::kTotal, {90.39, 84.32, 89.07, 74.85}, 87.93, 84.89}};

PcpResult Evaluate(const TrackSequence& truth, const TrackSequence& tracks,
                   HeadConversion head, EndpointRule endpoints) {
  PcpProtocol protocol = ShelfProtocol();
  protocol.head = head;
  protocol.endpoints = endpoints;
  return EvaluatePcp(truth, tracks, protocol);
}

void ExpectRow(const TrackSequence& truth, const TrackSequence& tracks,
               const Row& row) {
  SCOPED_TRACE(std::string(ToString(row.head)) + ", " + ToString(row.group));
  const PcpResult result =
      Evaluate(truth, tracks, row.head, EndpointRule::kMean);
  for (int actor = 0; actor < 4; ++actor) {
    EXPECT_NEAR(CountParts(result, actor, row.group).percent(),
                row.actors[actor], kTwoDecimals)
        << "actor " << actor;
  }
  EXPECT_NEAR(MeanOfActors(result, row.group), row.mean, kTwoDecimals);
  if (row.strict_mean == kNone) return;
  EXPECT_NEAR(
      MeanOfActors(Evaluate(truth, tracks, row.head, EndpointRule::kEach),
                   row.group),
      row.strict_mean, kTwoDecimals);
}

TEST(KnownAnswersTest, ScoresOfTheAuthorsCodeOnShelf) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  const TrackSequence truth = ReadTracks(folder + "/raw/gt.txt");
  const TrackSequence tracks =
      ReadTracks(folder + "/reference/paper_code_shelf_warm3.json");
  for (const Row& row : kReferenceRows) ExpectRow(truth, tracks, row);
  // README: "Under the other conventions the parts other than head are the
  // same."
  const PcpResult chu = Evaluate(truth, tracks, kChu, EndpointRule::kMean);
  for (const HeadConversion head : {kMvpose, kVoxelpose, kRaw}) {
    const PcpResult other = Evaluate(truth, tracks, head, EndpointRule::kMean);
    for (const PcpGroup group :
         {PcpGroup::kTorso, PcpGroup::kUpperArms, PcpGroup::kLowerArms,
          PcpGroup::kUpperLegs, PcpGroup::kLowerLegs}) {
      EXPECT_EQ(PooledParts(chu, group).count, PooledParts(other, group).count);
    }
  }
}

TEST(KnownAnswersTest, ShelfHasThePublishedNumbersOfParts) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  for (const char* file : {"/raw/gt.txt", "/tum/actorsGT.mat"}) {
    SCOPED_TRACE(file);
    const TrackSequence truth = ReadTracks(folder + file);
    const PcpResult result = Evaluate(truth, truth, kChu, EndpointRule::kMean);
    int actor = 0;
    for (const int64_t parts : {2790, 370, 1610, 330}) {
      EXPECT_EQ(CountParts(result, actor++, PcpGroup::kTotal).total, parts);
    }
    EXPECT_EQ(MeanOfActors(result, PcpGroup::kTotal), 100.0);
  }
}

TEST(KnownAnswersTest, ScoresOfFourDAssociationByItsProtocolOnShelf) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf/raw");
  TrackReadOptions options;
  options.stored_zeros = StoredZeros::kKeep;
  const TrackSequence truth = ReadTracks(folder + "/gt.txt", options);
  const std::array<std::pair<const char*, std::array<double, 4>>, 2> answers = {
      {{"/skel.txt", {99.75, 91.35, 97.70, 96.27}},
       {"/skel_202006.txt", {99.64, 96.22, 97.89, 97.92}}}};
  for (const auto& [file, answer] : answers) {
    SCOPED_TRACE(file);
    const PcpResult result = EvaluatePcp(
        truth, ReadTracks(folder + file, options), FourDAssociationProtocol());
    for (int actor = 0; actor < 3; ++actor) {
      EXPECT_NEAR(CountParts(result, actor, PcpGroup::kTotal).percent(),
                  answer[actor], kTwoDecimals);
    }
    EXPECT_NEAR(MeanOfActors(result, PcpGroup::kTotal), answer[3],
                kTwoDecimals);
  }
}

TEST(KnownAnswersTest, ScoresOfCrossViewTrackingOnCampus) {
  KINEGRAPH_DATA_OR_SKIP(folder, "campus");
  const TrackSequence truth = ReadTracks(folder + "/annotation_3d.json");
  const TrackSequence tracks = ReadTracks(folder + "/result_3d.json");
  const PcpResult result = EvaluatePcp(truth, tracks, CampusProtocol());
  struct Answer {
    int64_t person_frames;
    double total, lower_arms, head;
  };
  int actor = 0;
  for (const Answer& answer :
       {Answer{49, 97.14, 89.8, 100.0}, Answer{189, 94.13, 70.6, 100.0},
        Answer{138, 98.62, 93.5, 99.3}}) {
    SCOPED_TRACE(actor);
    const auto share = [&](PcpGroup group) {
      return CountParts(result, actor, group);
    };
    EXPECT_EQ(share(G::kHead).total, answer.person_frames);
    EXPECT_NEAR(share(G::kTotal).percent(), answer.total, kTwoDecimals);
    EXPECT_NEAR(share(G::kLowerArms).percent(), answer.lower_arms, kOneDecimal);
    EXPECT_NEAR(share(G::kHead).percent(), answer.head, kOneDecimal);
    ++actor;
  }
}

// Single-person tools on actor 0 (data/shelf/peers/README.md): PCP by both
// rules with two decimals, acceleration [mm/frame^2] printed with a last digit
// of `last_digit_mm`, bone spread and error [mm] with one decimal.
TEST(KnownAnswersTest, ScoresOfSinglePersonPeersOnShelf) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  const TrackSequence truth = ReadTracks(folder + "/raw/gt.txt");
  struct Peer {
    const char* file;
    double mean;
    double strict;
    double acceleration_mm;
    double last_digit_mm;
    double spread_mm;
    double error_mm;
  };
  for (const Peer& peer :
       {Peer{"anipose_triangulate", 99.35, 95.77, 23.6, .1, 16.6, 52.7},
        Peer{"anipose_optim_default_bones", 99.57, 96.34, 2.44, .01, 3.9, 50.4},
        Peer{"anipose_optim_c03_program_config_scores", 99.43, 95.70, 2.97, .01,
             2.2, 47.5},
        Peer{"p2s_tri_raw", 99.18, 95.66, 17.2, .1, 13.1, 48.7},
        Peer{"p2s_hampel_butterworth", 99.50, 95.91, 5.2, .1, 11.6, 48.0},
        Peer{"p2s_hampel_kalman", 99.53, 96.06, 3.17, .01, 11.2, 47.8},
        Peer{"p2s_hampel_gcv_spline", 99.57, 96.02, 5.39, .01, 11.4, 47.9},
        Peer{"p2s_hampel_one_euro", 99.53, 96.24, 3.62, .01, 10.7, 47.6}}) {
    SCOPED_TRACE(peer.file);
    const TrackSequence tracks =
        ReadTracks(folder + "/peers/" + peer.file + ".json");
    const auto percent = [&](EndpointRule rule) {
      return CountParts(Evaluate(truth, tracks, kChu, rule), 0, G::kTotal)
          .percent();
    };
    EXPECT_NEAR(percent(EndpointRule::kMean), peer.mean, kTwoDecimals);
    EXPECT_NEAR(percent(EndpointRule::kEach), peer.strict, kTwoDecimals);
    const MotionResult motion = EvaluateMotion(tracks, 1.0);  // per frame
    EXPECT_NEAR(1000.0 * motion.acceleration_m_s2, peer.acceleration_mm,
                0.5 * peer.last_digit_mm + 1e-9);
    EXPECT_NEAR(1000.0 * motion.bone_length_spread_m, peer.spread_mm,
                kOneDecimal);
    EXPECT_NEAR(1000.0 * EvaluateMpjpe(truth, tracks).raw_m, peer.error_mm,
                kOneDecimal);
  }
}

// The authors' five runs, each without one camera.
HeldOutScores ScoreAuthors(const std::string& folder) {
  const std::string reference_folder = folder + "/reference/";
  const TrackSequence reference =
      ReadTracks(reference_folder + "paper_code_shelf_warm3.json");
  const DetectionSequence detections =
      ReadDetections(folder + "/detections/openpose");
  const std::vector<std::string>& views = detections.header.view_names;
  const CameraRig cameras =
      ChooseViews(views, ReadCameras(folder + "/calibration.json")).cameras;
  const HeldOutSet set =
      ReadHeldOutSet(reference_folder + "held_out_set.json", views);
  HeldOutScores scores;
  for (int view = 0; view < 5; ++view) {
    const TrackSequence run =
        ReadTracks(reference_folder + "paper_code_shelf_without_cam" +
                   std::to_string(view) + ".json");
    ScoreHeldOutCamera(set, detections, view, cameras[view], reference, run,
                       &scores);
  }
  return scores;
}

TEST(KnownAnswersTest, HeldOutErrorsOfTheAuthorsRuns) {
  KINEGRAPH_DATA_OR_SKIP(folder, "shelf");
  const HeldOutScores scores = ScoreAuthors(folder);
  EXPECT_EQ(scores.people.size(), 3642u);
  EXPECT_EQ(scores.joints.size(), 49594u);
  const HeldOutSummary all = SummariseHeldOut(scores, AllJoints());
  EXPECT_NEAR(all.figure_px(HeldOutFigure::kMedian), 11.01, kTwoDecimals);
  EXPECT_NEAR(all.figure_px(HeldOutFigure::kP90), 45.7, kOneDecimal);
  EXPECT_NEAR(all.figure_px(HeldOutFigure::kMeanTruncated), 13.77,
              kTwoDecimals);
  EXPECT_NEAR(all.predicted.percent(), 93.0, kOneDecimal);
  EXPECT_NEAR(all.paired.percent(), 93.9, kOneDecimal);
  for (const HeldOutFigure figure :
       {HeldOutFigure::kMedian, HeldOutFigure::kP90,
        HeldOutFigure::kMeanTruncated}) {
    const Interval& interval = all.intervals_px[static_cast<int>(figure)];
    EXPECT_LT(interval.low, all.figure_px(figure));
    EXPECT_GT(interval.high, all.figure_px(figure));
  }

  BootstrapOptions few;
  few.resamples = 10;
  const HeldOutSummary body =
      SummariseHeldOut(scores, JointsWithoutFace(), few);
  EXPECT_NEAR(body.figure_px(HeldOutFigure::kMedian), 10.72, kTwoDecimals);
  EXPECT_NEAR(body.figure_px(HeldOutFigure::kP90), 45.7, kOneDecimal);
  EXPECT_NEAR(body.figure_px(HeldOutFigure::kMeanTruncated), 13.54,
              kTwoDecimals);

  // Median with one decimal, 90th percentile with none.
  struct ClassAnswer {
    std::set<JointClass> classes;
    double median_px, p90_px;
  };
  for (const ClassAnswer& answer :
       {ClassAnswer{{JointClass::kElbow}, 8.3, 56.0},
        {{JointClass::kWrist}, 10.3, 85.0},
        {{JointClass::kKnee}, 12.0, 40.0},
        {{JointClass::kAnkle}, 9.2, 54.0},
        {{JointClass::kShoulder, JointClass::kHip}, 12.2, 36.0},
        {{JointClass::kHead}, 12.1, 46.0}}) {
    SCOPED_TRACE(ToString(*answer.classes.begin()));
    const HeldOutSummary summary = SummariseHeldOut(
        scores,
        [&](const HeldOutPerson&, const HeldOutJoint& joint) {
          return answer.classes.count(joint.joint_class) > 0;
        },
        few);
    EXPECT_NEAR(summary.figure_px(HeldOutFigure::kMedian), answer.median_px,
                kOneDecimal);
    EXPECT_NEAR(summary.figure_px(HeldOutFigure::kP90), answer.p90_px,
                0.5 + 1e-9);
  }
}

}  // namespace
}  // namespace kinegraph
