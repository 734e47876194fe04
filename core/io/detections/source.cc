#include "core/io/detections/source.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/plausible_pixels.h"
#include "core/io/detections/rated_source.h"
#include "core/io/files/folder_entry.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> FormatNames() {
  std::vector<std::string> names = {"auto"};
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.open != nullptr) names.push_back(format.name);
  }
  return names;
}

std::string KnownSkeletons() {
  std::string names;
  for (const std::string& name : SkeletonNames()) {
    names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

DetectionReadOptions Checked(DetectionReadOptions options) {
  if (!(options.frame_rate_hz >= 0.0 && options.frame_rate_hz <= 1e6)) {
    throw OptionError("input.frame_rate", "expected above 0 .. 1e6 Hz");
  }
  if (options.first_frame < 0 || options.first_frame > kMaxFrame) {
    throw OptionError("detections.first_frame", "expected a frame number >= 0");
  }
  if (options.max_per_view < 1) {
    throw OptionError("detections.max_per_view", "expected at least 1");
  }
  if (options.max_per_frame < 1) {
    throw OptionError("detections.max_per_frame", "expected at least 1");
  }
  if (options.max_joints < 1) {
    throw OptionError("detections.max_joints", "expected at least 1");
  }
  if (options.skeleton || options.skeleton_name.empty()) return options;
  const Skeleton* skeleton = FindSkeleton(options.skeleton_name);
  if (skeleton == nullptr) {
    throw OptionError("detections.skeleton",
                      "found '" + Printable(options.skeleton_name) +
                          "', expected one of " + KnownSkeletons());
  }
  options.skeleton = *skeleton;
  return options;
}

[[noreturn]] void FailUnknown(const std::string& path,
                              const DetectionHead& head) {
  if (head.is_folder && head.file.empty()) {
    throw InputError(path, "",
                     "is a folder without detections, expected one folder or "
                     "one .json or .csv file a view");
  }
  if (head.HasKey("people")) {
    throw InputError(path, "",
                     "is one OpenPose frame, expected the folder that holds "
                     "one folder a view");
  }
  if (head.HasKey("kinegraph")) {
    throw InputError(path, "", "is a file of tracks, expected detections");
  }
  std::string names;
  for (const std::string& name : FormatNames()) {
    if (name != "auto") names += (names.empty() ? "" : ", ") + name;
  }
  throw InputError(path, "",
                   "is no known detection format, expected one of " + names +
                       " (`convert --formats` says what they are)");
}

const DetectionFormat& RecognisedFormat(const std::string& path) {
  const DetectionHead head = LookAtDetections(path);
  const DetectionFormat* format = RecogniseDetections(head);
  if (format == nullptr) FailUnknown(path, head);
  if (head.is_folder && format->files == DetectionFormat::Files::kOne) {
    throw InputError(head.file, "",
                     "names a whole recording: give this file, not its folder");
  }
  return *format;
}

std::unique_ptr<DetectionSource> Open(const std::string& path,
                                      const DetectionReadOptions& options) {
  // What comes through a pipe cannot be looked at and then read.
  const std::string name = options.format == "auto" && IsPipe(path)
                               ? std::string("kinegraph")
                               : options.format;
  const DetectionFormat* format =
      name == "auto" ? &RecognisedFormat(path) : FindDetectionFormat(name);
  if (format == nullptr || format->open == nullptr) {
    throw OptionError("detections.format",
                      "found '" + Printable(name) + "', which is not read");
  }
  if (options.skip_bad_frames && format->name != "kinegraph") {
    throw OptionError("input.skip_bad_frames",
                      "is for our own detections (JSON Lines), and '" +
                          Printable(path) + "' is " + format->name);
  }
  return format->open(path, options);
}

// Refuses what would take too long to associate, and what are no pixels.
class CheckedSource : public DetectionSource {
 public:
  CheckedSource(std::string path, const DetectionReadOptions& options,
                std::unique_ptr<DetectionSource> source)
      : path_(std::move(path)),
        max_per_view_(static_cast<size_t>(options.max_per_view)),
        max_per_frame_(static_cast<size_t>(options.max_per_frame)),
        skips_(options.skip_bad_frames),
        source_(std::move(source)),
        pixels_(source_->header().view_names) {
    for (const std::string& name : options.exchange_sides) {
      const std::vector<std::string>& views = header().view_names;
      const auto at = std::find(views.begin(), views.end(), name);
      if (at == views.end()) {
        throw OptionError(
            "detections.exchange_sides",
            "the detections have no view '" + Printable(name) + "'");
      }
      exchanged_.push_back(static_cast<size_t>(at - views.begin()));
    }
    const int64_t joints = header().skeleton.joint_count();
    if (joints <= options.max_joints) return;
    throw InputError(path_, "skeleton",
                     "has " + std::to_string(joints) + " joints, more than " +
                         std::to_string(options.max_joints) +
                         "; detections.max_joints raises the limit");
  }

  const DetectionHeader& header() const override { return source_->header(); }
  int64_t frame_count() const override { return source_->frame_count(); }
  BadFrames bad_frames() const override {
    BadFrames all = source_->bad_frames();
    all.count += bad_.count;
    if (all.last.empty()) all.last = bad_.last;
    return all;
  }
  bool Next(DetectionFrame* frame) override {
    while (source_->Next(frame)) {
      try {
        Check(*frame);
        for (const size_t v : exchanged_) ExchangeSides(&frame->views[v]);
        return true;
      } catch (const InputError& error) {
        if (!skips_) throw;
        ++bad_.count;
        bad_.last = error.what();
      }
    }
    Located(path_, [&] { pixels_.SeeEnd(); });
    return false;
  }

 private:
  void Check(const DetectionFrame& frame) {
    const std::string place = "frame " + std::to_string(frame.frame);
    size_t sum = 0;
    for (size_t v = 0; v < frame.views.size(); ++v) {
      const size_t count = frame.views[v].detections.size();
      sum += count;
      if (count <= max_per_view_) continue;
      Fail(place + ", view '" + Printable(header().view_names[v]) + "'", count,
           max_per_view_, "detections.max_per_view");
    }
    if (sum > max_per_frame_) {
      Fail(place, sum, max_per_frame_, "detections.max_per_frame");
    }
    Located(path_, [&] { pixels_.See(frame); });
  }

  void ExchangeSides(ViewDetections* view) const {
    const Skeleton& skeleton = header().skeleton;
    for (Detection& detection : view->detections) {
      for (int j = 0; j < skeleton.joint_count(); ++j) {
        const int other = skeleton.mirror(j);
        if (other > j)
          std::swap(detection.joints[static_cast<size_t>(j)],
                    detection.joints[static_cast<size_t>(other)]);
      }
    }
  }

  [[noreturn]] void Fail(const std::string& place, size_t count, size_t most,
                         const std::string& key) const {
    throw InputError(path_, place,
                     "has " + std::to_string(count) +
                         " detections, more than " + std::to_string(most) +
                         "; " + key + " raises the limit");
  }

  const std::string path_;
  const size_t max_per_view_;
  const size_t max_per_frame_;
  const bool skips_;
  std::vector<size_t> exchanged_;  // views
  BadFrames bad_;
  const std::unique_ptr<DetectionSource> source_;
  PlausiblePixels pixels_;
};

// Hands out frames that are in memory.
class CollectedSource : public DetectionSource {
 public:
  CollectedSource(DetectionHeader header,
                  std::map<int64_t, DetectionFrame> frames)
      : header_(std::move(header)), frames_(std::move(frames)) {
    frame_count_ = static_cast<int64_t>(frames_.size());
  }

  const DetectionHeader& header() const override { return header_; }
  bool Next(DetectionFrame* frame) override {
    if (frames_.empty()) return false;
    *frame = std::move(frames_.begin()->second);
    frames_.erase(frames_.begin());
    return true;
  }
  int64_t frame_count() const override { return frame_count_; }

 private:
  DetectionHeader header_;
  std::map<int64_t, DetectionFrame> frames_;
  int64_t frame_count_ = 0;
};

}  // namespace

void DetectionReadOptions::Describe(OptionVisitor& visitor) {
  const std::vector<std::string> names = FormatNames();
  const auto at = std::find(names.begin(), names.end(), format);
  int index = at == names.end() ? 0 : static_cast<int>(at - names.begin());
  visitor.ChoiceIndex(
      "format", &index, names,
      "format of the detections; auto recognises it by content");
  format = names[static_cast<size_t>(index)];
  visitor.Text("skeleton", &skeleton_name,
               "skeleton of the detections where the file does not tell it");
  visitor.Choice("zero_confidence", &zero_confidence, {"missing", "position"},
                 "what a joint with confidence 0, or at exactly (0, 0), is");
  visitor.TextList("exchange_sides", &exchange_sides,
                   "views in which left and right are exchanged");
  visitor.Integer("first_frame", &first_frame,
                  Between(0.0, static_cast<double>(kMaxFrame)), "frames",
                  "frame number of a file that names none");
  visitor.Integer("max_per_view", &max_per_view, Between(1.0, 1e6),
                  "detections",
                  "most detections of one view in one frame; more are refused");
  visitor.Integer(
      "max_per_frame", &max_per_frame, Between(1.0, 1e6), "detections",
      "most detections of all views in one frame; more are refused");
  visitor.Integer("max_joints", &max_joints, Between(1.0, 1e4), "joints",
                  "most joints of the detections' skeleton; more are refused");
}

std::unique_ptr<DetectionSource> OpenDetections(
    const std::string& path, const DetectionReadOptions& options) {
  try {
    const DetectionReadOptions checked = Checked(options);
    const auto check = [&](std::unique_ptr<DetectionSource> source) {
      return std::make_unique<CheckedSource>(path, checked, std::move(source));
    };
    if (checked.view_frame_rate_hz.empty() &&
        checked.view_frame_offset.empty()) {
      return check(Open(path, checked));
    }
    if (IsPipe(path)) {
      throw InputError(path, "",
                       "views that count frames in their own way "
                       "(input.view_frame_rate, input.view_frame_offset) are "
                       "read several times, which a stream cannot be");
    }
    return check(OpenRated([=] { return Open(path, checked); }, checked));
  } catch (const fs::filesystem_error& error) {
    throw InputError(path, "", "cannot be read: " + error.code().message());
  }
}

DetectionSequence ReadDetections(const std::string& path,
                                 const DetectionReadOptions& options) {
  const std::unique_ptr<DetectionSource> source = OpenDetections(path, options);
  DetectionSequence sequence;
  DetectionFrame frame;
  while (source->Next(&frame)) sequence.frames.push_back(std::move(frame));
  sequence.header = source->header();
  return sequence;
}

Keypoint MakeKeypoint(double x_px, double y_px, double confidence,
                      ZeroConfidence zero_confidence) {
  Keypoint joint;
  if (!std::isfinite(x_px) || !std::isfinite(y_px) ||
      !std::isfinite(confidence)) {
    return joint;
  }
  joint.px = {x_px, y_px};
  joint.confidence = confidence;
  joint.found = zero_confidence == ZeroConfidence::kPosition ||
                (confidence > 0.0 && (x_px != 0.0 || y_px != 0.0));
  return joint;
}

std::vector<std::pair<std::string, std::string>> ListViewFiles(
    const std::string& path, const std::string& extension) {
  std::vector<std::pair<std::string, std::string>> files;
  if (!fs::is_directory(path)) {
    files.emplace_back(fs::path(path).stem().string(), path);
    return files;
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const fs::path& file = entry.path();
    if (file.extension() != extension || file.filename() == "truth.json" ||
        file.filename().string().front() == '.' || !IsFileOrFolder(entry)) {
      continue;
    }
    files.emplace_back(file.stem().string(), file.string());
  }
  if (files.empty()) {
    throw InputError(path, "",
                     "holds no " + extension + " files, expected one a view");
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return NaturalLess(a.first, b.first);
  });
  return files;
}

