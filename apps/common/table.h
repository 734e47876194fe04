// Tables as aligned columns for a terminal, Markdown or CSV; and the layout of
// Markdown for a terminal. Widths are in characters, not bytes.
#ifndef KINEGRAPH_APPS_COMMON_TABLE_H_
#define KINEGRAPH_APPS_COMMON_TABLE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/evaluation/statistics.h"

namespace kinegraph {

using Cells = std::vector<std::string>;

inline void AppendCells(const std::string& part, Cells* cells) {
  cells->push_back(part);
}
inline void AppendCells(const Cells& part, Cells* cells) {
  cells->insert(cells->end(), part.begin(), part.end());
}
// Concatenates cells; a part is a text, or cells itself.
template <typename... Part>
Cells RowOf(const Part&... parts) {
  Cells cells;
  (AppendCells(parts, &cells), ...);
  return cells;
}
// One cell per item of a list.
template <typename List, typename Text>
Cells CellsOf(const List& list, const Text& text) {
  Cells cells;
  for (const auto& item : list) cells.emplace_back(text(item));
  return cells;
}

enum class TableStyle { kPlain, kMarkdown, kCsv };

// The first column is left-aligned, all others (numbers) right-aligned.
class Table {
 public:
  explicit Table(Cells header);

  // Shorter rows are padded with empty cells; a longer one is a bug.
  void AddRow(Cells cells);
  // Lines end with '\n'.
  std::string ToString(TableStyle style = TableStyle::kPlain) const;

 private:
  std::vector<Cells> rows_;  // the header first
};

// `value` with `decimals` digits after the point; "-" for NaN.
std::string Fixed(double value, int decimals);
// "[1, 2]", and "1.5 [1, 2]".
std::string IntervalCell(const Interval& interval, int decimals);
std::string WithInterval(double value, const Interval& interval, int decimals);

// Maximum width of the output of commands.
inline constexpr size_t kTerminalColumns = 100;

// Wraps paragraphs at spaces and aligns tables; a table that is too wide loses
// the bracketed parts of its cells, then characters of its first column, then
// columns from the right, for which a line below the table refers to `where`.
std::string ForTerminal(const std::string& markdown, size_t columns,
                        const std::string& where);

// Lines of at most `columns`, broken at white space; all but the first begin
// with `indent`. A single word may exceed the width.
std::string Wrapped(const std::string& text, size_t columns,
                    const std::string& indent = "");

// At most `letters` characters, the last one a "~" if truncated.
std::string Cut(const std::string& text, size_t letters);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TABLE_H_
