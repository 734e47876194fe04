// Shared by readers and writers of track formats. For core/io only.
#ifndef KINEGRAPH_CORE_IO_TRACKS_SHARED_H_
#define KINEGRAPH_CORE_IO_TRACKS_SHARED_H_

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/constants.h"
#include "core/data/identity_edit.h"
#include "core/io/adapters/adapter.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/lost_fields.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"

namespace kinegraph {

// Throws InputError with a formatted text that does not name the file.
template <typename... Args>
[[noreturn]] void Refuse(fmt::format_string<Args...> text, Args&&... args) {
  throw InputError(fmt::format(text, std::forward<Args>(args)...));
}

// ---- Axes ----

// The convention of motion capture laboratories: Z is up.
inline AxisMap C3dAxes() { return AxisMap::Parse("x,y,z"); }
// For BVH and glTF, in which Y is up. Blender's importers rotate Y to Z and
// thereby restore the world of the tracks.
inline AxisMap AnimationAxes() { return AxisMap::Parse("x,z,-y"); }

// ---- Reading ----

// The skeleton of a file that names its joints and optionally bones: the one in
// the options, otherwise SkeletonOfLabels. Throws InputError, which does not
// name the file, if the skeleton in the options has other joints.
Skeleton SkeletonOfNames(const std::vector<std::string>& joints,
                         const TrackReadOptions& options,
                         const std::vector<Bone>& bones = {});

// The joint at a position; missing if a coordinate is not finite.
inline Joint3d ObservedJoint(const Eigen::Vector3d& position_m) {
  if (!std::isfinite(position_m.sum())) return {};
  return {position_m, JointStatus::kObserved};
}

// A joint's position [cm]; zero if it is missing.
inline Eigen::Vector3d CentimetresOf(const Joint3d& joint) {
  if (!joint.present()) return Eigen::Vector3d::Zero();
  return kCentimetresPerMetre * joint.position_m;
}

// Parses "observed", "inferred" or "missing". Its InputError does not name the
// file.
JointStatus ParseJointStatus(std::string_view text);

// Collects people; frames may be added in any order.
class TrackCollector {
 public:
  // `mode`: name of the format. The frame rate is the one in the options,
  // otherwise `file_hz`, the one that the file states. Throws InputError if
  // these differ and TrackReadOptions::refuse_other_rate is set.
  TrackCollector(const std::string& mode, const Skeleton& skeleton,
                 const TrackReadOptions& options, double file_hz = 0.0);
  size_t joint_count() const { return header_.skeleton.joints().size(); }
  // Returns the frame; creates it, without people, if it does not exist.
  TrackFrame* Touch(int64_t frame);
  // Adds a person. Throws InputError, which does not name the file, if the
  // frame has this person already.
  PersonPose* Add(int64_t frame, TrackId id);
  // Adds the person if any joint is present; creates the frame in any case.
  void AddIfSeen(int64_t frame, TrackId id, Pose3d joints);
  TrackSequence Finish();

