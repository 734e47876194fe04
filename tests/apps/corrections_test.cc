// track --corrections: a file edited by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/evaluation/correspondence.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/tracks.h"
#include "tests/apps/command.h"
#include "tests/support/rig.h"

namespace kinegraph::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Two people three metres apart in x for four seconds; the one at x = 1.5 is
// absent from 1.2 to 2.4 s, and so returns as a new identity.
std::vector<Pose3d> TwoPeople(int frame) {
  std::vector<Pose3d> people = {StandingPerson(-1.5, 0.01 * frame)};
  if (frame < 30 || frame >= 60) {
    people.push_back(StandingPerson(1.5, 0.0));
  }
  return people;
}

class CorrectionsTest : public CommandTest {
 protected:
  CorrectionsTest() {
    const CameraRig rig = RingOfCameras(4);
    WriteDetections(Path("seen.jsonl"), SeenBy(rig, 100, TwoPeople));
    WriteCameras(Path("cameras.json"), rig);
  }

  // Flags for tracking with a corrections file of these lines; with an empty
  // file identities are not merged.
  std::string Flags(const std::string& lines, const std::string& out) const {
    return "--cameras=" + Path("cameras.json") +
           " --detections=" + Path("seen.jsonl") +
           " --mode=graph --set=output.estimator=gaussian --corrections=" +
           folder_.Write("edits.jsonl", lines) + " --out=" + Path(out);
  }
  static std::vector<int64_t> IdsAt(const TrackSequence& tracks,
                                    int64_t frame) {
    std::vector<int64_t> ids;
    for (const PersonPose& person : FindFrame(tracks, frame)->people) {
      ids.push_back(person.id.value());
    }
    return ids;
  }
};

const char kEdited[] =
    R"({"op": "join", "persons": [1, 2], "frames": [30, 60]}
{"op": "cut", "persons": [0, 9], "frames": [70, 99]}

{"op": "swap", "persons": [1, 9], "frames": [90, 99]}
{"op": "delete", "persons": [0], "frames": [10, 12]}
{"op": "name", "persons": [1], "name": "Anna"}
)";

TEST_F(CorrectionsTest, AHandEditedFileIsAppliedDeterministically) {
  Done("track", Flags("", "before.jsonl"));
  const TrackSequence before = ReadTracks(Path("before.jsonl"));
  ASSERT_THAT(IdsAt(before, 20), ElementsAre(0, 1));
  ASSERT_THAT(IdsAt(before, 80), ElementsAre(0, 2));

  Done("track", Flags(kEdited, "one.jsonl") + " --threads=1");
  Done("track", Flags(kEdited, "again.jsonl") + " --threads=2");
  EXPECT_EQ(ContentOf(Path("one.jsonl")), ContentOf(Path("again.jsonl")));
  EXPECT_EQ(ContentOf(Path("one.identity.jsonl")),
            ContentOf(Path("again.identity.jsonl")));

  const TrackSequence tracks = ReadTracks(Path("one.jsonl"));
  EXPECT_THAT(IdsAt(tracks, 9), ElementsAre(0, 1));
  EXPECT_THAT(IdsAt(tracks, 11), ElementsAre(1));
  EXPECT_THAT(IdsAt(tracks, 69), ElementsAre(0, 1));
  EXPECT_THAT(IdsAt(tracks, 80), ElementsAre(1, 9));
  const auto x_of = [&](int64_t frame, size_t person) {
    return FindFrame(tracks, frame)->people[person].joints[0].position_m.x();
  };
  EXPECT_GT(x_of(89, 0), 1.0);   // person 1
  EXPECT_LT(x_of(90, 0), -1.0);  // exchanged
  EXPECT_THAT(ContentOf(Path("one.jsonl")), HasSubstr("Anna"));

  // The run's own edits may be passed back unchanged.
  Done("track", Flags(ContentOf(Path("one.identity.jsonl")), "third.jsonl"));
  EXPECT_EQ(ContentOf(Path("third.jsonl")), ContentOf(Path("one.jsonl")));
}

TEST_F(CorrectionsTest, ErrorsNameTheLine) {
  const struct {
    std::string line;
    std::string why;
  } wrongs[] = {
      {R"({"op": "join", "persons": [1, 77]})", "person 77 is unknown"},
      {R"({"op": "delete", "persons": [0], "frames": [9, 5]})", "empty range"},
      {R"({"op": "delete", "persons": [1], "frames": [40, 50]})",
       "person 1 is not in frames 40 to 50"},
      {R"({"op": "join", "persons": [0, 1]})", "both present in frame"},
      {R"({"op": "glue", "persons": [0, 1]})", "op"},
      {R"({"op": "join", "persons": [0, )", ""},
  };
  for (const auto& wrong : wrongs) {
    EXPECT_THAT(
        Refusal("track", Flags("{\"op\": \"name\", \"persons\": [0], \"name\": "
                               "\"Bo\"}\n" +
                                   wrong.line + "\n",
                               "wrong.jsonl")),
        AllOf(HasSubstr("edits.jsonl: line 2"), HasSubstr(wrong.why)));
    EXPECT_EQ(ContentOf(Path("wrong.jsonl")), "") << "an output file was left";
  }
}

}  // namespace
}  // namespace kinegraph::testing
