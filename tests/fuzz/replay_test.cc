// Replays inputs that once failed, and a few seeded mutations of valid inputs,
// so that every build gets a short fuzz test. Long runs use libFuzzer
// (CONTRIBUTING.md).
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "core/base/random.h"
#include "tests/fuzz/targets.h"
#include "tests/support/processor_time.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const FuzzTarget &target : FuzzTargets()) names.push_back(target.name);
  return names;
}

class ReplayTest : public ::testing::TestWithParam<std::string> {
 protected:
  const FuzzTarget &Target() const { return FindFuzzTarget(GetParam()); }
};

// Each input once exhausted memory or time, or crashed the program.
TEST_P(ReplayTest, RegressionInputsEndQuickly) {
  const fs::path folder = ProjectFile("tests/fuzz/regressions") / GetParam();
  int count = 0;
  if (fs::is_directory(folder)) {
    for (const auto &entry : fs::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path().filename().string());
      const ProcessorTime used;
      Target().run(ContentOf(entry.path()));
      // Some once took ten seconds or never ended; now each takes milliseconds.
      EXPECT_LT(used.Seconds(), 5.0);
      ++count;
    }
  }
  RecordProperty("inputs", count);
}

// Mutations of seeds that are rejected anyway would test little.
TEST_P(ReplayTest, EveryGoodInputIsRead) {
  const std::vector<std::string> seeds = FuzzSeeds(GetParam());
  EXPECT_FALSE(seeds.empty());
  std::string refused;  // beginnings of the rejected seeds
  size_t read = 0;
  for (const std::string &seed : seeds) {
    if (Target().run(seed)) {
      ++read;
    } else {
      refused += seed.substr(0, 80) + "\n";
    }
  }
  // These targets recognise formats by content, so they reject seeds of formats
  // that are recognised only by file name.
  static const std::set<std::string> kByContent = {
      "detections", "tracks", "rewritten_detections", "rewritten_tracks"};
  const bool by_content = kByContent.count(GetParam()) > 0;
  EXPECT_GE(read, by_content ? seeds.size() / 2 : seeds.size()) << refused;
}

std::string Mutated(std::string input, Random *random) {
  const int64_t changes = 1 + random->Index(4);
  for (int64_t c = 0; c < changes && !input.empty(); ++c) {
    const auto size = static_cast<int64_t>(input.size());
    const auto at = static_cast<size_t>(random->Index(size));
    switch (random->Index(5)) {
      case 0:
        input[at] = static_cast<char>(random->Index(256));
        break;
      case 1:
        input.erase(at, static_cast<size_t>(1 + random->Index(16)));
        break;
      case 3:  // cut off
        input.resize(at);
        break;
      case 2:
        input.insert(at, input.substr(static_cast<size_t>(random->Index(size)),
                                      static_cast<size_t>(random->Index(32))));
        break;
      default: {
        static constexpr const char *kWords[] = {
            ",",  "[", "{", "\"", "null", "-1", "1e400", "99999999999999999999",
            "\n", "0"};
        input.insert(at, kWords[random->Index(10)]);
      }
    }
  }
  return input;
}

int64_t NumberFrom(const char *variable, int64_t otherwise) {
  const char *text = std::getenv(variable);
  return text == nullptr ? otherwise : std::atoll(text);
}

// KINEGRAPH_FUZZ_RUNS sets the number of mutations per seed,
// KINEGRAPH_FUZZ_SEED selects different mutations, and KINEGRAPH_FUZZ_INPUT
// names a file to which each mutation is written before it is tried, so that a
// mutation that ends the program is kept.
TEST_P(ReplayTest, MutationsOfGoodInputsEndQuickly) {
  const std::string &name = GetParam();
  const int64_t count = NumberFrom("KINEGRAPH_FUZZ_RUNS",
                                   name == "scene"                    ? 3
                                   : name.rfind("rewritten_", 0) == 0 ? 5
                                                                      : 150);
  const char *const kept = std::getenv("KINEGRAPH_FUZZ_INPUT");
  Random random(static_cast<uint64_t>(NumberFrom("KINEGRAPH_FUZZ_SEED", 1)));
  for (const std::string &seed : FuzzSeeds(name)) {
    ASSERT_FALSE(seed.empty());
    Target().run(seed);
    for (int64_t i = 0; i < count; ++i) {
      const std::string input = Mutated(seed, &random);
      if (kept != nullptr) {
        std::ofstream(kept, std::ios::binary | std::ios::trunc) << input;
      }
      const ProcessorTime used;
      Target().run(input);
      // Inputs of a few kilobytes take milliseconds; a scene takes a second
      // under sanitizers.
      ASSERT_LT(used.Seconds(), 5.0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Every, ReplayTest, ::testing::ValuesIn(Names()),
                         [](const ::testing::TestParamInfo<std::string> &test) {
                           return test.param;
                         });

}  // namespace
}  // namespace kinegraph::testing
