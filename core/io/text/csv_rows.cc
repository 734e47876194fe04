#include "core/io/text/csv_rows.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/text.h"

namespace kinegraph {
namespace {

constexpr std::string_view kSeparators = ",;\t";

// The first separator in the first line outside quoted text; ',' if there is
// none.
char SeparatorOf(std::string_view text) {
  bool quoted = false;
  for (const char c : text) {
    if (c == '\n' && !quoted) break;
    if (c == '"') quoted = !quoted;
    if (!quoted && kSeparators.find(c) != std::string_view::npos) return c;
  }
  return ',';
}

// "-12,5e3" becomes "-12.5e3"; anything else is unchanged.
void ReadDecimalComma(std::string* cell) {
  const size_t comma = cell->find(',');
  if (comma == std::string::npos ||
      cell->find_first_not_of("0123456789,+-eE ") != std::string::npos ||
      cell->find(',', comma + 1) != std::string::npos) {
    return;
  }
  (*cell)[comma] = '.';
}

bool NeedsApostrophe(char first) {
  return first == '=' || first == '+' || first == '-' || first == '@' ||
         first == '\t' || first == '\r' || first == '\'';
}

}  // namespace

CsvRows::CsvRows(std::string_view text)
    : rest_(text), separator_(SeparatorOf(text)) {
  constexpr std::string_view kNamed = "sep=";
  if (text.substr(0, kNamed.size()) == kNamed) {
    rest_.remove_prefix(std::min(text.find('\n'), text.size()));
  }
}

bool CsvRows::Next(std::vector<std::string>* cells, size_t width) {
  cells->clear();
  while (!rest_.empty() && (rest_.front() == '\n' || rest_.front() == '\r')) {
    next_line_ += rest_.front() == '\n' ? 1 : 0;
    rest_.remove_prefix(1);
  }
  if (rest_.empty()) return false;
  line_ = next_line_;
  do {
    cells->push_back(Cell());
  } while (TakeIf(separator_));
  TakeIf('\r');
  if (!rest_.empty() && !TakeIf('\n')) {
    throw InputError("text after a closing quotation mark");
  }
  ++next_line_;
  if (width > 0 && cells->size() != width) {
    throw InputError("found " + std::to_string(cells->size()) +
                     " cells, expected " + std::to_string(width));
  }
  return true;
}

std::string CsvRows::Cell() {
  if (!TakeIf('"')) {
    const char ends[] = {separator_, '\r', '\n'};
    const size_t end =
        std::min(rest_.find_first_of(std::string_view(ends, sizeof(ends))),
                 rest_.size());
    std::string cell(rest_.substr(0, end));
    rest_.remove_prefix(end);
    if (separator_ != ',') ReadDecimalComma(&cell);
    return cell;
  }
  std::string cell;
  while (!rest_.empty()) {
    const char c = rest_.front();
    rest_.remove_prefix(1);
    if (c == '"' && !TakeIf('"')) return cell;
    next_line_ += c == '\n' ? 1 : 0;
    cell += c;
  }
  throw InputError("a quotation mark is not closed");
}

std::vector<std::string> FirstCsvRow(std::string_view text) {
  std::vector<std::string> cells;
  try {
    CsvRows(text).Next(&cells);
  } catch (const InputError&) {
    cells.clear();
  }
  return cells;
}

std::optional<double> NumberOfCell(std::string_view cell) {
  std::string_view word = cell;
  while (!word.empty() && word.front() == ' ') word.remove_prefix(1);
  while (!word.empty() && word.back() == ' ') word.remove_suffix(1);
  if (word.empty()) return std::nullopt;
  const auto number = ParseNumber<double>(WithoutPlus(word));
  if (!number.has_value()) {
    const bool has_comma = cell.find(',') != std::string_view::npos;
    throw InputError("found the text '" + Printable(std::string(cell)) +
                     "', expected a number" +
                     (has_comma ? " with a decimal point" : ""));
  }
  if (std::isnan(*number)) return std::nullopt;
  return number;
}

std::string CsvCell(const std::string& text) {
  const bool is_formula = !text.empty() && NeedsApostrophe(text.front());
  std::string cell = (is_formula ? "'" : "") + text;
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
