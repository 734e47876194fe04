#include "apps/common/table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>

namespace kinegraph {
namespace {

Table SampleTable() {
  Table table({"actor", "PCP"});
  table.AddRow({"first", "99.71"});
  table.AddRow({"2", "4.3"});
  return table;
}

TEST(Table, AlignsNamesLeftAndNumbersRight) {
  EXPECT_EQ(SampleTable().ToString(),
            "actor    PCP\n"
            "-----  -----\n"
            "first  99.71\n"
            "2        4.3\n");
}

TEST(Table, WritesMarkdown) {
  EXPECT_EQ(SampleTable().ToString(TableStyle::kMarkdown),
            "| actor |   PCP |\n"
            "|-------|------:|\n"
            "| first | 99.71 |\n"
            "| 2     |   4.3 |\n");
}

TEST(Table, EscapesBarsOnlyInMarkdown) {
  Table table({"a"});
  table.AddRow({"x|y|z"});
  EXPECT_EQ(table.ToString(TableStyle::kMarkdown),
            "| a       |\n"
            "|---------|\n"
            "| x\\|y\\|z |\n");
  EXPECT_EQ(table.ToString(),
            "a\n"
            "-----\n"
            "x|y|z\n");
}

TEST(Table, CountsCharactersNotBytes) {
  Table table({"a", "b"});
  table.AddRow({"\xc2\xb5m", "1"});  // a micro sign: two bytes
  table.AddRow({"mm", "2"});
  EXPECT_EQ(table.ToString(),
            "a   b\n"
            "--  -\n"
            "\xc2\xb5m  1\n"
            "mm  2\n");
}

TEST(Table, FillsShortRowsAndTrimsLineEnds) {
  Table table({"a", "b"});
  table.AddRow({"x"});
  EXPECT_EQ(table.ToString(),
            "a  b\n"
            "-  -\n"
            "x\n");
}

TEST(TableDeathTest, ARowWithTooManyCellsFailsACheck) {
  Table table({"a"});
  EXPECT_DEATH(table.AddRow({"x", "y"}), "Check failed");
}

TEST(Fixed, RoundsAndWritesNaNAsADash) {
  EXPECT_EQ(Fixed(97.237, 2), "97.24");
  EXPECT_EQ(Fixed(-0.5, 1), "-0.5");
  EXPECT_EQ(Fixed(std::nan(""), 2), "-");
  EXPECT_EQ(Fixed(std::numeric_limits<double>::infinity(), 2), "inf");
  EXPECT_EQ(Fixed(std::numeric_limits<double>::max(), 2).size(), 312u);
}

TEST(Fixed, HasNoNegativeZero) {
  EXPECT_EQ(Fixed(-0.004, 2), "0.00");
  EXPECT_EQ(Fixed(-0.0, 0), "0");
  EXPECT_EQ(Fixed(-0.006, 2), "-0.01");
  EXPECT_EQ(Fixed(-20.0, 0), "-20");
}

TEST(ForTerminal, AlignsTablesAndWrapsText) {
  EXPECT_EQ(ForTerminal("# Head\n\n| a | long |\n|---|---|\n| 1 | 2 |\n\n"
                        "one two three\n",
                        9, "f.md"),
            "# Head\n\n"
            "a  long\n"
            "-------\n"
            "1  2\n"
            "\none two\nthree\n");
}

TEST(ForTerminal, ShowsBarsWithinCells) {
  EXPECT_EQ(ForTerminal("| a | b |\n|---|---|\n| 1\\|2 | 3 |\n", 20, "f.md"),
            "a    b\n------\n1|2  3\n");
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
  EXPECT_NE(fewer.find("(1 more column: f.md)"), std::string::npos);
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
