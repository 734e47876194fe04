#include "apps/common/config_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/base/error.h"
#include "core/data/limits.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/system/process.h"
#include "solvers/session/options.h"

namespace kinegraph {
namespace {

// "/usr/bin" for "/usr/bin/kinegraph-track"; empty for "/usr".
std::string Parent(const std::string& path) {
  const size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

// Empty if not found.
std::string FindProjectConfig(const std::string& name) {
  std::string folder = Parent(ProgramPath());
  const std::string installed =
      Parent(folder) + "/share/kinegraph/configs/" + name;
  if (IsFile(installed)) return installed;
  // build/apps: the project's root is further up.
  for (; !folder.empty(); folder = Parent(folder)) {
    const std::string candidate = folder + "/configs/" + name;
    if (IsFile(candidate)) return candidate;
  }
  return "";
}

// The end of a message, "configurations of kinegraph: default.toml, ...": those
// for tracking and for synthetic scenes.
std::string ShippedConfigs() {
  const std::string root = Parent(FindProjectConfig("default.toml"));
  if (root.empty()) return "expected a configuration (TOML)";
  std::string names;
  for (const std::string folder : {"", "graph/", "paper/", "synthetic/"}) {
    for (const std::string& name : ListFolder(root + "/" + folder)) {
      if (!IsFile(root + "/" + folder + name)) continue;
      names += (names.empty() ? "" : ", ") + folder + name;
    }
  }
  return "configurations of kinegraph: " + names;
}

// Keys that often differ between recordings; the others rarely need changes.
constexpr const char* kEveryday[] = {
    "mode",
    "skeleton",
    "input.frame_rate",
    "detections.skeleton",
    "detections.zero_confidence",
    "cameras.unit",
    "cameras.image_size",
    "cameras.ignore_distortion",
    "cameras.use",
    "cameras.map",
    "cameras.refine",
    "cameras.refine_clock",
    "cameras.ground",
    "cameras.subject_m",
    "gates.units",
    "tracking.max_age_s",
    "tracking.max_gap_s",
    "tracking.backfill",
    "tracking.second_pass",
    "identity.link",
    "identity.people",
    "output.estimator",
    "output.observations",
    "graph.lag_s",
    "graph.bones",
    "graph.view_bias",
    "graph.solver",
};

// Moves the everyday keys to the front, in the order of kEveryday.
std::vector<ConfigKey> EverydayFirst(std::vector<ConfigKey> keys) {
  auto next = keys.begin();
  for (const char* name : kEveryday) {
    const auto at = std::find_if(next, keys.end(), [&](const ConfigKey& key) {
      return key.path() == name;
    });
    if (at == keys.end()) throw std::logic_error("no key " + std::string(name));
    std::rotate(next, at, at + 1);
    ++next;
  }
  return keys;
}

}  // namespace

std::string ProjectConfig(const std::string& name) {
  const std::string path = FindProjectConfig(name);
  if (!path.empty()) return path;
  throw InputError("configs/" + name, "",
                   "found neither beside the program nor in a folder above it");
}

std::string ShippedConfig(const std::string& name) {
  const std::string folder = "configs/";
  return FindProjectConfig(
      name.rfind(folder, 0) == 0 ? name.substr(folder.size()) : name);
}

std::string FindConfig(const std::string& path) {
  // If such a path is wrong, reading it reports the error.
  const bool unchecked = path.empty() || path.front() == '/';
  if (unchecked || IsFile(path) || IsFolder(path) || IsPipe(path)) return path;
  const std::string found = ShippedConfig(path);
  if (!found.empty()) return found;
  if (path == "configs/graph/offline.toml" || path == "graph/offline.toml") {
    throw InputError(path, "",
                     "was removed; use configs/offline.toml, if necessary with "
                     "--set='skeleton=NAME;input.frame_rate=HZ'");
  }
  throw InputError(path, "", "is not there; " + ShippedConfigs());
}

RunOptions OptionsOfFlags(const std::string& config, const std::string& set,
                          const std::string& mode) {
  return ReadRunOptions(
      config.empty() ? ProjectConfig("default.toml") : FindConfig(config), set,
      mode);
}

RunOptions DefaultOptions(double frame_rate_hz, const std::string& skeleton,
                          std::string set) {
  if (!(frame_rate_hz >= 0.0 && frame_rate_hz <= kMaxFrameRate_hz)) {
    throw InputError(
        "--frame_rate: expected a rate in Hz above 0 and at most 1e6");
  }
  if (frame_rate_hz > 0.0) {
    set = JoinSets(set, fmt::format("input.frame_rate={:.17g}", frame_rate_hz));
  }
  if (!skeleton.empty()) set = JoinSets(set, "detections.skeleton=" + skeleton);
  return OptionsOfFlags("", set, "");
}

std::string JoinSets(const std::string& first, const std::string& second) {
  return first.empty() || second.empty() ? first + second
                                         : first + ";" + second;
}

std::string DriverName() {
  const std::string name = "kinegraph";
  return IsFile(Parent(ProgramPath()) + "/" + name) ? name : "./" + name;
}

std::string KeyTables(const std::vector<ConfigKey>& keys) {
  const std::vector<ConfigKey> sorted = EverydayFirst(keys);
  const auto expert = sorted.begin() + std::size(kEveryday);
  return "## Everyday keys\n\n" + KeyTable({sorted.begin(), expert}) +
         "\n## Expert keys\n\n" + KeyTable({expert, sorted.end()});
}

std::string CommentedConfig(const std::vector<ConfigKey>& given,
                            const std::vector<ConfigKey>& usual) {
  const std::vector<ConfigKey> keys = EverydayFirst(given);
  const std::vector<ConfigKey> defaults = EverydayFirst(usual);
  std::vector<ConfigKey> shown;
  for (size_t i = 0; i < keys.size(); ++i) {
    const bool is_default = keys[i].value == defaults.at(i).value;
    if (is_default && i >= std::size(kEveryday)) continue;
    shown.push_back(keys[i]);
    if (is_default) shown.back().name = "#" + keys[i].name;
    std::string& help = shown.back().help;
    help[0] = static_cast<char>(std::toupper(help[0]));
  }
  // Each table has one header.
  std::vector<std::string> tables;
  for (const ConfigKey& key : shown) {
    if (std::find(tables.begin(), tables.end(), key.table) == tables.end()) {
      tables.push_back(key.table);
    }
  }
  std::string text;
  for (const std::string& table : tables) {
    if (!table.empty()) text += "\n[" + table + "]\n";
    for (const ConfigKey& key : shown) {
      if (key.table != table) continue;
      text += fmt::format("# {}{}. Allowed: {}.\n{} = {}\n", key.help,
                          key.unit.empty() ? "" : " [" + key.unit + "]",
                          key.allowed, key.name, key.value);
    }
  }
  return text;
}

std::string SkeletonTables(const std::vector<Skeleton>& skeletons) {
  std::string text;
  for (const Skeleton& skeleton : skeletons) {
    Json bones = Json::array();
    for (const Bone& bone : skeleton.bones()) {
      bones.push_back({skeleton.joints()[static_cast<size_t>(bone.a)],
                       skeleton.joints()[static_cast<size_t>(bone.b)]});
    }
    text += fmt::format("\n[skeletons.{}]\njoints = {}\nbones = {}\n",
                        JsonText(skeleton.name()),
                        DumpJson(Json(skeleton.joints())), DumpJson(bones));
  }
  return text;
}

}  // namespace kinegraph
