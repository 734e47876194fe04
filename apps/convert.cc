// kinegraph-convert: calibrations, detections and tracks between formats.
#include <gflags/gflags.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/summary.h"
#include "core/base/error.h"
#include "core/io/calibration.h"
#include "core/io/calibration_format.h"
#include "core/io/calibration_writer.h"
#include "core/io/config.h"
#include "core/io/detection_format.h"
#include "core/io/detection_source.h"
#include "core/io/file_kind.h"
#include "core/io/identity_edits.h"
#include "core/io/joint_names.h"
#include "core/io/person_names.h"
#include "core/io/text_file.h"
#include "core/io/track_format.h"
#include "core/io/tracks.h"

DEFINE_string(from, "auto", "format of the input; auto tells it by content");
DEFINE_string(
    to, "",
    "format of the result; tracks are told by the end of --out, such as "
    ".c3d, without it");
DEFINE_string(in, "", "file or folder to read");
DEFINE_string(out, "",
              "file, or folder for formats of several files; of formats with a "
              "file a person, such as TRC, NAME.trc is one person's file");
DEFINE_string(skeleton, "", "skeleton of the input where it does not tell");
DEFINE_double(frame_rate, 0.0, "frame rate [Hz] where the input does not tell");
DEFINE_string(unit, "", "unit of a calibration: m, cm or mm");
DEFINE_string(image_size, "",
              "image size [px] of a calibration that does not tell: W,H");
DEFINE_string(
    axes, "",
    "world axes that the file's X,Y,Z are, such as x,-z,y, in formats "
    "that have their own (written or read); --formats tells theirs");
DEFINE_string(markers, "ours",
              "names of the joints in formats that name them: ours (l_hip), "
              "pose2sim (LHip, Hip) or opensim (LHip, midHip)");
DEFINE_string(person, "",
              "the one person to write: the identity's number, or the name "
              "that NAME.identity.jsonl beside the input gives it");
DEFINE_string(set, "",
              "keys of reading: cameras.KEY=value;detections.KEY=value;"
              "tracks.first_frame=N");
DEFINE_bool(formats, false, "list the formats and leave");

namespace kinegraph {
namespace {

// A format's name in one kind.
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
  for (const std::string& extension : format.extensions) {
    text +=
        (&extension == &format.extensions.front() ? " (" : ", ") + extension;
  }
  if (!format.extensions.empty()) text += ")";
  if (format.axes.has_value()) text += "; axes " + format.axes->Text();
  return text;
}

// They follow from the three registries.
std::vector<Format> MakeFormats() {
  std::vector<Format> formats;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    formats.push_back({kCalibration, format.name, true, format.write != nullptr,
                       format.layout});
  }
  for (const DetectionFormat& format : DetectionFormats()) {
    formats.push_back({kDetections, format.name, format.open != nullptr,
                       format.write != nullptr, format.layout});
  }
  for (const TrackFormat& format : TrackFormats()) {
    formats.push_back({kTracks, format.name, format.readable(),
                       format.write != nullptr, LayoutOf(format)});
  }
  return formats;
}

const std::vector<Format>& Formats() {
  static const std::vector<Format> kFormats = MakeFormats();
  return kFormats;
}

using Wanted = std::function<bool(const Format&)>;

bool IsReadable(const Format& format) { return format.readable; }
bool IsWritable(const Format& format) { return format.writable; }

// The end of --out tells what --to does not.
void ChooseByExtension() {
  if (!FLAGS_to.empty()) return;
  const TrackFormat* format = TrackFormatOfExtension(FLAGS_out);
  if (format == nullptr) {
    throw InputError("--to is missing, and no format ends as --out=" +
                     Printable(FLAGS_out) + ", expected " + TrackExtensions());
  }
  FLAGS_to = format->name;
}

// The kinds in which a format of that name is there.
std::vector<FileKind> KindsOf(const std::string& name, const Wanted& wanted) {
  std::vector<FileKind> kinds;
  for (const Format& format : Formats()) {
    if (format.name == name && wanted(format)) kinds.push_back(format.kind);
  }
  return kinds;
}

std::string NamesOf(const Wanted& wanted) {
  std::vector<std::string> names;
  std::string text;
  for (const Format& format : Formats()) {
    if (!wanted(format)) continue;
    if (std::count(names.begin(), names.end(), format.name) > 0) continue;
    names.push_back(format.name);
    text += (text.empty() ? "" : ", ") + names.back();
  }
  return text;
}

