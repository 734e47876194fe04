#include "apps/common/key_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <stdexcept>

namespace kinegraph {
namespace {

// What recordings differ in; the other keys are right for most of them.
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

// The keys of every day in their order, before the others.
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
  // A table is opened once.
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

}  // namespace kinegraph
