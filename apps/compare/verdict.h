// What a comparison ends with: which strategy to use, how sure that is, what it
// costs, and the configuration that asks for it.
#ifndef KINEGRAPH_APPS_COMPARE_VERDICT_H_
#define KINEGRAPH_APPS_COMPARE_VERDICT_H_

#include <optional>
#include <string>

#include "apps/compare/results.h"

namespace kinegraph {

// The strategy with the least mean held-out error among those that ran;
// nullopt when nothing could be scored.
std::optional<size_t> BestStrategy(const CompareResult& result);

// recommended.toml: the configuration that the comparison was given, with the
// best strategy; keys at their defaults are left out. Empty without a best one.
std::string RecommendedToml(const CompareResult& result);

// The keys of `options` that differ from their defaults, a line each.
std::string ChangedKeysToml(const RunOptions& options);

// How wide what is printed is at the most.
inline constexpr size_t kDigestColumns = 100;

// For a terminal, at most 100 columns: a row a strategy, the verdict, and the
// files of `folder` that hold the rest.
std::string Digest(const CompareResult& result, const std::string& folder);

// The sentences of the verdict, for compare.md.
std::string VerdictText(const CompareResult& result);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_VERDICT_H_
