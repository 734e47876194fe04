#include "core/io/tracks/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/base/split.h"
#include "core/io/binary/npz_file.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/tracks.h"
#include "tests/core/io/input_error.h"
#include "tests/support/opensim_trc.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::IsEmpty;
using testing::TemporaryFolder;

std::vector<std::string> LinesOf(const std::string& path) {
  std::vector<std::string> lines = Split(ReadTextFile(path), '\n');
  EXPECT_EQ(lines.back(), "") << "the last line ends";
  lines.pop_back();
  return lines;
}

double NumberOf(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  EXPECT_TRUE(!text.empty() && *end == '\0') << text;
  return number;
}

// Two people who come and go, numbers of all digits, a dropped frame.
TrackSequence TracksToExport(bool with_covariances) {
  Random random(5);
  TrackSequence tracks;
  tracks.header.skeleton = Coco17();
  tracks.header.mode = "graph";
  tracks.header.frame_rate_hz = 25.0;
  for (const int64_t f : {300, 301, 302, 304, 305}) {
    TrackFrame frame;
    frame.frame = f;
    frame.time = f * 40'000'000;
    for (const int64_t id : {7, 2}) {
      if (f == 300 || (f == 302 && id == 7)) continue;
      PersonPose person;
      person.id = TrackId(id);
      for (int j = 0; j < 17; ++j) {
        Joint3d joint;
        joint.status = static_cast<JointStatus>(random.Index(3));
        if (joint.present()) {
          joint.position_m = {random.Normal() / 3.0, random.Normal() * 1e-7,
                              -random.Uniform()};
        }
        person.joints.push_back(joint);
        person.inlier_views.push_back(static_cast<int>(random.Index(5)));
        person.covariances.emplace_back();
        if (with_covariances && joint.present() && random.Chance(0.7)) {
          Eigen::Matrix3d c;
          for (int r = 0; r < 3; ++r) {
            for (int k = r; k < 3; ++k) {
              c(r, k) = c(k, r) = 1e-4 * random.Normal();
            }
          }
          person.covariances.back() = c;
        }
      }
      frame.people.push_back(person);
    }
    tracks.frames.push_back(frame);
  }
  return tracks;
}

// ---- CSV ----

TEST(TrackExport, CsvHoldsEveryJointBitForBit) {
  for (const bool with_covariances : {false, true}) {
    const TrackSequence tracks = TracksToExport(with_covariances);
    const TemporaryFolder folder;
    const std::string path = folder.path() / "tracks.csv";
    LostFields lost_fields;
    WriteTracksCsv(path, tracks, {}, &lost_fields);
    EXPECT_THAT(lost_fields,
                Contains("1 frames with nobody in them are not kept"));
    const std::vector<std::string> lines = LinesOf(path);
    EXPECT_EQ(lines[0],
              std::string("frame,time_s,id,joint,x_m,y_m,z_m,status,views") +
                  (with_covariances ? ",cov_xx_m2,cov_xy_m2,cov_xz_m2,"
                                      "cov_yy_m2,cov_yz_m2,cov_zz_m2"
                                    : ""));
    size_t line = 1;
    for (const TrackFrame& frame : tracks.frames) {
      for (const PersonPose& person : frame.people) {
        for (size_t j = 0; j < 17; ++j) {
          ASSERT_LT(line, lines.size());
          const std::vector<std::string> cells = Split(lines[line++], ',');
          ASSERT_EQ(cells.size(), with_covariances ? 15u : 9u);
          EXPECT_EQ(NumberOf(cells[0]), frame.frame);
          EXPECT_EQ(NumberOf(cells[1]), ToSeconds(frame.time));
          EXPECT_EQ(NumberOf(cells[2]), person.id.value());
          EXPECT_EQ(cells[3], Coco17().joints()[j]);
          EXPECT_EQ(cells[7], ToString(person.joints[j].status));
          EXPECT_EQ(NumberOf(cells[8]), person.inlier_views[j]);
          for (size_t axis = 0; axis < 3; ++axis) {
            if (!person.joints[j].present()) {
              EXPECT_EQ(cells[4 + axis], "");
              continue;
            }
            EXPECT_EQ(NumberOf(cells[4 + axis]),
                      person.joints[j].position_m[static_cast<int>(axis)]);
          }
          if (!with_covariances) continue;
          const auto& covariance = person.covariances[j];
          EXPECT_EQ(cells[9].empty(), !covariance.has_value());
          if (!covariance) continue;
          EXPECT_EQ(NumberOf(cells[9]), (*covariance)(0, 0));
          EXPECT_EQ(NumberOf(cells[11]), (*covariance)(0, 2));
          EXPECT_EQ(NumberOf(cells[13]), (*covariance)(1, 2));
          EXPECT_EQ(NumberOf(cells[14]), (*covariance)(2, 2));
        }
      }
    }
    EXPECT_EQ(line, lines.size());
  }
}