std::string TextOf(const std::vector<FileKind>& kinds) {
  std::string text;
  for (const FileKind kind : kinds) {
    text += (text.empty() ? "" : " or ") + std::string(ToString(kind));
  }
  return text;
}

// Kinds of the format that --`flag` names; throws when nothing of that name can
// be read or written (`verb`).
std::vector<FileKind> RequireKinds(const std::string& flag,
                                   const std::string& name,
                                   const std::string& verb,
                                   const Wanted& wanted) {
  const std::vector<FileKind> kinds = KindsOf(name, wanted);
  if (!kinds.empty()) return kinds;
  const bool known = !KindsOf(name, [](const Format&) { return true; }).empty();
  throw InputError("--" + flag + ": '" + Printable(name) + "' " +
                   (known ? "cannot be " + verb : "is no format") +
                   ", expected " + (flag == "from" ? "auto, " : "") +
                   NamesOf(wanted));
}

// What is to be converted: it follows from the two formats, and from the
// input's content where several kinds are left.
FileKind ChooseKind() {
  const std::vector<FileKind> to =
      RequireKinds("to", FLAGS_to, "written", IsWritable);
  std::vector<FileKind> from = {kCalibration, kDetections, kTracks};
  if (FLAGS_from != "auto") {
    from = RequireKinds("from", FLAGS_from, "read", IsReadable);
  }
  std::vector<FileKind> both;
  std::copy_if(from.begin(), from.end(), std::back_inserter(both),
               [&to](FileKind kind) {
                 return std::count(to.begin(), to.end(), kind) > 0;
               });
  if (both.size() == 1 && FLAGS_from != "auto") return both.front();
  if (both.empty()) {
    throw InputError("--from=" + FLAGS_from + " is of " + TextOf(from) +
                     ", --to=" + FLAGS_to + " of " + TextOf(to));
  }
  const FileKind kind = RecogniseKind(FLAGS_in);
  if (std::count(both.begin(), both.end(), kind) == 0) {
    throw InputError(FLAGS_in, "",
                     "holds " + std::string(ToString(kind)) +
                         ", --to=" + FLAGS_to + " is of " + TextOf(both));
  }
  return kind;
}

// Everything that reading can be told.
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
                    "Frame of the first entry of 4D association's files.");
    visitor.Leave();
  }
};

// Flags that mean nothing for what is converted are a mistake.
void RefuseFlag(const char* name, bool given, const char* belongs_to,
                FileKind kind) {
  if (!given) return;
  throw InputError("--" + std::string(name) + " belongs to " + belongs_to +
                   ", the input holds " + ToString(kind));
}

void CheckFlags(FileKind kind) {
  const bool is_calibration = kind == kCalibration;
  if (!is_calibration) {
    RefuseFlag("unit", !FLAGS_unit.empty(), "calibrations", kind);
    if (kind != kDetections || FLAGS_to != "longcw") {
      RefuseFlag("image_size", !FLAGS_image_size.empty(), "calibrations", kind);
    }
  } else {
    RefuseFlag("skeleton", !FLAGS_skeleton.empty(), "detections and tracks",
               kind);
    RefuseFlag("frame_rate", FLAGS_frame_rate != 0.0, "detections and tracks",
               kind);
  }
  if (kind != kTracks) {
    RefuseFlag("axes", !FLAGS_axes.empty(), "tracks", kind);
    RefuseFlag("person", !FLAGS_person.empty(), "tracks", kind);
    RefuseFlag("markers", FLAGS_markers != "ours", "tracks", kind);
  }
  if (!(FLAGS_frame_rate >= 0.0 && FLAGS_frame_rate <= 1e6)) {
    throw InputError("--frame_rate: expected above 0 .. 1e6 Hz");
  }
}

ConvertOptions ReadOptions() {
  ConfigFile config = ConfigFile::Empty();
  if (!FLAGS_set.empty()) config.Override(FLAGS_set, "--set");
  if (!FLAGS_unit.empty()) {
    config.Override("cameras.unit=" + FLAGS_unit, "--unit");
  }
  ConvertOptions options;
  config.Apply(&options);
  config.RejectUnknown();
  if (!FLAGS_image_size.empty()) {
    for (const std::string& side : ParseList(FLAGS_image_size, "image_size")) {
      char* end = nullptr;
      options.cameras.image_size.push_back(std::strtod(side.c_str(), &end));
      if (*end != '\0') options.cameras.image_size.push_back(0.0);
    }
  }
  return options;
}

Skeleton SkeletonFlag() {
  try {
    return ResolveSkeleton(FLAGS_skeleton, {});
  } catch (const InputError& error) {
    throw InputError("--skeleton: " + std::string(error.what()));
  }
}

