#include "core/io/configuration/manifest.h"

#include <algorithm>
#include <filesystem>
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

// The keys of a table and where their texts stand.
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

class ManifestReader {
 public:
  ManifestReader(const std::string& path, const Json& root)
      : path_(path), root_(root, path) {}

  Manifest Read() {
    Manifest manifest;
    for (const JsonField::Member& member : root_.Members("key")) {
      const std::string& key = member.key;
      if (key == "held_out") {
        manifest.held_out = member.field.Boolean();
      } else if (key == "compare") {
        manifest.compare = member.field.Boolean();
      } else if (key == "report") {
        manifest.report = member.field.Boolean();
      } else if (key == "takes") {
        ReadRecordings(member.field, &manifest);
      } else if (key == "configurations") {
        ReadConfigurations(member.field, &manifest);
      } else {
        FailKey(key, "held_out, compare, report, takes, configurations");
      }
    }
    if (manifest.recordings.empty()) Fail("[[takes]]: there is none");
    if (manifest.configurations.empty()) {
      Fail("[[configurations]]: there is none");
    }
    return manifest;
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(path_, "", message);
  }

  [[noreturn]] void FailKey(const std::string& key,
                            const std::string& known) const {
    throw InputError(path_, "key '" + Printable(key) + "'",
                     "is not known, expected one of " + known);
  }

  // The texts of one table; every key must be among them. The first `required`
  // must be there, and the name is that of a folder.
  void ReadTexts(const JsonField& table, const KeyTexts& texts, size_t required,
                 std::set<std::string>* names) const {
    std::string known;
    for (const auto& [key, text] : texts) {
      known += (known.empty() ? "" : ", ") + key;
    }
    for (const JsonField::Member& member : table.Members("key")) {
      const auto at = std::find_if(
          texts.begin(), texts.end(),
          [&](const auto& text) { return text.first == member.key; });
      if (at == texts.end()) FailKey(member.key, known);
      *at->second =
          member.field.Named(table.where() + ": " + member.key).Text();
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

  // A path as the manifest names it: absolute, or from its own folder.
  void Place(std::string* path) const {
    if (path->empty()) return;
    const fs::path folder = fs::absolute(path_).parent_path();
    *path = (folder / *path).lexically_normal().string();
  }

  void ReadRecordings(const JsonField& recordings, Manifest* manifest) const {
    std::set<std::string> names;
    for (const JsonField& table : recordings.Elements("take")) {
      ManifestRecording recording;
      ReadTexts(table, TextsOf(&recording), 3, &names);
      if (recording.ground_truth.empty() != recording.protocol.empty()) {
        table.Fail("ground_truth and protocol belong together");
      }
      Place(&recording.cameras);
      Place(&recording.detections);
      Place(&recording.ground_truth);
      manifest->recordings.push_back(std::move(recording));
    }
  }

  void ReadConfigurations(const JsonField& tables, Manifest* manifest) const {
    std::set<std::string> names;
    for (const JsonField& table : tables.Elements("configuration")) {
      ManifestConfiguration one;
      ReadTexts(table, TextsOf(&one), 2, &names);
      Place(&one.config);
      manifest->configurations.push_back(std::move(one));
    }
  }

  const std::string path_;
  const JsonField root_;
};

// JSON's escapes are TOML's too. Texts that are not given are left out.
template <typename Table>
std::string TableText(const std::string& heading, Table table) {
  std::string text = "\n[[" + heading + "]]\n";
  for (const auto& [key, value] : TextsOf(&table)) {
    if (!value->empty()) text += key + " = " + JsonText(*value) + "\n";
  }
  return text;
}

}  // namespace

Manifest ReadManifest(const std::string& path) {
  const Json root =
      ToJson(ParseToml(ReadTextFile(path, kMaxSmallFileBytes), path));
  return ManifestReader(path, root).Read();
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
