// Runs the tasks of a batch, several at once, each in programs of its own.
#ifndef KINEGRAPH_APPS_BATCH_RUNNER_H_
#define KINEGRAPH_APPS_BATCH_RUNNER_H_

#include <functional>
#include <string>
#include <vector>

#include "apps/batch/tasks.h"

namespace kinegraph {

enum class TaskState {
  kMissing,  // not done yet
  kDone,     // by a task with the same fingerprint
  kOther,    // done by another one: other inputs, or other settings
};

// State of the folder DIR/TAKE/CONFIGURATION, whose task.json names its
// fingerprint.
TaskState StateOf(const Task& task, const std::string& out);

struct TaskOutcome {
  bool done = false;
  std::string error;  // one line, the program's own
};

// Runs the steps one after the other. The folder appears under its name when
// all of them are done; else DIR/TAKE/CONFIGURATION.failed.txt holds the error.
TaskOutcome RunTask(const Task& task, const std::string& out);

// Runs all of them, `jobs` at once, and calls `report` with each outcome, one
// at a time. Returns how many failed.
int RunTasks(
    const std::vector<Task>& tasks, const std::string& out, int jobs,
    const std::function<void(const Task&, const TaskOutcome&)>& report);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_BATCH_RUNNER_H_
