#include "core/io/tracks/shared.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBegin = "person_";

// The number after the last "person_" in a file's name that digits follow,
// otherwise after the last such "_P"; nullopt if there is neither.
std::optional<int64_t> PersonOf(const std::string& name) {
  for (const std::string mark : {"person_", "_P"}) {
    for (size_t at = name.rfind(mark); at != std::string::npos;
         at = at == 0 ? std::string::npos : name.rfind(mark, at - 1)) {
      const size_t begin = at + mark.size();
      const size_t end =
          std::min(name.find_first_not_of("0123456789", begin), name.size());
      if (end > begin) return LastInteger(name.substr(begin, end - begin));
    }
  }
  return std::nullopt;
}

// The files of this extension in a folder, or the file `path` itself.
std::vector<std::string> FilesOf(const std::string& path,
                                 const std::string& extension) {
  if (!IsFolder(path)) return {path};
  std::vector<std::string> files;
  for (const std::string& name : ListFolder(path)) {
    if (name.front() != '.' && EndsInAnyCase(name, extension)) {
      files.push_back(path + "/" + name);
    }
  }
  return files;
}

// The file name without extension: "person_3_Anna-Lena".
std::string FileStem(int64_t id, const PersonNames& names) {
  const auto name = names.find(TrackId(id));
  if (name == names.end()) return PersonLabel(id);
  constexpr size_t kMaxBytes = 100;
  std::string letters = WholeLetters(name->second, kMaxBytes);
  for (char& c : letters) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && std::isalnum(byte) == 0) c = '-';
  }
  return PersonLabel(id) + "_" + letters;
}

}  // namespace

// ---- Reading ----

Skeleton SkeletonOfNames(const std::vector<std::string>& joints,
                         const TrackReadOptions& options,
                         const std::vector<Bone>& bones) {
  if (!options.skeleton.has_value()) return SkeletonOfLabels(joints, bones);
  if (options.skeleton->joints() != joints &&
      options.skeleton->joints() != SkeletonOfLabels(joints).joints()) {
    Refuse("the joints are not those of '{}'",
           Printable(options.skeleton->name()));
  }
  return *options.skeleton;
}

JointStatus ParseJointStatus(std::string_view text) {
  for (const JointStatus status :
       {JointStatus::kMissing, JointStatus::kInferred,
        JointStatus::kObserved}) {
    if (text == ToString(status)) return status;
  }
  Refuse("status: found '{}', expected observed, inferred or missing",
         Printable(std::string(text)));
}

TrackCollector::TrackCollector(const std::string& mode,
                               const Skeleton& skeleton,
                               const TrackReadOptions& options,
                               double file_hz) {
  header_.mode = mode;
  header_.skeleton = skeleton;
  header_.frame_rate_hz = ChooseFrameRate(options.frame_rate_hz, file_hz,
                                          options.refuse_other_rate);
}

TrackFrame* TrackCollector::Touch(int64_t frame_number) {
  const auto [at, is_new] = frames_.try_emplace(frame_number);
  if (is_new) {
    at->second.frame = frame_number;
    at->second.time = TimeOfFrame(frame_number, header_.frame_rate_hz);
  }
  return &at->second;
}

PersonPose* TrackCollector::Add(int64_t frame, TrackId id) {
  TrackFrame* at = Touch(frame);
  if (FindPerson(at, id) != nullptr) {
    Refuse("frame {}: person {} appears twice", frame, id.value());
  }
  PersonPose& person = at->people.emplace_back();
  person.id = id;
  person.joints.resize(joint_count());
  return &person;
}

void TrackCollector::AddIfSeen(int64_t frame, TrackId id, Pose3d joints) {
  Touch(frame);
  if (CountPresent(joints) == 0) return;
  Add(frame, id)->joints = std::move(joints);
}

