// Converts calibrations, detections and tracks between formats:
// kinegraph-convert.
#ifndef KINEGRAPH_CORE_IO_CONVERSION_H_
#define KINEGRAPH_CORE_IO_CONVERSION_H_

#include <string>

#include "core/io/text/lost_fields.h"

namespace kinegraph {

// The flags of `convert`; messages use their names.
struct ConversionOptions {
  std::string in;                // file or folder
  std::string out;               // file or folder
  std::string from = "auto";     // format; "auto": recognised by content
  std::string to;                // empty: tracks, by the extension of `out`
  std::string skeleton;          // if the input does not specify it
  double frame_rate_hz = 0.0;    // if the input does not specify it; 0: none
  std::string unit;              // of calibrations and tracks: m, cm or mm
  std::string image_size;        // "W,H" px, if the input lacks it
  std::string axes;              // "x,-z,y": world axes along X, Y, Z of files
  std::string markers = "ours";  // names of joints: ours, pose2sim or opensim
  std::string person;            // person to write, by number or name
  std::string set;               // how to read: "cameras.KEY=value;..."
};

struct Conversion {
  std::string what;        // what was written: "500 frames"
  LostFields lost_fields;  // what the format cannot store, and remarks
};

// Creates the parent folder of `out`. Throws InputError naming flag or file,
// OptionError for wrong values of keys that only reading reveals, and
// std::runtime_error if writing fails, for instance if the disk is full.
Conversion Convert(const ConversionOptions& options);

// One line per format: kind, name, supported operations, description.
std::string FormatList();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONVERSION_H_
