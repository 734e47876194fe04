// CMU Panoptic's hdPose3d, a folder: body3DScene_FFFFFFFF.json a frame. Joints
// are Panoptic's nineteen, taken over by name.
#include <fmt/format.h>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

void WriteBody(const PersonPose& person, const std::vector<int>& map,
               JsonOutput* out) {
  out->Add("{ \"id\": ", person.id.value(), ",\n\"joints19\": [");
  out->Join(map, [&](int j) {
    const bool is_there =
        j >= 0 && person.joints[static_cast<size_t>(j)].present();
    Eigen::Vector3d at_cm = Eigen::Vector3d::Zero();
    if (is_there) {
      at_cm = kCentimetresPerMetre *
              person.joints[static_cast<size_t>(j)].position_m;
    }
    out->Numbers({at_cm.x(), at_cm.y(), at_cm.z()});
    out->Text(is_there ? ", 1" : ", -1");
  });
  out->Text("]\n}");
}

}  // namespace

void WriteTracksPanoptic(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& /*options*/,
                         LostFields* lost_fields) {
  const std::vector<int> map = MapByName(tracks.header.skeleton, Panoptic19());
  AtomicFolder folder(path);
  JsonOutput out;
  for (const TrackFrame& frame : tracks.frames) {
    out.Text("{ \"version\": 0.7,\n\"fpsType\": \"hd_29_97\",\n\"bodies\": [");
    if (!frame.people.empty()) out.Text("\n");
    out.Join(
        frame.people,
        [&](const PersonPose& person) { WriteBody(person, map, &out); }, ",\n");
    out.Text("\n] }\n");
    AtomicFile file(
        folder.PathOf(fmt::format("body3DScene_{:08d}.json", frame.frame)));
    out.FlushTo(&file);
    file.Commit();
  }
  folder.Commit();
  NotePositionsOnly(tracks, lost_fields);
  if (tracks.header.frame_rate_hz != kHdFrameRateHz) {
    lost_fields->push_back(
        "times and frame rate are not kept: name the rate when reading, it is "
        "taken for 29.97 Hz");
  }
  size_t kept = 0;
  for (const int j : map) kept += j >= 0 ? 1 : 0;
  const auto joints = static_cast<size_t>(tracks.header.skeleton.joint_count());
  if (kept < map.size() || kept < joints) {
    lost_fields->push_back(
        "joints are Panoptic's nineteen by name: " + std::to_string(kept) +
        " of the input's " + std::to_string(joints) +
        " are kept, the others of the nineteen are missing");
  }
}

}  // namespace kinegraph