TrackSequence TrackCollector::Finish() {
  TrackSequence sequence;
  sequence.header = std::move(header_);
  sequence.frames.reserve(frames_.size());
  for (auto& [number, frame] : frames_) {
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

// ---- Rows ----

std::vector<TrackRow> MakeTrackRows(const TrackSequence& tracks,
                                    const std::string& format) {
  std::vector<TrackRow> rows;
  if (tracks.frames.empty()) return rows;
  const int64_t first = tracks.frames.front().frame;
  const int64_t count = tracks.frames.back().frame - first + 1;
  if (count > kMaxRows) {
    Refuse("the tracks span {} frames, but a {} file may have at most {}",
           count, format, kMaxRows);
  }
  rows.resize(static_cast<size_t>(count));
  size_t last = 0;
  for (const TrackFrame& frame : tracks.frames) {
    const auto row = static_cast<size_t>(frame.frame - first);
    rows[row] = {ToSeconds(frame.time), &frame};
    for (size_t r = last + 1; r < row; ++r) {
      const double share =
          static_cast<double>(r - last) / static_cast<double>(row - last);
      rows[r].time_s =
          rows[last].time_s + share * (rows[row].time_s - rows[last].time_s);
    }
    last = row;
  }
  return rows;
}

const PersonPose* FindPerson(const TrackFrame* frame, TrackId id) {
  if (frame == nullptr) return nullptr;
  for (const PersonPose& person : frame->people) {
    if (person.id == id) return &person;
  }
  return nullptr;
}

double RequireFrameRate(const TrackSequence& tracks,
                        const std::string& format) {
  if (tracks.header.frame_rate_hz > 0.0) return tracks.header.frame_rate_hz;
  Refuse(
      "{} requires a frame rate, which the input does not specify "
      "(--frame_rate=HZ)",
      format);
}

// ---- People ----

std::vector<int64_t> IdsOf(const TrackSequence& tracks) {
  std::set<int64_t> ids;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) ids.insert(person.id.value());
  }
  return {ids.begin(), ids.end()};
}

std::vector<int64_t> RequirePeople(const TrackSequence& tracks) {
  std::vector<int64_t> ids = IdsOf(tracks);
  if (!ids.empty()) return ids;
  throw InputError(
      "the tracks contain no people, so there is nothing to write");
}

std::optional<TrackId> PersonIdOf(std::string_view text) {
  const auto id = ParseNumber<int64_t>(text);
  return id && *id >= 0 ? std::optional(TrackId(*id)) : std::nullopt;
}

std::string PersonLabel(int64_t id) {
  return std::string(kBegin) + std::to_string(id);
}

std::vector<std::string> PersonTitles(const std::vector<int64_t>& ids,
                                      const PersonNames& names) {
  std::vector<std::string> titles;
  for (const int64_t id : ids) {
    titles.push_back(PersonLabel(id));
    const auto name = names.find(TrackId(id));
    if (name == names.end()) continue;
    const auto count = std::count_if(
        names.begin(), names.end(),
        [&](const auto& other) { return other.second == name->second; });
    titles.back() =
        count > 1 ? name->second + "_" + titles.back() : name->second;
  }
  return titles;
}

std::vector<PersonFile> ListPersonFiles(const std::string& path,
                                        const std::string& extension) {
  std::vector<PersonFile> files;
  std::set<int64_t> ids;
  for (const std::string& file : FilesOf(path, extension)) {
    const auto id = PersonOf(fs::path(file).filename().string());
    if (id.has_value()) ids.insert(*id);
    files.push_back({file, TrackId(id.value_or(0))});
  }
  if (files.empty()) {
    throw InputError(path, "", "has no " + extension + " files");
  }
  if (ids.size() == files.size()) return files;
  for (size_t i = 0; i < files.size(); ++i) {
    files[i].id = TrackId(static_cast<int64_t>(i));
  }
  return files;
}

PersonNames NamesOfPersonFiles(const std::string& path,
                               const std::string& extension) {
  PersonNames names;
  for (const std::string& file : FilesOf(path, extension)) {
    const std::string stem = fs::path(file).stem().string();
    if (stem.compare(0, kBegin.size(), kBegin) != 0) continue;
    const size_t end = std::min(stem.find('_', kBegin.size()), stem.size());
    const auto id = PersonIdOf(stem.substr(kBegin.size(), end - kBegin.size()));
    if (id && end + 1 < stem.size()) names[*id] = stem.substr(end + 1);
  }
  return names;
}

void WritePersonFiles(const std::string& path, const std::string& extension,
                      const TrackSequence& tracks, const PersonNames& names,
                      const std::function<void(const std::string& file,
                                               TrackId id)>& write_file) {
  const std::vector<int64_t> ids = RequirePeople(tracks);
  if (EndsInAnyCase(path, extension)) {
    if (ids.size() > 1) {
      Refuse("a {} file contains one person, but the tracks have {}", extension,
             ids.size());
    }
    return write_file(path, TrackId(ids.front()));
  }
  AtomicFolder folder(path);
  for (const int64_t id : ids) {
    write_file(folder.PathOf(FileStem(id, names) + extension), TrackId(id));
  }
  folder.Commit();
}

