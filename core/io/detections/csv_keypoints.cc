#include "core/io/detections/csv_keypoints.h"

#include <charconv>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

// NaN for a cell that says nothing.
double NumberOf(const std::string& cell, const std::string& label) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  if (cell.empty()) return kNothing;
  double number = 0.0;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, number);
  if (error != std::errc() || stop != end) {
    throw InputError(label + ": found the text '" + Printable(cell) +
                     "', expected a number");
  }
  return number;
}

}  // namespace

Detection ReadKeypointRow(const std::vector<std::string>& cells,
                          const std::vector<KeypointColumns>& columns,
                          const std::vector<std::string>& labels,
                          ZeroConfidence zero_confidence) {
  Detection detection;
  detection.joints.reserve(columns.size());
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto at = [&](int column) {
      return NumberOf(cells[static_cast<size_t>(column)], labels[j]);
    };
    const double confidence =
        columns[j].confidence < 0 ? 1.0 : at(columns[j].confidence);
    detection.joints.push_back(MakeKeypoint(at(columns[j].x), at(columns[j].y),
                                            confidence, zero_confidence));
  }
  return detection;
}

int64_t FrameOfCell(const std::string& cell) {
  const std::optional<int64_t> frame = FrameOfFileName(cell);
  if (frame && *frame <= kMaxFrame) return *frame;
  throw InputError("frame: found the text '" + Printable(cell) +
                   "', expected a frame number or a file name with one");
}

bool LooksNormalised(double low_px, double high_px) {
  // MediaPipe's landmarks may leave the image a little.
  return low_px > -2.0 && high_px < 3.0;
}

}  // namespace kinegraph
