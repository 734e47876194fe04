// Lists the tasks of a batch, each recording with each configuration, and runs
// them: several at once, each in processes of its own.
#ifndef KINEGRAPH_APPS_BATCH_TASKS_H_
#define KINEGRAPH_APPS_BATCH_TASKS_H_

#include <functional>
#include <string>
#include <vector>

#include "core/io/configuration/manifest.h"

namespace kinegraph {

// One command of a task, run in the task's folder. Later steps may read its
// output.
struct TaskStep {
  std::string command;  // "track" for kinegraph-track
  std::vector<std::string> arguments;
  std::string output;  // name in the folder
};

struct Task {
  std::string recording;
  std::string configuration;
  std::vector<TaskStep> steps;
  // Checksum of the arguments of all steps and of the contents of the
  // calibration, ground truth and configuration files; the contents of folders
  // and of detections are not included. Another fingerprint means another task.
  std::string fingerprint;

  std::string Name() const { return recording + "/" + configuration; }
};

// The tasks in the order of the manifest: all configurations of a recording,
// then the next recording. Throws InputError if a file whose contents are part
// of a fingerprint exists but cannot be read.
std::vector<Task> TasksOf(const Manifest& manifest);

enum class TaskState {
  kMissing,  // no folder, or an empty one
  kDone,     // by a task with the same fingerprint
  // The folder contains something else: the result of a task with other inputs
  // or settings, or files without task.json.
  kOther,
};

// OUT/RECORDING/CONFIGURATION, and the file with the error of a failed task.
std::string FolderOf(const Task& task, const std::string& out);
std::string FailureFile(const Task& task, const std::string& out);

// State of the folder FolderOf(task, out), whose task.json contains the
// fingerprint. Throws InputError if task.json is unreadable or invalid.
TaskState StateOf(const Task& task, const std::string& out);

struct TaskOutcome {
  bool done = false;
  std::string error;  // one line: the program's error, or how it ended
};

// Runs all tasks, `jobs` at once, and calls `report` with each outcome, one at
// a time. Returns the number of failed tasks.
int RunTasks(
    const std::vector<Task>& tasks, const std::string& out, int jobs,
    const std::function<void(const Task&, const TaskOutcome&)>& report);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_BATCH_TASKS_H_
