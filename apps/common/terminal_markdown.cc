#include "apps/common/terminal_markdown.h"

#include <algorithm>
#include <sstream>
#include <vector>

#include "core/base/text.h"

namespace kinegraph {
namespace {

using TextCells = std::vector<std::string>;

constexpr size_t kLeastFirstColumn = 24;  // letters

// Letters of UTF-8 text.
size_t Letters(const std::string& text) {
  return static_cast<size_t>(std::count_if(
      text.begin(), text.end(),
      [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string Padded(const std::string& text, size_t letters) {
  return text + std::string(letters - std::min(letters, Letters(text)), ' ');
}

TextCells CellsOf(const std::string& line) {
  TextCells cells;
  size_t begin = 1;
  for (size_t at = 1; at < line.size(); ++at) {
    if (line[at] != '|' || line[at - 1] == '\\') continue;
    cells.push_back(Trimmed(line.substr(begin, at - begin)));
    begin = at + 1;
  }
  return cells;
}

bool IsRule(const TextCells& cells) {
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

std::vector<size_t> WidthsOf(const std::vector<TextCells>& rows) {
  std::vector<size_t> widths;
  for (const TextCells& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (size_t c = 0; c < row.size(); ++c) {
      widths[c] = std::max(widths[c], Letters(row[c]));
    }
  }
  return widths;
}

size_t WidthOf(const std::vector<size_t>& widths) {
  size_t sum = 0;
  for (const size_t width : widths) sum += width + 2;
  return sum < 2 ? 0 : sum - 2;
}

std::string TableText(std::vector<TextCells> rows, size_t columns,
                      const std::string& where) {
  std::vector<size_t> widths = WidthsOf(rows);
  if (WidthOf(widths) > columns) {
    for (TextCells& row : rows) {
      for (std::string& cell : row) cell = WithoutBrackets(cell);
    }
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
  for (size_t r = 0; r < rows.size(); ++r) {
    std::string line;
    for (size_t c = 0; c < std::min(rows[r].size(), widths.size()); ++c) {
      line +=
          (c == 0 ? "" : "  ") + Padded(Cut(rows[r][c], widths[c]), widths[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
    if (r == 0) text += std::string(WidthOf(widths), '-') + "\n";
  }
  if (widths.size() < all) {
    text += "(" + std::to_string(all - widths.size()) +
            " more columns: " + where + ")\n";
  }
  return text;
}

}  // namespace

std::string Cut(const std::string& text, size_t letters) {
  if (Letters(text) <= letters) return text;
  std::string cut;
  size_t kept = 0;
  for (const char c : text) {
    const bool begins = (static_cast<unsigned char>(c) & 0xc0) != 0x80;
    if (begins && kept++ == letters - 1) break;
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
  std::vector<TextCells> table;
  const auto flush = [&] {
    if (!table.empty()) text += TableText(std::move(table), columns, where);
    table.clear();
  };
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line[0] == '|') {
      TextCells cells = CellsOf(line);
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
