// kinegraph-batch: runs every recording with every configuration, each in its
// own folder.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "apps/batch/merge.h"
#include "apps/batch/tasks.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "core/base/error.h"
#include "core/io/configuration/manifest.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"

DEFINE_string(manifest, "",
              "recordings and configurations (TOML, docs/batch.md)");
DEFINE_string(out, "", "folder of the results; created if missing");
DEFINE_int32(jobs, 0, "number of parallel tasks; 0: one per processor");
DEFINE_bool(resume, false, "continue a batch that was stopped");
DEFINE_bool(merge, false, "only write the tables of the finished tasks");
DEFINE_bool(list, false, "print the names of the tasks and exit");
DEFINE_string(task, "",
              "run only this task, named RECORDING/CONFIGURATION or by its "
              "number from 0; implies --resume and writes no tables");

namespace kinegraph {
namespace {

int JobCount() {
  if (FLAGS_jobs < 0) throw InputError("--jobs: expected at least 0");
  if (FLAGS_jobs > 0) return FLAGS_jobs;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// The one task named by --task.
const Task& ChosenTask(const std::vector<Task>& tasks) {
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (FLAGS_task == tasks[i].Name() || FLAGS_task == std::to_string(i)) {
      return tasks[i];
    }
  }
  throw InputError("--task: '" + Printable(FLAGS_task) +
                   "' is no task, expected a name that --list prints, or its "
                   "place in that list, from 0");
}

// The tasks not done yet. Throws if a folder contains anything but the result
// of its task, which is neither reused nor removed, or if tasks are done and
// `resume` is false.
std::vector<Task> TasksToDo(const std::vector<Task>& tasks, bool resume) {
  std::vector<Task> missing;
  size_t done = 0;
  for (const Task& task : tasks) {
    const TaskState state = StateOf(task, FLAGS_out);
    if (state == TaskState::kOther) {
      throw InputError(FLAGS_out + "/" + task.Name(), "",
                       "is not the result of this task, or was made from other "
                       "inputs or settings; remove it or name another --out");
    }
    if (state == TaskState::kMissing) missing.push_back(task);
    done += state == TaskState::kDone ? 1 : 0;
  }
  if (done > 0 && !resume) {
    throw InputError(
        FLAGS_out, "",
        fmt::format("{} tasks are already done; --resume runs the others",
                    done));
  }
  return missing;
}

void PrintOutcome(const Task& task, const TaskOutcome& outcome) {
  std::printf("%s %s%s\n", task.Name().c_str(),
              outcome.done ? "done" : "FAILED: ", outcome.error.c_str());
  std::fflush(stdout);
}

void Merge(const std::vector<Task>& tasks) {
  const int missing = MergeBatch(tasks, FLAGS_out);
  std::printf("%zu of %zu tasks -> %s/batch.md\n",
              tasks.size() - static_cast<size_t>(missing), tasks.size(),
              FLAGS_out.c_str());
}

// The manifest is copied to the results, so that --merge works without it.
std::string KeptManifest() { return FLAGS_out + "/manifest.toml"; }

void KeepManifest(const Manifest& manifest) {
  const std::string text = ManifestText(manifest);
  if (IsFile(KeptManifest()) && ReadTextFile(KeptManifest()) == text) return;
  WriteTextFile(KeptManifest(), text);
}

Manifest GivenManifest() {
  if (FLAGS_merge && FLAGS_manifest.empty()) {
    return ReadManifest(KeptManifest());
  }
  RequireFlag("manifest", FLAGS_manifest);
  Manifest manifest = ReadManifest(FLAGS_manifest, ShippedConfig);
  if (manifest.configurations.empty()) {
    throw InputError(FLAGS_manifest, "", "has no [[configurations]]");
  }
  for (const ManifestConfiguration& one : manifest.configurations) {
    if (IsFile(one.config)) continue;
    throw InputError(FLAGS_manifest, "configuration '" + one.name + "'",
                     "its config " + Printable(one.config) + " is not there");
  }
  return manifest;
}

void RunBatch() {
  if (!FLAGS_list) RequireFlag("out", FLAGS_out);
  const Manifest manifest = GivenManifest();
  const std::vector<Task> tasks = TasksOf(manifest);
  if (FLAGS_list) {
    for (const Task& task : tasks) std::printf("%s\n", task.Name().c_str());
    return;
  }
  const OutputFolder folder(FLAGS_out);
  if (FLAGS_merge) return Merge(tasks);
  std::vector<Task> chosen = tasks;
  if (!FLAGS_task.empty()) chosen = {ChosenTask(tasks)};
  const std::vector<Task> missing =
      TasksToDo(chosen, FLAGS_resume || !FLAGS_task.empty());
  KeepManifest(manifest);
  const int failed = RunTasks(missing, FLAGS_out, JobCount(), PrintOutcome);
  if (FLAGS_task.empty()) Merge(tasks);
  if (failed > 0) {
    throw std::runtime_error(fmt::format(
        "{} of {} tasks failed; the others are done", failed, missing.size()));
  }
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"batch",
       "runs every recording of a study with every configuration",
       "--manifest=F.toml --out=DIR [--jobs=N] [--resume]\n"
       "       kinegraph-batch --merge --out=DIR",
       {"--manifest=study.toml --jobs=2 --out=out/study",
        "--manifest=study.toml --resume --out=out/study"}},
      kinegraph::RunBatch);
}
