// Reading and writing calibrations. A Camera uses pixels, metres and
// cam_from_world, whatever the conventions of its file.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_CALIBRATION_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_CALIBRATION_H_

#include <map>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// "auto" and the names of the formats (format.h).
std::vector<std::string> CalibrationFormatNames();

enum class LengthUnit {
  kAuto,  // the file's or the format's own
  kMetre,
  kCentimetre,
  kMillimetre,
};

// Options of reading cameras: the keys of the table "cameras". Describe neither
// enters nor leaves the table; its caller does (OptionVisitor).
struct CameraReadOptions {
  std::string format = "auto";  // or a name of CalibrationFormatNames()
  // Unit of lengths in the file. kAuto: the one that the file or its format
  // specifies (CalibrationFile), otherwise the format's usual one: mm for
  // VoxelPose, OpenCap and bioCV, and for pose2sim (TOML) if the stated side of
  // the calibration board's squares is above 1 (users give it in mm or leave it
  // at 1); cm for longcw and Panoptic; m for others.
  LengthUnit unit = LengthUnit::kAuto;
  std::vector<double> image_size;  // px: width, height; empty: the file's
  bool ignore_distortion = false;
  std::vector<std::string> use;            // names; empty: all
  std::map<std::string, std::string> map;  // view -> camera

  void Describe(OptionVisitor& visitor);
};

// The cameras of a file (or of a folder, for formats of several files) in the
// order of the file or of `options.use`. Throws InputError naming file and
// camera or key, OptionError for a wrong image_size, an unknown format or a
// camera that `options.use` lists twice.
CameraRig ReadCameras(const std::string& path,
                      const CameraReadOptions& options = {});

// The unit in which ReadCameras reads the lengths of a file.
struct CalibrationUnit {
  double per_metre = 1.0;  // 1, 100 or 1000
  // Whether cameras.unit can name another unit: neither the file nor its format
  // specifies one.
  bool can_be_changed = true;
};
CalibrationUnit UnitOfCalibration(const std::string& path,
                                  const CameraReadOptions& options = {});

// Writes kinegraph's own format, from which the same bits are read back.
// `refinement`: a JSON text stored beside the cameras, which readers ignore;
// empty: none.
void WriteCameras(const std::string& path, const CameraRig& cameras,
                  const std::string& refinement = "");

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_CALIBRATION_H_
