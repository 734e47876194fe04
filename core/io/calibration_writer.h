// Writing calibrations in the formats of other programs.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_WRITER_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_WRITER_H_

#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/io/calibration.h"
#include "core/io/losses.h"

namespace kinegraph {

// The formats that can be written.
const std::vector<CalibrationFormat>& WritableCalibrationFormats();

// Writes a file, or a folder for TUM (P0.txt, ...) and EasyMocap (intri.yml,
// extri.yml), in the unit of the format: it appears when it is complete. What
// changes the geometry and cannot be said in the format (a lens in TUM's
// matrices, a skewed K in VoxelPose's) throws InputError naming the camera;
// what is merely left out is added to `losses`.
void WriteCalibration(const std::string& path, CalibrationFormat format,
                      const CameraRig& cameras, Losses* losses);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_WRITER_H_
