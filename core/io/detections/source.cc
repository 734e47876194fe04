#include "core/io/detections/source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/box.h"
#include "core/data/limits.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/gone_formats.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> FormatNames() {
  std::vector<std::string> names = {"auto"};
  for (const DetectionFormat& format : DetectionFormats()) {
    names.push_back(format.name);
  }
  return names;
}

DetectionReadOptions Checked(DetectionReadOptions options) {
  if (!(options.frame_rate_hz >= 0.0 &&
        options.frame_rate_hz <= kMaxFrameRate_hz)) {
    throw OptionError("input.frame_rate",
                      "expected a rate above 0 and at most 1e6 Hz");
  }
  if (options.first_frame < 0 || options.first_frame > kMaxFrame) {
    throw OptionError(
        "detections.first_frame",
        "expected a frame number from 0 to " + std::to_string(kMaxFrame));
  }
  for (const auto& [key, most] :
       {std::pair{"detections.max_per_view", options.max_per_view},
        {"detections.max_per_frame", options.max_per_frame},
        {"detections.max_joints", options.max_joints}}) {
    if (most < 1) throw OptionError(key, "expected at least 1");
  }
  if (options.skeleton || options.skeleton_name.empty()) return options;
  const Skeleton* skeleton = FindSkeleton(options.skeleton_name);
  if (skeleton == nullptr) {
    throw OptionError("detections.skeleton",
                      fmt::format("found '{}', expected one of {}",
                                  Printable(options.skeleton_name),
                                  fmt::join(SkeletonNames(), ", ")));
  }
  options.skeleton = *skeleton;
  return options;
}

[[noreturn]] void FailUnknown(const std::string& path,
                              const DetectionHead& head) {
  if (head.is_folder && head.file.empty()) {
    throw InputError(path, "",
                     "is a folder without detections, expected one folder per "
                     "view, or one .json or .csv file per view");
  }
  if (head.HasKey("people")) {
    throw InputError(path, "",
                     "is a single OpenPose frame, expected the folder with one "
                     "subfolder per view");
  }
  if (head.HasKey("kinegraph")) {
    throw InputError(path, "", "contains tracks, expected detections");
  }
  const std::vector<std::string> names = FormatNames();
  throw InputError(
      path, "",
      fmt::format("is in no known detection format, expected one of {} "
                  "(`convert --formats` describes them){}",
                  fmt::join(names.begin() + 1, names.end(), ", "),
                  WayOnFrom(head.HasKey("3d_pairs") ? "smap" : "")));
}

void CheckWhole(const DetectionHead& head, const DetectionFormat& format) {
  if (head.is_folder && format.files == DetectionFormat::Files::kOne) {
    throw InputError(
        head.file, "",
        "contains a whole recording: pass this file, not its folder");
  }
}

void CheckSkipping(const std::string& path, const std::string& format,
                   const DetectionReadOptions& options) {
  if (!options.skip_bad_frames || format == "kinegraph") return;
  throw OptionError(
      "input.skip_bad_frames",
      "applies only to kinegraph's own format (JSON Lines), and '" +
          Printable(path) + "' is " + format);
}

std::unique_ptr<DetectionSource> OpenAs(const Adapter& adapter,
                                        const std::string& path,
                                        const DetectionReadOptions& options) {
  CheckSkipping(path, adapter.name, options);
  return OpenByAdapter(adapter, path, options);
}

std::unique_ptr<DetectionSource> OpenAs(const DetectionFormat& format,
                                        const std::string& path,
                                        const DetectionReadOptions& options) {
  CheckSkipping(path, format.name, options);
  return format.open(path, options);
}

