// Rows of CSV text. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_
#define KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

// Cells of one row after the other (RFC 4180), blank lines left out. What
// separates cells is the first comma, semicolon or tabulator of the first line,
// or what a spreadsheet's line "sep=;" names. Where it is no comma,
// spreadsheets of many countries write decimal commas: a cell such as 12,5
// reads 12.5.
class CsvRows {
 public:
  explicit CsvRows(std::string_view text);

  // The cells are valid until the next call; false at the end. Throws
  // InputError without a file, also where they are not `width`, if that is
  // given.
  bool Next(std::vector<std::string>* cells, size_t width = 0);

  std::string Place() const { return "line " + std::to_string(line_); }

 private:
  bool TakeIf(char c) {
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  std::string Cell();

  std::string_view rest_;
  char separator_ = ',';
  int64_t line_ = 0;
  int64_t next_line_ = 1;
};

// The cells of the first row; none of a text that has no rows.
std::vector<std::string> FirstCsvRow(std::string_view text);

// The number in a cell of a table; nullopt for an empty one and for NaN. Spaces
// around it do not count. Throws InputError without a file for a text.
std::optional<double> NumberOfCell(std::string_view cell);

// A text as a cell: quoted where RFC 4180 asks for it. Spreadsheets run a cell
// that begins with = + - @ or a control character as a formula, whoever wrote
// the name that it holds; an apostrophe before it makes it a text. One more
// stands before a text that begins with an apostrophe, so that nothing is lost.
std::string CsvCell(const std::string& text);

// The text of such a cell, its quotation marks removed already.
std::string PlainCell(const std::string& cell);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_
