#include "core/io/tracks/format.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"

// One line a format, in the order in which they are listed; no other order
// matters, as no two recognise the same. Each names the function that makes the
// format's entry.
#define KINEGRAPH_TRACK_FORMATS(FORMAT) \
  FORMAT(KinegraphTrackFormat)          \
  FORMAT(CsvTrackFormat)                \
  FORMAT(NpzTrackFormat)                \
  FORMAT(TrcTrackFormat)                \
  FORMAT(C3dTrackFormat)                \
  FORMAT(BvhTrackFormat)                \
  FORMAT(GltfTrackFormat)               \
  FORMAT(MovementTrackFormat)           \
  FORMAT(AniposeTrackFormat)            \
  FORMAT(Coco3dTrackFormat)             \
  FORMAT(FreeMoCapTrackFormat)          \
  FORMAT(PosesTrackFormat)              \
  FORMAT(LongcwTrackFormat)             \
  FORMAT(FourDAssociationTrackFormat)   \
  FORMAT(PanopticTrackFormat)           \
  FORMAT(TumTrackFormat)

namespace kinegraph {

#define KINEGRAPH_DECLARE(make) TrackFormat make();
KINEGRAPH_TRACK_FORMATS(KINEGRAPH_DECLARE)
#undef KINEGRAPH_DECLARE

namespace {

void Check(const TrackReadOptions& options) {
  if (!(options.frame_rate_hz >= 0.0 && options.frame_rate_hz <= 1e6)) {
    throw OptionError("frame_rate", "expected above 0 .. 1e6 Hz");
  }
  if (options.first_frame < 0 || options.first_frame > kMaxFrame) {
    throw OptionError("first_frame", "expected a frame number >= 0");
  }
}

// In another unit than the format's usual one.
void Scale(double factor, TrackSequence* tracks) {
  for (TrackFrame& frame : tracks->frames) {
    for (PersonPose& person : frame.people) {
      for (Joint3d& joint : person.joints) joint.position_m *= factor;
      for (auto& covariance : person.covariances) {
        if (covariance) *covariance *= factor * factor;
      }
    }
  }
}

}  // namespace

const std::vector<TrackFormat>& TrackFormats() {
#define KINEGRAPH_MAKE(make) make(),
  static const std::vector<TrackFormat> kFormats = {
      KINEGRAPH_TRACK_FORMATS(KINEGRAPH_MAKE)};
#undef KINEGRAPH_MAKE
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
    if (format.write == nullptr) continue;
    for (const std::string& extension : format.extensions) {
      if (EndsIn(path, extension)) return &format;
    }
  }
  return nullptr;
}

std::string TrackExtensions() {
  std::vector<std::string> all;
  for (const TrackFormat& format : TrackFormats()) {
    if (format.write == nullptr) continue;
    all.insert(all.end(), format.extensions.begin(), format.extensions.end());
  }
  std::string text;
  for (size_t i = 0; i < all.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == all.size() ? " or " : ", ") + all[i];
  }
  return text;
}

bool TrackHead::HasKey(const std::string& key) const {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

std::vector<std::string> TrackHead::FirstRow() const {
  return FirstCsvRow(beginning);
}

bool TrackHead::HasFile(const std::string& extension) const {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return EndsIn(name, extension);
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
  const JsonHead json = PeekJson(path);
  head.kind = json.kind;
  head.keys = json.keys;
  head.beginning = BeginningOf(path, 1 << 16);
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
                                    "', expected one of " + known());
  }
  if (IsPipe(path)) return *FindTrackFormat("kinegraph");
  const TrackHead head = LookAtTracks(path);
  const TrackFormat* format = RecogniseTracks(head);
  if (format != nullptr) return *format;
  if (head.HasKey("kinegraph_detections")) {
    throw InputError(path, "", "is a file of detections, expected tracks");
  }
  throw InputError(path, "",
                   "is no known format of tracks, expected one of " + known());
}

TrackSequence ReadTracks(const std::string& path,
                         const TrackReadOptions& options) {
  Check(options);
  const TrackFormat& format = FormatOfTracks(path, options);
  const double unit_m = options.unit_m;
  if (unit_m > 0.0 && !format.unit_m) {
    throw InputError(
        path, "",
        "is " + format.name +
            ", which tells its unit; --unit belongs to tracks of " +
            TrackFormatNames([](const TrackFormat& other) {
              return other.unit_m.has_value();
            }));
  }
  TrackSequence tracks = format.read(path, options);
  if (unit_m > 0.0 && unit_m != *format.unit_m) {
    Scale(unit_m / *format.unit_m, &tracks);
  }
  return tracks;
}

double ParseLengthUnit(const std::string& text, const std::string& flag) {
  for (const auto& [name, length_m] : kLengthUnits) {
    if (text == name) return length_m;
  }
  throw InputError(flag + ": found '" + Printable(text) +
                   "', expected m, cm or mm");
}

bool LeavesUnitOpen(const std::string& path, const TrackReadOptions& options) {
  return FormatOfTracks(path, options).unit_m.has_value();
}

PersonNames ReadPersonNames(const std::string& path) {
  if (IsPipe(path) || (!IsFolder(path) && !IsFile(path))) return {};
  const TrackFormat* format = RecogniseTracks(LookAtTracks(path));
  if (format == nullptr || format->read_names == nullptr) return {};
  return format->read_names(path);
}

}  // namespace kinegraph
