// OpenPose's JSON output: VIEW/VIEW_FFFFFFFFFFFF_keypoints.json, each
// {"version": 1.3, "people": [{"person_id": [-1], "pose_keypoints_2d":
// [x, y, c, ...], "face_keypoints_2d": [], ...}, ...]}.
#include <fmt/format.h>

#include "core/io/detections/export.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/lost_fields.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json_output.h"

namespace kinegraph {
namespace {

// Lists that OpenPose always writes, empty when that part is off.
constexpr const char* kEmptyParts =
    ", \"face_keypoints_2d\": [], \"hand_left_keypoints_2d\": [], "
    "\"hand_right_keypoints_2d\": [], \"pose_keypoints_3d\": [], "
    "\"face_keypoints_3d\": [], \"hand_left_keypoints_3d\": [], "
    "\"hand_right_keypoints_3d\": []}";

void WritePeople(const std::string& path,
                 const std::vector<Detection>& detections, JsonOutput* out) {
  out->Text("{\"version\": 1.3, \"people\": [");
  out->Join(detections, [out](const Detection& detection) {
    out->Text("{\"person_id\": [-1], \"pose_keypoints_2d\": [");
    out->Join(detection.joints,
              [out](const Keypoint& joint) { WriteKeypoint(joint, out); });
    out->Add("]", kEmptyParts);
  });
  out->Text("]}\n");
  AtomicFile file(path);
  out->FlushTo(&file);
  file.Commit();
}

}  // namespace

void WriteOpenPose(const std::string& path,
                   const DetectionWriteOptions& /*options*/,
                   DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  AtomicFolder folder(path);
  for (const std::string& view : header.view_names) {
    CheckFileName(view, "view");
    MakeFolder(folder.PathOf(view));
  }
  DetectionLossFinder finder(header);
  DetectionFrame frame;
  JsonOutput out;
  while (source->Next(&frame)) {
    finder.See(frame);
    for (size_t v = 0; v < header.view_names.size(); ++v) {
      const std::string& view = header.view_names[v];
      const std::string name =
          fmt::format("{}/{}_{:012}_keypoints.json", view, view, frame.frame);
      WritePeople(folder.PathOf(name), frame.views[v].detections, &out);
    }
  }
  folder.Commit();
  finder.Report(IsToldByJointCount(header.skeleton), lost_fields);
}

}  // namespace kinegraph