std::string Count(size_t count, const std::string& what) {
  return std::to_string(count) + " " + what;
}

// ---- One kind each: reads, writes, and says how much there was ----

std::string ConvertCalibration(const ConvertOptions& options, Losses* losses) {
  CameraReadOptions read = options.cameras;
  if (FLAGS_from != "auto") read.format = FLAGS_from;
  const CameraRig cameras = ReadCameras(FLAGS_in, read);
  WriteCalibration(FLAGS_out, FLAGS_to, cameras, losses);
  return Count(cameras.size(), "cameras");
}

// Counts the frames that pass through.
class CountingSource final : public DetectionSource {
 public:
  explicit CountingSource(std::unique_ptr<DetectionSource> source)
      : source_(std::move(source)) {}
  const DetectionHeader& header() const override { return source_->header(); }
  bool Next(DetectionFrame* frame) override {
    const bool has_frame = source_->Next(frame);
    frame_count_ += has_frame ? 1 : 0;
    return has_frame;
  }
  size_t frames() const { return frame_count_; }

 private:
  std::unique_ptr<DetectionSource> source_;
  size_t frame_count_ = 0;
};

DetectionWriteOptions DetectionWriteOptionsOf(const ConvertOptions& options) {
  DetectionWriteOptions write;
  const std::vector<double>& size = options.cameras.image_size;
  if (!FLAGS_image_size.empty() && size.size() != 2) {
    throw InputError("--image_size: found '" + Printable(FLAGS_image_size) +
                     "', expected W,H");
  }
  if (size.size() == 2) {
    write.image_size = {static_cast<int>(size[0]), static_cast<int>(size[1])};
  }
  return write;
}

std::string ConvertDetections(const ConvertOptions& options, Losses* losses) {
  DetectionReadOptions read = options.detections;
  if (FLAGS_from != "auto") read.format = FLAGS_from;
  if (!FLAGS_skeleton.empty()) read.skeleton = SkeletonFlag();
  read.frame_rate_hz = FLAGS_frame_rate;
  CountingSource source(OpenDetections(FLAGS_in, read));
  FindDetectionFormat(FLAGS_to)->write(
      FLAGS_out, DetectionWriteOptionsOf(options), &source, losses);
  return Count(source.frames(), "frames of ") +
         Count(source.header().view_names.size(), "views");
}

bool EndsIn(const std::string& path, const std::string& end) {
  return path.size() > end.size() &&
         path.compare(path.size() - end.size(), end.size(), end) == 0;
}

// "0, 3, 7": the identities that there are.
std::string KnownPeople(const std::set<int64_t>& ids) {
  constexpr size_t kMostShown = 30;
  std::string text;
  size_t shown = 0;
  for (const int64_t id : ids) {
    if (++shown > kMostShown) return text + ", ...";
    text += (text.empty() ? "" : ", ") + std::to_string(id);
  }
  return text;
}

// The identity that --person asks for.
int64_t WantedPerson(const std::set<int64_t>& ids) {
  int64_t number = 0;
  const char* end = FLAGS_person.data() + FLAGS_person.size();
  const auto [stop, error] = std::from_chars(FLAGS_person.data(), end, number);
  std::string known = KnownPeople(ids);
  if (error == std::errc() && stop == end) {
    if (ids.count(number) > 0) return number;
  } else if (const std::string edits = IdentityPathOf(FLAGS_in);
             IsFile(edits)) {
    for (const IdentityEdit& edit : ReadIdentityEdits(edits)) {
      if (edit.op != EditOp::kName || edit.persons.empty()) continue;
      if (edit.name == FLAGS_person) return edit.persons.front().value();
      known += ", '" + Printable(edit.name) + "'";
    }
  }
  throw InputError("--person: no '" + Printable(FLAGS_person) +
                   "' in the tracks, expected one of " + known);
}

// Leaves the person of --person alone in the tracks.
void KeepPerson(const TrackFormat& to, TrackSequence* tracks) {
  std::set<int64_t> ids;
  for (const TrackFrame& frame : tracks->frames) {
    for (const PersonPose& person : frame.people) ids.insert(person.id.value());
  }
  const bool one_file = to.files == TrackFormat::Files::kFileAPerson &&
                        EndsIn(FLAGS_out, to.person_extension);
  if (FLAGS_person.empty()) {
    if (!one_file || ids.size() < 2) return;
    throw InputError("--out=" + Printable(FLAGS_out) +
                     ": a file of this format holds one person, the tracks "
                     "have " +
                     KnownPeople(ids) +
                     "; choose one with --person, or name a folder");
  }
  const TrackId wanted(WantedPerson(ids));
  for (TrackFrame& frame : tracks->frames) {
    std::vector<PersonPose> kept;
    for (PersonPose& person : frame.people) {
      if (person.id == wanted) kept.push_back(std::move(person));
    }
    frame.people = std::move(kept);
  }
}

