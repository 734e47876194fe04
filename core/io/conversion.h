// Converts calibrations, detections and tracks between formats:
// kinegraph-convert.
#ifndef KINEGRAPH_CORE_IO_CONVERSION_H_
#define KINEGRAPH_CORE_IO_CONVERSION_H_

#include <string>

#include "core/io/text/lost_fields.h"

namespace kinegraph {

// The command's flags, whose names are used in messages.
struct ConversionOptions {
  std::string in;             // file or folder
  std::string out;            // file or folder
  std::string from = "auto";  // format, by content
  std::string to;             // format; empty: by the extension of `out`
  std::string skeleton;       // this and unit, if the input has none
  double frame_rate_hz = 0.0;
  std::string unit;              // of calibrations and tracks: m, cm or mm
  std::string image_size;        // "W,H" px, if a calibration has none
  std::string axes;              // "x,-z,y": world axes of the file's X, Y, Z
  std::string markers = "ours";  // names of joints: ours, pose2sim or opensim
  std::string person;            // the one to write, by number or name
  std::string set;               // keys of reading, "cameras.KEY=value;..."
};

struct Conversion {
  std::string what;        // "500 frames"
  LostFields lost_fields;  // fields that the format cannot hold
};

// Creates the parent folder of `out`. Throws InputError naming flag or file.
Conversion Convert(const ConversionOptions& options);

// One line per format: kind, name, supported operations, description.
std::string FormatList();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONVERSION_H_