void WritePersonTables(
    const std::string& path, const std::string& extension,
    const TrackSequence& tracks, const PersonNames& names,
    const std::vector<TrackRow>& rows,
    const std::function<std::string(const std::string& file)>& head,
    const std::function<void(size_t row, const PersonPose* person,
                             JsonOutput* out)>& write_row) {
  WritePersonFiles(path, extension, tracks, names,
                   [&](const std::string& file_path, TrackId id) {
                     AtomicFile file(file_path);
                     file.Write(head(file_path));
                     JsonOutput out;
                     for (size_t r = 0; r < rows.size(); ++r) {
                       write_row(r, FindPerson(rows[r].frame, id), &out);
                       out.FlushTo(&file);
                     }
                     file.Commit();
                   });
}

// ---- Losses of a format ----

TrackContents ContentsOf(const TrackSequence& tracks) {
  TrackContents contents;
  contents.has_clock = tracks.header.frame_rate_hz > 0.0;
  for (const TrackFrame& frame : tracks.frames) {
    contents.empty_frames += frame.people.empty() ? 1 : 0;
    contents.has_clock |= frame.time != 0;
    for (const PersonPose& person : frame.people) {
      contents.has_views |= !person.inlier_views.empty();
      contents.has_matches |= !person.matches.empty();
      for (const auto& covariance : person.covariances) {
        contents.has_covariances |= covariance.has_value();
      }
      for (const Joint3d& joint : person.joints) {
        contents.has_inferred |= joint.status == JointStatus::kInferred;
      }
    }
  }
  return contents;
}

std::vector<bool> JointsSeen(const TrackSequence& tracks) {
  std::vector<bool> is_seen(tracks.header.skeleton.joints().size(), false);
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < is_seen.size(); ++j) {
        if (person.joints[j].present()) is_seen[j] = true;
      }
    }
  }
  return is_seen;
}

void NoteLosses(const TrackContents& contents,
                std::initializer_list<Loss> losses, LostFields* lost_fields) {
  const struct {
    Loss loss;
    bool is_there;
    std::string text;
  } texts[] = {
      {Loss::kCovariances, contents.has_covariances,
       "covariances are not kept"},
      {Loss::kViews, contents.has_views || contents.has_matches,
       "counts of views and matches are not kept"},
      {Loss::kMatches, contents.has_matches, "matches are not kept"},
      {Loss::kInferredAlike, contents.has_inferred,
       "inferred joints are written like observed ones"},
      {Loss::kInferredObserved, contents.has_inferred,
       "inferred joints are read back as observed"},
      {Loss::kEmptyFrames, contents.empty_frames > 0,
       Counted(contents.empty_frames, "frame without people is",
               "frames without people are") +
           " not kept"},
      {Loss::kClock, contents.has_clock,
       "times and frame rate are not kept: specify the rate when reading "
       "(--frame_rate=HZ)"},
      {Loss::kUnknownClock, !contents.has_clock,
       "times are unknown and omitted (--frame_rate=HZ)"}};
  for (const Loss loss : losses) {
    for (const auto& one : texts) {
      if (one.loss == loss && one.is_there) lost_fields->push_back(one.text);
    }
  }
}

void NotePositionsOnly(const TrackContents& contents, LostFields* lost_fields) {
  lost_fields->push_back(
      "bones, names of joints and configuration are not kept");
  NoteLosses(contents,
             {Loss::kInferredObserved, Loss::kCovariances, Loss::kViews},
             lost_fields);
}

void NoteAddedRows(const TrackSequence& tracks, size_t row_count,
                   const std::string& what, LostFields* lost_fields) {
  if (row_count <= tracks.frames.size()) return;
  lost_fields->push_back(
      Counted(static_cast<int64_t>(row_count - tracks.frames.size()),
              "frame that is", "frames that are") +
      " missing in the input " + what);
}

void NoteRenumbering(const TrackSequence& tracks, int64_t first_lost,
                     LostFields* lost_fields) {
  const std::vector<int64_t> ids = IdsOf(tracks);
  if (ids.empty() || ids.back() < first_lost) return;
  lost_fields->push_back(
      "ids of " + std::to_string(first_lost) +
      " and above are too large: readers of the result number people "
      "anew, from 0");
}

void NoteSkeleton(const TrackSequence& tracks, LostFields* lost_fields) {
  lost_fields->push_back("the file does not specify the skeleton '" +
                         tracks.header.skeleton.name() +
                         "': specify it when reading (--skeleton)");
}

std::string WholeLetters(const std::string& text, size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  size_t end = 0;
  for (size_t next = 0; next <= max_bytes; next += LetterAt(text, next).size) {
    end = next;
  }
  return text.substr(0, end);
}

}  // namespace kinegraph
