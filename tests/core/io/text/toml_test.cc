#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/text/toml_file.h"
#include "tests/core/io/input_error.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::IsEmpty;

std::string Repeated(const std::string& part, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += part;
  return text;
}

// The error message; empty if the text is accepted.
std::string TomlError(const std::string& text) {
  try {
    ToJson(ParseToml(text, "a.toml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// Runs `work` with a stack of `bytes`.
void OnSmallStack(size_t bytes, std::function<void()> work) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, bytes), 0);
  pthread_t thread{};
  const auto run = [](void* given) -> void* {
    (*static_cast<std::function<void()>*>(given))();
    return nullptr;
  };
  ASSERT_EQ(pthread_create(&thread, &attributes, run, &work), 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
}

TEST(ParseToml, RefusesDepthHiddenByQuotes) {
  const std::string deep = "a" + Repeated(".a", 60000) + " = 1\n";
  for (const std::string before :
       {"", "x = \"\"\"\\\"\"\"a\"\"\"\n", "x = \"\"\"a\"\"\"\"\"\n",
        "x = '''a''''\n", "x = \"\\\\\"\n", "x = '\\'\n", "# \"\n",
        "x = \"\"\"\\\\\"\"\"\n", "x = \"\"\"\n\"\"\\\"\"\"\"\n", "x = \"\"\n",
        "x = ''''''\n", "x = {a = \"\"\"b\"\"\"\"}\n"}) {
    EXPECT_THAT(TomlError(before + deep), HasSubstr("nested deeper")) << before;
  }
  EXPECT_THAT(TomlError("[" + deep), HasSubstr("nested deeper"));
  EXPECT_THAT(TomlError("b = {" + deep + "}"), HasSubstr("nested deeper"));
  EXPECT_THAT(TomlError("b = " + Repeated("{a.a = ", 30)),
              HasSubstr("nested deeper"));
}

TEST(ParseToml, AcceptsLongTextsThatAreNotDeep) {
  const std::string dots = Repeated(".", 5000);
  EXPECT_THAT(TomlError("a = \"" + dots + "\" # " + dots + "\nb = '" + dots +
                        "'\nc = \"\"\"\n" + dots + "\"\"\"\n"),
              IsEmpty());
  EXPECT_THAT(TomlError("a = [" + Repeated("1.5, ", 5000) + "]\n"), IsEmpty());
  EXPECT_THAT(
      TomlError(Repeated("[[a.b]]\nc.d = [[1.5, 2.5], [3.5, 4.5]]\n", 5000)),
      IsEmpty());
}

TEST(ParseToml, LimitsValues) {
  EXPECT_THAT(TomlError("a = [" + Repeated("1,", 1000001) + "]"),
              HasSubstr("a.toml:1: contains more than 1000000 values"));
}

// The limits of depth (TomlGuard) are tested with the parser that they protect:
// accepted texts are parsed, traversed and destroyed within 64 KiB of stack;
// otherwise a signal ends this program.
TEST(ParseToml, AcceptedTextsNeedLittleStack) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need more stack";
#endif
  std::vector<std::string> pieces = {"\"\"\"",
                                     "'''",
                                     "\\\"",
                                     "\r\n",
                                     " = ",
                                     "[[",
                                     "]]",
                                     "1.5",
                                     "\\n",
                                     "a = ",
                                     "[a]\n",
                                     "\"a\\\"",
                                     "\\u0041",
                                     "\xc2\x85",
                                     Repeated("a.", 3000) + "a",
                                     Repeated("a.", 7) + "a = 1\n",
                                     Repeated("{a.a=", 400),
                                     Repeated("[", 30),
                                     Repeated("]", 30)};
  for (const char c : std::string("\"'\\#\n\t[]{},a.\x0b")) {
    pieces.emplace_back(1, c);
  }
  // 64 KiB, and 32 KiB for the thread and the test itself.
  constexpr size_t kStackBytes = (size_t{64} + 32) << 10;
  int accepted = 0;
  OnSmallStack(kStackBytes, [&] {
    std::minstd_rand random(1);
    for (int round = 0; round < 20000; ++round) {
      std::string text = random() % 2 == 0 ? "x = " : "";
      for (size_t n = random() % 24; n > 0; --n) {
        text += pieces[random() % pieces.size()];
      }
      accepted += TomlError(text).empty() ? 1 : 0;
    }
    // Nearly 32 levels, the limit, in the header; 32 in the key and in the
    // brackets.
    const std::string header = "[[" + Repeated("a.", 29) + "a]]\n";
    EXPECT_THAT(TomlError(header + Repeated("b.", 32) + "b = 1\n"), IsEmpty());
    EXPECT_THAT(TomlError(header + "c = " + Repeated("[", 32) +
                          Repeated("]", 32) + "\n"),
                IsEmpty());
  });
  EXPECT_GT(accepted, 100) << "too few to test the parser";
}

}  // namespace
}  // namespace kinegraph
