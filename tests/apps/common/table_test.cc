#include "apps/common/table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kinegraph {
namespace {

Table SampleTable() {
  Table table({"actor", "PCP"});
  table.AddRow({"first", "99.71"});
  table.AddRow({"2", "4.3"});
  return table;
}

TEST(Table, SetsNamesLeftAndNumbersRight) {
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

TEST(Table, EscapesBarsInMarkdownAlone) {
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

TEST(TableDeathTest, ALongRowIsABug) {
  Table table({"a"});
  EXPECT_DEATH(table.AddRow({"x", "y"}), "Check failed");
}

TEST(Fixed, RoundsAndKnowsNaN) {
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

}  // namespace
}  // namespace kinegraph
