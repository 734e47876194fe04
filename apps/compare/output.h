// A comparison as files and for people.
#ifndef KINEGRAPH_APPS_COMPARE_OUTPUT_H_
#define KINEGRAPH_APPS_COMPARE_OUTPUT_H_

#include <string>

#include "apps/compare/results.h"
#include "core/io/text/json.h"

namespace kinegraph {

// Everything but run times, which differ each time.
Json CompareJson(const CompareResult& result);
// Tidy: one row a strategy and measure.
std::string CompareCsv(const CompareResult& result);
// One row a scored joint: its frame and each strategy's held-out error [px],
// empty without a prediction.
std::string ErrorsCsv(const CompareResult& result);
std::string CompareMarkdown(const CompareResult& result);

// Processor time of each strategy.
Json RuntimeJson(const CompareResult& result);
std::string RuntimeTable(const CompareResult& result);

// Who is better and worse than the baseline by held-out error, in sentences: a
// strategy is named only where the interval of the difference is clear of zero.
std::string RankingText(const CompareResult& result);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_OUTPUT_H_
