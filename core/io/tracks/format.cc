#include "core/io/tracks/format.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/limits.h"
#include "core/io/adapters/adapter.h"
#include "core/io/files/text_file.h"
#include "core/io/text/gone_formats.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {

// Declares the functions of a format; other sources of this folder define them.
#define KINEGRAPH_DECLARE(Format)                                      \
  bool Recognise##Format##Tracks(const TrackHead& head);               \
  TrackSequence Read##Format##Tracks(const std::string& path,          \
                                     const TrackReadOptions& options); \
  PersonNames Read##Format##Names(const std::string& path);            \
  void Write##Format##Tracks(                                          \
      const std::string& path, const TrackSequence& tracks,            \
      const TrackExportOptions& options, LostFields* lost_fields)
KINEGRAPH_DECLARE(Kinegraph);
KINEGRAPH_DECLARE(Csv);
KINEGRAPH_DECLARE(Npz);
KINEGRAPH_DECLARE(Trc);
KINEGRAPH_DECLARE(C3d);
KINEGRAPH_DECLARE(Bvh);
KINEGRAPH_DECLARE(Gltf);
KINEGRAPH_DECLARE(Movement);
KINEGRAPH_DECLARE(Anipose);
KINEGRAPH_DECLARE(FreeMoCap);
KINEGRAPH_DECLARE(Poses);
KINEGRAPH_DECLARE(Longcw);
KINEGRAPH_DECLARE(FourDAssociation);
KINEGRAPH_DECLARE(Panoptic);
KINEGRAPH_DECLARE(Tum);
#undef KINEGRAPH_DECLARE

namespace {

void Check(const TrackReadOptions& options) {
  if (!(options.frame_rate_hz >= 0.0 &&
        options.frame_rate_hz <= kMaxFrameRate_hz)) {
    throw OptionError("frame_rate",
                      "expected a rate above 0 and at most 1e6 Hz");
  }
  if (options.first_frame < 0 || options.first_frame > kMaxFrame) {
    throw OptionError("first_frame", "expected a frame number from 0 to " +
                                         std::to_string(kMaxFrame));
  }
}

// Stands for the formats of adapters that have no entry in TrackFormats(), and
// for any format that the program of SetAdapter reads.
const TrackFormat& FormatOfAdapters() {
  static const TrackFormat kFormat = {
      "adapter",
      "",
      {},
      nullptr,
      [](const std::string& path, const TrackReadOptions& options) {
        const auto adapter = AdapterOf(path, AdapterKind::kTracks);
        if (!adapter.has_value()) {
          throw InputError(path, "",
                           "has changed since its format was recognised");
        }
        return ReadTracksByAdapter(*adapter, path, options);
      }};
  return kFormat;
}

// Builds an entry of TrackFormats(); properties that a format lacks keep their
// defaults.
struct Row : TrackFormat {
  Row(const char* of_name, const char* of_layout) {
    name = of_name;
    layout = of_layout;
  }
  Row& Extensions(const char* list) {
    extensions = Split(list, ',');
    return *this;
  }
  Row& Reads(Recognise how_recognised, Read how_read) {
    recognise = how_recognised;
    read = how_read;
    return *this;
  }
  Row& Writes(Write how) {
    write = how;
    return *this;
  }
  // Joints may be renamed to other programs' names; people have names.
  Row& WithNames(ReadNames how_read = nullptr) {
    has_marker_names = true;
    return WithPersonNames(how_read);
  }
  Row& WithPersonNames(ReadNames how_read) {
    keeps_names = true;
    read_names = how_read;
    return *this;
  }
  Row& OwnAxes(const AxisMap& of_file) {
    axes = of_file;
    return *this;
  }
  Row& UsualUnit(double metres) {
    unit_m = metres;
    return *this;
  }
  Row& FileAPerson(const char* extension) {
    person_extension = extension;
    return *this;
  }
  Row& FileAFrame() {
    is_file_a_frame = true;
    return *this;
  }
  // The format also recognises files that are not tracks.
  Row& Mistakable() {
    is_unmistakable = false;
    return *this;
  }
  Row& OfAdapter() {
    is_of_adapter = true;
    return *this;
  }
};

}  // namespace

