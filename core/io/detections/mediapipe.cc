// MediaPipe's landmarks as a table, a file a view: "frame,NAME_x,NAME_y,
// NAME_visibility,...", a row a frame (and, with a column "person", a person),
// in pixels. Names are those of any skeleton, in any spelling.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
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
    for (const auto& [end, column] :
         {std::pair<std::string, int KeypointColumns::*>{"_x",
                                                         &KeypointColumns::x},
          {"_y", &KeypointColumns::y},
          {"_visibility", &KeypointColumns::confidence},
          {"_confidence", &KeypointColumns::confidence},
          {"_score", &KeypointColumns::confidence}}) {
      if (!EndsIn(name, end)) continue;
      joint_of(name.substr(0, name.size() - end.size())).*column = place;
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

void ReadMediapipeFile(const std::string& path, size_t view_idx,
                       const DetectionReadOptions& options,
                       DetectionCollector* collector) {
  MediapipeColumns columns;
  ReadCsv(
      path,
      [&](const std::vector<std::string>& header) {
        columns = FindMediapipeColumns(header);
        collector->SettleSkeleton(columns.labels);
      },
      [&](const std::vector<std::string>& cells) {
        const int64_t frame =
            FrameOfName(cells[static_cast<size_t>(columns.frame)]);
        std::vector<Keypoint> joints = ReadKeypointRow(
            cells, columns.joints, columns.labels, options.zero_confidence);
        collector->Touch(frame);
        collector->AddFound(frame, view_idx, std::move(joints));
      });
}

void WriteMediapipeView(int64_t frame, const std::vector<Detection>& detections,
                        ViewFile* file) {
  int person = 0;
  for (const Detection& detection : detections) {
    file->out.Add(frame, ",", person++);
    for (const Keypoint& joint : detection.joints) {
      if (joint.found) {
        file->out.Add(",", joint.px.x(), ",", joint.px.y(), ",",
                      joint.confidence);
      } else {
        file->out.Text(",,,");
      }
    }
    file->out.Text("\n");
  }
}

}  // namespace

bool RecogniseMediapipe(const DetectionHead& head) {
  const std::vector<std::string> row = head.FirstRow();
  return !row.empty() && row.front() == "frame" &&
         std::any_of(row.begin(), row.end(), [](const std::string& name) {
           return EndsIn(name, "_x");
         });
}

std::unique_ptr<DetectionSource> OpenMediapipe(
    const std::string& path, const DetectionReadOptions& options) {
  return ReadViews(ListViewFiles(path, ".csv"), options, ReadMediapipeFile);
}

void WriteMediapipe(const std::string& path, const DetectionWriteOptions&,
                    DetectionSource* source, LostFields* lost_fields) {
  const Skeleton& skeleton = source->header().skeleton;
  std::string heading = "frame,person";
  for (const std::string& joint : skeleton.joints()) {
    for (const char* column : {"_x", "_y", "_visibility"}) {
      heading += "," + LongJointName(joint) + column;
    }
  }
  const int64_t empty_frames =
      WriteViewFiles(path, ".csv", heading + "\n", source,
                     FindSkeletonOf(skeleton.joints()) != nullptr, lost_fields,
                     WriteMediapipeView);
  NoteEmptyFrames(empty_frames, lost_fields);
}

}  // namespace kinegraph