DetectionHeader HeaderOfViews(
    const std::vector<std::pair<std::string, std::string>>& files,
    const DetectionReadOptions& options) {
  DetectionHeader header;
  header.skeleton = options.skeleton.value_or(Skeleton());
  header.frame_rate_hz = options.frame_rate_hz;
  for (const auto& [view, file] : files) header.view_names.push_back(view);
  return header;
}

std::vector<const Skeleton*> DetectorSkeletons(size_t joint_count,
                                               const std::string& key) {
  std::vector<const Skeleton*> found;
  std::string expected;
  for (const Skeleton* skeleton :
       {&Coco17(), &Coco18(), &Body25(), &Body25B(), &Halpe26(), &MediaPipe33(),
        &WholeBody133()}) {
    const size_t count = skeleton->joints().size();
    if (count == joint_count) found.push_back(skeleton);
    expected += (expected.empty() ? "" : ", ") + std::to_string(count) + " (" +
                skeleton->name() + ")";
  }
  if (!found.empty()) return found;
  throw InputError(key + ": found " + std::to_string(joint_count) +
                   " joints, expected " + expected +
                   "; detections.skeleton names other skeletons");
}

bool IsToldByJointCount(const Skeleton& skeleton) {
  try {
    return *DetectorSkeletons(skeleton.joints().size(), "").front() == skeleton;
  } catch (const InputError&) {
    return false;
  }
}