TEST(TrackExport, CsvQuotesJointNames) {
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("odd", {"a,b", "c\"d"}, {});
  TrackFrame frame;
  frame.people.resize(1);
  frame.people[0].id = TrackId(1);
  frame.people[0].joints.resize(2);
  tracks.frames = {frame};
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.csv";
  LostFields lost_fields;
  WriteTracksCsv(path, tracks, {}, &lost_fields);
  EXPECT_EQ(ReadTextFile(path),
            "frame,time_s,id,joint,x_m,y_m,z_m,status\n"
            "0,,1,\"a,b\",,,,missing\n0,,1,\"c\"\"d\",,,,missing\n");
}

// ---- TRC ----

// What a reader of TRC relies on.
struct TrcFile {
  std::vector<std::vector<std::string>> header;  // five lines
  std::vector<std::string> markers;
  std::vector<std::vector<std::string>> rows;
};

TrcFile ReadTrc(const std::string& path) {
  TrcFile file;
  for (const std::string& line : LinesOf(path)) {
    std::vector<std::string> cells = Split(line, '\t');
    // What ends a row, or line 5, is no cell.
    if (file.header.size() > 3 && cells.size() % 3 == 0) cells.pop_back();
    if (file.header.size() < 5) {
      file.header.push_back(cells);
    } else {
      file.rows.push_back(cells);
    }
  }
  for (size_t c = 2; c < file.header[3].size(); c += 3) {
    file.markers.push_back(file.header[3][c]);
  }
  return file;
}

// The counts of the header are those of the body.
void ExpectSound(const TrcFile& file) {
  const size_t columns = 2 + 3 * file.markers.size();
  EXPECT_EQ(file.header[0].size(), 4u);
  EXPECT_EQ(file.header[1].size(), 8u);
  EXPECT_EQ(file.header[2].size(), 8u);
  EXPECT_EQ(file.header[3].size(), columns);
  EXPECT_EQ(file.header[4].size(), columns);
  EXPECT_EQ(NumberOf(file.header[2][2]), file.rows.size());
  EXPECT_EQ(NumberOf(file.header[2][3]), file.markers.size());
  for (size_t r = 0; r < file.rows.size(); ++r) {
    ASSERT_EQ(file.rows[r].size(), columns) << "row " << r;
    EXPECT_EQ(NumberOf(file.rows[r][0]), r + 1);
  }
}

