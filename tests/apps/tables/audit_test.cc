#include "apps/tables/audit.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/evaluation/people.h"
#include "tests/support/rig.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::Frame;
using testing::Person;
using testing::StandingTum14;
using testing::Tracks;

size_t CountOf(const std::string& text, const std::string& word) {
  size_t count = 0;
  for (size_t at = text.find(word); at != std::string::npos;
       at = text.find(word, at + 1)) {
    ++count;
  }
  return count;
}

// One wrong annotation, one lost head; names that would break a page.
AuditedBenchmark Hostile() {
  AuditedBenchmark audited;
  audited.title = "<script>alert(1)</script>";
  audited.detections_note = "\"quotes\" & <b>tags</b>";
  audited.caution = "</p><img src=x>";
  audited.cameras = testing::RingOfCameras(3);
  audited.detections.header.skeleton = Tum14();
  DetectionFrame& frame = audited.detections.frames.emplace_back();
  for (const Camera& camera : audited.cameras) {
    audited.view_names.push_back("<i>" + camera.name());
    frame.views.emplace_back().detections = {
        testing::Project(StandingTum14(), camera)};
  }
  Pose3d annotation = StandingTum14();
  annotation[6].position_m.z() += 0.5;  // the wrist
  Pose3d estimate = StandingTum14();
  estimate[13].position_m.z() += 1.0;  // the top of the head
  const TrackSequence truth = Tracks({Frame(0, {Person(0, annotation)})});
  const TrackSequence tracks = Tracks({Frame(0, {Person(0, estimate)})});
  AuditedEstimate one;
  one.method = "a <method> | with a bar";
  PcpProtocol protocol;
  one.pcp = EvaluatePcp(truth, tracks, protocol);
  AuditInput input;
  input.truth = &truth;
  input.tracks = &tracks;
  input.pcp = &one.pcp;
  input.detections = &audited.detections;
  input.cameras = &audited.cameras;
  one.audit = AuditAnnotation(input);
  audited.estimates.push_back(one);
  return audited;
}

TEST(AuditPageTest, ShowsEveryAuditedCaseInEveryView) {
  const std::string page = AuditPage(Hostile());
  EXPECT_EQ(CountOf(page, "<section class=\"case\""), 1u);  // not the head
  EXPECT_EQ(CountOf(page, "<figure>"), 3u);
  EXPECT_NE(page.find("r_lower_arm: contradicted"), std::string::npos);
}

TEST(AuditPageTest, NeedsNoOtherFileAndEscapesText) {
  const std::string page = AuditPage(Hostile());
  for (const char* outside : {"http:", "https:", "url(", "@import"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }
  EXPECT_EQ(page.find(" src="), page.find(" src=x&gt;"));
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_EQ(page.find("<i>"), std::string::npos);
  EXPECT_NE(page.find("&lt;method&gt;"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy"), std::string::npos);
}

TEST(AuditTableTest, GivesTheSeparateFigures) {
  const TableOutput table = AuditTable(Hostile(), {}, {}, "page.html");
  // Ten parts: the lower arm and the head are lost, the first contradicted.
  const Json& scores = table.json["scores"][0];
  EXPECT_EQ(scores["as_scored"]["right"], 8);
  EXPECT_EQ(scores["as_scored"]["parts"], 10);
  EXPECT_EQ(scores["without_contradicted_annotations"]["parts"], 9);
  EXPECT_EQ(scores["without_held_out_confirmed"]["parts"], 10);
  EXPECT_EQ(scores["without_refuted_by_views_alone"]["parts"], 9);
  EXPECT_EQ(table.json["estimates"][0]["contradicted"], 1);
  EXPECT_EQ(table.json["estimates"][0]["not auditable"], 1);
}

TEST(AuditCasesTest, ListFrameActorPartAndEvidence) {
  const AuditedBenchmark audited = Hostile();
  const Json json = AuditCasesJson(audited);
  const Json& one = json["estimates"][0]["cases"][0];
  EXPECT_EQ(one["frame"], 0);
  EXPECT_EQ(one["actor"], 0);
  EXPECT_EQ(one["part"], "r_lower_arm");
  EXPECT_EQ(one["verdict"], "contradicted");
  ASSERT_EQ(one["views"].size(), 3u);
  EXPECT_EQ(one["views"][0]["verdict"], "estimate");
  EXPECT_GT(one["views"][0]["annotation_mean_px"].get<double>(), 10.0);
  EXPECT_NE(AuditCasesMarkdown(audited).find("r_lower_arm"), std::string::npos);
}

// Circular evidence would show here: the witnesses of Campus are the 2D
// annotation, made with the 3D one, and may not refute it.
TEST(AuditOnDataTest, TheCampusAnnotationAgreesWithItself) {
  KINEGRAPH_DATA_OR_SKIP(data, "campus/annotation_2d.json");
  const std::string root = testing::FindData("")->string();
  for (const Benchmark& benchmark : FindBenchmarks(root).benchmarks) {
    if (benchmark.set != BenchmarkSet::kCampus) continue;
    const AuditedBenchmark audited =
        RunAudit("Campus", benchmark, root, "", [] {});
    ASSERT_EQ(audited.estimates.size(), 1u);
    const AuditResult& audit = audited.estimates[0].audit;
    // 376 person-frames of eight limbs, all of them annotated in 2D.
    EXPECT_EQ(audit.limbs, 376 * 8);
    EXPECT_EQ(audit.limbs_seen, 376 * 8);
    EXPECT_TRUE(audit.refuted_by_views.empty());
    EXPECT_EQ(audit.Count(AuditVerdict::kContradicted), 0);
    for (const AuditCase& one : audit.cases) {
      for (const ViewEvidence& view : one.views) {
        EXPECT_NE(audited.view_names[view.view_idx], "Camera2");
      }
    }
  }
}

}  // namespace
}  // namespace kinegraph
