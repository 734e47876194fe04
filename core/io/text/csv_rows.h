// Rows of CSV text.
#ifndef KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_
#define KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

// Splits a text into rows of cells (RFC 4180), without blank lines. The
// separator is the first comma, semicolon or tab outside quotation marks in the
// first line, which may be a spreadsheet's "sep=;"; without any, a comma. If it
// is not a comma, decimal commas, which spreadsheets write in many countries,
// are accepted in cells without quotation marks: 12,5 is read as 12.5.
class CsvRows {
 public:
  explicit CsvRows(std::string_view text);

  // Reads the next row; false at the end. Throws InputError, which does not
  // name the file, if the row is malformed or if `width` is given and is not
  // the number of cells.
  bool Next(std::vector<std::string>* cells, size_t width = 0);

  // The line at which the last row begins.
  std::string Place() const { return "line " + std::to_string(line_); }

 private:
  bool TakeIf(char c) {
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  std::string Cell();

  std::string_view rest_;
  char separator_;
  int64_t line_ = 0;
  int64_t next_line_ = 1;
};

// The cells of the first row; none if there is no row or it is malformed.
std::vector<std::string> FirstCsvRow(std::string_view text);

// The number in a cell, which may be infinite; nullopt for an empty cell and
// for NaN. Surrounding spaces are ignored. Throws InputError, which does not
// name the file, for other text.
std::optional<double> NumberOfCell(std::string_view cell);

// A text as a cell, quoted if RFC 4180 requires it. Spreadsheets execute a cell
// that begins with = + - @, a tab or a carriage return as a formula, which an
// apostrophe in front prevents. An apostrophe is also added to a text that
// begins with one, so that the conversion is reversible.
std::string CsvCell(const std::string& text);

// The text of a cell of CsvCell, whose quotation marks are already removed.
std::string PlainCell(const std::string& cell);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_
