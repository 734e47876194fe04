#include "core/io/text/csv_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/io/input_error.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::ExpectInputError;
using ::testing::HasSubstr;
using Rows = std::vector<std::vector<std::string>>;

Rows RowsOf(const std::string& text) {
  CsvRows rows(text);
  Rows all;
  for (std::vector<std::string> row; rows.Next(&row);) all.push_back(row);
  return all;
}

TEST(CsvRows, SeparatorsAreRecognised) {
  const Rows expected = {{"a", "b"}, {"1", "2"}};
  EXPECT_EQ(RowsOf("a,b\n1,2\n"), expected);
  EXPECT_EQ(RowsOf("a;b\r\n\r\n1;2"), expected);
  EXPECT_EQ(RowsOf("a\tb\n1\t2\n"), expected);
  EXPECT_EQ(RowsOf("sep=;\na;b\n1;2\n"), expected);
  // A separator within quotes is text.
  EXPECT_THAT(RowsOf("\"x,y\";b\n"), ElementsAre(ElementsAre("x,y", "b")));
}

TEST(CsvRows, DecimalCommasAreReadUnlessTheSeparatorIsAComma) {
  EXPECT_THAT(
      RowsOf("x;y\n-12,5e3;one,two\n"),
      ElementsAre(ElementsAre("x", "y"), ElementsAre("-12.5e3", "one,two")));
}

TEST(CsvRows, QuotedCellsMayHaveAnyText) {
  EXPECT_THAT(RowsOf("\"a \"\"b\"\"\nc\",2\n"),
              ElementsAre(ElementsAre("a \"b\"\nc", "2")));
  ExpectInputError([] { RowsOf("\"a\n"); }, "not closed");
  ExpectInputError([] { RowsOf("\"a\"b\n"); }, "closing");
}

TEST(CsvRows, PlacesAreLineNumbers) {
  CsvRows rows("a\n\n\"b\nc\"\nd\n");
  std::vector<std::string> row;
  for (const char* place : {"line 1", "line 3", "line 5"}) {
    ASSERT_TRUE(rows.Next(&row));
    EXPECT_EQ(rows.Place(), place);
  }
  EXPECT_FALSE(rows.Next(&row));
}

TEST(NumberOfCell, ReadsNumbersAndEmptyCellsButRejectsTexts) {
  EXPECT_EQ(NumberOfCell(" +1.5 "), 1.5);
  EXPECT_EQ(NumberOfCell("-2e3"), -2000.0);
  EXPECT_EQ(NumberOfCell("  "), std::nullopt);
  EXPECT_EQ(NumberOfCell("nan"), std::nullopt);
  ExpectInputError([] { NumberOfCell("1,5"); }, "decimal point");
  ExpectInputError([] { NumberOfCell("1 m"); }, "1 m");
}

TEST(CsvCell, ReadsBackAndIsEscapedAgainstFormulas) {
  for (const std::string text :
       {"plain", "a,b", "say \"x\"", "=1+1", "-x", "@x", "'quoted", "a\nb"}) {
    const Rows rows = RowsOf(CsvCell(text) + "\n");
    ASSERT_THAT(rows, ElementsAre(ElementsAre(::testing::_))) << text;
    EXPECT_EQ(PlainCell(rows[0][0]), text);
    EXPECT_THAT(std::string("=+-@"),
                ::testing::Not(HasSubstr(rows[0][0].substr(0, 1))));
  }
}

}  // namespace
}  // namespace kinegraph
