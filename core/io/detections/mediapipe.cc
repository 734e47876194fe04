// MediaPipe's landmarks as a table, a file a view: "frame,NAME_x,NAME_y,
// NAME_visibility,...", a row a frame (and, with a column "person", a person),
// in pixels. Names are those of any skeleton, in any spelling.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/split.h"
#include "core/io/detections/csv_keypoints.h"
#include "core/io/detections/format.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

struct MediapipeColumns {
  int frame = -1;
  std::vector<std::string> labels;  // of the joints
  std::vector<KeypointColumns> joints;
};

MediapipeColumns FindMediapipeColumns(const std::vector<std::string>& header) {
  MediapipeColumns columns;
  const auto joint_of = [&columns](const std::string& label) -> auto& {
    const auto at =
        std::find(columns.labels.begin(), columns.labels.end(), label);
    if (at != columns.labels.end()) {
      return columns.joints[static_cast<size_t>(at - columns.labels.begin())];
    }
    columns.labels.push_back(label);
    return columns.joints.emplace_back();
  };
  for (size_t c = 0; c < header.size(); ++c) {
    const std::string& name = header[c];
    const int place = static_cast<int>(c);
    if (name == "frame") columns.frame = place;
    if (EndsIn(name, "_x")) {
      joint_of(name.substr(0, name.size() - 2)).x = place;
    } else if (EndsIn(name, "_y")) {
      joint_of(name.substr(0, name.size() - 2)).y = place;
    }
    for (const std::string end : {"_visibility", "_confidence", "_score"}) {
      if (EndsIn(name, end)) {
        joint_of(name.substr(0, name.size() - end.size())).confidence = place;
      }
    }
  }
  if (columns.frame < 0 || columns.joints.empty()) {
    throw InputError("expected columns frame, NAME_x, NAME_y, NAME_visibility");
  }
  for (size_t j = 0; j < columns.joints.size(); ++j) {
    if (columns.joints[j].x < 0 || columns.joints[j].y < 0) {
      throw InputError("joint '" + Printable(columns.labels[j]) +
                       "': expected the columns _x and _y");
    }
  }
  return columns;
}

class MediapipeReader {
 public:
  MediapipeReader(const DetectionHeader& header,
                  const DetectionReadOptions& options)
      : options_(options), collector_(header) {}

  void ReadFile(const std::string& path, size_t view_idx) {
    const std::string text = ReadTextFile(path);
    CsvRows rows(text);
    Located(
        path, [&] { return rows.Place(); },
        [&] {
          std::vector<std::string> cells;
          if (!rows.Next(&cells)) throw InputError("is empty");
          const size_t width = cells.size();
          const MediapipeColumns columns = FindMediapipeColumns(cells);
          collector_.SettleSkeleton(columns.labels);
          while (rows.Next(&cells, width)) ReadRow(cells, columns, view_idx);
        });
  }

  std::unique_ptr<DetectionSource> Finish() { return collector_.Finish(); }

 private:
  void ReadRow(const std::vector<std::string>& cells,
               const MediapipeColumns& columns, size_t view_idx) {
    const int64_t frame =
        FrameOfName(cells[static_cast<size_t>(columns.frame)]);
    Detection detection = ReadKeypointRow(cells, columns.joints, columns.labels,
                                          options_.zero_confidence);
    collector_.Touch(frame);
    if (CountFound(detection) == 0) return;
    collector_.Add(frame, view_idx)->joints = std::move(detection.joints);
  }

  const DetectionReadOptions& options_;
  DetectionCollector collector_;
};

std::unique_ptr<DetectionSource> OpenMediapipeFile(
    const std::string& path, const DetectionReadOptions& options) {
  return OpenViewFiles<MediapipeReader>(path, options, ".csv");
}

bool RecogniseMediapipe(const DetectionHead& head) {
  const std::vector<std::string> row = head.FirstRow();
  return !row.empty() && row.front() == "frame" &&
         std::any_of(row.begin(), row.end(), [](const std::string& name) {
           return EndsIn(name, "_x");
         });
}

// ---- Writing ----

class MediapipeView {
 public:
  MediapipeView(const std::string& path, const Skeleton& skeleton)
      : file_(path) {
    out_.Text("frame,person");
    for (const std::string& joint : skeleton.joints()) {
      for (const char* column : {"_x", "_y", "_visibility"}) {
        out_.Add(",", LongJointName(joint), column);
      }
    }
    out_.Text("\n");
  }

  void Write(int64_t frame, const std::vector<Detection>& detections) {
    int person = 0;
    for (const Detection& detection : detections) {
      out_.Add(frame, ",", person++);
      for (const Keypoint& joint : detection.joints) {
        if (joint.found) {
          out_.Add(",", joint.px.x(), ",", joint.px.y(), ",", joint.confidence);
        } else {
          out_.Text(",,,");
        }
      }
      out_.Text("\n");
    }
    out_.FlushTo(&file_);
  }

  void Commit() {
    out_.FlushTo(&file_);
    file_.Commit();
  }

 private:
  AtomicFile file_;
  JsonOutput out_;
};

void WriteMediapipe(const std::string& path,
                    const DetectionWriteOptions& /*options*/,
                    DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  AtomicFolder folder(path);
  const auto files =
      MakeViewFiles<MediapipeView>(header, ".csv", folder, header.skeleton);
  DetectionLossFinder finder(header);
  const int64_t empty_frames = WriteViewFiles(files, source, &finder);
  folder.Commit();
  finder.Report(FindSkeletonOf(header.skeleton.joints()) != nullptr,
                lost_fields);
  NoteEmptyFrames(empty_frames, lost_fields);
}

}  // namespace

DetectionFormat MediaPipeCsvFormat() {
  DetectionFormat format;
  format.name = "mediapipe";
  format.layout = "CSV, a file a view: frame, NAME_x, NAME_y, NAME_visibility";
  format.extension = ".csv";
  format.files = DetectionFormat::Files::kFileAView;
  format.recognise = RecogniseMediapipe;
  format.open = OpenMediapipeFile;
  format.write = WriteMediapipe;
  return format;
}

}  // namespace kinegraph
