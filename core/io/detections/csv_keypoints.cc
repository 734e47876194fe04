#include "core/io/detections/csv_keypoints.h"

#include <limits>

#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"

namespace kinegraph {

Detection ReadKeypointRow(const std::vector<std::string>& cells,
                          const std::vector<KeypointColumns>& columns,
                          const std::vector<std::string>& labels,
                          ZeroConfidence zero_confidence) {
  Detection detection;
  detection.joints.reserve(columns.size());
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto at = [&](int column) {
      return Located(labels[j], [&] {
        return NumberOfCell(cells[static_cast<size_t>(column)])
            .value_or(std::numeric_limits<double>::quiet_NaN());
      });
    };
    const double confidence =
        columns[j].confidence < 0 ? 1.0 : at(columns[j].confidence);
    detection.joints.push_back(MakeKeypoint(at(columns[j].x), at(columns[j].y),
                                            confidence, zero_confidence));
  }
  return detection;
}

}  // namespace kinegraph
