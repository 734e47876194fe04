#include "apps/common/table.h"

#include <glog/logging.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <utility>

#include "core/base/text.h"
#include "core/io/text/csv_rows.h"

namespace kinegraph {
namespace {

constexpr size_t kLeastFirstColumn = 24;  // in characters

// Whether a byte of UTF-8 text begins a character, i.e. is not a continuation
// 10xxxxxx.
bool BeginsLetter(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
}

size_t Letters(const std::string& text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), BeginsLetter));
}

std::vector<size_t> WidthsOf(const std::vector<Cells>& rows) {
  std::vector<size_t> widths;
  for (const Cells& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (size_t c = 0; c < row.size(); ++c) {
      widths[c] = std::max(widths[c], Letters(row[c]));
    }
  }
  return widths;
}

// One line without trailing blanks. `first_left`: the first column is
// left-aligned and all others right-aligned; otherwise all are left-aligned.
std::string Line(const Cells& row, const std::vector<size_t>& widths,
                 const std::string& before, const std::string& between,
                 const std::string& after, bool first_left = true) {
  std::string line = before;
  for (size_t c = 0; c < std::min(row.size(), widths.size()); ++c) {
    if (c > 0) line += between;
    const std::string padding(widths[c] - Letters(row[c]), ' ');
    line += first_left && c > 0 ? padding + row[c] : row[c] + padding;
  }
  line += after;
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string ToPlain(const std::vector<Cells>& rows) {
  const std::vector<size_t> widths = WidthsOf(rows);
  std::string text;
  for (const Cells& row : rows) {
    text += Line(row, widths, "", "  ", "");
    if (&row != &rows.front()) continue;
    const auto rule = [](size_t width) { return std::string(width, '-'); };
    text += Line(CellsOf(widths, rule), widths, "", "  ", "");
  }
  return text;
}

std::string ToMarkdown(std::vector<Cells> rows) {
  for (Cells& row : rows) {
    for (std::string& cell : row) {
      for (size_t at = cell.find('|'); at != std::string::npos;
           at = cell.find('|', at + 2)) {
        cell.insert(at, "\\");
      }
    }
  }
  const std::vector<size_t> widths = WidthsOf(rows);
  std::string text;
  for (const Cells& row : rows) {
    text += Line(row, widths, "| ", " | ", " |");
    if (&row != &rows.front()) continue;
    // "|---|---:|": a colon makes a column right-aligned.
    text += "|";
    for (const size_t& width : widths) {
      text += std::string(width + 1, '-') +
              (&width == &widths.front() ? "-|" : ":|");
    }
    text += "\n";
  }
  return text;
}

// A number, or the dash that Fixed returns for NaN: spreadsheets do not treat
// these as formulas.
bool IsFigure(const std::string& cell) {
  double value = 0.0;
  const char* const end = cell.data() + cell.size();
  return cell == "-" || std::from_chars(cell.data(), end, value).ptr == end;
}

std::string ToCsv(const std::vector<Cells>& rows) {
  std::string text;
  for (const Cells& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) {
      if (c > 0) text += ',';
      text += IsFigure(row[c]) ? row[c] : CsvCell(row[c]);
    }
    text += '\n';
  }
  return text;
}

// ---- Markdown for a terminal

// The cells of a line of ToMarkdown, in which "\\|" is a bar within a cell.
Cells CellsOfLine(const std::string& line) {
  Cells cells;
  std::string cell;
  for (size_t at = 1; at < line.size(); ++at) {
    if (line[at] != '|') {
      cell += line[at];
    } else if (line[at - 1] == '\\') {
      cell.back() = '|';
    } else {
      cells.push_back(Trimmed(cell));
      cell.clear();
    }
  }
  return cells;
}

bool IsRule(const Cells& cells) {
  return !cells.empty() &&
         std::all_of(cells.begin(), cells.end(), [](const std::string& cell) {
           return cell.find_first_not_of("-:") == std::string::npos;
         });
}

// "97.1 [95.9, 98.3]" -> "97.1"
std::string WithoutBrackets(std::string cell) {
  while (true) {
    const size_t begin = cell.find(" [");
    const size_t end = cell.find(']', begin);
    if (begin == std::string::npos || end == std::string::npos) return cell;
    cell.erase(begin, end + 1 - begin);
  }
}

