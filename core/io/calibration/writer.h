// Writing calibrations in the formats of other programs.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_WRITER_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_WRITER_H_

#include <string>

#include "core/geometry/camera.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

// Writes a file or a folder in a format of CalibrationFormats()
// (calibration_format.h), in its unit: it appears when it is complete. What
// changes the geometry and cannot be said in the format throws InputError
// naming the camera; what is merely left out is added to `losses`.
void WriteCalibration(const std::string& path, const std::string& format,
                      const CameraRig& cameras, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_WRITER_H_
