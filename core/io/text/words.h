// Words and numbers of plain text. For core/io only.
#ifndef KINEGRAPH_CORE_IO_TEXT_WORDS_H_
#define KINEGRAPH_CORE_IO_TEXT_WORDS_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

// What separates words. kSpaceOrCommas: also commas and semicolons.
enum class WordBreak { kSpace, kSpaceOrCommas };

// Reads the words of a text one after the other. Its InputErrors do not name
// the file.
class Words {
 public:
  explicit Words(std::string_view text, WordBreak at = WordBreak::kSpace)
      : rest_(text), commas_(at == WordBreak::kSpaceOrCommas) {}

  // The next word; empty at the end.
  std::string_view Next();
  // Read the next word; throw InputError at the end of the text or if the word
  // is not the wanted one, a finite number, or a whole number from `low` to
  // `high`. `what` completes "ends before ..." and "expected ...".
  std::string_view Need(const char* what);
  void Expect(const char* wanted);
  double Number(const char* what);
  int64_t Integer(const char* what, int64_t low, int64_t high);
  [[noreturn]] static void Fail(std::string_view found,
                                const std::string& expected);

  // The line of the last word read.
  std::string Place() const { return "line " + std::to_string(line_); }

 private:
  bool IsBetween(char c) const {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' ||
           (commas_ && (c == ',' || c == ';'));
  }

  std::string_view rest_;
  const bool commas_;
  int64_t line_ = 1;
};

// Whether all of the first 64 words of a text (or all, if there are fewer) are
// numbers; false for a text without words.
bool IsNumberTable(std::string_view text);

// The numbers of a small file, separated by white space, commas or semicolons.
// Throws InputError if a number is not finite, or if there are not `count`
// numbers; `what` describes the expected numbers.
std::vector<double> ReadNumberTable(const std::string& path, size_t count,
                                    const std::string& what);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_WORDS_H_
