// Flags of the research programs.
#ifndef KINEGRAPH_RESEARCH_ARGUMENTS_H_
#define KINEGRAPH_RESEARCH_ARGUMENTS_H_

#include <algorithm>
#include <string>
#include <vector>

namespace kinegraph::testing {

// Removes the argument that begins with `flag` ("--json=") and returns the rest
// of it; empty if there is none.
inline std::string ExtractFlag(const std::string& flag,
                               std::vector<std::string>* arguments) {
  const auto at = std::find_if(
      arguments->begin(), arguments->end(),
      [&](const std::string& text) { return text.rfind(flag, 0) == 0; });
  if (at == arguments->end()) return "";
  std::string value = at->substr(flag.size());
  arguments->erase(at);
  return value;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_RESEARCH_ARGUMENTS_H_
