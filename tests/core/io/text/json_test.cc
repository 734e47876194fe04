#include "core/io/text/json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/core/io/input_error.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::IsEmpty;

std::string JsonError(const std::string& text) {
  return InputErrorOf([&] { ParseJson(text, "a.json"); });
}

TEST(ParseJson, KeepsTheOrderOfTheFile) {
  const Json json = ParseJson(R"({"b": 1, "a": 2, "c": 3})", "a.json");
  const JsonField root(json, "a.json");
  std::vector<std::string> keys;
  for (const auto& member : root.Members("key")) keys.push_back(member.key);
  EXPECT_THAT(keys, ElementsAre("b", "a", "c"));
}

TEST(ParseJson, RefusesAKeyRepeatedInOneObject) {
  EXPECT_EQ(JsonError(R"({"a": {"b": 1, "b": 2}})"),
            "a.json: key 'b': appears twice in one object");
  EXPECT_EQ(
      ParseJson(R"({"a": {"a": 1}, "b": [{"a": 1}, {"a": 2}]})", "").size(),
      2u);
}

TEST(ParseJson, RefusesTextAfterTheValue) {
  EXPECT_THAT(JsonError("{} {}"), HasSubstr("line 1, column 4"));
  EXPECT_THAT(JsonError("{}\n,"), HasSubstr("line 2"));
  EXPECT_THAT(JsonError("{} // comment"), HasSubstr("not JSON"));
}

TEST(ParseJson, LimitsDepth) {
  const auto nested = [](int depth) {
    const auto count = static_cast<size_t>(depth);
    return std::string(count, '[') + std::string(count, ']');
  };
  EXPECT_TRUE(ParseJson(nested(kMaxJsonDepth), "a.json").is_array());
  EXPECT_THAT(JsonError(nested(kMaxJsonDepth + 1)), HasSubstr("nested"));
}

TEST(ParseJson, LimitsValues) {
  std::string objects = "[{}";
  for (size_t i = 1; i < kMaxJsonValues - 1; ++i) objects += ",{}";
  EXPECT_EQ(ParseJson(objects + "]", "a.json").size(), kMaxJsonValues - 1);
  EXPECT_EQ(JsonError(objects + ",{},{}]"),
            "a.json: contains more than 1000000 values");
}

TEST(ParseJson, ErrorsNameNaNAndInfinityWithTheLine) {
  for (const std::string name : {"NaN", "Infinity"}) {
    EXPECT_EQ(JsonError("{\"K\": [1,\n" + name + "]}"),
              "a.json:2: is not JSON: found " + name + ", expected a number");
  }
  EXPECT_THAT(JsonError("[-Infinity]"), HasSubstr("found Infinity"));
  EXPECT_EQ(ParseJson(R"(["NaN"])", "a.json")[0], "NaN");
}

// Names come from file systems and from files in Latin-1. TOML requires U+007F
// to be escaped, which JSON permits.
TEST(DumpJson, AcceptsAnyBytes) {
  const std::string text = "a\xe9\x7f\"\n\xc3\xa9";
  EXPECT_EQ(JsonText(text), "\"a\xef\xbf\xbd\\u007f\\\"\\n\xc3\xa9\"");
  const Json json = ParseJson(DumpJson(Json{{text, text}}, 1), "a.json");
  EXPECT_EQ(json.begin().value(), "a\xef\xbf\xbd\x7f\"\n\xc3\xa9");
}

TEST(JsonField, ErrorsNameTheKeyPath) {
  const Json json = ParseJson(R"({"a": {"b": "text"}, "c": [1, [2]]})", "");
  const JsonField root(json, "a.json");
  EXPECT_EQ(InputErrorOf([&] { root.At("a").At("b").Number(); }),
            "a.json: a: b: found the text 'text', expected a number");
  EXPECT_EQ(InputErrorOf([&] { root.At("a").At("d"); }),
            "a.json: a: has no key 'd'");
  EXPECT_EQ(InputErrorOf([&] { root.At("c").Elements("row")[0].Text(); }),
            "a.json: row 0: found 1, expected a text");
  EXPECT_EQ(InputErrorOf([&] { root.At("c").Named("here").Boolean(); }),
            "a.json: here: found an array of 2, expected true or false");
  EXPECT_FALSE(root.Find("d").has_value());
}

TEST(JsonField, ReadsMatricesOfEveryShape) {
  const auto matrix = [](const std::string& text, int rows, int cols) {
    return JsonField(ParseJson(text, "a.json"), "a.json", "M")
        .Matrix(rows, cols);
  };
  for (const char* text : {"[1, 2, 3, 4, 5, 6]", "[[1, 2, 3], [4, 5, 6]]"}) {
    EXPECT_THAT(matrix(text, 2, 3), ElementsAre(1, 2, 3, 4, 5, 6));
  }
  for (const char* text : {"[[1], [2]]", "[[1, 2]]", "[1, 2]"}) {
    EXPECT_THAT(matrix(text, 2, 1), ElementsAre(1, 2));
  }
  for (const char* text :
       {"[]", "[[]]", "[1]", "[[1, 2], [3]]", "[[1, 2], 3]", "[1, [2]]",
        "[[1, 2, 3], [4, 5]]", "[[1, 4], [2, 5], [3, 6]]", "{}", "3", "null",
        "[[[1]], [[2]]]", "[1, 2, 3, 4, 5, true]"}) {
    ExpectInputError([&] { matrix(text, 2, 3); }, "a.json: M: ");
  }
}

TEST(JsonField, ReadsListsOfAnyLength) {
  const auto numbers = [](const std::string& text) {
    return JsonField(ParseJson(text, "a.json"), "a.json").Numbers();
  };
  EXPECT_THAT(numbers("[]"), IsEmpty());
  EXPECT_THAT(numbers("[[]]"), IsEmpty());
  EXPECT_THAT(numbers("[1, 2]"), ElementsAre(1, 2));
  EXPECT_THAT(numbers("[[1], [2]]"), ElementsAre(1, 2));
  EXPECT_THAT(numbers("[[1, 2, 3]]"), ElementsAre(1, 2, 3));
}

TEST(JsonField, IntegersAreExact) {
  const auto integer = [](const std::string& text) {
    return JsonField(ParseJson(text, "a.json"), "a.json").Integer();
  };
  EXPECT_EQ(integer("1032.0"), 1032);
  EXPECT_EQ(integer("-9007199254740992"), -9007199254740992);
  for (const char* text : {"1.5", "1e300", "18446744073709551615", "\"1\""}) {
    ExpectInputError([&] { integer(text); }, "expected a");
  }
}

}  // namespace
}  // namespace kinegraph
