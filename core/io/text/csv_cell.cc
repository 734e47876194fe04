#include "core/io/text/csv_cell.h"

namespace kinegraph {
namespace {

bool NeedsApostrophe(char first) {
  return first == '=' || first == '+' || first == '-' || first == '@' ||
         first == '\t' || first == '\r' || first == '\'';
}

}  // namespace

std::string CsvCell(const std::string& text) {
  const bool is_formula = !text.empty() && NeedsApostrophe(text.front());
  const std::string cell = (is_formula ? "'" : "") + text;
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string PlainCell(const std::string& cell) {
  const bool is_escaped =
      cell.size() > 1 && cell[0] == '\'' && NeedsApostrophe(cell[1]);
  return is_escaped ? cell.substr(1) : cell;
}

}  // namespace kinegraph