TEST(TrackExport, TrcHoldsEveryMarkerBitForBit) {
  const TrackSequence tracks = TracksToExport(false);
  const TemporaryFolder folder;
  const std::string path = folder.path() / "trc";
  LostFields lost_fields;
  WriteTracksTrc(path, tracks, {}, &lost_fields);
  EXPECT_THAT(lost_fields,
              Contains(HasSubstr("1 frames that the input leaves out")));
  EXPECT_THAT(ListFolder(path), ElementsAre("person_2.trc", "person_7.trc"));
  EXPECT_TRUE(testing::OpenSimReads(path));
  for (const int64_t id : {2, 7}) {
    const std::string name = "person_" + std::to_string(id) + ".trc";
    const TrcFile file = ReadTrc(path + "/" + name);
    ExpectSound(file);
    EXPECT_THAT(file.header[0],
                ElementsAre("PathFileType", "4", "(X/Y/Z)", name));
    EXPECT_THAT(file.header[2],
                ElementsAre("25", "25", "6", "17", "m", "25", "300", "6"));
    EXPECT_EQ(file.markers, Coco17().joints());
    for (size_t r = 0; r < file.rows.size(); ++r) {
      const int64_t number = 300 + static_cast<int64_t>(r);
      // 303 is not in the tracks: half way between its neighbours.
      EXPECT_DOUBLE_EQ(NumberOf(file.rows[r][1]),
                       static_cast<double>(number) / 25.0);
      const PersonPose* person = nullptr;
      for (const TrackFrame& frame : tracks.frames) {
        if (frame.frame != number) continue;
        for (const PersonPose& candidate : frame.people) {
          if (candidate.id.value() == id) person = &candidate;
        }
      }
      for (size_t j = 0; j < 17; ++j) {
        const size_t c = 2 + 3 * j;
        if (person == nullptr || !person->joints[j].present()) {
          EXPECT_EQ(file.rows[r][c] + file.rows[r][c + 1] + file.rows[r][c + 2],
                    "");
          continue;
        }
        const Eigen::Vector3d& world = person->joints[j].position_m;
        EXPECT_EQ(NumberOf(file.rows[r][c]), world.y());
        EXPECT_EQ(NumberOf(file.rows[r][c + 1]), world.z()) << "y is up";
        EXPECT_EQ(NumberOf(file.rows[r][c + 2]), world.x());
      }
    }
  }
}

// Line by line beside a file that Pose2Sim wrote: everything but names and
// numbers is the same.
TEST(TrackExport, TrcIsLaidOutAsPose2SimsOwn) {
  KINEGRAPH_DATA_OR_SKIP(
      peer_path, "pose2sim/peer_result/S00_P00_T01_BalancingTrial_0-100.trc");
  const TrcFile peer = ReadTrc(peer_path);
  ExpectSound(peer);
  // A recording of the same size.
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("peer", peer.markers, {});
  tracks.header.frame_rate_hz = 60.0;
  for (int64_t f = 0; f < 100; ++f) {
    TrackFrame frame;
    frame.frame = f;
    frame.time = FromSeconds(static_cast<double>(f) / 60.0);
    frame.people.resize(1);
    frame.people[0].id = TrackId(0);
    const std::vector<std::string>& cells = peer.rows[static_cast<size_t>(f)];
    for (size_t j = 0; j < peer.markers.size(); ++j) {
      const size_t c = 2 + 3 * j;
      frame.people[0].joints.push_back(
          {{NumberOf(cells[c + 2]), NumberOf(cells[c]), NumberOf(cells[c + 1])},
           JointStatus::kObserved});
    }
    tracks.frames.push_back(frame);
  }
  const TemporaryFolder folder;
  LostFields lost_fields;
  WriteTracksTrc(folder.path() / "trc", tracks, {}, &lost_fields);
  const std::string path = folder.path() / "trc/person_0.trc";
  const TrcFile ours = ReadTrc(path);
  ExpectSound(ours);
  EXPECT_TRUE(testing::OpenSimReads(path));
  EXPECT_EQ(LinesOf(path).size(), LinesOf(peer_path).size());
  for (const size_t line : {1u, 2u, 3u, 4u}) {
    EXPECT_EQ(ours.header[line], peer.header[line]) << "line " << line + 1;
  }
  for (size_t r = 0; r < 100; ++r) {
    for (size_t c = 2; c < peer.rows[r].size(); ++c) {
      EXPECT_EQ(NumberOf(ours.rows[r][c]), NumberOf(peer.rows[r][c]));
    }
  }
}

