#include "core/io/detections/source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/data/box.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/rated_source.h"
#include "core/io/text/bulk_json.h"

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
  if (!(options.frame_rate_hz >= 0.0 && options.frame_rate_hz <= 1e6)) {
    throw OptionError("input.frame_rate", "expected above 0 .. 1e6 Hz");
  }
  if (options.first_frame < 0 || options.first_frame > kMaxFrame) {
    throw OptionError("detections.first_frame", "expected a frame number >= 0");
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
  const std::vector<std::string> names = FormatNames();
  throw InputError(
      path, "",
      fmt::format("is no known detection format, expected one of {} (`convert "
                  "--formats` says what they are)",
                  fmt::join(names.begin() + 1, names.end(), ", ")));
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
  if (format == nullptr) {
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

// ---- Checks of what is read ----

// Joints may leave the image by as much as its size, -1 .. 2 or -3 .. 3.
constexpr double kMostShare = 3.0;
// Shares of people spread over some of the image. What a detector writes for
// joints that it does not see, such as (-1, -1), does not.
constexpr double kLeastSpread = 0.1;
constexpr double kLargestImagePx = 65535.0;  // of JPEG; videos have fewer
// One detection in the corner of an image is no reason to refuse a recording.
constexpr int64_t kEnoughPeople = 10;

bool CanBeShares(const Eigen::AlignedBox2d& box) {
  return box.min().minCoeff() >= -kMostShare &&
         box.max().maxCoeff() <= kMostShare;
}

bool IsBeyondImages(const Eigen::AlignedBox2d& box) {
  return box.min().maxCoeff() > kLargestImagePx ||
         box.max().minCoeff() < -kLargestImagePx;
}

// Finds views whose positions are shares of the image, 0 .. 1 (MediaPipe,
// OpenPose with --keypoint_scale 3) or -1 .. 1 (4). Frames are handed in as
// they are read; one position that can only be pixels settles its view.
class PlausiblePixels {
 public:
  explicit PlausiblePixels(std::vector<std::string> view_names);

  // Throws InputError without a file, naming the view, once enough people show
  // that its positions are no pixels.
  void See(const DetectionFrame& frame);
  // The same for a recording that is too short for that.
  void SeeEnd() const;

 private:
  struct View {
    std::string name;
    bool has_pixels = false;
    int64_t shares = 0;       // people who can be shares of the image
    int64_t far = 0;          // people beyond any image
    Eigen::AlignedBox2d box;  // of all positions
  };

  static void Check(const View& view, int64_t enough_people);

  std::vector<View> views_;
};

PlausiblePixels::PlausiblePixels(std::vector<std::string> view_names)
    : views_(view_names.size()) {
  for (size_t v = 0; v < views_.size(); ++v) {
    views_[v].name = std::move(view_names[v]);
  }
}

void PlausiblePixels::See(const DetectionFrame& frame) {
  for (size_t v = 0; v < views_.size(); ++v) {
    View& view = views_[v];
    for (const Detection& detection : frame.views[v].detections) {
      if (view.has_pixels) break;
      const Eigen::AlignedBox2d box = BoxAround(detection.joints);
      if (box.isEmpty()) continue;
      const bool is_share = CanBeShares(box);
      const bool is_far = IsBeyondImages(box);
      view.shares += is_share ? 1 : 0;
      view.far += is_far ? 1 : 0;
      view.has_pixels = !is_share && !is_far;
      view.box.extend(box);
    }
    Check(view, kEnoughPeople);
  }
}

void PlausiblePixels::SeeEnd() const {
  const bool has_pixels =
      std::any_of(views_.begin(), views_.end(),
                  [](const View& view) { return view.has_pixels; });
  if (has_pixels) return;
  for (const View& view : views_) Check(view, 1);
}

void PlausiblePixels::Check(const View& view, int64_t enough_people) {
  if (view.has_pixels || view.box.isEmpty()) return;
  const std::string where = fmt::format(
      "view '{}': positions are within x {:.3g} .. {:.3g} and y {:.3g} .. "
      "{:.3g}",
      Printable(view.name), view.box.min().x(), view.box.max().x(),
      view.box.min().y(), view.box.max().y());
  if (view.shares == 0 && view.far >= kEnoughPeople) {
    throw InputError(where + ", where no image reaches, expected pixels");
  }
  if (view.far > 0 || view.shares < enough_people ||
      view.box.sizes().maxCoeff() < kLeastSpread) {
    return;
  }
  const bool is_signed = view.box.min().minCoeff() < -0.5;
  throw InputError(where + ", shares of the image, expected pixels: multiply " +
                   (is_signed ? "(x + 1) / 2" : "x") +
                   " by the image's width and " +
                   (is_signed ? "(y + 1) / 2" : "y") +
                   " by its height (OpenPose: detect without "
                   "--keypoint_scale)");
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

}  // namespace kinegraph
