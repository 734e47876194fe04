// The tasks of a batch: each recording with each configuration.
#ifndef KINEGRAPH_APPS_BATCH_TASKS_H_
#define KINEGRAPH_APPS_BATCH_TASKS_H_

#include <string>
#include <vector>

#include "core/io/configuration/manifest.h"

namespace kinegraph {

// One command of a task, run in the task's folder: what it reads of other steps
// and what it writes stands there.
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
  // they name: another fingerprint means another task.
  std::string fingerprint;

  std::string Name() const { return recording + "/" + configuration; }
};

// In the order of the manifest, takes first. Throws InputError for a
// configuration that cannot be read.
std::vector<Task> TasksOf(const Manifest& manifest);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_BATCH_TASKS_H_
