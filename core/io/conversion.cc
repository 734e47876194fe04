#include "core/io/conversion.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/time.h"
#include "core/data/identity_edit.h"
#include "core/data/limits.h"
#include "core/io/adapters/adapter.h"
#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/configuration/config.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/file_kind.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/gone_formats.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/identity_edits.h"
#include "core/io/tracks/reading_notes.h"
#include "core/io/tracks/shared.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {
namespace {

// A format of calibrations, detections or tracks.
struct Format {
  FileKind kind;
  std::string name;
  bool readable;
  bool writable;
  std::string layout;
};

constexpr FileKind kCalibration = FileKind::kCalibration;
constexpr FileKind kDetections = FileKind::kDetections;
constexpr FileKind kTracks = FileKind::kTracks;

std::string LayoutOf(const TrackFormat& format) {
  std::string text = format.layout;
  if (!format.extensions.empty()) {
    text += fmt::format(" ({})", fmt::join(format.extensions, ", "));
  }
  if (format.axes.has_value()) text += "; axes " + format.axes->Text();
  return text;
}

// All formats, from the three tables of formats.
std::vector<Format> Formats() {
  std::vector<Format> formats;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    formats.push_back({kCalibration, format.name, /*readable=*/true,
                       format.write != nullptr, format.layout});
  }
  for (const DetectionFormat& format : DetectionFormats()) {
    formats.push_back({kDetections, format.name, format.open != nullptr,
                       format.write != nullptr, format.layout});
  }
  for (const TrackFormat& format : TrackFormats()) {
    formats.push_back({kTracks, format.name, format.read != nullptr,
                       format.write != nullptr, LayoutOf(format)});
  }
  return formats;
}

bool Contains(const std::vector<FileKind>& kinds, FileKind kind) {
  return std::count(kinds.begin(), kinds.end(), kind) > 0;
}

std::string TextOf(const std::vector<FileKind>& kinds) {
  std::vector<std::string> names(kinds.size());
  std::transform(kinds.begin(), kinds.end(), names.begin(),
                 [](FileKind kind) { return ToString(kind); });
  return fmt::format("{}", fmt::join(names, " or "));
}

// The kinds of files whose format of this name supports reading or writing
// (`can`). Throws InputError naming --`flag` if there are none.
std::vector<FileKind> KindsOf(const std::string& flag, const std::string& name,
                              const std::string& verb, bool Format::*can) {
  std::vector<FileKind> kinds;
  bool is_known = false;
  std::vector<std::string> names;  // of formats that support it
  for (const Format& format : Formats()) {
    is_known = is_known || format.name == name;
    if (!(format.*can)) continue;
    if (format.name == name) kinds.push_back(format.kind);
    if (std::count(names.begin(), names.end(), format.name) > 0) continue;
    names.push_back(format.name);
  }
  if (!kinds.empty()) return kinds;
  Refuse("--{}: '{}' {}, expected {}{}{}", flag, Printable(name),
         is_known ? "cannot be " + verb : "is not a format",
         flag == "from" ? "auto, " : "", fmt::join(names, ", "),
         WayOnFrom(name));
}

// The kind to convert, determined by the two formats and, without --from or if
// several kinds remain, by the input's content.
FileKind ChooseKind(const ConversionOptions& flags) {
  const std::vector<FileKind> to =
      KindsOf("to", flags.to, "written", &Format::writable);
  std::vector<FileKind> from = {kCalibration, kDetections, kTracks};
  if (flags.from != "auto") {
    from = KindsOf("from", flags.from, "read", &Format::readable);
  }
  std::vector<FileKind> both;
  for (const FileKind kind : from) {
    if (Contains(to, kind)) both.push_back(kind);
  }
  if (both.size() == 1 && flags.from != "auto") return both.front();
  if (both.empty()) {
    Refuse("--from={} is a format of {}, --to={} of {}", flags.from,
           TextOf(from), flags.to, TextOf(to));
  }
  // Examining a pipe would consume it.
  if (IsPipe(flags.in)) {
    if (both.size() == 1) return both.front();
    throw InputError(
        flags.in, "",
        "cannot be recognised from a pipe, expected " +
            (flags.from == "auto" ? "--from (a format of " + TextOf(both) + ")"
                                  : "a file"));
  }
  const FileKind kind = RecogniseKind(flags.in);
  if (Contains(both, kind)) return kind;
  // A folder recognised as a calibration may also contain detections, as that
  // of a Caliscope session does.
  if (Contains(both, kDetections) && IsFolder(flags.in) &&
      (RecogniseDetections(LookAtDetections(flags.in)) != nullptr ||
       AdapterOf(flags.in, AdapterKind::kDetections).has_value())) {
    return kDetections;
  }
  throw InputError(flags.in, "",
                   "contains " + std::string(ToString(kind)) + ", but --to=" +
                       flags.to + " is a format of " + TextOf(both));
}

