// Caliscope's points: xy_TRACKER.csv (or xy.csv), one table of the whole
// recording, a row a point: sync_index, cam_id (port in older versions),
// keypoint_id (point_id), img_loc_x, img_loc_y [px], and perhaps object_id and
// frame_time [s]. Where the table has no times they come from timestamps.csv or
// frame_time_history.csv beside it. Views are cam_0, cam_1, ... after the
// cameras; frames are the indices of synchronised pictures.
//
// A session's folder is read by the one such table in it: its own, one of a
// recording, or that of the calibration. Views of cameras that the session
// ignores or has not placed are left out there.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/time.h"
#include "core/data/limits.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/names.h"
#include "core/io/text/toml_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// ---- Where the table is ----

bool IsTableName(const std::string& name) {
  return name.rfind("xy_", 0) == 0 && fs::path(name).extension() == ".csv";
}

void FindTables(const fs::path& folder, int depth,
                std::vector<std::string>* tables) {
  if (depth == 0) return;
  std::vector<fs::path> folders;
  bool found = false;
  for (const std::string& name : ListFolder(folder.string())) {
    if (name.front() == '.') continue;
    const fs::path inside = folder / name;
    if (IsTableName(name)) {
      tables->push_back(inside.string());
      found = true;
    }
    if (IsFolder(inside.string())) folders.push_back(inside);
  }
  if (found) return;
  for (const fs::path& inside : folders) FindTables(inside, depth - 1, tables);
}

// The tables of points in a session: its own, else those of its recordings,
// else those of its calibration.
std::vector<std::string> TablesOf(const std::string& path) {
  if (!IsFolder(path)) return {path};
  std::vector<std::string> tables;
  // SESSION/calibration/extrinsic/TRACKER
  constexpr int kDepth = 4;
  const fs::path recordings = fs::path(path) / "recordings";
  if (IsFolder(recordings.string())) FindTables(recordings, kDepth, &tables);
  if (tables.empty()) FindTables(path, kDepth, &tables);
  return tables;
}

std::string TableOf(const std::string& path) {
  const std::vector<std::string> tables = TablesOf(path);
  if (tables.size() == 1) return tables.front();
  if (tables.empty()) throw InputError(path, "", "has no xy_TRACKER.csv");
  std::string names;
  for (const std::string& table : tables) {
    names += (names.empty() ? "" : ", ") +
             Printable(fs::path(table).lexically_relative(path).string());
  }
  throw InputError(path, "",
                   "has several tables of points: give one of them (" + names +
                       ") as detections");
}

// Cameras that a session's folder says it ignores or has not placed: their
// views belong to no camera.
std::set<int64_t> UnusedCameras(const std::string& session) {
  std::set<int64_t> unused;
  if (!IsFolder(session)) return unused;
  for (const char* name : {"camera_array.toml", "config.toml"}) {
    const std::string path = (fs::path(session) / name).string();
    if (!IsFile(path)) continue;
    const Json root =
        ToJson(ParseToml(ReadTextFile(path, kMaxSmallFileBytes), path));
    const bool is_array =
        root.contains("cameras") && root["cameras"].is_object();
    for (const auto& [key, camera] :
         (is_array ? root["cameras"] : root).items()) {
      const std::optional<int64_t> number = LastInteger(key);
      const bool is_camera = number.has_value() && camera.is_object() &&
                             (is_array || key.rfind("cam_", 0) == 0);
      if (!is_camera) continue;
      const bool is_placed =
          camera.contains("rotation") && camera["rotation"].is_array();
      if (!is_placed || camera.value("ignore", Json()) == Json(true)) {
        unused.insert(*number);
      }
    }
    break;
  }
  return unused;
}

// Where the columns stand, by their names in newer versions.
using Places = std::map<std::string, size_t>;

Places PlacesOf(const std::vector<std::string>& header) {
  Places places;
  for (size_t c = 0; c < header.size(); ++c) places.emplace(header[c], c);
  for (const auto& [old, now] :
       {std::pair{"port", "cam_id"}, {"point_id", "keypoint_id"}}) {
    if (places.count(old) > 0) places.emplace(now, places[old]);
  }
  return places;
}

bool HasAll(const Places& places, std::initializer_list<const char*> names) {
  return std::all_of(names.begin(), names.end(),
                     [&](const char* name) { return places.count(name) > 0; });
}

bool AreOfPoints(const Places& places) {
  return HasAll(places, {"sync_index", "cam_id", "keypoint_id", "img_loc_x",
                         "img_loc_y"});
}

struct Point {
  int64_t sync = 0;
  int64_t camera = 0;
  int64_t object = 0;
  int64_t point = 0;
  double x_px = 0.0;
  double y_px = 0.0;
};

// Seconds of a camera's picture.
using Times = std::map<std::pair<int64_t, int64_t>, double>;

