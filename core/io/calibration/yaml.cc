#include "core/io/calibration/yaml.h"

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/io/calibration/formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/yaml_file.h"

namespace kinegraph {

bool IsYamlName(const std::string& name) {
  const std::string extension =
      std::filesystem::path(name).extension().string();
  return extension == ".yml" || extension == ".yaml";
}

std::vector<std::string> YamlFilesAmong(const std::vector<std::string>& names) {
  std::vector<std::string> files;
  std::copy_if(names.begin(), names.end(), std::back_inserter(files),
               IsYamlName);
  return files;
}

Json ReadCalibrationYaml(const std::string& path) {
  // Four thousand cameras; the parser is slow.
  constexpr size_t kMaxBytes = size_t{4} << 20;
  return ParseYaml(ReadTextFile(path, kMaxBytes), path);
}

void WriteCalibrationYaml(const std::string& path, const std::string& content) {
  AtomicFile file(path);
  file.Write("%YAML:1.0\n---\n" + content);
  file.Commit();
}

std::string YamlNameOf(const JsonField& field) {
  if (field.value().is_number()) return std::to_string(field.Integer());
  return field.Text();
}

void CheckKeyName(const Camera& camera) {
  for (const char c : camera.name()) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                       (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
    if (!plain) {
      throw CannotWrite(camera,
                        "the name cannot stand in a key of OpenCV's YAML, "
                        "expected letters, digits, '_' and '-'");
    }
  }
}

}  // namespace kinegraph