void DetectionCollector::SettleSkeleton(const std::vector<std::string>& labels,
                                        const std::vector<Bone>& bones,
                                        const std::string& name) {
  const Skeleton& known = header_.skeleton;
  if (known.joint_count() == 0) {
    set_skeleton(SkeletonOfLabels(labels, bones, name));
    labels_ = labels;
  }
  if (known.joints().size() != labels.size()) {
    throw InputError("found " + std::to_string(labels.size()) +
                     " joints, expected the " +
                     std::to_string(known.joints().size()) + " of '" +
                     Printable(known.name()) + "'");
  }
  if (labels_.empty()) return;  // the options' skeleton
  for (size_t j = 0; j < labels.size(); ++j) {
    if (labels[j] == labels_[j]) continue;
    throw InputError("joint " + std::to_string(j) + " is '" +
                     Printable(labels[j]) + "', expected '" +
                     Printable(labels_[j]) + "' as in the first file");
  }
}

DetectionFrame* DetectionCollector::Touch(int64_t frame_number) {
  DetectionFrame& frame = frames_[frame_number];
  if (frame.views.empty()) {
    frame.frame = frame_number;
    frame.time = TimeOfFrame(frame_number, header_.frame_rate_hz);
    frame.views.resize(header_.view_names.size());
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
  }
  return &frame;
}

Detection* DetectionCollector::Add(int64_t frame, size_t view_idx) {
  std::vector<Detection>& detections = Touch(frame)->views[view_idx].detections;
  detections.emplace_back();
  detections.back().index_in_file = static_cast<int>(detections.size()) - 1;
  return &detections.back();
}

std::unique_ptr<DetectionSource> DetectionCollector::Finish() {
  return std::make_unique<CollectedSource>(std::move(header_),
                                           std::move(frames_));
}

}  // namespace kinegraph