// Cells of one row, with what is wrong with them.
class Row {
 public:
  Row(const std::vector<std::string>& header, const Places& places,
      const std::vector<std::string>& cells)
      : header_(header), places_(places), cells_(cells) {}

  const Places& places() const { return places_; }
  double Number(const char* name) const {
    const size_t at = places_.at(name);
    const auto number =
        Located(header_[at], [&] { return NumberOfCell(cells_[at]); });
    if (number.has_value() && std::isfinite(*number)) return *number;
    Fail(name, "a number");
  }

  int64_t Index(const char* name) const {
    const double number = Number(name);
    if (number >= 0.0 && number <= static_cast<double>(kMaxFrame) &&
        number == std::floor(number)) {
      return static_cast<int64_t>(number);
    }
    Fail(name, "a whole number from 0");
  }

 private:
  [[noreturn]] void Fail(const char* name, const char* expected) const {
    const size_t at = places_.at(name);
    throw InputError(header_[at] + ": found '" + Printable(cells_[at]) +
                     "', expected " + expected);
  }

  const std::vector<std::string>& header_;
  const Places& places_;
  const std::vector<std::string>& cells_;
};

template <typename Read>
void ForEachRow(const std::string& path, const Read& read) {
  std::vector<std::string> header;
  Places places;
  ReadCsv(
      path,
      [&](const std::vector<std::string>& names) {
        header = names;
        places = PlacesOf(names);
      },
      [&](const std::vector<std::string>& cells) {
        read(Row(header, places, cells));
      });
}

void AddTime(const Row& row, Times* times) {
  const double time_s = row.Number("frame_time");
  if (!(std::abs(time_s) < 1e9)) {
    throw InputError("frame_time: found " + std::to_string(time_s) +
                     ", expected seconds");
  }
  times->emplace(std::make_pair(row.Index("sync_index"), row.Index("cam_id")),
                 time_s);
}

// Of the tables of times beside the points.
Times ReadTimesBeside(const std::string& table) {
  Times times;
  const fs::path folder = fs::path(table).parent_path();
  for (const char* name : {"timestamps.csv", "frame_time_history.csv"}) {
    const std::string path = (folder / name).string();
    if (!IsFile(path)) continue;
    ForEachRow(path, [&](const Row& row) {
      if (!HasAll(row.places(), {"sync_index", "cam_id", "frame_time"})) return;
      AddTime(row, &times);
    });
    if (!times.empty()) break;
  }
  return times;
}

class CaliscopeReader {
 public:
  CaliscopeReader(const DetectionReadOptions& options, std::set<int64_t> unused)
      : options_(options), unused_(std::move(unused)) {}

  std::unique_ptr<DetectionSource> Read(const std::string& table) {
    ForEachRow(table, [&](const Row& row) {
      if (!AreOfPoints(row.places())) {
        throw InputError(
            "expected columns sync_index, cam_id, keypoint_id, img_loc_x and "
            "img_loc_y");
      }
      ReadPoint(row);
    });
    if (times_.empty()) times_ = ReadTimesBeside(table);
    return Located(table, [&] { return Collect(fs::path(table)); });
  }

 private:
  void ReadPoint(const Row& row) {
    Point point;
    point.sync = row.Index("sync_index");
    point.camera = row.Index("cam_id");
    const bool has_objects = row.places().count("object_id") > 0;
    point.object = has_objects ? row.Index("object_id") : 0;
    point.point = row.Index("keypoint_id");
    point.x_px = row.Number("img_loc_x");
    point.y_px = row.Number("img_loc_y");
    if (unused_.count(point.camera) > 0) return;
    points_.push_back(point);
    if (row.places().count("frame_time") > 0) AddTime(row, &times_);
  }

  // Joints by the points' numbers.
  void SettleSkeleton(const fs::path& table) {
    const std::string tracker = table.stem().string();
    const bool is_mediapipe = tracker == "xy_POSE" ||
                              tracker == "xy_HOLISTIC" ||
                              tracker == "xy_SIMPLE_HOLISTIC";
    if (options_.skeleton.has_value() || is_mediapipe) {
      // Holistic's hands count from 100 and 200, its face from 500.
      skeleton_ = options_.skeleton.value_or(MediaPipe33());
      for (int64_t j = 0; j < skeleton_.joint_count(); ++j) joints_[j] = j;
      return;
    }
    std::set<int64_t> numbers;
    for (const Point& point : points_) numbers.insert(point.point);
    std::vector<std::string> names;
    for (const int64_t number : numbers) {
      joints_[number] = static_cast<int64_t>(names.size());
      names.push_back("point_" + std::to_string(number));
    }
    skeleton_ = Skeleton("caliscope", names, {});
  }

