// The C++ example of README.md compiles and tracks; it is repeated here
// verbatim.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

#include "core/io/files/text_file.h"
#include "include/kinegraph/kinegraph.h"
#include "tests/support/test_data.h"

namespace {

namespace fs = std::filesystem;
using kinegraph::testing::BuildFile;
using kinegraph::testing::ProjectFile;

kinegraph::TrackSequence TrackedAsTheReadmeSays() {
  // clang-format off
kinegraph::RunOptions options;
options.estimators.mode = kinegraph::Mode::kGraph;
kinegraph::RunRequest request;
request.cameras = kinegraph::ReadCameras("calibration.json");
const kinegraph::TrackSequence tracks = kinegraph::TrackSequenceOf(
    options, request, kinegraph::ReadDetections("detections.jsonl"));
  // clang-format on
  return tracks;
}

std::string Between(const std::string& text, const std::string& begin,
                    const std::string& end) {
  const size_t at = text.find(begin) + begin.size();
  return text.substr(at, text.find(end, at) - at);
}

TEST(ReadmeSnippetTest, EqualsTheSnippetOfTheReadme) {
  const std::string readme =
      Between(kinegraph::ReadTextFile(ProjectFile("README.md").string()),
              "```cpp\n#include <kinegraph/kinegraph.h>\n\n", "```");
  const std::string here = kinegraph::ReadTextFile(
      ProjectFile("tests/apps/docs/readme_snippet_test.cc").string());
  EXPECT_EQ(Between(here, "clang-format off\n", "  // clang-format on"),
            readme);
}

TEST(ReadmeSnippetTest, TracksEveryFrame) {
  const kinegraph::testing::TemporaryFolder folder;
  const fs::path recording = folder.path() / "take";
  std::ostringstream command;
  command << BuildFile("apps/kinegraph-synthesize")
          << " --config=" << ProjectFile("configs/synthetic/demo.toml")
          << " --set=scene.duration=2 --out=" << recording << " > /dev/null";
  ASSERT_EQ(std::system(command.str().c_str()), 0);
  fs::rename(recording / "cameras.json", recording / "calibration.json");
  const fs::path before = fs::current_path();
  fs::current_path(recording);
  const kinegraph::TrackSequence tracks = TrackedAsTheReadmeSays();
  fs::current_path(before);
  EXPECT_EQ(tracks.frames.size(), 50u);  // two seconds at 25 Hz
  EXPECT_FALSE(tracks.frames.back().people.empty());
}

}  // namespace