TEST(TrackExport, TrcAxesKeepLeftAndRightApart) {
  const Eigen::Vector3d world(1.0, 2.0, 3.0);
  EXPECT_EQ(AxisMap().Apply(world), Eigen::Vector3d(2, 3, 1));
  EXPECT_EQ(AxisMap::Parse("y,z,x").Apply(world), Eigen::Vector3d(2, 3, 1));
  EXPECT_EQ(AxisMap::Parse("x,-y,-z").Apply(world), Eigen::Vector3d(1, -2, -3));
  for (const char* text : {"", "x", "x,y", "x,y,z,x", "x,y,y", "x y z", "a,b,c",
                           "x,z,y", "-x,y,z", "--x,y,z", "x,y,z,", ",x,y"}) {
    EXPECT_THAT(InputErrorOf([&] { AxisMap::Parse(text); }),
                HasSubstr("--axes"))
        << text;
  }
}

TEST(TrackExport, TrcRefusesWhatItCannotHold) {
  const TemporaryFolder folder;
  const auto error_of = [&](const TrackSequence& tracks) {
    LostFields lost_fields;
    return InputErrorOf([&] {
      WriteTracksTrc(folder.path() / "trc", tracks, {}, &lost_fields);
    });
  };
  TrackSequence tracks = TracksToExport(false);
  tracks.header.frame_rate_hz = 0.0;
  EXPECT_THAT(error_of(tracks), HasSubstr("frame rate"));
  tracks = TracksToExport(false);
  tracks.frames.back().frame = int64_t{1} << 40;
  EXPECT_THAT(error_of(tracks), HasSubstr("span"));
  tracks = TracksToExport(false);
  for (TrackFrame& frame : tracks.frames) frame.people.clear();
  EXPECT_THAT(error_of(tracks), HasSubstr("nobody"));
  EXPECT_THAT(ListFolder(folder.path().string()), IsEmpty());
}

// ---- NPZ ----

TEST(NpzFile, CrcIsThatOfZip) {
  // The check value of the catalogue of CRC algorithms (CRC-32/ISO-HDLC).
  EXPECT_EQ(Crc32("123456789"), 0xCBF43926u);
  EXPECT_EQ(Crc32(""), 0u);
}

bool HasNumpy() {
  return std::system("/usr/bin/python3 -c 'import numpy' > /dev/null 2>&1") ==
         0;
}

// Runs Python, which fails with an assertion's message.
void ExpectPython(const TemporaryFolder& folder, const std::string& script) {
  const std::string path = folder.Write("check.py", script);
  const std::string errors = folder.path() / "errors.txt";
  EXPECT_EQ(std::system(("/usr/bin/python3 " + path + " 2> " + errors).c_str()),
            0)
      << ReadTextFile(errors);
}

