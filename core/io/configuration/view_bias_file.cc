#include "core/io/configuration/view_bias_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

ViewCoefficients ReadCoefficients(const JsonField& field) {
  const std::vector<double> numbers = field.Numbers();
  ViewCoefficients coefficients;
  if (numbers.size() != coefficients.size()) {
    field.FailExpected(std::to_string(coefficients.size()) + " numbers");
  }
  std::copy(numbers.begin(), numbers.end(), coefficients.begin());
  return coefficients;
}

ViewBias::OfJoint ReadJoint(const JsonField& field) {
  ViewBias::OfJoint joint;
  joint.joint = field.At("joint").Text();
  joint.used = field.At("used").Boolean();
  joint.observations = field.At("observations").Integer();
  joint.gain = field.At("gain").Number();
  joint.gain_error = field.At("gain_error").Number();
  joint.across_m = ReadCoefficients(field.At("across_m"));
  joint.along_m = ReadCoefficients(field.At("along_m"));
  return joint;
}

}  // namespace

void WriteViewBias(const std::string& path, const ViewBias& bias,
                   const std::string& tracks) {
  Json json = {{"kinegraph_bias", 1}, {"azimuth_deg", bias.azimuth_deg}};
  json["joints"] = Json::array();
  for (const ViewBias::OfJoint& joint : bias.joints) {
    json["joints"].push_back({{"joint", joint.joint},
                              {"used", joint.used},
                              {"observations", joint.observations},
                              {"gain", joint.gain},
                              {"gain_error", joint.gain_error},
                              {"across_m", joint.across_m},
                              {"along_m", joint.along_m}});
  }
  WriteTextFile(path, WithFingerprint(DumpJson(json, 1) + "\n", tracks));
}

ViewBias ReadViewBias(const std::string& path) {
  const Json json = ParseJson(ReadTextFile(path, kMaxSmallFileBytes), path);
  const JsonField root(json, path);
  const JsonField version = root.At("kinegraph_bias");
  if (version.Integer() != 1) version.FailExpected("1");
  ViewBias bias;
  bias.azimuth_deg = root.At("azimuth_deg").Number();
  for (const JsonField& joint : root.At("joints").Elements("joint")) {
    bias.joints.push_back(ReadJoint(joint));
  }
  return bias;
}

}  // namespace kinegraph
