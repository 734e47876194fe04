#include "apps/common/table.h"

#include <glog/logging.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/io/text/csv_rows.h"

namespace kinegraph {
namespace {

using Row = std::vector<std::string>;

// Characters of UTF-8 text: every byte but the continuations 10xxxxxx.
size_t Width(const std::string& text) {
  return static_cast<size_t>(std::count_if(
      text.begin(), text.end(),
      [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::vector<size_t> ColumnWidths(const std::vector<Row>& rows) {
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], Width(row[i]));
    }
  }
  return widths;
}

std::string Aligned(const std::string& text, size_t width, bool to_left) {
  const std::string padding(width - Width(text), ' ');
  return to_left ? text + padding : padding + text;
}

std::string Line(const Row& row, const std::vector<size_t>& widths,
                 const std::string& before, const std::string& between,
                 const std::string& after) {
  std::string line = before;
  for (size_t i = 0; i < row.size(); ++i) {
    if (i > 0) line += between;
    line += Aligned(row[i], widths[i], i == 0);
  }
  line += after;
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

// "|---|---:|": a colon sets a column to the right.
std::string MarkdownRule(const std::vector<size_t>& widths) {
  std::string line = "|";
  for (size_t i = 0; i < widths.size(); ++i) {
    line += std::string(widths[i] + 1, '-') + (i == 0 ? "-|" : ":|");
  }
  return line + "\n";
}

std::vector<Row> EscapeForMarkdown(std::vector<Row> rows) {
  for (Row& row : rows) {
    for (std::string& cell : row) {
      for (size_t at = cell.find('|'); at != std::string::npos;
           at = cell.find('|', at + 2)) {
        cell.insert(at, "\\");
      }
    }
  }
  return rows;
}

std::string ToPlain(const std::vector<Row>& rows) {
  const std::vector<size_t> widths = ColumnWidths(rows);
  Row rule;
  for (const size_t width : widths) rule.emplace_back(width, '-');
  std::string text;
  for (size_t i = 0; i < rows.size(); ++i) {
    text += Line(rows[i], widths, "", "  ", "");
    if (i == 0) text += Line(rule, widths, "", "  ", "");
  }
  return text;
}

std::string ToMarkdown(const std::vector<Row>& rows) {
  const std::vector<size_t> widths = ColumnWidths(rows);
  std::string text;
  for (size_t i = 0; i < rows.size(); ++i) {
    text += Line(rows[i], widths, "| ", " | ", " |");
    if (i == 0) text += MarkdownRule(widths);
  }
  return text;
}

// A number, or the dash of Fixed: no spreadsheet takes it for a formula.
bool IsFigure(const std::string& cell) {
  double value = 0.0;
  const char* const end = cell.data() + cell.size();
  return cell == "-" || std::from_chars(cell.data(), end, value).ptr == end;
}

std::string ToCsv(const std::vector<Row>& rows) {
  std::string text;
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) {
      if (i > 0) text += ',';
      text += IsFigure(row[i]) ? row[i] : CsvCell(row[i]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace

Table::Table(std::vector<std::string> header) {
  CHECK(!header.empty());
  rows_.push_back(std::move(header));
}

void Table::AddRow(std::vector<std::string> cells) {
  CHECK_LE(cells.size(), rows_.front().size());
  cells.resize(rows_.front().size());
  rows_.push_back(std::move(cells));
}

std::string Table::ToString(TableStyle style) const {
  if (style == TableStyle::kMarkdown) {
    return ToMarkdown(EscapeForMarkdown(rows_));
  }
  if (style == TableStyle::kCsv) return ToCsv(rows_);
  return ToPlain(rows_);
}

std::string Fixed(double value, int decimals) {
  if (std::isnan(value)) return "-";
  char text[350];  // the largest double has 309 digits before the point
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  // No "-0.0".
  const bool zero = std::strspn(text, "-0.") == std::strlen(text);
  return zero && text[0] == '-' ? text + 1 : text;
}

}  // namespace kinegraph
