// Tables with a column a coordinate: what CSV files of key points share. For
// core/io alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_CSV_KEYPOINTS_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_CSV_KEYPOINTS_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/io/detections/formats.h"

namespace kinegraph {

// Where a joint of a person stands in a row; -1: there is no such column.
struct KeypointColumns {
  int x = -1;
  int y = -1;
  int confidence = -1;  // without it every joint that is there has 1
};

// One person of a row, a joint each; an empty cell or "nan" is no measurement.
// Throws InputError without a file, naming the column by `labels`.
Detection ReadKeypointRow(const std::vector<std::string>& cells,
                          const std::vector<KeypointColumns>& columns,
                          const std::vector<std::string>& labels,
                          ZeroConfidence zero_confidence);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_CSV_KEYPOINTS_H_
