#include "core/io/tracks.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/io/bulk_json.h"
#include "core/io/joint_names.h"
#include "core/io/text_file.h"
#include "core/io/track_formats.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// Formats that begin with a word of their own.
std::optional<TrackFormat> FormatOfBeginning(const std::string& text) {
  for (const auto& [begin, format] :
       {std::pair{"frame,time_s,id,joint,", TrackFormat::kCsv},
        {"PathFileType", TrackFormat::kTrc},
        {"PK\x03\x04", TrackFormat::kNpz}}) {
    if (text.rfind(begin, 0) == 0) return format;
  }
  return std::nullopt;
}

TrackFormat Recognise(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    return ListTrcFiles(path).empty() ? TrackFormat::kPanoptic
                                      : TrackFormat::kTrc;
  }
  if (IsPipe(path)) return TrackFormat::kKinegraph;
  if (const auto format = FormatOfBeginning(BeginningOf(path, 64))) {
    return *format;
  }
  const JsonHead head = PeekJson(path);
  if (head.kind == 'M') return TrackFormat::kTum;  // "MATLAB 5.0 MAT-file"
  if (std::isdigit(static_cast<unsigned char>(head.kind)) != 0) {
    return TrackFormat::kFourDAssociation;
  }
  if (head.kind == '[') return TrackFormat::kLongcw;
  if (head.Has("kinegraph")) return TrackFormat::kKinegraph;
  if (head.Has("poses")) return TrackFormat::kPoses;
  if (head.Has("bodies")) return TrackFormat::kPanoptic;
  if (head.Has("kinegraph_detections")) {
    throw InputError(path, "", "is a file of detections, expected tracks");
  }
  throw InputError(path, "",
                   "is no known format of tracks, expected ours, TUM's .mat, "
                   "4D association's text, longcw, {\"poses\"}, Panoptic, "
                   "CSV, TRC or NPZ");
}

void Check(const TrackReadOptions& options) {
  if (!(options.frame_rate_hz >= 0.0 && options.frame_rate_hz <= 1e6)) {
    throw OptionError("frame_rate", "expected above 0 .. 1e6 Hz");
  }
  if (options.first_frame < 0 || options.first_frame > kMaxFrame) {
    throw OptionError("first_frame", "expected a frame number >= 0");
  }
}

TrackSequence ReadAll(TrackSource* source) {
  TrackSequence sequence;
  TrackFrame frame;
  while (source->Next(&frame)) sequence.frames.push_back(std::move(frame));
  sequence.header = source->header();  // may have learnt the views' names
  return sequence;
}

TrackSequence Read(const std::string& path, TrackFormat format,
                   const TrackReadOptions& options) {
  switch (format) {
    case TrackFormat::kTum:
      return ReadTumTracks(path, options);
    case TrackFormat::kFourDAssociation:
      return ReadFourDAssociation(path, options);
    case TrackFormat::kLongcw:
      return ReadLongcwTracks(path, options);
    case TrackFormat::kPoses:
      return ReadPoses(path, options);
    case TrackFormat::kPanoptic:
      return ReadPanoptic(path, options);
    case TrackFormat::kCsv:
      return ReadTracksCsv(path, options);
    case TrackFormat::kTrc:
      return ReadTracksTrc(path, options);
    case TrackFormat::kNpz:
      return ReadTracksNpz(path, options);
    default:
      return ReadAll(OpenKinegraphTracks(path, options).get());
  }
}

// Hands out frames that are in memory.
class SequenceSource : public TrackSource {
 public:
  explicit SequenceSource(TrackSequence sequence)
      : sequence_(std::move(sequence)) {}
  const TrackHeader& header() const override { return sequence_.header; }
  bool Next(TrackFrame* frame) override {
    if (next_ == sequence_.frames.size()) return false;
    *frame = std::move(sequence_.frames[next_++]);
    return true;
  }

 private:
  TrackSequence sequence_;
  size_t next_ = 0;
};

}  // namespace

std::unique_ptr<TrackSource> OpenTracks(const std::string& path,
                                        const TrackReadOptions& options) {
  Check(options);
  const TrackFormat format =
      options.format == TrackFormat::kAuto ? Recognise(path) : options.format;
  if (format == TrackFormat::kKinegraph) {
    return OpenKinegraphTracks(path, options);
  }
  return std::make_unique<SequenceSource>(Read(path, format, options));
}

TrackSequence ReadTracks(const std::string& path,
                         const TrackReadOptions& options) {
  Check(options);
  return Read(
      path,
      options.format == TrackFormat::kAuto ? Recognise(path) : options.format,
      options);
}

bool IsTracksExport(const std::string& path) {
  if (IsFolder(path)) return !ListTrcFiles(path).empty();
  return FormatOfBeginning(BeginningOf(path, 64)).has_value();
}

Skeleton SkeletonOfNames(const std::vector<std::string>& joints,
                         const TrackReadOptions& options) {
  if (options.skeleton.has_value()) {
    if (options.skeleton->joints() != joints) {
      throw InputError("the joints are not those of '" +
                       Printable(options.skeleton->name()) + "'");
    }
    return *options.skeleton;
  }
  if (const Skeleton* known = FindSkeletonOf(joints)) return *known;
  // Under the names that another program gives them.
  std::vector<std::string> ours;
  for (const std::string& joint : joints) ours.push_back(JointNameOf(joint));
  if (const Skeleton* known = FindSkeletonOf(ours)) return *known;
  try {
    return Skeleton("custom", joints, {});
  } catch (const OptionError& error) {
    throw InputError(std::string("joints: ") + error.message());
  }
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
