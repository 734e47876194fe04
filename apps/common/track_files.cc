#include "apps/common/track_files.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/reading_notes.h"
#include "core/io/tracks/writer.h"

namespace kinegraph {
namespace {

// Text after the last dot of the file's name, with the dot; empty without one.
std::string ExtensionOf(const std::string& path) {
  const size_t slash = path.find_last_of('/');
  const size_t dot = path.find_last_of('.');
  const bool has_dot =
      dot != std::string::npos && (slash == std::string::npos || dot > slash);
  return has_dot ? path.substr(dot) : "";
}

class JsonLinesOutput final : public TrackOutput {
 public:
  JsonLinesOutput(const std::string& path, const TrackHeader& header,
                  bool observations, const PersonNames& names)
      : path_(path), writer_(path, header, {observations, names}) {}
  void Write(TrackFrame&& frame) override { writer_.Write(frame); }
  void Flush() override { writer_.Flush(); }
  void Commit() override { writer_.Commit(); }
  std::string path() const override { return path_; }

 private:
  const std::string path_;
  TrackWriter writer_;
};

// Formats that need the whole recording.
class WholeRecordingOutput final : public TrackOutput {
 public:
  WholeRecordingOutput(const std::string& path, const TrackHeader& header,
                       const PersonNames& names, MarkerNames markers,
                       const CameraRig& cameras,
                       const std::optional<AxisMap>& axes)
      : format_(*TrackFormatOfExtension(path)),
        path_(path),
        markers_(markers),
        cameras_(cameras) {
    options_.names = names;
    options_.axes = axes;
    tracks_.header = header;
    if (format_.files != TrackFormat::Files::kOne) {
      path_ = WithoutExtension(path);
    }
  }
  void Write(TrackFrame&& frame) override {
    for (PersonPose& person : frame.people) person.matches.clear();
    tracks_.frames.push_back(std::move(frame));
  }
  void Commit() override {
    LostFields lost_fields;
    if (const auto note =
            FindAxesNote(StanceOf(tracks_), cameras_, format_, options_.axes)) {
      lost_fields.push_back(note->text + ": " +
                            (note->axes.empty() ? "--set=cameras.ground=feet"
                                                : "--axes=" + note->axes) +
                            " stands them up");
    }
    tracks_.header.skeleton =
        WithMarkerNames(tracks_.header.skeleton, markers_);
    format_.write(path_, tracks_, options_, &lost_fields);
    SayNotes(lost_fields, "kinegraph-track: ");
  }
  std::string path() const override { return path_; }

 private:
  const TrackFormat& format_;
  std::string path_;
  const MarkerNames markers_;
  const CameraRig cameras_;
  TrackExportOptions options_;
  TrackSequence tracks_;
};

bool IsJsonLines(const std::string& extension) {
  return extension == ".jsonl" || extension == ".json";
}

}  // namespace

std::string WithoutExtension(const std::string& path) {
  return path.substr(0, path.size() - ExtensionOf(path).size());
}

void CheckTrackOutput(const std::string& path, MarkerNames markers,
                      const std::optional<AxisMap>& axes) {
  const std::string extension = ExtensionOf(path);
  const bool is_ours = IsJsonLines(extension) || IsStream(path);
  const TrackFormat* format = is_ours ? nullptr : TrackFormatOfExtension(path);
  if (is_ours || format != nullptr) {
    if (axes && (format == nullptr || !format->axes)) {
      throw InputError("--axes belongs to formats with axes of their own, '" +
                       Printable(path) + "' has none");
    }
    const bool has_names = format != nullptr && format->has_marker_names;
    if (has_names || markers == MarkerNames::kOurs) return;
    throw InputError("--markers belongs to formats with names of markers, '" +
                     Printable(path) + "' has none");
  }
  throw InputError("--out: '" + Printable(path) + "' must end in " +
                   TrackExtensions() +
                   "; `kinegraph convert` writes other formats");
}

std::unique_ptr<TrackOutput> MakeTrackOutput(
    const std::string& path, const TrackHeader& header, bool observations,
    const PersonNames& names, MarkerNames markers, const CameraRig& cameras,
    const std::optional<AxisMap>& axes) {
  CheckTrackOutput(path, markers, axes);
  const std::string extension = ExtensionOf(path);
  if (IsJsonLines(extension) || IsStream(path)) {
    return std::make_unique<JsonLinesOutput>(path, header, observations, names);
  }
  return std::make_unique<WholeRecordingOutput>(path, header, names, markers,
                                                cameras, axes);
}

MarkerNames MarkersFlag(const std::string& text) {
  const std::optional<MarkerNames> names = ParseMarkerNames(text);
  if (names.has_value()) return *names;
  throw InputError("--markers: no '" + Printable(text) + "', expected one of " +
                   kMarkerNamesList);
}

void PrintUnitNote(const std::string& command, const std::string& path,
                   const TrackReadOptions& options,
                   const TrackSequence& tracks) {
  const std::string note = UnitNote(path, options, tracks);
  if (note.empty()) return;
  std::fprintf(stderr, "kinegraph-%s: note: %s: %s\n", command.c_str(),
               Printable(path).c_str(), note.c_str());
}

TrackInput::TrackInput(std::string command, const std::string& unit_flag,
                       const std::vector<std::string>& paths)
    : command_(std::move(command)) {
  if (unit_flag.empty()) return;
  unit_m_ = ParseLengthUnit(unit_flag);
  if (std::none_of(paths.begin(), paths.end(), [](const std::string& path) {
        return LeavesUnitOpen(path);
      })) {
    throw InputError(
        "--unit belongs to tracks whose format does not tell it, "
        "as BVH; these tell it");
  }
}

TrackSequence TrackInput::Read(const std::string& path,
                               TrackReadOptions options) const {
  if (unit_m_ > 0.0 && LeavesUnitOpen(path)) options.unit_m = unit_m_;
  TrackSequence tracks = ReadTracks(path, options);
  PrintUnitNote(command_, path, options, tracks);
  return tracks;
}

}  // namespace kinegraph
