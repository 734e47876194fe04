// Reads results and ground truth of real data. Counts are compared with the
// READMEs, and files with each other if they contain the same data.
#include "core/io/tracks/tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::TemporaryFolder;

int CountPoses(const TrackSequence& sequence) {
  int count = 0;
  for (const TrackFrame& frame : sequence.frames) {
    count += static_cast<int>(frame.people.size());
  }
  return count;
}

int CountMissingJoints(const TrackSequence& sequence) {
  int count = 0;
  for (const TrackFrame& frame : sequence.frames) {
    for (const PersonPose& person : frame.people) {
      count +=
          sequence.header.skeleton.joint_count() - CountPresent(person.joints);
    }
  }
  return count;
}

// Number of person-frames of each id in the frames first .. last.
std::map<int64_t, int> CountById(const TrackSequence& sequence, int64_t first,
                                 int64_t last) {
  std::map<int64_t, int> counts;
  for (const TrackFrame& frame : sequence.frames) {
    if (frame.frame < first || frame.frame > last) continue;
    for (const PersonPose& person : frame.people) ++counts[person.id.value()];
  }
  return counts;
}

struct RealFile {
  std::string path;
  const Skeleton* skeleton;
  size_t frames;
  int64_t first_frame;
  int poses;
  int missing_joints;
};

// Skips only this file if it is missing.
void ExpectCounts(const RealFile& file) {
  KINEGRAPH_DATA_OR_SKIP(path, file.path);
  const TrackSequence tracks = ReadTracks(path);
  EXPECT_TRUE(tracks.header.skeleton == *file.skeleton) << path;
  EXPECT_EQ(tracks.frames.size(), file.frames) << path;
  EXPECT_EQ(tracks.frames.at(0).frame, file.first_frame) << path;
  EXPECT_EQ(CountPoses(tracks), file.poses) << path;
  EXPECT_EQ(CountMissingJoints(tracks), file.missing_joints) << path;
}

TEST(ReadTracks, CountsMatchReadmes) {
  const Skeleton* const coco = &Coco17();
  const std::string peers = "shelf/peers/";
  for (const RealFile& file : std::vector<RealFile>{
           {"shelf/tum/actorsGT.mat", &Tum14(), 3200, 0, 1180, 0},
           {"shelf/raw/gt.txt", &Tum15(), 301, 300, 510, 0},
           {"shelf/raw/skel.txt", &FourDA19(), 301, 300, 1019, 3091},
           {"shelf/raw/skel_202006.txt", &FourDA19(), 301, 300, 857, 0},
           {"campus/annotation_3d.json", &Tum14(), 2000, 0, 2175, 0},
           // Begins at 6.08 s.
           {"campus/result_3d.json", coco, 1660, 152, 4058, 1168},
           {"panoptic/body3DScene_00010600.json", &Panoptic19(), 1, 10600, 6,
            1},
           {peers + "4da_linux_O3_SKEL19.json", coco, 301, 300, 854, 0},
           {peers + "anipose_optim_c03_program_config_scores.json", coco, 301,
            300, 301, 0},
           {peers + "anipose_optim_default_bones.json", coco, 301, 300, 301, 0},
           {peers + "anipose_triangulate.json", coco, 301, 300, 301, 78},
           {peers + "p2s_hampel_butterworth.json", coco, 301, 300, 301, 1204},
           {peers + "p2s_hampel_gcv_spline.json", coco, 301, 300, 301, 1204},
           {peers + "p2s_hampel_kalman.json", coco, 301, 300, 301, 1204},
           {peers + "p2s_hampel_one_euro.json", coco, 301, 300, 301, 1204},
           {peers + "p2s_multi.json", coco, 301, 300, 846, 3384},
           {peers + "p2s_tri_raw.json", coco, 301, 300, 301, 1209}}) {
    ExpectCounts(file);
  }
}

TEST(ReadTracks, TumIdsAreTheIndicesOfActors) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/tum/actorsGT.mat");
  const TrackSequence truth = ReadTracks(path);
  using Counts = std::map<int64_t, int>;
  EXPECT_EQ(CountById(truth, 0, 3199),
            (Counts{{0, 433}, {1, 73}, {2, 424}, {3, 250}}));
  EXPECT_EQ(CountById(truth, 300, 600),
            (Counts{{0, 279}, {1, 37}, {2, 161}, {3, 33}}));
  EXPECT_EQ(truth.frames[300].frame, 300);
  EXPECT_TRUE(truth.frames[600].people.empty());
}

TEST(ReadTracks, FourDAssociationTruthEqualsTumTruth) {
  KINEGRAPH_DATA_OR_SKIP(mat, "shelf/tum/actorsGT.mat");
  KINEGRAPH_DATA_OR_SKIP(text, "shelf/raw/gt.txt");
  const TrackSequence truth = ReadTracks(mat);
  const TrackSequence other = ReadTracks(text);
  double worst_m = 0.0;
  for (const TrackFrame& frame : other.frames) {
    const TrackFrame& same = truth.frames[static_cast<size_t>(frame.frame)];
    ASSERT_EQ(frame.people.size(), same.people.size()) << frame.frame;
    for (const PersonPose& person : frame.people) {
      const auto original = std::find_if(
          same.people.begin(), same.people.end(),
          [&](const PersonPose& one) { return one.id == person.id; });
      ASSERT_NE(original, same.people.end()) << frame.frame;
      for (size_t j = 0; j < original->joints.size(); ++j) {
        worst_m = std::max(worst_m, (person.joints[j].position_m -
                                     original->joints[j].position_m)
                                        .norm());
      }
    }
  }
  // The text has six significant digits: for a number below 10 m, half a unit
  // of the sixth digit is 5e-6 m per axis, 8.7e-6 m in space.
  EXPECT_LT(worst_m, 1e-5);
}

