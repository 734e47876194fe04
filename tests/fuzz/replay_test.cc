// Inputs that once failed, replayed, and a few seeded mutations of good ones,
// so that every build is tried a little. The hours are libFuzzer's
// (docs/robustness.md).
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "core/base/random.h"
#include "tests/fuzz/targets.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

void TryInput(const FuzzTarget& target, const std::string& input) {
  target.run(reinterpret_cast<const uint8_t*>(input.data()), input.size());
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const FuzzTarget& target : FuzzTargets()) names.push_back(target.name);
  return names;
}

class ReplayTest : public ::testing::TestWithParam<std::string> {
 protected:
  const FuzzTarget& Target() const { return FindFuzzTarget(GetParam()); }
};

// Each was chosen because it once took memory, time or the program.
TEST_P(ReplayTest, InputsThatOnceFailed) {
  const fs::path folder = ProjectFile("tests/fuzz/regressions") / GetParam();
  int count = 0;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path().filename().string());
      const auto start = std::chrono::steady_clock::now();
      TryInput(Target(), ContentOf(entry.path()));
      // They took from ten seconds to for ever; now milliseconds.
      EXPECT_LT(std::chrono::steady_clock::now() - start,
                std::chrono::seconds(5));
      ++count;
    }
  }
  RecordProperty("inputs", count);
}

std::string Mutated(std::string input, Random* random) {
  const int64_t changes = 1 + random->Index(4);
  for (int64_t c = 0; c < changes && !input.empty(); ++c) {
    const auto size = static_cast<int64_t>(input.size());
    const auto at = static_cast<size_t>(random->Index(size));
    switch (random->Index(4)) {
      case 0:
        input[at] = static_cast<char>(random->Index(256));
        break;
      case 1:
        input.erase(at, static_cast<size_t>(1 + random->Index(16)));
        break;
      case 2:
        input.insert(at, input.substr(static_cast<size_t>(random->Index(size)),
                                      static_cast<size_t>(random->Index(32))));
        break;
      default: {
        static constexpr const char* kWords[] = {
            ",",  "[", "{", "\"", "null", "-1", "1e400", "99999999999999999999",
            "\n", "0"};
        input.insert(at, kWords[random->Index(10)]);
      }
    }
  }
  return input;
}

TEST_P(ReplayTest, MutationsOfGoodInputs) {
  const std::string& name = GetParam();
  const int count = name == "scene" ? 3 : 150;
  Random random(1);
  for (const std::string& seed : FuzzSeeds(name)) {
    ASSERT_FALSE(seed.empty());
    TryInput(Target(), seed);
    for (int i = 0; i < count; ++i) {
      TryInput(Target(), Mutated(seed, &random));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Every, ReplayTest, ::testing::ValuesIn(Names()),
                         [](const ::testing::TestParamInfo<std::string>& test) {
                           return test.param;
                         });

}  // namespace
}  // namespace kinegraph::testing
