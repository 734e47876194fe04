// Manifests of recordings and configurations, for `batch`.
#ifndef KINEGRAPH_TESTS_APPS_BATCH_STUDY_H_
#define KINEGRAPH_TESTS_APPS_BATCH_STUDY_H_

#include <string>
#include <vector>

#include "tests/apps/command.h"
#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {

// Two short recordings, to be tracked with a configuration per entry of `sets`
// (--set).
struct BatchStudy {
  TemporaryFolder folder;
  std::string manifest;

  // `more`: further recordings, in TOML.
  explicit BatchStudy(const std::vector<std::string>& sets,
                      const std::string& more = "") {
    std::string text;
    for (const std::string seed : {"1", "2"}) {
      const std::string name = "take" + seed;
      Done("synthesize",
           "--config=" + ProjectFile("configs/synthetic/demo.toml").string() +
               " --set='scene.duration=0.4;scene.seed=" + seed +
               "' --out=" + Path(name));
      text += "[[takes]]\nname = \"" + name + "\"\ncameras = \"" + name +
              "/cameras.json\"\ndetections = \"" + name +
              "/detections.jsonl\"\nground_truth = \"" + name +
              "/truth.jsonl\"\nprotocol = \"mpjpe\"\n";
    }
    text += more;
    for (size_t i = 0; i < sets.size(); ++i) {
      text += "[[configurations]]\nname = \"c" + std::to_string(i) +
              "\"\nconfig = \"" +
              ProjectFile("configs/synthetic/track_paper.toml").string() +
              "\"\nset = \"" + sets[i] + "\"\n";
    }
    manifest = folder.Write("study.toml", text);
  }

  std::string Path(const std::string& name) const {
    return (folder.path() / name).string();
  }
  std::string Flags(const std::string& out,
                    const std::string& more = "") const {
    return "--manifest=" + manifest + " --out=" + Path(out) + " " + more;
  }
  void ExpectSameFiles(const std::string& a, const std::string& b) const {
    const ProgramOutcome difference =
        RunShell("diff -r '" + Path(a) + "' '" + Path(b) + "'");
    EXPECT_EQ(difference.exit_code, 0) << difference.output;
  }
};

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_APPS_BATCH_STUDY_H_