// All options of reading.
struct ConvertOptions {
  CameraReadOptions cameras;
  DetectionReadOptions detections;
  int64_t first_frame = TrackReadOptions().first_frame;

  void Describe(OptionVisitor& visitor) {
    visitor.Enter("cameras");
    cameras.Describe(visitor);
    visitor.Leave();
    visitor.Enter("detections");
    detections.Describe(visitor);
    visitor.Leave();
    visitor.Enter("tracks");
    visitor.Integer("first_frame", &first_frame, NonNegative(), "",
                    "number of the first frame of 4D association's files");
    visitor.Leave();
  }
};

// Whether the result can store an image size that the input does not specify.
bool TakesImageSize(const ConversionOptions& flags, FileKind kind) {
  return kind == kCalibration ||
         (kind == kDetections &&
          FindDetectionFormat(flags.to)->names_image_size);
}

// Throws InputError for keys of --set that do not apply to this kind of files.
void CheckKeys(const ConversionOptions& flags, FileKind kind) {
  const std::string table = kind == kCalibration  ? "cameras."
                            : kind == kDetections ? "detections."
                                                  : "tracks.";
  for (const std::string& part : Split(flags.set, ';')) {
    const std::string key = Trimmed(part.substr(0, part.find('=')));
    if (key.empty() || key.rfind(table, 0) == 0) continue;
    if (key == "cameras.image_size" && TakesImageSize(flags, kind)) continue;
    throw InputError("--set: key '" + Printable(key) +
                     "' does not apply: the input contains " + ToString(kind));
  }
}

// Throws InputError for flags that do not apply to this kind of files.
void CheckFlags(const ConversionOptions& flags, FileKind kind) {
  const auto refuse = [kind](const char* name, bool given,
                             const char* belongs_to) {
    if (!given) return;
    throw InputError("--" + std::string(name) + " applies to " + belongs_to +
                     ", but the input contains " + ToString(kind));
  };
  if (kind == kDetections) {
    refuse("unit", !flags.unit.empty(), "calibrations and tracks");
  }
  if (!TakesImageSize(flags, kind)) {
    refuse("image_size", !flags.image_size.empty(),
           "calibrations and to detections written as coco_views or longcw");
  }
  if (kind == kCalibration) {
    refuse("skeleton", !flags.skeleton.empty(), "detections and tracks");
    refuse("frame_rate", flags.frame_rate_hz != 0.0, "detections and tracks");
  }
  if (kind != kTracks) {
    refuse("axes", !flags.axes.empty(), "tracks");
    refuse("person", !flags.person.empty(), "tracks");
    refuse("markers", flags.markers != "ours", "tracks");
  }
  if (!(flags.frame_rate_hz >= 0.0 &&
        flags.frame_rate_hz <= kMaxFrameRate_hz)) {
    throw InputError(
        "--frame_rate: expected a rate above 0 and at most 1e6 Hz");
  }
}

ConvertOptions ReadOptions(const ConversionOptions& flags, FileKind kind) {
  ConfigFile config = ConfigFile::Empty();
  if (!flags.set.empty()) config.Override(flags.set, "--set");
  if (!flags.unit.empty() && kind == kCalibration) {
    config.Override("cameras.unit=" + flags.unit, "--unit");
  }
  ConvertOptions options;
  config.Apply(&options);
  config.RejectUnknown();
  CheckKeys(flags, kind);
  if (!flags.image_size.empty()) {
    for (const std::string& side : Split(flags.image_size, ',')) {
      char* end = nullptr;
      options.cameras.image_size.push_back(std::strtod(side.c_str(), &end));
      // A text that is not a number gives an additional side of 0, which is
      // refused when the size is used.
      if (*end != '\0') options.cameras.image_size.push_back(0.0);
    }
  }
  return options;
}

Skeleton SkeletonFlag(const ConversionOptions& flags) {
  try {
    return ResolveSkeleton(flags.skeleton, {});
  } catch (const InputError& error) {
    throw InputError("--skeleton: " + std::string(error.what()));
  }
}

// ---- One function per kind: reads, writes and returns the size as text ----

