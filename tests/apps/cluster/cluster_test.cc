// A batch run by cluster engines: Debian's snakemake, and a one-node Slurm that
// the test starts and stops. Both write the same bytes as `batch` itself.
#include <gtest/gtest.h>

#include "tests/apps/batch/study.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> Sets(int count) {
  std::vector<std::string> sets;
  for (int i = 0; i < count; ++i) {
    sets.push_back("reconstruction.alpha_epi=" + std::to_string(20 + i));
  }
  return sets;
}

bool AreThere(const std::vector<std::string>& programs) {
  return std::all_of(
      programs.begin(), programs.end(), [](const std::string& program) {
        return RunShell("PATH=$PATH:/usr/sbin command -v " + program)
                   .exit_code == 0;
      });
}

// Runs the tasks of `study` by a script that kills the node before they are
// done, and expects the files of an undisturbed run.
void ExpectSameAfterDeath(const BatchStudy& study, int tasks,
                          const std::string& script,
                          const std::string& last_argument = "") {
  Done("batch", study.Flags("plain"));
  const ProgramOutcome drill =
      RunShell("'" + ProjectFile("tests/apps/cluster/" + script).string() +
               "' '" + ProgramPath("batch") + "' '" + study.manifest + "' '" +
               study.Path("slurm") + "' '" + study.Path("engine") + "' " +
               last_argument);
  ASSERT_EQ(drill.exit_code, 0) << drill.errors;
  const int at_death = std::atoi(drill.output.c_str());
  EXPECT_GT(at_death, 0);
  EXPECT_LT(at_death, tasks);
  study.ExpectSameFiles("plain", "slurm");
}

TEST(ClusterTest, SnakemakeMakesTheSameFiles) {
  if (!AreThere({"snakemake"})) {
    GTEST_SKIP() << "needs Debian's snakemake: apt-get install snakemake";
  }
  const BatchStudy study(Sets(2));
  Done("batch", study.Flags("plain"));
  const std::string run = "cd '" + study.folder.path().string() +
                          "' && HOME=$PWD snakemake --quiet -j 2 -s '" +
                          ProjectFile("workflow/Snakefile").string() +
                          "' --config manifest=study.toml out=snake batch='" +
                          ProgramPath("batch") + "'";
  const ProgramOutcome first = RunShell(run);
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  study.ExpectSameFiles("plain", "snake");
  // Existing results are not made again; missing ones are.
  const std::string done = study.Path("snake/take1/c0/task.json");
  const auto time = fs::last_write_time(done);
  fs::remove_all(study.Path("snake/take2/c1"));
  const ProgramOutcome second = RunShell(run);
  ASSERT_EQ(second.exit_code, 0) << second.errors;
  EXPECT_EQ(fs::last_write_time(done), time);
  study.ExpectSameFiles("plain", "snake");
}

TEST(ClusterTest, SlurmCompletesFortyTasksAfterTheNodeIsKilled) {
  if (!AreThere({"slurmctld", "slurmd", "munged", "sbatch"})) {
    GTEST_SKIP() << "needs Slurm: apt-get install slurm-wlm munge";
  }
  ExpectSameAfterDeath(BatchStudy(Sets(20)), 40, "slurm_drill.sh");
}

// The same Snakefile with each task as a Slurm job; tasks that die with the
// node are resubmitted automatically.
TEST(ClusterTest, SnakemakeOnSlurmCompletesAfterTheNodeIsKilled) {
  if (!AreThere({"snakemake", "slurmctld", "slurmd", "munged"})) {
    GTEST_SKIP() << "needs Snakemake and Slurm: apt-get install snakemake "
                    "slurm-wlm munge";
  }
  ExpectSameAfterDeath(BatchStudy(Sets(3)), 6, "profile_drill.sh",
                       "'" + ProjectFile("workflow/Snakefile").string() + "'");
}

}  // namespace
}  // namespace kinegraph::testing