// Opens `path` in the format recognised by its content.
std::unique_ptr<DetectionSource> OpenAny(const std::string& path,
                                         const DetectionReadOptions& options) {
  // Input from a pipe cannot be inspected before it is read.
  if (IsPipe(path)) {
    return OpenAs(*FindDetectionFormat("kinegraph"), path, options);
  }
  if (const auto given = GivenAdapterOf(path, AdapterKind::kDetections)) {
    return OpenAs(*given, path, options);
  }
  const DetectionHead head = LookAtDetections(path);
  const DetectionFormat* format = RecogniseDetections(head);
  // A folder of subfolders without data files is OpenPose's only if no adapter
  // reads it.
  const bool is_certain = !head.is_folder || head.kind != '\0';
  if (format != nullptr && is_certain) {
    CheckWhole(head, *format);
    return OpenAs(*format, path, options);
  }
  const auto adapter = AdapterOf(path, AdapterKind::kDetections);
  if (!adapter.has_value()) {
    if (format == nullptr) FailUnknown(path, head);
    CheckWhole(head, *format);
    return OpenAs(*format, path, options);
  }
  // The entry in DetectionFormats() may do more than run the adapter.
  format = FindDetectionFormat(adapter->name);
  return format != nullptr ? OpenAs(*format, path, options)
                           : OpenAs(*adapter, path, options);
}

std::unique_ptr<DetectionSource> Open(const std::string& path,
                                      const DetectionReadOptions& options) {
  if (options.format == "auto") return OpenAny(path, options);
  const DetectionFormat* format = FindDetectionFormat(options.format);
  if (format == nullptr) {
    throw OptionError(
        "detections.format",
        "found '" + Printable(options.format) +
            "', which is no detection format (`convert --formats` lists them)");
  }
  return OpenAs(*format, path, options);
}

// ---- Checks of the input ----

// Largest normalised coordinate. Joints may lie up to one image size outside
// the image: at -1 .. 2 if normalised to 0 .. 1, at -3 .. 3 if to -1 .. 1.
constexpr double kMostShare = 3.0;
// Smallest extent of normalised positions: people take up part of the image,
// unlike the placeholders that detectors write for unseen joints, such as
// (-1, -1).
constexpr double kLeastSpread = 0.1;
constexpr double kLargestImagePx = 65535.0;  // limit of JPEG; videos are
                                             // smaller
// A view is rejected at this number of people whose coordinates cannot be
// pixels or may be normalised: a single one may be a detection in a corner of
// the image.
constexpr int64_t kEnoughPeople = 10;

bool CanBeShares(const Eigen::AlignedBox2d& box) {
  return box.min().minCoeff() >= -kMostShare &&
         box.max().maxCoeff() <= kMostShare;
}

bool IsBeyondImages(const Eigen::AlignedBox2d& box) {
  return box.min().maxCoeff() > kLargestImagePx ||
         box.max().minCoeff() < -kLargestImagePx;
}

// A mirrored axis, and the sum of a coordinate and its mirror image [px].
struct Mirror {
  Eigen::Index axis = 0;
  double sum_px = 0.0;
};

Mirror MirrorOf(const std::string& key, const std::string& text) {
  const double sum_px =
      ParseNumber<double>(text.empty() ? "" : text.substr(1)).value_or(0.0);
  if (text.empty() || (text[0] != 'x' && text[0] != 'y') ||
      !(sum_px > 0.0 && sum_px <= kLargestImagePx)) {
    throw OptionError(
        key, fmt::format("found '{}', expected x or y and the width or height "
                         "of the image less 1, as in x1279",
                         Printable(text)));
  }
  return {text[0] == 'x' ? 0 : 1, sum_px};
}

void MirrorBack(const Mirror& mirror, ViewDetections* view) {
  for (Detection& detection : view->detections) {
    for (Keypoint& joint : detection.joints) {
      if (!joint.found) continue;
      joint.px[mirror.axis] = mirror.sum_px - joint.px[mirror.axis];
    }
  }
}