// The formats that are written and have what `wanted` says, for messages.
std::string TrackFormatsWith(bool (*wanted)(const TrackFormat&)) {
  std::string names;
  for (const TrackFormat& format : TrackFormats()) {
    if (!wanted(format)) continue;
    names += (names.empty() ? "" : ", ") + format.name;
  }
  return names;
}

void RenameMarkers(const TrackFormat& to, TrackSequence* tracks) {
  const std::optional<MarkerNames> names = ParseMarkerNames(FLAGS_markers);
  if (!names.has_value()) {
    throw InputError("--markers: no '" + Printable(FLAGS_markers) +
                     "', expected one of " + kMarkerNamesList);
  }
  if (*names == MarkerNames::kOurs) return;
  if (!to.has_marker_names) {
    throw InputError("--markers belongs to --to=" +
                     TrackFormatsWith([](const TrackFormat& format) {
                       return format.has_marker_names;
                     }));
  }
  tracks->header.skeleton = WithMarkerNames(tracks->header.skeleton, *names);
}

// --axes, where one of the two formats has axes of its own.
std::optional<AxisMap> AxesFlag(const TrackFormat& to,
                                const std::string& mode) {
  if (FLAGS_axes.empty()) return std::nullopt;
  const TrackFormat* from = FindTrackFormat(mode);
  const bool is_read = from != nullptr && from->axes.has_value();
  if (!to.axes.has_value() && !is_read) {
    throw InputError("--axes belongs to files of " +
                     TrackFormatsWith([](const TrackFormat& format) {
                       return format.axes.has_value();
                     }));
  }
  return AxisMap::Parse(FLAGS_axes);
}

std::string ConvertTracks(const ConvertOptions& options, Losses* losses) {
  TrackReadOptions read;
  if (FLAGS_from != "auto") read.format = FLAGS_from;
  if (!FLAGS_skeleton.empty()) read.skeleton = SkeletonFlag();
  read.frame_rate_hz = FLAGS_frame_rate;
  read.first_frame = options.first_frame;
  if (!FLAGS_axes.empty()) read.axes = AxisMap::Parse(FLAGS_axes);
  TrackSequence tracks = ReadTracks(FLAGS_in, read);
  const TrackFormat& to = *FindTrackFormat(FLAGS_to);
  KeepPerson(to, &tracks);
  RenameMarkers(to, &tracks);
  TrackExportOptions write;
  write.axes = AxesFlag(to, tracks.header.mode);
  write.names = ReadPersonNames(FLAGS_in);
  if (!write.names.empty() && !to.keeps_names) {
    losses->push_back("names of people are not kept");
  }
  to.write(FLAGS_out, tracks, write, losses);
  return Count(tracks.frames.size(), "frames");
}

void PrintFormats() {
  for (const Format& format : Formats()) {
    std::printf("%-13s %-10s %-15s %s\n", ToString(format.kind),
                format.name.c_str(),
                !format.writable   ? "read only"
                : !format.readable ? "write only"
                                   : "read and write",
                format.layout.c_str());
  }
}

void RunConvert() {
  if (FLAGS_formats) return PrintFormats();
  RequireFlag("from", FLAGS_from);
  RequireFlag("in", FLAGS_in);
  RequireFlag("out", FLAGS_out);
  ChooseByExtension();
  const FileKind kind = ChooseKind();
  CheckFlags(kind);
  const ConvertOptions options = ReadOptions();
  WithFolders(FLAGS_out);
  Losses losses;
  const std::string done =
      kind == kCalibration  ? ConvertCalibration(options, &losses)
      : kind == kDetections ? ConvertDetections(options, &losses)
                            : ConvertTracks(options, &losses);
  for (const std::string& loss : losses) {
    std::fprintf(stderr, "kinegraph-convert: note: %s\n",
                 Printable(loss, 500).c_str());
  }
  std::fprintf(SummaryStream(FLAGS_out), "%s -> %s\n", done.c_str(),
               FLAGS_out.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"convert", "calibrations, detections and tracks between formats",
       "--in=PATH --out=PATH [--to=FORMAT] [--from=FORMAT]"},
      kinegraph::RunConvert);
}
