// Tables of text: aligned columns for a terminal, Markdown, or CSV.
#ifndef KINEGRAPH_APPS_COMMON_TABLE_H_
#define KINEGRAPH_APPS_COMMON_TABLE_H_

#include <string>
#include <vector>

namespace kinegraph {

enum class TableStyle { kPlain, kMarkdown, kCsv };

// The first column is set to the left, all others (numbers) to the right.
class Table {
 public:
  explicit Table(std::vector<std::string> header);

  // Shorter rows are filled with empty cells; a longer one is a bug.
  void AddRow(std::vector<std::string> cells);
  // Lines end with '\n'.
  std::string ToString(TableStyle style = TableStyle::kPlain) const;

 private:
  std::vector<std::vector<std::string>> rows_;  // the header first
};

// `value` with `decimals` digits after the point; "-" for NaN.
std::string Fixed(double value, int decimals);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TABLE_H_
