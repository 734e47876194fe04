// Rows of CSV text. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_
#define KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {

// Cells of one row after the other (RFC 4180).
class CsvRows {
 public:
  explicit CsvRows(std::string_view text) : rest_(text) {}

  // The cells are valid until the next call; false at the end.
  bool Next(std::vector<std::string>* cells) {
    cells->clear();
    if (rest_.empty()) return false;
    line_ = next_line_;
    do {
      cells->push_back(Cell());
    } while (TakeIf(','));
    TakeIf('\r');
    if (!rest_.empty() && !TakeIf('\n')) {
      throw InputError("text after a closing quotation mark");
    }
    ++next_line_;
    return true;
  }

  std::string Place() const { return "line " + std::to_string(line_); }

 private:
  bool TakeIf(char c) {
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }

  std::string Cell() {
    if (!TakeIf('"')) {
      const size_t end = std::min(rest_.find_first_of(",\r\n"), rest_.size());
      const std::string cell(rest_.substr(0, end));
      rest_.remove_prefix(end);
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

  std::string_view rest_;
  int64_t line_ = 0;
  int64_t next_line_ = 1;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_CSV_ROWS_H_
