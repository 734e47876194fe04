// DeepLabCut's CSV of predictions (Lightning Pose's too), a file a view: header
// rows "scorer", "individuals" (several animals or people only), "bodyparts",
// "coords", then a row a frame.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/bulk_json.h"
#include "core/io/csv_keypoints.h"
#include "core/io/csv_rows.h"
#include "core/io/detection_format.h"
#include "core/io/joint_names.h"
#include "core/io/text_file.h"

namespace kinegraph {
namespace {

// The columns of a file: people, each with all joints.
struct Columns {
  size_t first = 0;  // column that holds a coordinate
  size_t width = 0;
  std::vector<std::string> labels;
  std::vector<std::vector<KeypointColumns>> people;
};

class HeaderReader {
 public:
  void Take(std::vector<std::string> row) {
    if (row.front() == "scorer") {
      width_ = row.size();
    } else if (row.size() != width_) {
      throw InputError("found " + std::to_string(row.size()) +
                       " cells, expected " + std::to_string(width_));
    } else if (row.front() == "individuals") {
      individuals_ = std::move(row);
    } else if (row.front() == "bodyparts") {
      parts_ = std::move(row);
    } else {
      coords_ = std::move(row);
    }
  }

  Columns Finish() const {
    if (parts_.empty()) throw InputError("expected a row 'bodyparts'");
    Columns columns;
    columns.width = width_;
    while (columns.first < width_ && coords_[columns.first] != "x") {
      ++columns.first;  // the index: a frame, or folders and a file name
    }
    std::vector<std::string> individuals;
    for (size_t c = columns.first; c < width_; ++c) {
      const size_t person =
          PlaceOf(individuals_.empty() ? "" : individuals_[c], &individuals);
      const size_t joint = PlaceOf(parts_[c], &columns.labels);
      if (columns.people.size() <= person) columns.people.emplace_back();
      std::vector<KeypointColumns>& joints = columns.people[person];
      if (joints.size() <= joint) joints.resize(joint + 1);
      const int place = static_cast<int>(c);
      if (coords_[c] == "x") joints[joint].x = place;
      if (coords_[c] == "y") joints[joint].y = place;
      if (coords_[c] == "likelihood") joints[joint].confidence = place;
    }
    Check(&columns);
    return columns;
  }

 private:
  static size_t PlaceOf(const std::string& name,
                        std::vector<std::string>* names) {
    const auto at = std::find(names->begin(), names->end(), name);
    const auto place = static_cast<size_t>(at - names->begin());
    if (at == names->end()) names->push_back(name);
    return place;
  }

  static void Check(Columns* columns) {
    if (columns->people.empty()) throw InputError("expected columns x and y");
    for (std::vector<KeypointColumns>& joints : columns->people) {
      joints.resize(columns->labels.size());
      for (size_t j = 0; j < joints.size(); ++j) {
        if (joints[j].x >= 0 && joints[j].y >= 0) continue;
        throw InputError("bodypart '" + Printable(columns->labels[j]) +
                         "': expected the coords x and y of every individual");
      }
    }
  }

  size_t width_ = 0;
  std::vector<std::string> individuals_;
  std::vector<std::string> parts_;
  std::vector<std::string> coords_;
};

class Reader {
 public:
  Reader(const DetectionHeader& header, ZeroConfidence zero_confidence)
      : zero_confidence_(zero_confidence), collector_(header) {}

  void ReadFile(const std::string& path, size_t view_idx) {
    const std::string text = ReadTextFile(path);
    CsvRows rows(text);
    Located(
        path, [&] { return rows.Place(); },
        [&] {
          const Columns columns = ReadHeader(&rows);
          SettleSkeleton(columns.labels);
          std::vector<std::string> cells;
          while (rows.Next(&cells)) {
            if (cells.size() != columns.width) {
              throw InputError("found " + std::to_string(cells.size()) +
                               " cells, expected " +
                               std::to_string(columns.width));
            }
            ReadRow(cells, columns, view_idx);
          }
        });
  }

  std::unique_ptr<DetectionSource> Finish() { return collector_.Finish(); }

 private:
  static Columns ReadHeader(CsvRows* rows) {
    HeaderReader header;
    std::vector<std::string> cells;
    while (rows->Next(&cells)) {
      const bool last = cells.front() == "coords";
      const bool known = last || cells.front() == "scorer" ||
                         cells.front() == "individuals" ||
                         cells.front() == "bodyparts";
      if (!known) break;
      header.Take(std::move(cells));
      if (last) return header.Finish();
    }
    throw InputError(
        "expected the header rows scorer, bodyparts and coords of DeepLabCut");
  }

  void SettleSkeleton(const std::vector<std::string>& labels) {
    const Skeleton& known = collector_.header().skeleton;
    if (known.joint_count() == 0) {
      collector_.set_skeleton(SkeletonOfLabels(labels));
    } else if (known.joints().size() != labels.size()) {
      throw InputError("found " + std::to_string(labels.size()) +
                       " bodyparts, expected the " +
                       std::to_string(known.joints().size()) + " of '" +
                       known.name() + "'");
    }
  }

  void ReadRow(const std::vector<std::string>& cells, const Columns& columns,
               size_t view_idx) {
    const int64_t frame = FrameOfCell(cells[columns.first - 1]);
    collector_.Touch(frame);
    for (const std::vector<KeypointColumns>& person : columns.people) {
      Detection detection =
          ReadKeypointRow(cells, person, columns.labels, zero_confidence_);
      if (CountFound(detection) == 0) continue;
      collector_.Add(frame, view_idx)->joints = std::move(detection.joints);
    }
  }

  const ZeroConfidence zero_confidence_;
  DetectionCollector collector_;
};

std::unique_ptr<DetectionSource> Open(const std::string& path,
                                      const DetectionReadOptions& options) {
  const auto files = ListViewFiles(path, ".csv");
  DetectionHeader header;
  header.skeleton = options.skeleton.value_or(Skeleton());
  header.frame_rate_hz = options.frame_rate_hz;
  for (const auto& [view, file] : files) header.view_names.push_back(view);
  Reader reader(header, options.zero_confidence);
  for (size_t v = 0; v < files.size(); ++v) reader.ReadFile(files[v].second, v);
  return reader.Finish();
}

bool Recognise(const DetectionHead& head) {
  return head.beginning.compare(0, 7, "scorer,") == 0;
}

}  // namespace

DetectionFormat DeepLabCutFormat() {
  DetectionFormat format;
  format.name = "deeplabcut";
  format.layout = "CSV, a file a view (Lightning Pose too)";
  format.extension = ".csv";
  format.files = DetectionFormat::Files::kFileAView;
  format.recognise = Recognise;
  format.open = Open;
  return format;
}

}  // namespace kinegraph
