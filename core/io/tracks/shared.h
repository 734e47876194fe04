// What readers and writers of track formats share. For core/io alone.
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

#include "core/data/identity_edit.h"
#include "core/io/adapters/adapter.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/lost_fields.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"

namespace kinegraph {

// Throws InputError, without a file, of a text as fmt makes it.
template <typename... Args>
[[noreturn]] void Refuse(fmt::format_string<Args...> text, Args&&... args) {
  throw InputError(fmt::format(text, std::forward<Args>(args)...));
}

// ---- Axes ----

// Those of laboratories: Z is up.
inline AxisMap C3dAxes() { return AxisMap::Parse("x,y,z"); }
// Of BVH and glTF. Blender, which turns Y up into Z up, then shows our world.
inline AxisMap AnimationAxes() { return AxisMap::Parse("x,z,-y"); }

// ---- Reading ----

// The skeleton of a file that names its joints, and perhaps bones: the
// option's, else SkeletonOfLabels'. Throws InputError without a file when the
// option's has other joints.
Skeleton SkeletonOfNames(const std::vector<std::string>& joints,
                         const TrackReadOptions& options,
                         const std::vector<Bone>& bones = {});

// What a file gives as a position; missing where a number is none.
inline Joint3d ObservedJoint(const Eigen::Vector3d& position_m) {
  if (!std::isfinite(position_m.sum())) return {};
  return {position_m, JointStatus::kObserved};
}

// What `read(&text)` makes of a file as a Text (CsvRows, Words); file and line
// stand in front of its errors.
template <typename Text, typename Read>
auto ReadText(const std::string& path, const Read& read) {
  const std::string content = ReadTextFile(path);
  Text text(content);
  return Located(
      path, [&] { return text.Place(); }, [&] { return read(&text); });
}

// "observed", "inferred" or "missing"; throws InputError without a file.
JointStatus ParseJointStatus(std::string_view text);

// The joints of `object`'s `key`, four numbers each: x, y, z in a unit and a
// weight. Missing where that is not above 0, else inferred where it is at most
// `inferred`. Throws InputError without a file.
void ReadWeighted(const JsonObject& object, const char* key, double unit_m,
                  double inferred, Pose3d* pose);

// Collects people in any order of frames.
class TrackCollector {
 public:
  // `mode` names the format. The frame rate is the option's, else `told_hz`.
  TrackCollector(const std::string& mode, const Skeleton& skeleton,
                 const TrackReadOptions& options, double told_hz = 0.0);
  const TrackHeader& header() const { return header_; }
  size_t joint_count() const { return header_.skeleton.joints().size(); }
  // Makes sure that the frame is there even if nobody is in it.
  TrackFrame* Touch(int64_t frame);
  // Throws InputError without a file when the frame has this person already.
  PersonPose* Add(int64_t frame, TrackId id);
  // Adds who has a joint at all; the frame is there in any case.
  void AddIfSeen(int64_t frame, TrackId id, Pose3d joints);
  TrackSequence Finish();

