#include "apps/common/key_tables.h"

#include <sstream>
#include <stdexcept>

namespace kinegraph {
namespace {

// What takes differ in; the other keys are right for most of them.
constexpr const char* kEveryday[] = {
    "mode",          "output.estimator", "graph.lag_s",
    "graph.bones",   "graph.solver",     "tracking.second_pass",
    "identity.link", "cameras.refine",   "input.frame_rate",
};

// The row of a key with its line end; empty where there is none.
std::string TakeRow(const std::string& key, std::string* table) {
  const size_t begin = table->find("\n| `" + key + "` |");
  if (begin == std::string::npos) return {};
  const size_t end = table->find('\n', begin + 1);
  const std::string row = table->substr(begin + 1, end - begin);
  table->erase(begin + 1, end - begin);
  return row;
}

}  // namespace

std::string KeyTables(const std::string& reference) {
  std::istringstream lines(reference);
  std::string names;
  std::string rule;
  std::getline(lines, names);
  std::getline(lines, rule);
  std::string everyday = names + '\n' + rule + '\n';
  std::string expert = reference;
  for (const char* key : kEveryday) {
    const std::string row = TakeRow(key, &expert);
    if (row.empty()) throw std::logic_error("no key " + std::string(key));
    everyday += row;
  }
  return "## Everyday keys\n\n" + everyday + "\n## Expert keys\n\n" + expert;
}

}  // namespace kinegraph
