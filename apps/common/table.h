// Tables of text: aligned columns for a terminal, Markdown, or CSV; and
// Markdown itself for a terminal of so many columns. All count characters, not
// bytes.
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
// Cells one after another; a part is a text, or cells itself.
template <typename... Part>
Cells RowOf(const Part&... parts) {
  Cells cells;
  (AppendCells(parts, &cells), ...);
  return cells;
}
// A cell for each item of a list.
template <typename List, typename Text>
Cells CellsOf(const List& list, const Text& text) {
  Cells cells;
  for (const auto& item : list) cells.emplace_back(text(item));
  return cells;
}

enum class TableStyle { kPlain, kMarkdown, kCsv };

// The first column is set to the left, all others (numbers) to the right.
class Table {
 public:
  explicit Table(Cells header);

  // Shorter rows are filled with empty cells; a longer one is a bug.
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

// How wide what commands print is at the most.
inline constexpr size_t kTerminalColumns = 100;

// Paragraphs wrap at spaces. Tables are lined up; one that is too wide loses
// what its cells have in brackets, then letters of its first column, then
// columns from the right, and a line says that `where` has them.
std::string ForTerminal(const std::string& markdown, size_t columns,
                        const std::string& where);

// Lines of at most `columns`, broken where there is white space; all but the
// first begin with `indent`. A single word may be longer than a line.
std::string Wrapped(const std::string& text, size_t columns,
                    const std::string& indent = "");

// At most `letters`, the last one a "~" where something is missing.
std::string Cut(const std::string& text, size_t letters);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TABLE_H_