 private:
  TrackHeader header_;
  std::map<int64_t, TrackFrame> frames_;
};

// What an adapter prints: our own tracks, under the option's skeleton where it
// has as many joints.
TrackSequence ReadTracksByAdapter(const Adapter& adapter,
                                  const std::string& path,
                                  const TrackReadOptions& options);
// Writes a file of a format of kinegraph-adapters.
void WriteTracksByAdapter(const std::string& format, const std::string& path,
                          const TrackSequence& tracks,
                          const TrackWriteOptions& options);

// ---- Rows: formats with a row for every frame ----

struct TrackRow {
  double time_s = 0.0;
  const TrackFrame* frame = nullptr;  // null: the tracks do not have it
};

// A row for every frame number from the first to the last. The times of frames
// that the tracks do not have lie evenly between their neighbours'. Throws
// InputError naming the format for more than ten million.
std::vector<TrackRow> MakeTrackRows(const TrackSequence& tracks,
                                    const std::string& format);

// nullptr when the person is not there.
const PersonPose* FindPerson(const TrackFrame* frame, TrackId id);

// Frame rate of the tracks [Hz]. Throws InputError naming the format when they
// do not tell it.
double RequireFrameRate(const TrackSequence& tracks, const std::string& format);

// ---- People ----

// Everybody in the recording, ascending.
std::vector<int64_t> IdsOf(const TrackSequence& tracks);
// The same; throws InputError when there is nobody.
std::vector<int64_t> RequirePeople(const TrackSequence& tracks);

// A number that can be an identity.
std::optional<TrackId> PersonIdOf(std::string_view text);

// "person_3", as a person without a name is called.
std::string PersonLabel(int64_t id);

// What each is called: the name, else "person_3"; people of one name get their
// identity too, so that all are told apart.
std::vector<std::string> PersonTitles(const std::vector<int64_t>& ids,
                                      const PersonNames& names);

// Formats with a file a person: a folder of person_3.trc, person_4_Anna.trc.
struct PersonFile {
  std::string path;
  TrackId id;
};

// The one file that `path` is, or those of that extension in a folder, whose
// ids are the numbers after the last "person_" (ours) or "_P" (Pose2Sim) of
// their names where every name has its own, else 0, 1, 2 in the order of the
// names. Throws InputError for a folder without such files.
std::vector<PersonFile> ListPersonFiles(const std::string& path,
                                        const std::string& extension);

// The names that stand in the files' names: "person_3_Anna.trc" is Anna's.
PersonNames NamesOfPersonFiles(const std::string& path,
                               const std::string& extension);

// Calls `write_file` for everybody: with `path` itself when it ends in the
// extension, else with files in the folder `path`, which appears when all are
// there. What may not stand in the name of a file, and the underscore, which
// parts it, are hyphens in people's names. Throws InputError when there is
// nobody, or are several for one file.
void WritePersonFiles(
    const std::string& path, const std::string& extension,
    const TrackSequence& tracks, const PersonNames& names,
    const std::function<void(const std::string& file, TrackId id)>& write_file);

// The same for tables with a row for every frame: `head(file)`, then what
// `write_row` writes of each row; the person is null where it is not there.
void WritePersonTables(
    const std::string& path, const std::string& extension,
    const TrackSequence& tracks, const PersonNames& names,
    const std::vector<TrackRow>& rows,
    const std::function<std::string(const std::string& file)>& head,
    const std::function<void(size_t row, const PersonPose* person,
                             JsonOutput* out)>& write_row);

// ---- What a format leaves out ----

// What a recording has besides positions.
struct TrackContents {
  bool has_covariances = false;
  bool has_views = false;     // counts of inlier views
  bool has_matches = false;   // matches, weights and scores
  bool has_inferred = false;  // joints with that status
  // Some frame has another time than 0, or the frame rate is known.
  bool has_clock = false;
  int64_t empty_frames = 0;  // nobody in them
};
TrackContents ContentsOf(const TrackSequence& tracks);

// Of each joint of the skeleton, whether anybody has it in some frame.
std::vector<bool> JointsSeen(const TrackSequence& tracks);

// What a format may leave out. Each is said where the tracks have it.
enum class Loss {
  kCovariances,
  kViews,             // counts of views, and matches
  kMatches,           // these alone
  kInferredAlike,     // inferred joints are written like observed ones
  kInferredObserved,  // or read back as such
  kEmptyFrames,
  kClock,         // times and frame rate
  kUnknownClock,  // said where there is none
};
void NoteLosses(const TrackContents& contents,
                std::initializer_list<Loss> losses, LostFields* lost_fields);
// What every format loses that keeps frames, identities and positions alone.
void NotePositionsOnly(const TrackContents& contents, LostFields* lost_fields);
// That rows were made for frames that the input leaves out.
void NoteAddedRows(const TrackSequence& tracks, size_t row_count,
                   const std::string& what, LostFields* lost_fields);
// That identities from `first_lost` on, and all others with them, are counted
// anew by the format's readers.
void NoteRenumbering(const TrackSequence& tracks, int64_t first_lost,
                     LostFields* lost_fields);
// That the file does not specify the skeleton.
void NoteSkeleton(const TrackSequence& tracks, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_SHARED_H_
