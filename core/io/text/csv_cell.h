// Texts as cells of a CSV file.
#ifndef KINEGRAPH_CORE_IO_TEXT_CSV_CELL_H_
#define KINEGRAPH_CORE_IO_TEXT_CSV_CELL_H_

#include <string>

namespace kinegraph {

// A text as a cell: quoted where RFC 4180 asks for it. Spreadsheets run a cell
// that begins with = + - @ or a control character as a formula, whoever wrote
// the name that it holds; an apostrophe before it makes it a text. One more
// stands before a text that begins with an apostrophe, so that nothing is lost.
std::string CsvCell(const std::string& text);

// The text of such a cell, its quotation marks removed already.
std::string PlainCell(const std::string& cell);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_CSV_CELL_H_
