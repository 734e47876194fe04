#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "apps/common/table.h"

namespace kinegraph {
namespace {

TEST(ForTerminal, LinesUpTablesAndWrapsText) {
  EXPECT_EQ(ForTerminal("# Head\n\n| a | long |\n|---|---|\n| 1 | 2 |\n\n"
                        "one two three\n",
                        9, "f.md"),
            "# Head\n\n"
            "a  long\n"
            "-------\n"
            "1  2\n"
            "\none two\nthree\n");
}

TEST(ForTerminal, WideTablesLoseBracketsThenLettersThenColumns) {
  const std::string row(40, 'x');
  const std::string markdown =
      "| name | PCP | more |\n|---|---|---|\n"
      "| " +
      row + " | 97.1 [95.9, 98.3] | 1234567890 |\n";
  // 40 + 2 + 4 + 2 + 10 letters without brackets.
  const std::string all = ForTerminal(markdown, 58, "f.md");
  EXPECT_EQ(all.find('['), std::string::npos);
  EXPECT_NE(all.find(row + "  97.1  1234567890"), std::string::npos);
  const std::string cut = ForTerminal(markdown, 50, "f.md");
  EXPECT_NE(cut.find(std::string(31, 'x') + "~  97.1  1234567890"),
            std::string::npos);
  const std::string fewer = ForTerminal(markdown, 36, "f.md");
  EXPECT_NE(fewer.find("(1 more columns: f.md)"), std::string::npos);
  for (const std::string& text : {all, cut, fewer}) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 58u) << line;
    }
  }
}

TEST(ForTerminal, CountsLettersNotBytes) {
  EXPECT_EQ(ForTerminal("| \xc3\xa4 | b |\n|---|---|\n| c | d |\n", 20, ""),
            "\xc3\xa4  b\n----\nc  d\n");
}

}  // namespace
}  // namespace kinegraph
