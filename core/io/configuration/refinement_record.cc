#include "core/io/configuration/refinement_record.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/files/text_file.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

int ParameterIndexOf(const JsonField& field) {
  const std::string name = field.Text();
  for (size_t i = 0; i < kCameraParameterNames.size(); ++i) {
    if (name == kCameraParameterNames[i]) return static_cast<int>(i);
  }
  field.FailExpected("the name of a parameter such as '" +
                     std::string(kCameraParameterNames[0]) + "'");
}

RefinementRecord::Camera CameraOf(const JsonField& field) {
  RefinementRecord::Camera camera;
  camera.name = field.At("name").Text();
  if (const auto clock = field.Find("clock")) {
    camera.offset_s = clock->At("offset_s").Number();
    camera.drift = clock->At("drift").Number();
  }
  if (const auto names = field.Find("parameters")) {
    for (const JsonField& one : names->Elements("parameter")) {
      const int index = ParameterIndexOf(one);
      if (!camera.places.empty() && index <= camera.places.back()) {
        one.FailExpected(
            "each parameter at most once, in the order of docs/formats.md");
      }
      camera.places.push_back(index);
    }
  }
  return camera;
}

Eigen::MatrixXd CovarianceOf(const JsonField& field, int size) {
  using RowMajor =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::vector<double> numbers = field.Matrix(size, size);
  const Eigen::MatrixXd matrix =
      Eigen::Map<const RowMajor>(numbers.data(), size, size);
  const bool is_covariance = (matrix.diagonal().array() >= 0.0).all() &&
                             matrix.isApprox(matrix.transpose(), 1e-9);
  if (!is_covariance)
    field.FailExpected("a covariance: symmetric, with variances >= 0");
  return matrix;
}

// The content of the file; an empty object if it cannot have a record.
Json JsonWithRecord(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return Json::object();
  const std::string text = ReadTextFile(path, kMaxSmallFileBytes);
  // Other formats, and cameras.json without a record, are not parsed.
  if (text.find("\"kinegraph_cameras\"") == std::string::npos ||
      text.find("\"refinement\"") == std::string::npos) {
    return Json::object();
  }
  return ParseJson(text, path);
}

}  // namespace

bool RefinementRecord::has_clocks() const {
  return std::any_of(cameras.begin(), cameras.end(), [](const Camera& c) {
    return c.offset_s != 0.0 || c.drift != 0.0;
  });
}

std::optional<RefinementRecord> ReadRefinementRecord(const std::string& path) {
  const Json json = JsonWithRecord(path);
  const auto root = JsonField(json, path).Find("refinement");
  if (!root.has_value()) return std::nullopt;
  RefinementRecord record;
  if (const auto zero = root->Find("clock_zero_s")) {
    record.clock_zero_s = zero->Number();
  }
  int count = 0;
  for (const JsonField& camera : root->At("cameras").Elements("camera")) {
    record.cameras.push_back(CameraOf(camera));
    count += static_cast<int>(record.cameras.back().places.size());
  }
  if (count > 0)
    record.covariance = CovarianceOf(root->At("covariance"), count);
  return record;
}

std::string RefinementText(const std::string& path) {
  if (!ReadRefinementRecord(path).has_value()) return "";
  return DumpJson(JsonWithRecord(path).at("refinement"));
}

}  // namespace kinegraph
