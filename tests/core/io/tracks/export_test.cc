#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "core/io/binary/npz_file.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/input_error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::IsEmpty;
using testing::RandomTracks;
using testing::TemporaryFolder;
using testing::WriteAs;

// ---- CSV ----

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
  WriteAs("csv", path, tracks);
  EXPECT_EQ(ReadTextFile(path),
            "frame,time_s,id,joint,x_m,y_m,z_m,status\n"
            "0,,1,\"a,b\",,,,missing\n0,,1,\"c\"\"d\",,,,missing\n");
}

// ---- TRC ----

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
    return InputErrorOf([&] { WriteAs("trc", folder.path() / "trc", tracks); });
  };
  TrackSequence tracks = RandomTracks(Coco17());
  tracks.header.frame_rate_hz = 0.0;
  EXPECT_THAT(error_of(tracks), HasSubstr("frame rate"));
  tracks = RandomTracks(Coco17());
  tracks.frames.back().frame = int64_t{1} << 40;
  EXPECT_THAT(error_of(tracks), HasSubstr("span"));
  tracks = RandomTracks(Coco17());
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

// Runs Python, which fails with an assertion's message.
void ExpectPython(const TemporaryFolder& folder, const std::string& script) {
  const std::string path = folder.Write("check.py", script);
  const std::string errors = folder.path() / "errors.txt";
  EXPECT_EQ(std::system(("/usr/bin/python3 " + path + " 2> " + errors).c_str()),
            0)
      << ReadTextFile(errors);
}

TEST(TrackExport, NumpyReadsTheArrays) {
  if (!testing::HasNumpy()) GTEST_SKIP() << "needs numpy of /usr/bin/python3";
  const TrackSequence tracks = RandomTracks(Coco17());
  const TemporaryFolder folder;
  const std::string npz = folder.path() / "tracks.npz";
  const std::string csv = folder.path() / "tracks.csv";
  WriteAs("npz", npz, tracks);
  // The table holds the same bits, so it is what to compare with.
  WriteAs("csv", csv, tracks);
  ExpectPython(folder, R"(
import csv, zipfile, numpy as np
npz, table = ')" + npz + "', '" +
                           csv + R"('
assert zipfile.ZipFile(npz).testzip() is None
a = np.load(npz, allow_pickle=False)
assert sorted(a.files) == ['bones', 'covariance', 'frame_rate', 'frames', 'ids',
    'joints', 'positions', 'skeleton', 'status', 'times', 'views'], a.files
assert a['positions'].shape == (10, 3, 17, 3), a['positions'].shape
assert a['positions'].dtype == np.float64 and a['status'].dtype == np.int8
assert a['covariance'].shape == (10, 3, 17, 3, 3)
assert a['ids'].tolist() == [0, 2, 5]
assert a['frames'].tolist() == list(range(300, 310))
assert a['frame_rate'] == 25.0 and str(a['skeleton']) == 'coco17'
assert a['bones'].shape[1] == 2 and a['bones'].max() < 17
joints = a['joints'].tolist()
assert joints[0] == 'nose' and len(joints) == 17
names = {'missing': 0, 'inferred': 1, 'observed': 2}
seen = np.full((10, 3, 17), False)
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
assert seen.sum() == 17 * 24
assert (a['status'][~seen] == -1).all() and (a['views'][~seen] == -1).all()
assert np.isnan(a['positions'][~seen]).all()
)");
}

TEST(TrackExport, NumpyReadsOddNamesAndNoPeople) {
  if (!testing::HasNumpy()) GTEST_SKIP() << "needs numpy of /usr/bin/python3";
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton(
      "k\xC3\xB6rper", {"\xE8\x86\x9D", "\xF0\x9F\x99\x82 b", "\xFF"}, {});
  tracks.frames.resize(2);
  tracks.frames[1].frame = 1;
  const TemporaryFolder folder;
  const std::string npz = folder.path() / "tracks.npz";
  WriteAs("npz", npz, tracks);
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

}  // namespace
}  // namespace kinegraph