  // Median rate of the pictures; 0 without times.
  double FrameRate() const {
    std::map<int64_t, std::pair<int64_t, double>> last;  // of each camera
    std::vector<double> steps;
    for (const auto& [place, time] : times_) {
      const auto& [sync, camera] = place;
      const auto before = last.find(camera);
      if (before != last.end() && sync > before->second.first) {
        steps.push_back((time - before->second.second) /
                        static_cast<double>(sync - before->second.first));
      }
      last[camera] = {sync, time};
    }
    if (steps.empty()) return 0.0;
    const double step = Median(steps);
    return step > 1e-6 ? std::round(100.0 / step) / 100.0 : 0.0;
  }

  std::unique_ptr<DetectionSource> Collect(const fs::path& table) {
    if (points_.empty()) throw InputError("has no points");
    SettleSkeleton(table);
    std::map<int64_t, size_t> views;
    for (const Point& point : points_) views[point.camera] = 0;
    DetectionHeader header = HeaderOf({}, options_, skeleton_);
    if (!(header.frame_rate_hz > 0.0)) header.frame_rate_hz = FrameRate();
    for (auto& [camera, place] : views) {
      place = header.view_names.size();
      header.view_names.push_back("cam_" + std::to_string(camera));
    }
    DetectionCollector collector(header);
    std::map<std::tuple<int64_t, int64_t, int64_t>, size_t> people;
    for (const Point& point : points_) {
      const auto joint = joints_.find(point.point);
      if (joint == joints_.end()) continue;
      const Keypoint keypoint =
          MakeKeypoint(point.x_px, point.y_px, 1.0, options_.zero_confidence);
      const size_t view = views.at(point.camera);
      ViewDetections& seen = collector.Touch(point.sync)->views[view];
      if (!keypoint.found) continue;
      const auto [place, is_new] =
          people.emplace(std::tuple(point.sync, point.camera, point.object),
                         seen.detections.size());
      if (is_new) {
        collector.Add(point.sync, view)
            ->joints.resize(skeleton_.joints().size());
      }
      seen.detections[place->second]
          .joints[static_cast<size_t>(joint->second)] = keypoint;
    }
    SetTimes(views, &collector);
    return collector.Finish();
  }

  // The cameras run freely: each picture has its own time, which counts from
  // where the first frame stands at the recording's rate.
  void SetTimes(const std::map<int64_t, size_t>& views,
                DetectionCollector* collector) {
    if (options_.frame_rate_hz > 0.0 || points_.empty()) return;
    std::map<int64_t, std::vector<std::pair<size_t, double>>> of_frames;
    for (const auto& [place, time] : times_) {
      const auto view = views.find(place.second);
      if (view != views.end()) {
        of_frames[place.first].emplace_back(view->second, time);
      }
    }
    std::set<int64_t> frames;
    for (const Point& point : points_) frames.insert(point.sync);
    std::optional<double> origin_s;
    TimeNs last = std::numeric_limits<TimeNs>::min();
    for (const auto& [sync, times] : of_frames) {
      if (frames.count(sync) == 0) continue;
      DetectionFrame* frame = collector->Touch(sync);
      std::vector<double> seconds;
      for (const auto& [view, time] : times) seconds.push_back(time);
      const double middle = Median(seconds);
      if (!origin_s.has_value()) {
        origin_s = middle - ToSeconds(frame->time);
      }
      // Times of frames ascend, whichever cameras saw them.
      frame->time = std::max(FromSeconds(middle - *origin_s), last + 1);
      last = frame->time;
      for (ViewDetections& view : frame->views) view.capture_time = frame->time;
      for (const auto& [view, time] : times) {
        frame->views[view].capture_time = FromSeconds(time - *origin_s);
      }
    }
  }

  const DetectionReadOptions& options_;
  const std::set<int64_t> unused_;
  std::vector<Point> points_;
  Times times_;
  Skeleton skeleton_;
  std::map<int64_t, int64_t> joints_;  // of a point's number
};

// Only what is a session is searched: folders may hold a million files.
bool IsSession(const std::string& folder) {
  const std::vector<std::string> names = ListFolder(folder);
  return std::any_of(names.begin(), names.end(), [](const std::string& name) {
    return name == "camera_array.toml" || name == "config.toml" ||
           IsTableName(name);
  });
}

}  // namespace

std::unique_ptr<DetectionSource> OpenCaliscope(
    const std::string& path, const DetectionReadOptions& options) {
  return CaliscopeReader(options, UnusedCameras(path)).Read(TableOf(path));
}

bool RecogniseCaliscope(const DetectionHead& head) {
  if (head.is_folder) {
    return IsSession(head.path) && !TablesOf(head.path).empty();
  }
  return head.beginning.rfind("sync_index", 0) == 0 &&
         AreOfPoints(PlacesOf(head.FirstRow()));
}

}  // namespace kinegraph
