// 4D association's gt.txt and skel.txt: "JOINTS FRAMES", then for each frame
// the number of people and for each person its id and four rows of JOINTS
// numbers: x, y, z [m] and weight.
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/words.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

Skeleton FourDAssociationSkeleton(int64_t joint_count,
                                  const TrackReadOptions& options) {
  if (options.skeleton && options.skeleton->joint_count() == joint_count) {
    return *options.skeleton;
  }
  if (joint_count == 15) return Tum15();
  if (joint_count == 19) return FourDA19();
  throw InputError("found " + std::to_string(joint_count) +
                   " joints, expected 15 (gt.txt) or 19 (skel.txt)");
}

void ReadPose(Words* words, StoredZeros stored_zeros, Pose3d* pose) {
  std::vector<double> numbers(4 * pose->size());
  for (double& number : numbers) {
    number = words->Number("a number: x, y, z or weight");
  }
  const size_t count = pose->size();
  for (size_t j = 0; j < count; ++j) {
    if (numbers[3 * count + j] > 0.0 || stored_zeros == StoredZeros::kKeep) {
      (*pose)[j] = ObservedJoint(
          {numbers[j], numbers[count + j], numbers[2 * count + j]});
    }
  }
}

TrackSequence ReadPeople(Words* words, const TrackReadOptions& options) {
  // Limits only keep a broken file from asking for all memory.
  constexpr int64_t kMaxJoints = 1000;
  constexpr int64_t kMaxFrames = 1 << 30;
  TrackCollector collector(
      "4d_association",
      FourDAssociationSkeleton(
          words->Integer("the number of joints", 1, kMaxJoints), options),
      options);
  const int64_t frame_count =
      words->Integer("the number of frames", 0, kMaxFrames);
  for (int64_t i = 0; i < frame_count; ++i) {
    const int64_t frame = options.first_frame + i;
    collector.Touch(frame);
    const int64_t people =
        words->Integer("the number of people", 0, kMaxFrames);
    for (int64_t p = 0; p < people; ++p) {
      const TrackId id(words->Integer("the id of a person", 0, kMaxId));
      ReadPose(words, options.stored_zeros, &collector.Add(frame, id)->joints);
    }
  }
  if (!words->Next().empty()) throw InputError("text after the last frame");
  return collector.Finish();
}

TrackSequence ReadFourDAssociation(const std::string& path,
                                   const TrackReadOptions& options) {
  const std::string text = ReadTextFile(path);
  Words words(text);
  return Located(
      path, [&] { return words.Place(); },
      [&] { return ReadPeople(&words, options); });
}

// ---- Writing ----

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

// 4D association's gt.txt or skel.txt, an entry for every frame from the first
// to the last; a missing joint has weight 0.
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
  const TrackContents contents = ContentsOf(tracks);
  NotePositionsOnly(contents, lost_fields);
  NoteClock(contents, lost_fields);
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

}  // namespace

TrackFormat FourDAssociationTrackFormat() {
  TrackFormat format;
  format.name = "4da";
  format.layout = "4D association's gt.txt, skel.txt";
  format.unit_m = 1.0;
  format.is_unmistakable = false;
  format.recognise = [](const TrackHead& head) {
    return head.kind >= '0' && head.kind <= '9';
  };
  format.read = ReadFourDAssociation;
  format.write = WriteTracks4dAssociation;
  return format;
}

}  // namespace kinegraph
