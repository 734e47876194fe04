// Paper mode on the real Shelf recording: parity with the authors' code, and
// scores on raw detections.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "apps/tables/dataset.h"
#include "core/evaluation/identity.h"
#include "core/evaluation/parity.h"
#include "core/evaluation/pcp.h"
#include "core/io/tracks/tracks.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

struct ParityCase {
  const char* name;
  const char* set;
  const char* reference;
};

class PaperParityTest : public ::testing::TestWithParam<ParityCase> {};

TEST_P(PaperParityTest, EqualsTheAuthorsCode) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/reference");
  Dataset shelf = ShelfFilled();
  shelf.set = GetParam().set;
  const LoadedDataset loaded =
      LoadDataset(shelf, testing::FindData("")->string());
  const TrackSequence ours = TracksOf(loaded);
  const TrackSequence reference = ReadTracks(data + "/" + GetParam().reference);

  const ParityResult parity = EvaluateParity(reference, ours);
  EXPECT_EQ(parity.person_frames, parity.reference_person_frames);
  EXPECT_EQ(parity.identities, parity.reference_identities);
  EXPECT_TRUE(parity.identities_one_to_one);
  // Every joint must agree within a millimetre. The reference was computed with
  // camera matrices of 32-bit floats, which affects badly determined joints.
  EXPECT_EQ(parity.near.count, parity.near.total)
      << "worst " << parity.worst.distance_m << " m in frame "
      << parity.worst.frame;
  EXPECT_LT(parity.worst.distance_m, 1e-3);

  for (const HeadConversion head :
       {HeadConversion::kChu, HeadConversion::kMvpose,
        HeadConversion::kVoxelposeShelf, HeadConversion::kRaw}) {
    for (const EndpointRule rule : {EndpointRule::kMean, EndpointRule::kEach}) {
      PcpProtocol protocol = ShelfProtocol();
      protocol.head = head;
      protocol.endpoints = rule;
      const PcpResult a = EvaluatePcp(loaded.truth, ours, protocol);
      const PcpResult b = EvaluatePcp(loaded.truth, reference, protocol);
      for (const int64_t actor : b.Actors()) {
        for (const PcpGroup group : kPcpGroups) {
          EXPECT_EQ(CountParts(a, actor, group).count,
                    CountParts(b, actor, group).count)
              << ToString(head) << ", actor " << actor << ", "
              << ToString(group);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shelf, PaperParityTest,
    ::testing::Values(
        ParityCase{"cold", "", "paper_code_shelf.json"},
        ParityCase{"warm", "input.repeat_first_frame=3",
                   "paper_code_shelf_warm3.json"},
        ParityCase{"warm_without_filter",
                   "input.repeat_first_frame=3;reconstruction.joints_filter="
                   "false",
                   "paper_code_shelf_warm3_nojf_conf.json"}),
    [](const ::testing::TestParamInfo<ParityCase>& test) {
      return std::string(test.param.name);
    });

TEST(PaperModeTest, KeepsPcpAndIdentitiesOnRawShelfDetections) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  const LoadedDataset loaded =
      LoadDataset(ShelfReal(), testing::FindData("")->string());
  ASSERT_FALSE(loaded.options.tracker.life.backfill);
  const TrackSequence tracks = TracksOf(loaded);
  const PcpResult pcp =
      EvaluatePcp(loaded.truth, tracks, loaded.dataset.protocol);
  // The lower end of the 95 % interval that `evaluate --protocol=shelf` prints
  // for this run: lower scores are significantly worse. With the choices of the
  // authors' code, the score is 71.37 (docs/results.md).
  EXPECT_GE(MeanOfActors(pcp, PcpGroup::kTotal), 94.37);
  std::set<TrackId> ids;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) ids.insert(person.id);
  }
  // Five people are in one view at once; one may be lost and found again under
  // another identity.
  EXPECT_LE(ids.size(), 6u);
  IdentityOptions options;
  options.frames = loaded.dataset.protocol.frames;
  EXPECT_EQ(EvaluateIdentity(loaded.truth, tracks, options).switches, 0);
}

}  // namespace
}  // namespace kinegraph
