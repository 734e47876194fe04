#include "core/io/configuration/manifest.h"

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/text/toml_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

using KeyTexts = std::vector<std::pair<std::string, std::string*>>;

// The keys of a table and the members that store their texts.
KeyTexts TextsOf(ManifestRecording* recording) {
  return {{"name", &recording->name},
          {"cameras", &recording->cameras},
          {"detections", &recording->detections},
          {"ground_truth", &recording->ground_truth},
          {"protocol", &recording->protocol},
          {"frames", &recording->frames},
          {"set", &recording->set}};
}
KeyTexts TextsOf(ManifestConfiguration* one) {
  return {{"name", &one->name},
          {"config", &one->config},
          {"set", &one->set},
          {"mode", &one->mode}};
}

[[noreturn]] void FailKey(const std::string& path, const std::string& key,
                          const std::string& known) {
  throw InputError(path, "key '" + Printable(key) + "'",
                   "is not known, expected one of " + known);
}

// Reads the texts of one table. Unknown keys are rejected, the first `required`
// keys must be present, and the name must be valid as the name of a folder and
// not be in `names`, to which it is added.
void ReadTexts(const JsonField& table, const KeyTexts& texts, size_t required,
               std::set<std::string>* names) {
  std::string known;
  for (const auto& [key, text] : texts) {
    known += (known.empty() ? "" : ", ") + key;
  }
  for (const auto& [key, field] : table.Members("key")) {
    const std::string& wanted = key;
    const auto at =
        std::find_if(texts.begin(), texts.end(),
                     [&](const auto& text) { return text.first == wanted; });
    if (at == texts.end()) FailKey(table.file(), key, known);
    *at->second = field.Named(table.where() + ": " + key).Text();
  }
  for (size_t i = 0; i < required; ++i) {
    if (texts[i].second->empty()) {
      table.Fail("'" + texts[i].first + "' is missing");
    }
  }
  const std::string& name = *texts[0].second;
  CheckFileName(name, table.where());
  if (!names->insert(name).second) {
    table.Fail("the name '" + Printable(name) + "' is given twice");
  }
}

// Makes paths absolute that are relative to the manifest's folder.
void MakeAbsolute(const std::string& manifest,
                  std::initializer_list<std::string*> paths) {
  const fs::path folder = fs::absolute(manifest).parent_path();
  for (std::string* path : paths) {
    if (!path->empty()) *path = (folder / *path).lexically_normal().string();
  }
}

void ReadRecordings(const JsonField& tables, Manifest* manifest) {
  std::set<std::string> names;
  for (const JsonField& table : tables.Elements("take")) {
    ManifestRecording& recording = manifest->recordings.emplace_back();
    ReadTexts(table, TextsOf(&recording), 3, &names);
    if (recording.ground_truth.empty() != recording.protocol.empty()) {
      table.Fail("ground_truth and protocol must be given together");
    }
    MakeAbsolute(table.file(), {&recording.cameras, &recording.detections,
                                &recording.ground_truth});
  }
}

void ReadConfigurations(const JsonField& tables, const FindShipped& shipped,
                        Manifest* manifest) {
  std::set<std::string> names;
  for (const JsonField& table : tables.Elements("configuration")) {
    ManifestConfiguration& one = manifest->configurations.emplace_back();
    ReadTexts(table, TextsOf(&one), 2, &names);
    const std::string named = one.config;
    MakeAbsolute(table.file(), {&one.config});
    if (shipped == nullptr || IsFile(one.config)) continue;
    const std::string found = shipped(named);
    if (!found.empty()) one.config = found;
  }
}

// JSON's escapes are valid in TOML. Empty texts are omitted.
template <typename Table>
std::string TableText(const std::string& heading, Table table) {
  std::string text = "\n[[" + heading + "]]\n";
  for (const auto& [key, value] : TextsOf(&table)) {
    if (!value->empty()) text += key + " = " + JsonText(*value) + "\n";
  }
  return text;
}

}  // namespace

Manifest ReadManifest(const std::string& path, const FindShipped& shipped) {
  const Json root = ReadToml(path);
  Manifest manifest;
  for (const auto& [key, field] : JsonField(root, path).Members("key")) {
    if (key == "held_out") {
      manifest.held_out = field.Boolean();
    } else if (key == "compare") {
      manifest.compare = field.Boolean();
    } else if (key == "report") {
      manifest.report = field.Boolean();
    } else if (key == "takes") {
      ReadRecordings(field, &manifest);
    } else if (key == "configurations") {
      ReadConfigurations(field, shipped, &manifest);
    } else {
      FailKey(path, key, "held_out, compare, report, takes, configurations");
    }
  }
  if (manifest.recordings.empty()) {
    throw InputError(path, "", "has no [[takes]]");
  }
  return manifest;
}

std::string ManifestText(const Manifest& manifest) {
  const auto flag = [](const char* key, bool value) {
    return std::string(key) + " = " + (value ? "true" : "false") + "\n";
  };
  std::string text = flag("held_out", manifest.held_out) +
                     flag("compare", manifest.compare) +
                     flag("report", manifest.report);
  for (const ManifestRecording& recording : manifest.recordings) {
    text += TableText("takes", recording);
  }
  for (const ManifestConfiguration& one : manifest.configurations) {
    text += TableText("configurations", one);
  }
  return text;
}

}  // namespace kinegraph
