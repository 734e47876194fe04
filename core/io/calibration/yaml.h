// What the YAML calibrations of OpenCV and EasyMocap share. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_YAML_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_YAML_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/io/calibration/write_formats.h"
#include "core/io/text/json.h"

namespace kinegraph {

// Ends in .yml or .yaml.
bool IsYamlName(const std::string& name);
// Those among others.
std::vector<std::string> YamlFilesAmong(const std::vector<std::string>& names);

Json ReadCalibrationYaml(const std::string& path);
// Writes "%YAML:1.0" and the content.
void WriteCalibrationYaml(const std::string& path, const std::string& content);

// A name: a text, or a number without quotes.
std::string YamlNameOf(const JsonField& field);

// A pose that is written in two ways must be one pose. Files are written with
// six decimals; further apart they are two different ones.
inline constexpr double kPoseRounding = 1e-3;

// Throws InputError naming a camera whose name cannot stand in a key of
// OpenCV's FileStorage, which EasyMocap reads with.
void CheckKeyName(const Camera& camera);

template <typename Matrix>
std::string OpencvMatrix(const std::string& key, const Matrix& matrix) {
  return key + ": !!opencv-matrix\n  rows: " + std::to_string(matrix.rows()) +
         "\n  cols: " + std::to_string(matrix.cols()) +
         "\n  dt: d\n  data: " + DecimalList(matrix) + "\n";
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_YAML_H_