// In the order of listings. Recognition depends on it only for a folder with
// files of several formats and for a JSON object with the keys of several.
const std::vector<TrackFormat>& TrackFormats() {
  static const std::vector<TrackFormat> kFormats = {
      Row("kinegraph", "JSON Lines")
          .Extensions(".jsonl")
          .Reads(RecogniseKinegraphTracks, ReadKinegraphTracks)
          .Writes(WriteKinegraphTracks)
          .WithPersonNames(ReadKinegraphNames),
      Row("csv", "one row per joint")
          .Extensions(".csv")
          .Reads(RecogniseCsvTracks, ReadCsvTracks)
          .Writes(WriteCsvTracks)
          .WithNames(ReadCsvNames),
      Row("npz", "NumPy's arrays")
          .Extensions(".npz")
          .Reads(RecogniseNpzTracks, ReadNpzTracks)
          .Writes(WriteNpzTracks)
          .UsualUnit(1.0)
          .WithNames(ReadNpzNames),
      Row("trc", "a folder with one file per person")
          .Extensions(".trc")
          .Reads(RecogniseTrcTracks, ReadTrcTracks)
          .Writes(WriteTrcTracks)
          .OwnAxes(AxisMap())
          .WithNames()
          .FileAPerson(".trc"),
      Row("c3d", "points of motion capture, mm")
          .Extensions(".c3d")
          .Reads(RecogniseC3dTracks, ReadC3dTracks)
          .Writes(WriteC3dTracks)
          .OwnAxes(C3dAxes())
          .WithNames(ReadC3dNames),
      Row("bvh", "skeleton and joint angles, cm, one file per person")
          .Extensions(".bvh")
          .Reads(RecogniseBvhTracks, ReadBvhTracks)
          .Writes(WriteBvhTracks)
          .OwnAxes(AnimationAxes())
          .UsualUnit(0.01)
          .WithNames()
          .FileAPerson(".bvh"),
      Row("gltf", "glTF 2.0, animated skeletons of all people, m")
          .Extensions(".glb,.gltf")
          .Writes(WriteGltfTracks)
          .OwnAxes(AnimationAxes())
          .WithNames(),
      Row("movement", "netCDF for movement and xarray, m")
          .Extensions(".nc")
          .Writes(WriteMovementTracks)
          .WithNames()
          .OfAdapter(),
      Row("anipose", "Anipose's table of 3D points, mm, one file per person")
          .Writes(WriteAniposeTracks)
          .WithNames()
          .FileAPerson(".csv"),
      Row("freemocap", "FreeMoCap's 3D points: CSV NAME_x, NAME_y, NAME_z; NPY")
          .Reads(RecogniseFreeMoCapTracks, ReadFreeMoCapTracks)
          .UsualUnit(0.001),
      Row("poses", "JSON: {\"poses\": [...]}")
          .Reads(RecognisePosesTracks, ReadPosesTracks),
      Row("longcw", "annotation_3d.json, result_3d.json")
          .Reads(RecogniseLongcwTracks, ReadLongcwTracks)
          .Writes(WriteLongcwTracks)
          .UsualUnit(0.01)
          .Mistakable(),
      Row("4da", "4D association's gt.txt, skel.txt")
          .Reads(RecogniseFourDAssociationTracks, ReadFourDAssociationTracks)
          .Writes(WriteFourDAssociationTracks)
          .UsualUnit(1.0)
          .Mistakable(),
      Row("panoptic", "body3DScene_*.json")
          .Reads(RecognisePanopticTracks, ReadPanopticTracks)
          .Writes(WritePanopticTracks)
          .UsualUnit(0.01)
          .FileAFrame(),
      Row("tum", "actorsGT.mat")
          .Reads(nullptr, ReadTumTracks)
          .Writes(WriteTumTracks)
          .UsualUnit(1.0)
          .OfAdapter()};
  return kFormats;
}

std::string TrackFormatNames(bool (*wanted)(const TrackFormat& format)) {
  std::string names;
  for (const TrackFormat& format : TrackFormats()) {
    if (!wanted(format)) continue;
    names += (names.empty() ? "" : ", ") + format.name;
  }
  return names;
}