TEST(TrackExport, NumpyReadsTheArrays) {
  if (!HasNumpy()) GTEST_SKIP() << "needs numpy of /usr/bin/python3";
  const TrackSequence tracks = TracksToExport(true);
  const TemporaryFolder folder;
  const std::string npz = folder.path() / "tracks.npz";
  const std::string csv = folder.path() / "tracks.csv";
  LostFields lost_fields;
  WriteTracksNpz(npz, tracks, {}, &lost_fields);
  // The table holds the same bits (above), so it is what to compare with.
  WriteTracksCsv(csv, tracks, {}, &lost_fields);
  ExpectPython(folder, R"(
import csv, zipfile, numpy as np
npz, table = ')" + npz + "', '" +
                           csv + R"('
assert zipfile.ZipFile(npz).testzip() is None
a = np.load(npz, allow_pickle=False)
assert sorted(a.files) == ['bones', 'covariance', 'frame_rate', 'frames', 'ids',
    'joints', 'positions', 'skeleton', 'status', 'times', 'views'], a.files
assert a['positions'].shape == (5, 2, 17, 3), a['positions'].shape
assert a['positions'].dtype == np.float64 and a['status'].dtype == np.int8
assert a['covariance'].shape == (5, 2, 17, 3, 3)
assert a['ids'].tolist() == [2, 7]
assert a['frames'].tolist() == [300, 301, 302, 304, 305]
assert a['frame_rate'] == 25.0 and str(a['skeleton']) == 'coco17'
assert a['bones'].shape[1] == 2 and a['bones'].max() < 17
joints = a['joints'].tolist()
assert joints[0] == 'nose' and len(joints) == 17
names = {'missing': 0, 'inferred': 1, 'observed': 2}
seen = np.full((5, 2, 17), False)
upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
for row in csv.DictReader(open(table)):
    f = a['frames'].tolist().index(int(row['frame']))
    p = a['ids'].tolist().index(int(row['id']))
    j = joints.index(row['joint'])
    seen[f, p, j] = True
    assert a['times'][f] == float(row['time_s'])
    assert a['status'][f, p, j] == names[row['status']]
    assert a['views'][f, p, j] == int(row['views'])
    for axis, key in enumerate(['x_m', 'y_m', 'z_m']):
        value = a['positions'][f, p, j, axis]
        assert np.isnan(value) if row[key] == '' else value == float(row[key])
    for (r, c), key in zip(upper, ['xx', 'xy', 'xz', 'yy', 'yz', 'zz']):
        text = row['cov_' + key + '_m2']
        for value in (a['covariance'][f, p, j, r, c], a['covariance'][f, p, j, c, r]):
            assert np.isnan(value) if text == '' else value == float(text)
assert seen.sum() == 17 * 7
assert (a['status'][~seen] == -1).all() and (a['views'][~seen] == -1).all()
assert np.isnan(a['positions'][~seen]).all()
)");
}

TEST(TrackExport, NumpyReadsOddNamesAndNoPeople) {
  if (!HasNumpy()) GTEST_SKIP() << "needs numpy of /usr/bin/python3";
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton(
      "k\xC3\xB6rper", {"\xE8\x86\x9D", "\xF0\x9F\x99\x82 b", "\xFF"}, {});
  tracks.frames.resize(2);
  tracks.frames[1].frame = 1;
  const TemporaryFolder folder;
  const std::string npz = folder.path() / "tracks.npz";
  LostFields lost_fields;
  WriteTracksNpz(npz, tracks, {}, &lost_fields);
  ExpectPython(folder, R"(
import numpy as np
a = np.load(')" + npz + R"(', allow_pickle=False)
assert a['positions'].shape == (2, 0, 3, 3)
assert a['bones'].shape == (0, 2)
assert np.isnan(a['frame_rate']) and np.isnan(a['times']).all()
assert a['joints'].tolist() == ['\u819d', '\U0001F642 b', '\ufffd']
assert str(a['skeleton']) == 'k\u00f6rper'
assert 'covariance' not in a.files and 'views' not in a.files
)");
}

// Real results: the authors' code on Shelf.
TEST(TrackExport, ShelfAsTrc) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/reference/paper_code_shelf_warm3.json");
  TrackReadOptions options;
  options.frame_rate_hz = 25.0;
  const TrackSequence shelf = ReadTracks(path, options);
  const TemporaryFolder folder;
  size_t joints = 0;
  for (const TrackFrame& frame : shelf.frames) {
    for (const PersonPose& person : frame.people) {
      joints += static_cast<size_t>(CountPresent(person.joints));
    }
  }
  EXPECT_GT(joints, 10'000u);
  const std::string trc = folder.path() / "trc";
  LostFields lost_fields;
  WriteTracksTrc(trc, shelf, {}, &lost_fields);
  EXPECT_TRUE(testing::OpenSimReads(trc));
  size_t cells = 0;
  for (const std::string& name : ListFolder(trc)) {
    const TrcFile file = ReadTrc(trc + "/" + name);
    ExpectSound(file);
    for (const auto& row : file.rows) {
      for (size_t c = 2; c < row.size(); c += 3)
        cells += row[c].empty() ? 0 : 1;
    }
  }
  EXPECT_EQ(cells, joints);
}

}  // namespace
}  // namespace kinegraph