TEST(ReadTracks, FourDAssociationZerosCanBeKept) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/raw/skel.txt");
  TrackReadOptions options;
  options.stored_zeros = StoredZeros::kKeep;
  options.first_frame = 0;
  const TrackSequence kept = ReadTracks(path, options);
  EXPECT_EQ(CountMissingJoints(kept), 0);
  EXPECT_EQ(kept.frames.front().frame, 0);
}

TEST(ReadTracks, LongcwAnnotationHasActorsNumbersAndMetres) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/annotation_3d.json");
  const TrackSequence truth = ReadTracks(path);
  EXPECT_EQ(truth.header.frame_rate_hz, 25.0);
  ASSERT_EQ(truth.frames.at(1999).frame, 1999);
  EXPECT_EQ(truth.frames[1999].time, 79'960'000'000);
  const auto in_first_part = CountById(truth, 350, 470);
  auto counts = CountById(truth, 650, 750);
  for (const auto& [id, count] : in_first_part) counts[id] += count;
  // Person-frames in the test frames by id, which is the actor's number.
  EXPECT_EQ(counts, (std::map<int64_t, int>{{0, 49}, {1, 189}, {2, 138}}));
  for (const TrackFrame& frame : truth.frames) {
    if (frame.people.empty()) continue;
    // Centimetres in the file; exact but for the rounding of the product.
    EXPECT_NEAR(frame.people[0].joints[0].position_m.x(), 1.2796239395899083,
                1e-12);
    break;
  }
}

TEST(ReadTracks, LongcwIdsBeyondIntegersAreRenumbered) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/result_3d.json");
  const TrackSequence result = ReadTracks(path);
  EXPECT_EQ(result.frames.back().frame, 1814);  // 72.56 s
  const auto ids = CountById(result, 0, 2000);
  EXPECT_EQ(ids.size(), 17u);
  EXPECT_EQ(ids.begin()->first, 0);
  EXPECT_EQ(ids.rbegin()->first, 16);
  EXPECT_EQ(result.frames.front().people.front().id, TrackId(0));
}

TEST(ReadTracks, FourDAssociationPeerFileIsReadWithTheGivenSkeleton) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/peers/4da_linux_O3_SKEL19.json");
  TrackReadOptions options;
  options.skeleton = FourDA19();
  const TrackSequence tracks = ReadTracks(path, options);
  EXPECT_TRUE(tracks.header.skeleton == FourDA19());
  EXPECT_EQ(tracks.frames[0].people[0].joints[0].position_m,
            Eigen::Vector3d(1.22559, -0.556535, 0.816124));
}

TEST(ReadTracks, PanopticIsReadFromFileAndFolder) {
  KINEGRAPH_DATA_OR_SKIP(file, "panoptic/body3DScene_00010600.json");
  const TrackSequence truth = ReadTracks(file);
  std::vector<int64_t> ids;
  for (const PersonPose& person : truth.frames[0].people) {
    ids.push_back(person.id.value());
  }
  EXPECT_THAT(ids, ElementsAre(14, 15, 16, 17, 18, 19));
  // Centimetres in the file; one rounding of the product.
  EXPECT_NEAR(truth.frames[0].people[0].joints[0].position_m.x(), -1.14695,
              1e-15);
  KINEGRAPH_DATA_OR_SKIP(folder, "panoptic");
  EXPECT_EQ(CountPoses(ReadTracks(folder)), 6);
}

TEST(ReadTracks, LongcwIdsAreKeptWhenAllAreSmall) {
  const auto frame = [](const std::string& time, const std::string& id) {
    std::string points;
    std::string scores;
    for (int j = 0; j < 14; ++j) {
      points += std::string(j == 0 ? "" : ", ") + "[1, 2, 3]";
      scores += std::string(j == 0 ? "" : ", ") + "1";
    }
    return "{\"timestamp\": " + time + ", \"poses\": [{\"id\": " + id +
           ", \"points_3d\": [" + points + "], \"scores\": [" + scores + "]}]}";
  };
  const TemporaryFolder folder;
  const auto ids = [&](const std::string& a, const std::string& b) {
    // 0.0601 s is nearest to frame 2 (0.08 s), and remains the frame's time.
    const TrackSequence tracks = ReadTracks(folder.Write(
        "t.json", "[" + frame("0.0", a) + ", " + frame("0.0601", b) + "]"));
    EXPECT_EQ(tracks.frames[1].frame, 2);
    EXPECT_EQ(tracks.frames[1].time, 60'100'000);
    return std::make_pair(tracks.frames[0].people[0].id.value(),
                          tracks.frames[1].people[0].id.value());
  };
  EXPECT_EQ(ids("7", "2"), (std::pair<int64_t, int64_t>(7, 2)));
  EXPECT_EQ(ids("18446744073709551615", "2"),
            (std::pair<int64_t, int64_t>(0, 1)));
}

}  // namespace
}  // namespace kinegraph