 private:
  TrackHeader header_;
  std::map<int64_t, TrackFrame> frames_;
};

// Reads what an adapter prints: kinegraph's own tracks, with the skeleton in
// the options, if any, which must have the same number of joints.
TrackSequence ReadTracksByAdapter(const Adapter& adapter,
                                  const std::string& path,
                                  const TrackReadOptions& options);
// Writes a file in a format of kinegraph-adapters.
void WriteTracksByAdapter(const std::string& format, const std::string& path,
                          const TrackSequence& tracks,
                          const TrackWriteOptions& options);

// ---- Rows: formats with one row per frame ----

struct TrackRow {
  double time_s = 0.0;
  const TrackFrame* frame = nullptr;  // null: the tracks lack this frame
};

inline constexpr int64_t kMaxRows = 10'000'000;

// One row for every frame number from the first to the last. Times of frames
// that the tracks lack are interpolated linearly. Throws InputError naming the
// format for more than kMaxRows.
std::vector<TrackRow> MakeTrackRows(const TrackSequence& tracks,
                                    const std::string& format);

// nullptr if the person is absent.
const PersonPose* FindPerson(const TrackFrame* frame, TrackId id);

// Frame rate of the tracks [Hz]. Throws InputError naming the format if it is
// unknown.
double RequireFrameRate(const TrackSequence& tracks, const std::string& format);

// ---- People ----

// Ids of all people in the recording, ascending.
std::vector<int64_t> IdsOf(const TrackSequence& tracks);
// The same, but throws InputError if there are no people.
std::vector<int64_t> RequirePeople(const TrackSequence& tracks);

// The id in a text; nullopt if it is not valid.
std::optional<TrackId> PersonIdOf(std::string_view text);

// "person_3", the label of a person without a name.
std::string PersonLabel(int64_t id);

// The name of each person, or "person_3" without a name. People of the same
// name become "Anna_person_3", so that all titles differ.
std::vector<std::string> PersonTitles(const std::vector<int64_t>& ids,
                                      const PersonNames& names);

// A file of a format with one file per person: person_3.trc, person_4_Anna.trc.
struct PersonFile {
  std::string path;
  TrackId id;
};

// The file `path` itself, or the files with this extension in a folder. Their
// ids are the numbers after the last "person_" (kinegraph) or "_P" (Pose2Sim)
// in their names if all have different numbers, otherwise 0, 1, 2 in the order
// of the names. Throws InputError for a folder without such files.
std::vector<PersonFile> ListPersonFiles(const std::string& path,
                                        const std::string& extension);

// The names contained in file names: "person_3_Anna.trc" is Anna's.
PersonNames NamesOfPersonFiles(const std::string& path,
                               const std::string& extension);

// Calls `write_file` for each person: with `path` itself if it has the
// extension, otherwise with files in the folder `path`, which appears when all
// are complete. People's names are cut after 100 bytes, and ASCII characters
// other than letters and digits become hyphens. Throws InputError if there are
// no people, or several for one file.
void WritePersonFiles(
    const std::string& path, const std::string& extension,
    const TrackSequence& tracks, const PersonNames& names,
    const std::function<void(const std::string& file, TrackId id)>& write_file);

// The same for tables with one row per frame: writes `head(file)`, then the
// output of `write_row` for each row; `person` is null if the person is absent.
void WritePersonTables(
    const std::string& path, const std::string& extension,
    const TrackSequence& tracks, const PersonNames& names,
    const std::vector<TrackRow>& rows,
    const std::function<std::string(const std::string& file)>& head,
    const std::function<void(size_t row, const PersonPose* person,
                             JsonOutput* out)>& write_row);

// ---- Losses of a format ----

// What tracks contain other than positions.
struct TrackContents {
  bool has_covariances = false;
  bool has_views = false;     // counts of inlier views
  bool has_matches = false;   // matches, weights and scores
  bool has_inferred = false;  // joints with that status
  // Some frame's time differs from 0, or the frame rate is known.
  bool has_clock = false;
  int64_t empty_frames = 0;  // number of frames without people
};
TrackContents ContentsOf(const TrackSequence& tracks);

// For each joint of the skeleton: whether any person has it in any frame.
std::vector<bool> JointsSeen(const TrackSequence& tracks);

// What a format may lose; noted only if the tracks have such content.
enum class Loss {
  kCovariances,
  kViews,             // counts of views, and matches
  kMatches,           // matches only
  kInferredAlike,     // inferred joints are written like observed ones
  kInferredObserved,  // inferred joints are read back as observed
  kEmptyFrames,
  kClock,         // times and frame rate
  kUnknownClock,  // noted if times and frame rate are unknown
};
void NoteLosses(const TrackContents& contents,
                std::initializer_list<Loss> losses, LostFields* lost_fields);
// Notes the losses of formats that store only frames, identities and positions.
void NotePositionsOnly(const TrackContents& contents, LostFields* lost_fields);
// Notes the number of frames that the input lacks but the file contains; `what`
// completes the note: "have empty rows".
void NoteAddedRows(const TrackSequence& tracks, size_t row_count,
                   const std::string& what, LostFields* lost_fields);
// If an identity is `first_lost` or above, notes that readers of the format
// renumber all identities.
void NoteRenumbering(const TrackSequence& tracks, int64_t first_lost,
                     LostFields* lost_fields);
// Notes that the file does not specify the skeleton.
void NoteSkeleton(const TrackSequence& tracks, LostFields* lost_fields);

// The longest prefix of `text` of up to `max_bytes` that does not end within a
// UTF-8 character.
std::string WholeLetters(const std::string& text, size_t max_bytes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_SHARED_H_
