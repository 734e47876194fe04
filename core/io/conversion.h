// Calibrations, detections and tracks between formats: what kinegraph-convert
// does.
#ifndef KINEGRAPH_CORE_IO_CONVERSION_H_
#define KINEGRAPH_CORE_IO_CONVERSION_H_

#include <string>

#include "core/io/text/lost_fields.h"

namespace kinegraph {

// As the command's flags, by whose names messages call them.
struct ConversionOptions {
  std::string in;             // file or folder
  std::string out;            // likewise
  std::string from = "auto";  // format, by content
  std::string to;             // format; empty: by the end of `out`
  std::string skeleton;       // these two where the input does not tell
  double frame_rate_hz = 0.0;
  std::string unit;              // of calibrations and tracks: m, cm or mm
  std::string image_size;        // "W,H" px, where a calibration does not tell
  std::string axes;              // "x,-z,y": world axes of the file's X, Y, Z
  std::string markers = "ours";  // names of joints: ours, pose2sim or opensim
  std::string person;            // the one to write, by number or name
  std::string set;               // keys of reading, "cameras.KEY=value;..."
};

struct Conversion {
  std::string what;        // "500 frames"
  LostFields lost_fields;  // what the format leaves out
};

// Makes the folder that `out` lies in. Throws InputError naming flag or file.
Conversion Convert(const ConversionOptions& options);

// One line a format: kind, name, what can be done with it, what it is.
std::string FormatList();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONVERSION_H_