std::string ConvertCalibration(const ConversionOptions& flags,
                               const ConvertOptions& options,
                               LostFields* lost_fields) {
  CameraReadOptions read = options.cameras;
  if (flags.from != "auto") read.format = flags.from;
  const CameraRig cameras = ReadCameras(flags.in, read);
  const std::string refinement = RefinementText(flags.in);
  if (!refinement.empty() && flags.to == "kinegraph") {
    WriteCameras(flags.out, cameras, refinement);
  } else {
    WriteCalibration(flags.out, flags.to, cameras, lost_fields);
    if (!refinement.empty()) {
      lost_fields->push_back(
          "the record of the refinement (clocks and covariances of the "
          "cameras) "
          "is not kept");
    }
  }
  return Counted(static_cast<int64_t>(cameras.size()), "camera", "cameras");
}

// A frame's number and time.
struct FrameTime {
  int64_t frame = 0;
  TimeNs time = 0;
};

// Throws InputError if the input's times contradict --frame_rate, which is for
// input without a rate.
void CheckFrameRate(const ConversionOptions& flags, const FrameTime& first,
                    const FrameTime& last) {
  const double seconds = ToSeconds(last.time - first.time);
  if (!(flags.frame_rate_hz > 0.0 && seconds > 0.0)) return;
  const double rate_hz =
      static_cast<double>(last.frame - first.frame) / seconds;
  if (!AreOtherRates(flags.frame_rate_hz, rate_hz)) return;
  Refuse(
      "--frame_rate={:g} is for input that does not specify its rate, but the "
      "times in the input imply {:.6g} Hz",
      flags.frame_rate_hz, rate_hz);
}

// Counts the frames that pass through, and checks their times at the end.
class CountingSource final : public DetectionSource {
 public:
  CountingSource(std::unique_ptr<DetectionSource> source,
                 const ConversionOptions& flags)
      : source_(std::move(source)), flags_(flags) {}
  const DetectionHeader& header() const override { return source_->header(); }
  bool Next(DetectionFrame* frame) override {
    if (!source_->Next(frame)) {
      CheckFrameRate(flags_, first_, last_);
      return false;
    }
    last_ = {frame->frame, frame->time};
    if (frame_count_++ == 0) first_ = last_;
    return true;
  }
  size_t frames() const { return frame_count_; }

 private:
  std::unique_ptr<DetectionSource> source_;
  const ConversionOptions& flags_;
  size_t frame_count_ = 0;
  FrameTime first_;
  FrameTime last_;
};

std::string ConvertDetections(const ConversionOptions& flags,
                              const ConvertOptions& options,
                              LostFields* lost_fields) {
  DetectionReadOptions read = options.detections;
  if (flags.from != "auto") read.format = flags.from;
  if (!flags.skeleton.empty()) read.skeleton = SkeletonFlag(flags);
  read.frame_rate_hz = flags.frame_rate_hz;
  read.refuse_other_rate = true;
  CountingSource source(OpenDetections(flags.in, read), flags);
  DetectionWriteOptions write;
  const std::vector<double>& size = options.cameras.image_size;
  if (!flags.image_size.empty() && size.size() != 2) {
    Refuse("--image_size: found '{}', expected W,H",
           Printable(flags.image_size));
  }
  for (const double side : size) {
    if (side >= 1.0 && side <= 1e6 && side == std::floor(side)) continue;
    Refuse("--image_size: found '{}', expected W,H in whole pixels",
           Printable(flags.image_size));
  }
  if (size.size() == 2) {
    write.image_size = {static_cast<int>(size[0]), static_cast<int>(size[1])};
  }
  FindDetectionFormat(flags.to)->write(flags.out, write, &source, lost_fields);
  const auto views = static_cast<int64_t>(source.header().view_names.size());
  return Counted(source.frames(), "frame", "frames") + " of " +
         Counted(views, "view", "views");
}

// The existing identities, such as "0, 3, 7".
std::string KnownPeople(const std::vector<int64_t>& ids) {
  constexpr size_t kMostShown = 30;
  const size_t shown = std::min(ids.size(), kMostShown);
  return fmt::format("{}{}", fmt::join(ids.data(), ids.data() + shown, ", "),
                     shown < ids.size() ? ", ..." : "");
}

// Names of the people in the tracks, from the file itself and from its identity
// edits.
PersonNames NamesIn(const std::string& path, std::vector<std::string>* notes) {
  PersonNames names = ReadPersonNames(path);
  const std::string edits = SideFileOf(path, kIdentityEnd, notes);
  if (!edits.empty()) names.merge(NamesAfter(ReadIdentityEdits(edits)));
  return names;
}

