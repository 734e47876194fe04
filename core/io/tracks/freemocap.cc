// FreeMoCap's 3D points of one person, in millimetres: a table NAME_x, NAME_y,
// NAME_z, ... with a row a frame and no number of it
// (mediapipe_body_3d_xyz.csv), or an array [frames, points, 3]
// (mediapipe_body_3d_xyz.npy, mediapipe_skeleton_3d.npy), NaN where a point is
// not there. Frames count from 0, the person is 0.
#include <string>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/binary/npz_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr const char* kMode = "freemocap";

void AddRow(int64_t frame, const double* numbers, TrackCollector* collector) {
  Pose3d joints(collector->joint_count());
  for (size_t j = 0; j < joints.size(); ++j) {
    joints[j] =
        ObservedJoint(Eigen::Vector3d(numbers + 3 * j) / kMillimetresPerMetre);
  }
  collector->AddIfSeen(frame, TrackId(0), std::move(joints));
}

// ---- The table ----

// Names of the points; empty when a column is none of NAME_x, NAME_y, NAME_z in
// this order.
std::vector<std::string> PointsOf(const std::vector<std::string>& cells) {
  std::vector<std::string> names;
  for (size_t c = 0; c + 2 < cells.size(); c += 3) {
    const std::string& first = cells[c];
    if (first.size() < 3) return {};
    const std::string name = first.substr(0, first.size() - 2);
    if (first != name + "_x" || cells[c + 1] != name + "_y" ||
        cells[c + 2] != name + "_z") {
      return {};
    }
    names.push_back(name);
  }
  return cells.size() % 3 == 0 ? names : std::vector<std::string>();
}

TrackSequence ReadTable(const std::string& path,
                        const TrackReadOptions& options) {
  const std::string text = ReadTextFile(path);
  CsvRows rows(text);
  return Located(
      path, [&] { return rows.Place(); },
      [&] {
        std::vector<std::string> cells;
        std::vector<std::string> names;
        if (rows.Next(&cells)) names = PointsOf(cells);
        if (names.empty()) {
          throw InputError("expected columns NAME_x, NAME_y, NAME_z, ...");
        }
        const size_t width = cells.size();
        TrackCollector collector(kMode, SkeletonOfNames(names, options),
                                 options);
        std::vector<double> numbers;
        int64_t frame = 0;
        while (rows.Next(&cells, width)) {
          numbers.clear();
          for (const std::string& cell : cells) {
            numbers.push_back(NumberOfCell(cell).value_or(kNan));
          }
          AddRow(frame++, numbers.data(), &collector);
        }
        return collector.Finish();
      });
}

// ---- The array ----

TrackSequence ReadArray(const std::string& path,
                        const TrackReadOptions& options) {
  const NpzReader reader(path);
  const std::vector<size_t> shape = reader.At("", 3).shape;
  const std::vector<double> numbers = reader.Numbers("", 3);
  if (shape[2] != 3) reader.Fail("", "expected the shape [frames, points, 3]");
  const Skeleton skeleton = options.skeleton.value_or(MediaPipe33());
  const size_t points = shape[1];
  if (points < skeleton.joints().size()) {
    reader.Fail("", "has " + std::to_string(points) +
                        " points, expected at least the " +
                        std::to_string(skeleton.joints().size()) + " of '" +
                        skeleton.name() + "'");
  }
  TrackCollector collector(kMode, skeleton, options);
  for (size_t f = 0; f < shape[0]; ++f) {
    AddRow(static_cast<int64_t>(f), &numbers[f * points * 3], &collector);
  }
  return collector.Finish();
}

bool IsArray(const TrackHead& head) {
  if (head.is_folder || !head.BeginsWith("\x93NUMPY")) return false;
  const size_t begin = head.beginning.find("'shape': (");
  const size_t end = head.beginning.find(", 3)", begin);
  if (begin == std::string::npos || end == std::string::npos) return false;
  // [frames, points, 3]
  size_t commas = 0;
  for (size_t at = begin + 10; at < end; ++at) {
    commas += head.beginning[at] == ',' ? 1 : 0;
  }
  return commas == 1 && end - begin < 60;
}

bool IsTable(const TrackHead& head) {
  return !head.is_folder && head.beginning.find('\n') != std::string::npos &&
         !PointsOf(head.FirstRow()).empty();
}

}  // namespace

TrackFormat FreeMoCapTrackFormat() {
  TrackFormat format;
  format.name = kMode;
  format.layout = "FreeMoCap's 3D points: CSV NAME_x, NAME_y, NAME_z; NPY";
  format.unit_m = 0.001;
  format.recognise = [](const TrackHead& head) {
    return IsArray(head) || IsTable(head);
  };
  format.read = [](const std::string& path, const TrackReadOptions& options) {
    return BeginningOf(path, 6) == "\x93NUMPY" ? ReadArray(path, options)
                                               : ReadTable(path, options);
  };
  return format;
}

}  // namespace kinegraph
