#include "core/io/detections/plausible_pixels.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/data/box.h"

namespace kinegraph {
namespace {

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

}  // namespace

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

}  // namespace kinegraph
