// TRC, the marker format of OpenSim and Pose2Sim: tab-separated, five header
// lines, then a row a frame. The layout is that of the files Pose2Sim writes.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/io/atomic_file.h"
#include "core/io/atomic_folder.h"
#include "core/io/json_output.h"
#include "core/io/track_export.h"
#include "core/io/track_losses.h"

namespace kinegraph {
namespace {

// A row of the file: what the tracks say of a frame, or nothing.
struct Row {
  double time_s = 0.0;
  const TrackFrame* frame = nullptr;
};

// A row for every frame number from the first to the last. The times of frames
// that the tracks do not have lie evenly between their neighbours'.
std::vector<Row> MakeRows(const TrackSequence& tracks) {
  constexpr int64_t kMaxRows = 10'000'000;
  std::vector<Row> rows;
  if (tracks.frames.empty()) return rows;
  const int64_t first = tracks.frames.front().frame;
  const int64_t count = tracks.frames.back().frame - first + 1;
  if (count > kMaxRows) {
    throw InputError("the tracks span " + std::to_string(count) +
                     " frames, a TRC file may have " +
                     std::to_string(kMaxRows));
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

void CheckMarkerNames(const Skeleton& skeleton) {
  for (const std::string& joint : skeleton.joints()) {
    if (joint.find_first_of("\t\r\n") != std::string::npos) {
      throw InputError("the joint '" + Printable(joint) +
                       "' cannot be the name of a TRC marker");
    }
  }
}

std::string HeaderText(const std::string& file_name,
                       const TrackSequence& tracks, size_t row_count) {
  const std::vector<std::string>& joints = tracks.header.skeleton.joints();
  const double rate = tracks.header.frame_rate_hz;
  const int64_t start = tracks.frames.empty() ? 0 : tracks.frames.front().frame;
  std::string text =
      "PathFileType\t4\t(X/Y/Z)\t" + file_name +
      "\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
      "OrigDataStartFrame\tOrigNumFrames\n";
  text += fmt::format("{}\t{}\t{}\t{}\tm\t{}\t{}\t{}\n", rate, rate, row_count,
                      joints.size(), rate, start, row_count);
  text += "Frame#\tTime";
  for (size_t j = 0; j < joints.size(); ++j) {
    text += (j == 0 ? "\t" : "\t\t\t") + joints[j];
  }
  text += "\t\t\n\t";
  for (size_t j = 1; j <= joints.size(); ++j) {
    text += fmt::format("\tX{}\tY{}\tZ{}", j, j, j);
  }
  return text + "\n";
}

const PersonPose* FindPerson(const TrackFrame* frame, TrackId id) {
  if (frame == nullptr) return nullptr;
  const auto at =
      std::find_if(frame->people.begin(), frame->people.end(),
                   [id](const PersonPose& person) { return person.id == id; });
  return at == frame->people.end() ? nullptr : &*at;
}

void WriteMarkers(const PersonPose* person, size_t joint_count,
                  const AxisMap& axes, JsonOutput* out) {
  for (size_t j = 0; j < joint_count; ++j) {
    if (person == nullptr || !person->joints[j].present()) {
      out->Text("\t\t\t");
      continue;
    }
    const Eigen::Vector3d marker = axes.Apply(person->joints[j].position_m);
    for (int axis = 0; axis < 3; ++axis) {
      out->Text("\t");
      out->Number(marker[axis]);
    }
  }
}

void WritePersonFile(const std::string& path, const std::string& name,
                     TrackId id, const TrackSequence& tracks,
                     const std::vector<Row>& rows, const AxisMap& axes) {
  AtomicFile file(path);
  file.Write(HeaderText(name, tracks, rows.size()));
  const auto joint_count =
      static_cast<size_t>(tracks.header.skeleton.joint_count());
  JsonOutput out;
  for (size_t r = 0; r < rows.size(); ++r) {
    out.Integer(static_cast<int64_t>(r) + 1);
    out.Text("\t");
    out.Number(rows[r].time_s);
    WriteMarkers(FindPerson(rows[r].frame, id), joint_count, axes, &out);
    out.Text("\n");
    file.Write(out.text().data(), out.text().size());
    out.Clear();
  }
  file.Commit();
}

// "person_3_Anna-Lena.trc"; what may not stand in the name of a file, and the
// underscore, which parts it, are hyphens.
std::string FileName(int64_t id, const PersonNames& names) {
  std::string file_name = "person_" + std::to_string(id);
  const auto name = names.find(TrackId(id));
  if (name != names.end()) {
    constexpr size_t kMaxBytes = 100;
    std::string letters = name->second.substr(0, kMaxBytes);
    // Not in the middle of a letter of UTF-8.
    if (name->second.size() > kMaxBytes) {
      while (!letters.empty() && (letters.back() & 0x80) != 0) {
        letters.pop_back();
      }
    }
    for (char& c : letters) {
      const auto byte = static_cast<unsigned char>(c);
      if (byte < 0x80 && std::isalnum(byte) == 0) c = '-';
    }
    file_name += "_" + letters;
  }
  return file_name + ".trc";
}

void NoteLosses(const TrackSequence& tracks, size_t row_count, Losses* losses) {
  const TrackContents contents = ContentsOf(tracks);
  losses->push_back("bones and configuration are not kept");
  if (contents.has_inferred) {
    losses->push_back("inferred joints are written like observed ones");
  }
  if (contents.has_covariances) losses->push_back("covariances are not kept");
  if (contents.has_views || contents.has_matches) {
    losses->push_back("counts of views and matches are not kept");
  }
  if (row_count > tracks.frames.size()) {
    losses->push_back(std::to_string(row_count - tracks.frames.size()) +
                      " frames that the input leaves out have empty rows");
  }
}

// Throws unless a TRC file can hold the tracks; the people in them.
std::vector<int64_t> IdsToWrite(const TrackSequence& tracks) {
  if (!(tracks.header.frame_rate_hz > 0.0)) {
    throw InputError(
        "TRC needs a frame rate, which the input does not tell "
        "(--frame_rate=HZ)");
  }
  CheckMarkerNames(tracks.header.skeleton);
  std::vector<int64_t> ids = IdsOf(tracks);
  if (ids.empty()) {
    throw InputError("the tracks have nobody in them, nothing to write");
  }
  return ids;
}

}  // namespace

void WriteTracksTrcFile(const std::string& path, const TrackSequence& tracks,
                        const AxisMap& axes, Losses* losses) {
  const std::vector<int64_t> ids = IdsToWrite(tracks);
  if (ids.size() > 1) {
    throw InputError("a TRC file holds one person, the tracks have " +
                     std::to_string(ids.size()));
  }
  const std::vector<Row> rows = MakeRows(tracks);
  const size_t slash = path.find_last_of('/');
  WritePersonFile(path, path.substr(slash == std::string::npos ? 0 : slash + 1),
                  TrackId(ids.front()), tracks, rows, axes);
  NoteLosses(tracks, rows.size(), losses);
}

void WriteTracksTrc(const std::string& path, const TrackSequence& tracks,
                    const AxisMap& axes, Losses* losses,
                    const PersonNames& names) {
  const std::vector<int64_t> ids = IdsToWrite(tracks);
  const std::vector<Row> rows = MakeRows(tracks);
  AtomicFolder folder(path);
  for (const int64_t id : ids) {
    const std::string name = FileName(id, names);
    WritePersonFile(folder.PathOf(name), name, TrackId(id), tracks, rows, axes);
  }
  folder.Commit();
  NoteLosses(tracks, rows.size(), losses);
  constexpr int64_t kKeptIds = 1'000'000'000'000'000'000;  // 18 digits
  NoteRenumbering(tracks, kKeptIds, losses);
}

}  // namespace kinegraph