const TrackFormat* FindTrackFormat(const std::string& name) {
  for (const TrackFormat& format : TrackFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

const TrackFormat* TrackFormatOfExtension(const std::string& path) {
  for (const TrackFormat& format : TrackFormats()) {
    for (const std::string& extension : format.extensions) {
      if (EndsInAnyCase(path, extension)) return &format;
    }
  }
  return nullptr;
}

std::string TrackExtensions() {
  std::string text;
  std::string last;
  for (const TrackFormat& format : TrackFormats()) {
    for (const std::string& extension : format.extensions) {
      if (!last.empty()) text += (text.empty() ? "" : ", ") + last;
      last = extension;
    }
  }
  return text + " or " + last;
}

bool TrackHead::HasFile(const std::string& extension) const {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return EndsInAnyCase(name, extension);
  });
}

TrackHead LookAtTracks(const std::string& path) {
  TrackHead head;
  head.is_folder = IsFolder(path);
  if (head.is_folder) {
    for (const std::string& name : ListFolder(path)) {
      if (name.front() != '.') head.names.push_back(name);
    }
    return head;
  }
  static_cast<FileHead&>(head) = LookAtFile(path);
  return head;
}

const TrackFormat* RecogniseTracks(const TrackHead& head) {
  for (const TrackFormat& format : TrackFormats()) {
    if (format.recognise != nullptr && format.recognise(head)) return &format;
  }
  return nullptr;
}

const TrackFormat& FormatOfTracks(const std::string& path,
                                  const TrackReadOptions& options) {
  const auto known = [] {
    return TrackFormatNames(
        [](const TrackFormat& format) { return format.read != nullptr; });
  };
  if (!options.format.empty()) {
    const TrackFormat* format = FindTrackFormat(options.format);
    if (format != nullptr && format->read != nullptr) return *format;
    throw OptionError("format", "found '" + Printable(options.format) +
                                    "', expected one of " + known() +
                                    WayOnFrom(options.format));
  }
  if (IsPipe(path)) return *FindTrackFormat("kinegraph");
  if (GivenAdapterOf(path, AdapterKind::kTracks)) return FormatOfAdapters();
  const TrackHead head = LookAtTracks(path);
  const TrackFormat* format = RecogniseTracks(head);
  if (format != nullptr) return *format;
  if (const auto adapter = AdapterOf(path, AdapterKind::kTracks)) {
    const TrackFormat* ours = FindTrackFormat(adapter->name);
    return ours != nullptr && ours->read != nullptr ? *ours
                                                    : FormatOfAdapters();
  }
  if (head.HasKey("kinegraph_detections")) {
    throw InputError(path, "", "contains detections, expected tracks");
  }
  const bool is_coco3d =
      head.HasKey("categories") &&
      head.beginning.find("keypoints_3d") != std::string::npos;
  throw InputError(path, "",
                   "is in no known format of tracks, expected one of " +
                       known() + WayOnFrom(is_coco3d ? "coco3d" : ""));
}

TrackSequence ReadTracks(const std::string& path,
                         const TrackReadOptions& options) {
  Check(options);
  const TrackFormat& format = FormatOfTracks(path, options);
  const double unit_m = options.unit_m;
  if (unit_m > 0.0 && !format.unit_m) {
    const std::string others = TrackFormatNames(
        [](const TrackFormat& other) { return other.unit_m.has_value(); });
    throw InputError(path, "",
                     "is " + format.name +
                         ", which specifies its unit; --unit "
                         "applies to tracks of " +
                         others);
  }
  TrackSequence tracks = format.read(path, options);
  // The file was read in the format's usual unit, but has another one.
  if (unit_m > 0.0 && unit_m != *format.unit_m) {
    for (TrackFrame& frame : tracks.frames) {
      Scale(unit_m / *format.unit_m, &frame);
    }
  }
  return tracks;
}

double ParseLengthUnit(const std::string& text, const std::string& flag) {
  for (const auto& [name, length_m] : kLengthUnits) {
    if (text == name) return length_m;
  }
  Refuse("{}: found '{}', expected m, cm or mm", flag, Printable(text));
}

bool LeavesUnitOpen(const std::string& path) {
  return FormatOfTracks(path, {}).unit_m.has_value();
}

PersonNames ReadPersonNames(const std::string& path) {
  if (IsPipe(path) || (!IsFolder(path) && !IsFile(path))) return {};
  const TrackFormat* format = RecogniseTracks(LookAtTracks(path));
  if (format == nullptr) return {};
  if (!format->person_extension.empty()) {
    return NamesOfPersonFiles(path, format->person_extension);
  }
  return format->read_names == nullptr ? PersonNames()
                                       : format->read_names(path);
}

}  // namespace kinegraph