// Rejects frames that would take too long to associate, and views whose
// positions are not pixels: normalised by the image, to 0 .. 1 (MediaPipe,
// OpenPose with --keypoint_scale 3) or -1 .. 1 (--keypoint_scale 4), or beyond
// any image. A view is accepted at the first person that can only be in pixels.
// Also applies exchange_sides and mirror_px.
class CheckedSource : public DetectionSource {
 public:
  CheckedSource(std::string path, const DetectionReadOptions& options,
                std::unique_ptr<DetectionSource> source)
      : path_(std::move(path)),
        options_(options),
        source_(std::move(source)),
        positions_(source_->header().view_names.size()) {
    for (const std::string& name : options.exchange_sides) {
      exchanged_.push_back(ViewNamed(name, "detections.exchange_sides"));
    }
    for (const auto& [name, text] : options.mirror_px) {
      const std::string key = "detections.mirror_px";
      mirrors_.emplace_back(ViewNamed(name, key),
                            MirrorOf(key + "." + name, text));
    }
    CheckMost("skeleton", header().skeleton.joint_count(), "joints",
              options.max_joints, "detections.max_joints");
  }

  const DetectionHeader& header() const override { return source_->header(); }
  int64_t frame_count() const override { return source_->frame_count(); }
  BadFrames bad_frames() const override {
    BadFrames all = source_->bad_frames();
    // The reader's last error is later than that in `bad_` if it has skipped
    // frames since.
    if (all.count == read_bad_) all.last = bad_.last;
    all.count += bad_.count;
    return all;
  }
  bool Next(DetectionFrame* frame) override {
    while (source_->Next(frame)) {
      try {
        CheckCounts(*frame);
        Located(path_, [&] { SeePositions(*frame); });
        for (const size_t v : exchanged_) ExchangeSides(&frame->views[v]);
        for (const auto& [v, mirror] : mirrors_) {
          MirrorBack(mirror, &frame->views[v]);
        }
        return true;
      } catch (const InputError& error) {
        if (!options_.skip_bad_frames) throw;
        ++bad_.count;
        bad_.last = error.what();
        read_bad_ = source_->bad_frames().count;
      }
    }
    Located(path_, [&] { CheckShortRecording(); });
    return false;
  }

 private:
  // Statistics of the positions of all people in one view.
  struct Positions {
    bool are_pixels = false;
    int64_t shares = 0;       // people whose positions may be normalised
    int64_t far = 0;          // people beyond any image
    Eigen::AlignedBox2d box;  // around all people
  };

  size_t ViewNamed(const std::string& name, const std::string& key) const {
    const std::vector<std::string>& views = header().view_names;
    const auto at = std::find(views.begin(), views.end(), name);
    if (at == views.end()) {
      throw OptionError(
          key, "the detections have no view '" + Printable(name) + "'");
    }
    return static_cast<size_t>(at - views.begin());
  }

  void CheckMost(const std::string& place, int64_t count, const char* what,
                 int64_t most, const char* key) const {
    if (count <= most) return;
    throw InputError(path_, place,
                     fmt::format("has {} {}, more than {}; {} raises the limit",
                                 count, what, most, key));
  }

  void CheckCounts(const DetectionFrame& frame) const {
    const std::string place = "frame " + std::to_string(frame.frame);
    int64_t sum = 0;
    for (size_t v = 0; v < frame.views.size(); ++v) {
      const auto count = static_cast<int64_t>(frame.views[v].detections.size());
      sum += count;
      if (count <= options_.max_per_view) continue;
      CheckMost(place + ", view '" + Printable(header().view_names[v]) + "'",
                count, "detections", options_.max_per_view,
                "detections.max_per_view");
    }
    CheckMost(place, sum, "detections", options_.max_per_frame,
              "detections.max_per_frame");
  }

