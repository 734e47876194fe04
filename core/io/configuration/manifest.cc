#include "core/io/configuration/manifest.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/text/toml_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

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
  using Texts = std::vector<std::pair<std::string, std::string*>>;

  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(path_, "", message);
  }

  [[noreturn]] void FailKey(const std::string& key,
                            const std::string& known) const {
    throw InputError(path_, "key '" + Printable(key) + "'",
                     "is not known, expected one of " + known);
  }

  // The texts of one table; every key must be among them.
  void ReadTexts(const JsonField& table, const Texts& texts) const {
    std::string known;
    for (const auto& [key, text] : texts) {
      known += (known.empty() ? "" : ", ") + key;
    }
    for (const JsonField::Member& member : table.Members("key")) {
      bool is_known = false;
      for (const auto& [key, text] : texts) {
        if (key != member.key) continue;
        is_known = true;
        *text = member.field.Named(table.where() + ": " + member.key).Text();
      }
      if (!is_known) FailKey(member.key, known);
    }
  }

  // The first texts are required, and the name is that of a folder.
  void Require(const JsonField& table, const Texts& texts, size_t count,
               std::set<std::string>* names) const {
    for (size_t i = 0; i < count; ++i) {
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
      const Texts texts = {{"name", &recording.name},
                           {"cameras", &recording.cameras},
                           {"detections", &recording.detections},
                           {"ground_truth", &recording.ground_truth},
                           {"protocol", &recording.protocol},
                           {"frames", &recording.frames},
                           {"set", &recording.set}};
      ReadTexts(table, texts);
      Require(table, texts, 3, &names);
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
      const Texts texts = {{"name", &one.name},
                           {"config", &one.config},
                           {"set", &one.set},
                           {"mode", &one.mode}};
      ReadTexts(table, texts);
      Require(table, texts, 2, &names);
      Place(&one.config);
      manifest->configurations.push_back(std::move(one));
    }
  }

  const std::string path_;
  const JsonField root_;
};

// JSON's escapes are TOML's too.
void AppendText(const char* key, const std::string& value, std::string* text) {
  if (value.empty()) return;
  *text += std::string(key) + " = " + JsonText(value) + "\n";
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
    text += "\n[[takes]]\n";
    AppendText("name", recording.name, &text);
    AppendText("cameras", recording.cameras, &text);
    AppendText("detections", recording.detections, &text);
    AppendText("ground_truth", recording.ground_truth, &text);
    AppendText("protocol", recording.protocol, &text);
    AppendText("frames", recording.frames, &text);
    AppendText("set", recording.set, &text);
  }
  for (const ManifestConfiguration& one : manifest.configurations) {
    text += "\n[[configurations]]\n";
    AppendText("name", one.name, &text);
    AppendText("config", one.config, &text);
    AppendText("set", one.set, &text);
    AppendText("mode", one.mode, &text);
  }
  return text;
}

}  // namespace kinegraph
