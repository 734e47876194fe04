// 4D association's gt.txt and skel.txt: "JOINTS FRAMES", then for each frame
// the number of people and for each of them the id and four rows: x, y, z,
// weight.
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

void WritePerson(const PersonPose& person, JsonOutput* out) {
  out->Add(person.id.value(), "\n");
  for (int row = 0; row < 4; ++row) {
    const auto write = [&](const Joint3d& joint) {
      const double weight = joint.present() ? 1.0 : 0.0;
      out->Number(row == 3 || weight == 0.0 ? weight : joint.position_m[row]);
    };
    out->Join(person.joints, write, " ");
    out->Text("\n");
  }
}

}  // namespace

void WriteTracks4dAssociation(const std::string& path,
                              const TrackSequence& tracks,
                              const TrackExportOptions& /*options*/,
                              LostFields* lost_fields) {
  constexpr int64_t kMaxFrames = 10'000'000;
  const int64_t first = tracks.frames.empty() ? 0 : tracks.frames[0].frame;
  const int64_t count =
      tracks.frames.empty() ? 0 : tracks.frames.back().frame - first + 1;
  if (count > kMaxFrames) {
    throw InputError("the tracks span " + std::to_string(count) +
                     " frames, this format has one entry for each");
  }
  AtomicFile file(path);
  JsonOutput out;
  out.Add(tracks.header.skeleton.joint_count(), " ", count, "\n");
  int64_t next = first;
  for (const TrackFrame& frame : tracks.frames) {
    for (; next < frame.frame; ++next) out.Text("0\n");
    ++next;
    out.Add(frame.people.size(), "\n");
    for (const PersonPose& person : frame.people) WritePerson(person, &out);
    out.FlushTo(&file);
  }
  out.FlushTo(&file);
  file.Commit();
  NotePositionsOnly(tracks, lost_fields);
  NoteClock(tracks, lost_fields);
  lost_fields->push_back(
      "the first frame is not kept: name it when reading "
      "(--set=tracks.first_frame=" +
      std::to_string(first) + ")");
  const auto missing = count - static_cast<int64_t>(tracks.frames.size());
  if (missing > 0) {
    lost_fields->push_back(
        std::to_string(missing) +
        " frames that the input leaves out have entries without "
        "people");
  }
  const Skeleton& skeleton = tracks.header.skeleton;
  if (skeleton != Tum15() && skeleton != FourDA19()) {
    NoteSkeleton(tracks, lost_fields);
  }
}

}  // namespace kinegraph
