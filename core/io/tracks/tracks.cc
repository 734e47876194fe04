#include "core/io/tracks/tracks.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"

namespace kinegraph {
namespace {

// The option's format, else the one that recognises the path.
const TrackFormat& FormatOf(const std::string& path,
                            const TrackReadOptions& options) {
  std::string known;
  for (const TrackFormat& format : TrackFormats()) {
    if (format.read == nullptr) continue;
    if (format.name == options.format) return format;
    known += (known.empty() ? "" : ", ") + format.name;
  }
  if (!options.format.empty()) {
    throw OptionError("format", "found '" + Printable(options.format) +
                                    "', expected one of " + known);
  }
  if (IsPipe(path)) return *FindTrackFormat("kinegraph");
  const TrackHead head = LookAtTracks(path);
  const TrackFormat* format = RecogniseTracks(head);
  if (format != nullptr) return *format;
  if (head.HasKey("kinegraph_detections")) {
    throw InputError(path, "", "is a file of detections, expected tracks");
  }
  throw InputError(path, "",
                   "is no known format of tracks, expected one of " + known);
}

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

TrackSequence Read(const std::string& path, const TrackFormat& format,
                   const TrackReadOptions& options) {
  if (options.unit_m > 0.0 && !format.unit_m) {
    std::string open;
    for (const TrackFormat& other : TrackFormats()) {
      if (other.unit_m) open += (open.empty() ? "" : ", ") + other.name;
    }
    throw InputError(
        path, "",
        "is " + format.name +
            ", which tells its unit; --unit belongs to tracks of " + open);
  }
  TrackSequence tracks = format.read(path, options);
  if (options.unit_m > 0.0 && options.unit_m != *format.unit_m) {
    Scale(options.unit_m / *format.unit_m, &tracks);
  }
  return tracks;
}

}  // namespace

const TrackFormat& FormatOfTracks(const std::string& path,
                                  const TrackReadOptions& options) {
  return FormatOf(path, options);
}

double ParseLengthUnit(const std::string& text, const std::string& flag) {
  for (const auto& [name, length_m] : kLengthUnits) {
    if (text == name) return length_m;
  }
  throw InputError(flag + ": found '" + Printable(text) +
                   "', expected m, cm or mm");
}

bool LeavesUnitOpen(const std::string& path, const TrackReadOptions& options) {
  return FormatOf(path, options).unit_m.has_value();
}

TrackSequence ReadTracks(const std::string& path,
                         const TrackReadOptions& options) {
  Check(options);
  return Read(path, FormatOf(path, options), options);
}

Skeleton SkeletonOfNames(const std::vector<std::string>& joints,
                         const TrackReadOptions& options,
                         const std::vector<Bone>& bones) {
  if (!options.skeleton.has_value()) return SkeletonOfLabels(joints, bones);
  if (options.skeleton->joints() != joints &&
      options.skeleton->joints() != SkeletonOfLabels(joints).joints()) {
    throw InputError("the joints are not those of '" +
                     Printable(options.skeleton->name()) + "'");
  }
  return *options.skeleton;
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
  std::vector<PersonPose>& people = Touch(frame)->people;
  for (const PersonPose& person : people) {
    if (person.id == id) {
      throw InputError("frame " + std::to_string(frame) + ": person " +
                       std::to_string(id.value()) + " stands there twice");
    }
  }
  people.emplace_back();
  people.back().id = id;
  people.back().joints.resize(header_.skeleton.joints().size());
  return &people.back();
}

TrackSequence TrackCollector::Finish() {
  TrackSequence sequence;
  sequence.header = std::move(header_);
  sequence.frames.reserve(frames_.size());
  for (auto& [number, frame] : frames_) {
    sequence.frames.push_back(std::move(frame));
  }
  frames_.clear();
  return sequence;
}

}  // namespace kinegraph