// Width of a whole line, in characters.
size_t WidthOf(const std::vector<size_t>& widths) {
  size_t sum = 0;
  for (const size_t width : widths) sum += width + 2;
  return sum < 2 ? 0 : sum - 2;
}

std::string NarrowTable(std::vector<Cells> rows, size_t columns,
                        const std::string& where) {
  std::vector<size_t> widths = WidthsOf(rows);
  if (WidthOf(widths) > columns) {
    for (Cells& row : rows) row = CellsOf(row, WithoutBrackets);
    widths = WidthsOf(rows);
  }
  const size_t all = widths.size();
  while (WidthOf(widths) > columns) {
    const size_t excess = WidthOf(widths) - columns;
    if (widths[0] > kLeastFirstColumn) {
      widths[0] -= std::min(excess, widths[0] - kLeastFirstColumn);
    } else if (widths.size() > 1) {
      widths.pop_back();
    } else {
      break;
    }
  }
  std::string text;
  for (Cells& row : rows) {
    if (!row.empty()) row[0] = Cut(row[0], widths[0]);
    text += Line(row, widths, "", "  ", "", false);
    if (&row == &rows.front()) text += std::string(WidthOf(widths), '-') + "\n";
  }
  if (widths.size() < all) {
    text += "(" +
            Counted(static_cast<int64_t>(all - widths.size()), "more column",
                    "more columns") +
            ": " + where + ")\n";
  }
  return text;
}

}  // namespace

Table::Table(Cells header) {
  CHECK(!header.empty());
  rows_.push_back(std::move(header));
}

void Table::AddRow(Cells cells) {
  CHECK_LE(cells.size(), rows_.front().size());
  cells.resize(rows_.front().size());
  rows_.push_back(std::move(cells));
}

std::string Table::ToString(TableStyle style) const {
  if (style == TableStyle::kMarkdown) return ToMarkdown(rows_);
  if (style == TableStyle::kCsv) return ToCsv(rows_);
  return ToPlain(rows_);
}

std::string Fixed(double value, int decimals) {
  if (std::isnan(value)) return "-";
  char text[350];  // the largest double has 309 integer digits
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  // No "-0.0".
  const bool zero = std::strspn(text, "-0.") == std::strlen(text);
  return zero && text[0] == '-' ? text + 1 : text;
}

std::string IntervalCell(const Interval& interval, int decimals) {
  return "[" + Fixed(interval.low, decimals) + ", " +
         Fixed(interval.high, decimals) + "]";
}

std::string WithInterval(double value, const Interval& interval, int decimals) {
  return Fixed(value, decimals) + " " + IntervalCell(interval, decimals);
}

std::string Cut(const std::string& text, size_t letters) {
  if (Letters(text) <= letters) return text;
  std::string cut;
  size_t kept = 0;
  for (const char c : text) {
    if (BeginsLetter(c) && kept++ == letters - 1) break;
    cut += c;
  }
  return cut + "~";
}

std::string Wrapped(const std::string& text, size_t columns,
                    const std::string& indent) {
  std::istringstream words(text);
  std::string lines;
  std::string line;
  for (std::string word; words >> word;) {
    if (!line.empty() && Letters(line) + 1 + Letters(word) > columns) {
      lines += line + "\n";
      line = indent + word;
    } else {
      line += (line.empty() ? "" : " ") + word;
    }
  }
  return lines + line + "\n";
}

std::string ForTerminal(const std::string& markdown, size_t columns,
                        const std::string& where) {
  std::istringstream lines(markdown);
  std::string text;
  std::vector<Cells> table;
  const auto flush = [&] {
    if (!table.empty()) text += NarrowTable(std::move(table), columns, where);
    table.clear();
  };
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line[0] == '|') {
      Cells cells = CellsOfLine(line);
      if (!IsRule(cells)) table.push_back(std::move(cells));
      continue;
    }
    flush();
    text += Wrapped(line, columns);
  }
  flush();
  return text;
}

}  // namespace kinegraph
