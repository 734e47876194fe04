#include "apps/common/track_files.h"

#include <algorithm>
#include <utility>

#include "core/io/tracks/reading_notes.h"

namespace kinegraph {
namespace {

// The extension of the file's name, with the dot; empty if there is none, or
// nothing before it.
std::string ExtensionOf(const std::string& path) {
  const size_t name = path.find_last_of('/') + 1;  // npos + 1 is 0
  const size_t dot = path.find_last_of('.');
  return dot != std::string::npos && dot > name ? path.substr(dot) : "";
}

// Whether the extension selects kinegraph's own format, which streams also
// have.
bool IsOurs(const std::string& path) {
  const std::string extension = ExtensionOf(path);
  return extension == ".jsonl" || extension == ".json" || IsStream(path);
}

}  // namespace

std::string WithoutExtension(const std::string& path) {
  return path.substr(0, path.size() - ExtensionOf(path).size());
}

void CheckTrackOutput(const std::string& path, MarkerNames markers,
                      const std::optional<AxisMap>& axes) {
  const bool may_be_other = !IsOurs(path) && !ExtensionOf(path).empty();
  const TrackFormat* format =
      may_be_other ? TrackFormatOfExtension(path) : nullptr;
  if (format == nullptr && !IsOurs(path)) {
    throw InputError("--out: '" + Printable(path) + "' must end in " +
                     TrackExtensions() +
                     ", with a name before the extension"
                     "; `kinegraph convert` writes other formats");
  }
  if (axes && (format == nullptr || !format->axes)) {
    throw InputError(
        "--axes applies only to formats with axes of their own, '" +
        Printable(path) + "' has none");
  }
  const bool has_names = format != nullptr && format->has_marker_names;
  if (!has_names && markers != MarkerNames::kOurs) {
    throw InputError("--markers applies only to formats with marker names, '" +
                     Printable(path) + "' has none");
  }
}

TrackOutput::TrackOutput(const std::string& path, const TrackHeader& header,
                         bool observations, const PersonNames& names,
                         MarkerNames markers, const CameraRig& cameras,
                         const std::optional<AxisMap>& axes)
    : path_(path),
      observations_(observations),
      options_{axes, names},
      markers_(markers),
      cameras_(cameras) {
  CheckTrackOutput(path, markers, axes);
  if (IsOurs(path)) {
    writer_.emplace(files_.Aside(path), header,
                    TrackWriteOptions{observations, names});
    return;
  }
  format_ = TrackFormatOfExtension(path);
  if (!format_->person_extension.empty() || format_->is_file_a_frame) {
    path_ = WithoutExtension(path);
    files_.FolderAside(path_);
  } else {
    files_.Aside(path_);
  }
  tracks_.header = header;
}

void TrackOutput::Write(TrackFrame&& frame) {
  if (writer_) return writer_->Write(frame);
  // Without observations, formats other than kinegraph's do not use matches.
  for (PersonPose& person : frame.people) {
    if (!observations_) person.matches.clear();
  }
  tracks_.frames.push_back(std::move(frame));
}

void TrackOutput::Flush() {
  if (writer_) writer_->Flush();
}

void TrackOutput::Finish() {
  if (writer_) return writer_->Commit();
  LostFields lost_fields;
  if (const auto note =
          FindAxesNote(StanceOf(tracks_), cameras_, *format_, options_.axes)) {
    lost_fields.push_back(note->text + ": " +
                          (note->axes.empty() ? "--set=cameras.ground=feet"
                                              : "--axes=" + note->axes) +
                          " makes people upright");
  }
  tracks_.header.skeleton = WithMarkerNames(tracks_.header.skeleton, markers_);
  format_->write(files_.Aside(path_), tracks_, options_, &lost_fields);
  SayNotes(lost_fields, "kinegraph-track: ");
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
  SayNotes({Printable(path) + ": " + note}, "kinegraph-" + command + ": ");
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
        "--unit applies only to tracks whose format does not specify it, "
        "such as BVH; the formats of these files specify it");
  }
}

TrackReadOptions TrackInput::OptionsFor(const std::string& path,
                                        TrackReadOptions options) const {
  if (unit_m_ > 0.0 && LeavesUnitOpen(path)) options.unit_m = unit_m_;
  return options;
}

TrackSequence TrackInput::Read(const std::string& path,
                               const TrackReadOptions& options) const {
  const TrackReadOptions own = OptionsFor(path, options);
  TrackSequence tracks = ReadTracks(path, own);
  PrintUnitNote(command_, path, own, tracks);
  return tracks;
}

}  // namespace kinegraph
