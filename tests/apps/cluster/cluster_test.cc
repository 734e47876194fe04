// A batch on the engines of clusters: Debian's snakemake, and a Slurm of one
// node that the test starts and stops. Both give the bytes of `batch` itself.
#include <gtest/gtest.h>

#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

// Two recordings and `configurations` ways to track them.
std::string WriteStudy(const TemporaryFolder& folder, int configurations) {
  std::string text;
  for (const std::string seed : {"1", "2"}) {
    const std::string name = "take" + seed;
    const ProgramOutcome made = RunProgram(
        "synthesize",
        "--config=" + ProjectFile("configs/synthetic/demo.toml").string() +
            " --set='scene.duration=0.4;scene.seed=" + seed +
            "' --out=" + (folder.path() / name).string());
    EXPECT_EQ(made.exit_code, 0) << made.errors;
    text += "[[takes]]\nname = \"" + name + "\"\ncameras = \"" + name +
            "/cameras.json\"\ndetections = \"" + name +
            "/detections.jsonl\"\nground_truth = \"" + name +
            "/truth.jsonl\"\nprotocol = \"mpjpe\"\n";
  }
  const std::string config =
      ProjectFile("configs/synthetic/track_paper.toml").string();
  for (int i = 0; i < configurations; ++i) {
    text += "[[configurations]]\nname = \"c" + std::to_string(i) +
            "\"\nconfig = \"" + config +
            "\"\nset = \"reconstruction.alpha_epi=" + std::to_string(20 + i) +
            "\"\n";
  }
  return folder.Write("study.toml", text);
}

void RunBatch(const std::string& manifest, const std::string& out) {
  const ProgramOutcome outcome =
      RunProgram("batch", "--manifest=" + manifest + " --out=" + out);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
}

void ExpectSameFiles(const std::string& a, const std::string& b) {
  const ProgramOutcome difference = RunShell("diff -r '" + a + "' '" + b + "'");
  EXPECT_EQ(difference.exit_code, 0) << difference.output;
}

bool IsThere(const std::string& program) {
  return RunShell("PATH=$PATH:/usr/sbin command -v " + program).exit_code == 0;
}

TEST(ClusterTest, SnakemakeMakesTheSameFiles) {
  if (!IsThere("snakemake")) {
    GTEST_SKIP() << "needs Debian's snakemake: apt-get install snakemake";
  }
  const TemporaryFolder folder;
  const std::string manifest = WriteStudy(folder, 2);
  const std::string plain = (folder.path() / "plain").string();
  const std::string snake = (folder.path() / "snake").string();
  RunBatch(manifest, plain);
  const std::string run = "cd '" + folder.path().string() +
                          "' && HOME=$PWD snakemake --quiet -j 2 -s '" +
                          ProjectFile("workflow/Snakefile").string() +
                          "' --config manifest=study.toml out=snake batch='" +
                          ProgramPath("batch") + "'";
  const ProgramOutcome first = RunShell(run);
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  ExpectSameFiles(plain, snake);
  // What is there is not made again; what is missing is.
  const auto time = fs::last_write_time(snake + "/take1/c0/task.json");
  fs::remove_all(snake + "/take2/c1");
  const ProgramOutcome second = RunShell(run);
  ASSERT_EQ(second.exit_code, 0) << second.errors;
  EXPECT_EQ(fs::last_write_time(snake + "/take1/c0/task.json"), time);
  ExpectSameFiles(plain, snake);
}

TEST(ClusterTest, FortyTasksOnASlurmWhoseNodeDies) {
  for (const char* program : {"slurmctld", "slurmd", "munged", "sbatch"}) {
    if (!IsThere(program)) {
      GTEST_SKIP() << "needs Slurm: apt-get install slurm-wlm munge";
    }
  }
  const TemporaryFolder folder;
  const std::string manifest = WriteStudy(folder, 20);
  const std::string plain = (folder.path() / "plain").string();
  const std::string slurm = (folder.path() / "slurm").string();
  RunBatch(manifest, plain);
  const ProgramOutcome drill =
      RunShell("'" + ProjectFile("tests/apps/cluster/slurm_drill.sh").string() +
               "' '" + ProgramPath("batch") + "' '" + manifest + "' '" + slurm +
               "' '" + (folder.path() / "engine").string() + "'");
  ASSERT_EQ(drill.exit_code, 0) << drill.errors;
  // It died in the middle.
  const int at_death = std::atoi(drill.output.c_str());
  EXPECT_GT(at_death, 0);
  EXPECT_LT(at_death, 40);
  ExpectSameFiles(plain, slurm);
}

// The same Snakefile, each task a job of Slurm; what dies with the node is
// submitted again without anybody's doing.
TEST(ClusterTest, SnakemakeOnASlurmWhoseNodeDies) {
  for (const char* program : {"snakemake", "slurmctld", "slurmd", "munged"}) {
    if (!IsThere(program)) {
      GTEST_SKIP() << "needs Snakemake and Slurm: apt-get install snakemake "
                      "slurm-wlm munge";
    }
  }
  const TemporaryFolder folder;
  const std::string manifest = WriteStudy(folder, 3);
  const std::string plain = (folder.path() / "plain").string();
  const std::string slurm = (folder.path() / "slurm").string();
  RunBatch(manifest, plain);
  const ProgramOutcome drill = RunShell(
      "'" + ProjectFile("tests/apps/cluster/profile_drill.sh").string() +
      "' '" + ProgramPath("batch") + "' '" + manifest + "' '" + slurm + "' '" +
      (folder.path() / "engine").string() + "' '" +
      ProjectFile("workflow/Snakefile").string() + "'");
  ASSERT_EQ(drill.exit_code, 0) << drill.errors;
  const int at_death = std::atoi(drill.output.c_str());
  EXPECT_GT(at_death, 0);
  EXPECT_LT(at_death, 6);
  ExpectSameFiles(plain, slurm);
}

}  // namespace
}  // namespace kinegraph::testing