// The identity selected by --person.
int64_t WantedPerson(const ConversionOptions& flags,
                     const std::vector<int64_t>& ids) {
  const auto is_there = [&ids](int64_t id) {
    return std::binary_search(ids.begin(), ids.end(), id);
  };
  const auto number = ParseNumber<int64_t>(flags.person);
  if (number && is_there(*number)) return *number;
  std::string known = KnownPeople(ids);
  std::vector<std::string> notes;
  if (!number) {
    for (const auto& [id, name] : NamesIn(flags.in, &notes)) {
      if (!is_there(id.value())) continue;
      if (name == flags.person) return id.value();
      known += ", '" + Printable(name) + "'";
    }
  }
  Refuse("--person: no '{}' in the tracks, expected one of {}{}",
         Printable(flags.person), known,
         notes.empty() ? "" : "; " + notes.front());
}

// Removes all people but the one that --person selects. Without --person,
// throws InputError if there are several people and --out is a single file in a
// format with one file per person.
void KeepPerson(const ConversionOptions& flags, const TrackFormat& to,
                TrackSequence* tracks) {
  const std::vector<int64_t> ids = IdsOf(*tracks);
  const bool one_file = !to.person_extension.empty() &&
                        EndsInAnyCase(flags.out, to.person_extension);
  if (flags.person.empty()) {
    if (!one_file || ids.size() < 2) return;
    Refuse(
        "--out={}: a file of this format contains one person, but the tracks "
        "have {}; choose one with --person, or give a folder",
        Printable(flags.out), KnownPeople(ids));
  }
  const TrackId wanted(WantedPerson(flags, ids));
  for (TrackFrame& frame : tracks->frames) {
    std::vector<PersonPose>& people = frame.people;
    people.erase(std::remove_if(people.begin(), people.end(),
                                [wanted](const PersonPose& person) {
                                  return person.id != wanted;
                                }),
                 people.end());
  }
}

void RenameMarkers(const ConversionOptions& flags, const TrackFormat& to,
                   TrackSequence* tracks) {
  const std::optional<MarkerNames> names = ParseMarkerNames(flags.markers);
  if (!names.has_value()) {
    Refuse("--markers: no '{}', expected one of {}", Printable(flags.markers),
           kMarkerNamesList);
  }
  if (*names == MarkerNames::kOurs) return;
  if (!to.has_marker_names) {
    throw InputError("--markers requires --to=" +
                     TrackFormatNames([](const TrackFormat& format) {
                       return format.has_marker_names;
                     }));
  }
  tracks->header.skeleton = WithMarkerNames(tracks->header.skeleton, *names);
}

// Rotates tracks into the world frame. They were read as if X, Y and Z of their
// file were x, y and z of the world. `axes`: the world axes along X, Y and Z.
void ReadAs(const AxisMap& axes, TrackSequence* tracks) {
  Eigen::Matrix3d world_from_file;
  for (int i = 0; i < 3; ++i) {
    world_from_file.col(i) = axes.Invert(Eigen::Vector3d::Unit(i));
  }
  for (TrackFrame& frame : tracks->frames) {
    for (PersonPose& person : frame.people) {
      for (Joint3d& joint : person.joints) {
        joint.position_m = world_from_file * joint.position_m;
      }
      for (auto& covariance : person.covariances) {
        if (!covariance) continue;
        *covariance =
            world_from_file * *covariance * world_from_file.transpose();
      }
    }
  }
}

// If people do not stand upright in the result, adds a note that names the
// remedy.
void NoteAxes(const TrackSequence& tracks, const TrackFormat& from,
              const TrackFormat& to, const std::optional<AxisMap>& axes,
              LostFields* lost_fields) {
  const Stance stance = StanceOf(tracks);
  if (!to.axes.has_value()) {
    if (!from.axes.has_value()) return;
    if (const auto note = FindReadingNote(stance, from, axes)) {
      lost_fields->push_back(note->text + ": --axes=" + note->axes +
                             " makes them stand upright");
    }
    return;
  }
  const auto note = FindAxesNote(stance, {}, to, axes, StatedUp(from));
  if (!note) return;
  if (note->axes.empty()) {
    lost_fields->push_back(
        note->text +
        ": no --axes makes them stand upright, but tracking with "
        "--set=cameras.ground=feet does");
  } else if (!from.axes.has_value()) {
    lost_fields->push_back(note->text + ": --axes=" + note->axes +
                           " makes them stand upright");
  } else {
    // One conversion would apply --axes to both reading and writing.
    const AxisMap right = AxisMap::Parse(note->axes);
    lost_fields->push_back(
        note->text + ": convert to a .jsonl with --axes=" +
        AxesOfReading(axes.value_or(*from.axes),
                      right.sign[1] * Eigen::Vector3d::Unit(right.axis[1])) +
        " first, then convert that file without --axes");
  }
}