  // Throws InputError, which names the view but no file, once kEnoughPeople
  // show that the positions in a view are not pixels.
  void SeePositions(const DetectionFrame& frame) {
    for (size_t v = 0; v < positions_.size(); ++v) {
      Positions& seen = positions_[v];
      for (const Detection& detection : frame.views[v].detections) {
        if (seen.are_pixels) break;
        const Eigen::AlignedBox2d box = BoxAround(detection.joints);
        if (box.isEmpty()) continue;
        const bool is_share = CanBeShares(box);
        const bool is_far = IsBeyondImages(box);
        seen.shares += is_share ? 1 : 0;
        seen.far += is_far ? 1 : 0;
        seen.are_pixels = !is_share && !is_far;
        seen.box.extend(box);
      }
      CheckPositions(v, kEnoughPeople);
    }
  }

  // For the end of a recording: if no view is certainly in pixels, a single
  // person is enough to reject a view (kEnoughPeople before the end).
  void CheckShortRecording() const {
    if (std::none_of(positions_.begin(), positions_.end(),
                     [](const Positions& seen) { return seen.are_pixels; })) {
      for (size_t v = 0; v < positions_.size(); ++v) CheckPositions(v, 1);
    }
  }

  void CheckPositions(size_t view_idx, int64_t enough_people) const {
    const Positions& seen = positions_[view_idx];
    const Eigen::AlignedBox2d& box = seen.box;
    if (seen.are_pixels || box.isEmpty()) return;
    const std::string where = fmt::format(
        "view '{}': positions are within x {:.3g} .. {:.3g} and y {:.3g} .. "
        "{:.3g}",
        Printable(header().view_names[view_idx]), box.min().x(), box.max().x(),
        box.min().y(), box.max().y());
    if (seen.shares == 0 && seen.far >= enough_people) {
      throw InputError(where + ", outside any possible image, expected pixels");
    }
    if (seen.far > 0 || seen.shares < enough_people ||
        box.sizes().maxCoeff() < kLeastSpread) {
      return;
    }
    const bool is_signed = box.min().minCoeff() < -0.5;
    throw InputError(
        where +
        ", which are normalised by the image size, expected pixels: multiply " +
        (is_signed ? "(x + 1) / 2" : "x") + " by the image's width and " +
        (is_signed ? "(y + 1) / 2" : "y") +
        " by its height (OpenPose: detect without "
        "--keypoint_scale)");
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

  const std::string path_;
  const DetectionReadOptions options_;
  const std::unique_ptr<DetectionSource> source_;
  std::vector<Positions> positions_;                // one per view
  std::vector<size_t> exchanged_;                   // views
  std::vector<std::pair<size_t, Mirror>> mirrors_;  // by view
  BadFrames bad_;         // frames that were read, but rejected here
  int64_t read_bad_ = 0;  // frames skipped by source_ before bad_.last
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
               "skeleton of the detections if the file does not specify it");
  visitor.Choice("zero_confidence", &zero_confidence, {"missing", "position"},
                 "how to treat a joint with confidence 0 or at exactly (0, 0)");
  visitor.TextList("exchange_sides", &exchange_sides,
                   "views in which left and right are exchanged");
  visitor.TextMap("mirror_px", &mirror_px,
                  "mirrored views: x1279 replaces x by 1279 - x, y719 "
                  "replaces y by 719 - y");
  visitor.Integer("first_frame", &first_frame,
                  Between(0.0, static_cast<double>(kMaxFrame)), "frames",
                  "number of the first frame, for files without frame numbers");
  visitor.Integer("max_per_view", &max_per_view, Between(1.0, 1e6),
                  "detections",
                  "maximum detections per view and frame; input with more is "
                  "rejected");
  visitor.Integer(
      "max_per_frame", &max_per_frame, Between(1.0, 1e6), "detections",
      "maximum detections per frame, all views together; input with more is "
      "rejected");
  visitor.Integer("max_joints", &max_joints, Between(1.0, 1e4), "joints",
                  "maximum joints of the detections' skeleton; input with more "
                  "is rejected");
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
                       "input.view_frame_rate and input.view_frame_offset "
                       "require reading the input several times, which is "
                       "impossible for a stream");
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

}  // namespace kinegraph
