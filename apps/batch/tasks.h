// The tasks of a batch, each recording with each configuration, and their
// execution: several at once, each in separate processes.
#ifndef KINEGRAPH_APPS_BATCH_TASKS_H_
#define KINEGRAPH_APPS_BATCH_TASKS_H_

#include <functional>
#include <string>
#include <vector>

#include "core/io/configuration/manifest.h"

namespace kinegraph {

// One command of a task, run in the task's folder. Later steps read its output.
struct TaskStep {
  std::string command;  // "track" for kinegraph-track
  std::vector<std::string> arguments;
  std::string output;  // name in the folder
};

struct Task {
  std::string recording;
  std::string configuration;
  std::vector<TaskStep> steps;
  // Covers the arguments of all steps and the contents of the small files that
  // they name: a different fingerprint is a different task.
  std::string fingerprint;

  std::string Name() const { return recording + "/" + configuration; }
};

// In the order of the manifest, takes first. Throws InputError for a
// configuration that cannot be read.
std::vector<Task> TasksOf(const Manifest& manifest);

enum class TaskState {
  kMissing,  // not done yet
  kDone,     // by a task with the same fingerprint
  kOther,    // done by a different one: other inputs, or other settings
};

// State of the folder DIR/TAKE/CONFIGURATION, whose task.json names its
// fingerprint.
TaskState StateOf(const Task& task, const std::string& out);

struct TaskOutcome {
  bool done = false;
  std::string error;  // one line, from the program itself
};

// Runs all of them, `jobs` at once, and calls `report` with each outcome, one
// at a time. Returns how many failed.
int RunTasks(
    const std::vector<Task>& tasks, const std::string& out, int jobs,
    const std::function<void(const Task&, const TaskOutcome&)>& report);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_BATCH_TASKS_H_