std::string ConvertTracks(const ConversionOptions& flags,
                          const ConvertOptions& options,
                          LostFields* lost_fields) {
  TrackReadOptions read;
  if (flags.from != "auto") read.format = flags.from;
  if (!flags.skeleton.empty()) read.skeleton = SkeletonFlag(flags);
  read.frame_rate_hz = flags.frame_rate_hz;
  read.refuse_other_rate = true;
  read.first_frame = options.first_frame;
  if (!flags.axes.empty()) read.axes = AxisMap::Parse(flags.axes);
  if (!flags.unit.empty()) read.unit_m = ParseLengthUnit(flags.unit);
  const TrackFormat& from = FormatOfTracks(flags.in, read);
  TrackSequence tracks = ReadTracks(flags.in, read);
  if (!tracks.frames.empty()) {
    const TrackFrame& first = tracks.frames.front();
    const TrackFrame& last = tracks.frames.back();
    CheckFrameRate(flags, {first.frame, first.time}, {last.frame, last.time});
  }
  if (read.skeleton &&
      tracks.header.skeleton.joints() != read.skeleton->joints()) {
    Refuse(
        "--skeleton={} is for input that does not specify its skeleton, but "
        "the tracks have '{}'",
        flags.skeleton, Printable(tracks.header.skeleton.name()));
  }
  const TrackFormat& to = *FindTrackFormat(flags.to);
  KeepPerson(flags, to, &tracks);
  TrackExportOptions write;
  write.axes = read.axes;
  if (read.axes && !from.axes && !to.axes) ReadAs(*read.axes, &tracks);
  if (const std::string note = UnitNote(flags.in, read, tracks);
      !note.empty()) {
    lost_fields->push_back(note);
  }
  NoteAxes(tracks, from, to, write.axes, lost_fields);
  RenameMarkers(flags, to, &tracks);
  write.names = ReadPersonNames(flags.in);
  if (IsPipe(flags.in) && from.read_names != nullptr) {
    lost_fields->push_back("names of people are not read from a pipe");
  }
  if (!flags.person.empty()) {
    const std::vector<int64_t> ids = IdsOf(tracks);
    for (auto at = write.names.begin(); at != write.names.end();) {
      const bool is_kept =
          std::binary_search(ids.begin(), ids.end(), at->first.value());
      at = is_kept ? std::next(at) : write.names.erase(at);
    }
  }
  if (!write.names.empty() && !to.keeps_names) {
    lost_fields->push_back("names of people are not kept");
  }
  to.write(flags.out, tracks, write, lost_fields);
  return Counted(static_cast<int64_t>(tracks.frames.size()), "frame", "frames");
}

}  // namespace

Conversion Convert(const ConversionOptions& options) {
  ConversionOptions flags = options;
  if (flags.to.empty()) {
    const TrackFormat* format = TrackFormatOfExtension(flags.out);
    if (format == nullptr) {
      Refuse(
          "--to is missing, and no format has the extension of --out={}, "
          "expected {}",
          Printable(flags.out), TrackExtensions());
    }
    flags.to = format->name;
  }
  const FileKind kind = ChooseKind(flags);
  CheckFlags(flags, kind);
  const ConvertOptions read = ReadOptions(flags, kind);
  const size_t slash = flags.out.find_last_of('/');
  std::optional<OutputFolder> folder;  // removed again after a failure
  if (slash != std::string::npos && slash > 0) {
    folder.emplace(flags.out.substr(0, slash));
  }
  Conversion conversion;
  LostFields* lost_fields = &conversion.lost_fields;
  conversion.what =
      kind == kCalibration  ? ConvertCalibration(flags, read, lost_fields)
      : kind == kDetections ? ConvertDetections(flags, read, lost_fields)
                            : ConvertTracks(flags, read, lost_fields);
  return conversion;
}

std::string FormatList() {
  std::string text;
  for (const Format& format : Formats()) {
    text += fmt::format("{:<13} {:<13} {:<15} {}\n", ToString(format.kind),
                        format.name,
                        !format.writable   ? "read only"
                        : !format.readable ? "write only"
                                           : "read and write",
                        format.layout);
  }
  return text;
}

}  // namespace kinegraph
