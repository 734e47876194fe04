#include "apps/common/machine.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

TEST(MachineTest, ReportsProcessorSystemCompilerAndThreads) {
  const Machine machine = ThisMachine();
  EXPECT_FALSE(machine.processor.empty());
  EXPECT_FALSE(machine.system.empty());
  EXPECT_FALSE(machine.compiler.empty());
  EXPECT_GE(machine.threads, 1);
  for (const std::string& text :
       {machine.processor, machine.system, machine.compiler}) {
    EXPECT_EQ(text.find('\n'), std::string::npos);
    EXPECT_EQ(text.find('"'), std::string::npos);
  }
}

// In a checkout the abbreviated hash, with "-dirty" if there are changes.
TEST(MachineTest, CommitIsAHashOrUnknown) {
  const std::string commit = ThisMachine().commit;
  if (commit == "unknown") return;
  const std::string hash = commit.substr(0, commit.find('-'));
  EXPECT_GE(hash.size(), 7u);
  for (const char c : hash) {
    EXPECT_TRUE(std::isxdigit(static_cast<unsigned char>(c))) << commit;
  }
  if (hash.size() < commit.size()) {
    EXPECT_EQ(commit.substr(hash.size()), "-dirty");
  }
}

// An installation inside a repository of the user is not a build of that
// repository's commit.
TEST(MachineTest, AForeignRepositoryHasNoCommitOfOurs) {
  const testing::TemporaryFolder folder;
  const std::string own = folder.path() / "configs";
  const std::string installed = folder.path() / "venv/share/kinegraph/configs";
  std::filesystem::create_directories(own);
  std::filesystem::create_directories(installed);
  const std::string git = "git -C '" + folder.path().string() + "' ";
  const std::string commit =
      git + "init -q && " + git +
      "-c user.name=a -c user.email=b commit -q --allow-empty -m c";
  if (std::system(commit.c_str()) != 0) GTEST_SKIP() << "git is not installed";
  EXPECT_NE(CommitOf(own), "unknown");
  EXPECT_EQ(CommitOf(installed), "unknown");
}

}  // namespace
}  // namespace kinegraph
