#include "apps/batch/tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <utility>

#include "apps/common/config_folder.h"
#include "apps/common/machine.h"
#include "core/base/error.h"
#include "core/io/binary/npz_file.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/input_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

// "--name=value" of each flag that has a value.
std::vector<std::string> Arguments(
    const std::vector<std::pair<std::string, std::string>>& flags) {
  std::vector<std::string> arguments;
  for (const auto& [name, value] : flags) {
    if (!value.empty()) arguments.push_back("--" + name + "=" + value);
  }
  return arguments;
}

TaskStep MakeStep(const std::string& command,
                  std::vector<std::string> arguments,
                  const std::string& output_flag, const std::string& output) {
  arguments.push_back("--" + output_flag + "=" + output);
  return {command, std::move(arguments), output};
}

std::vector<TaskStep> StepsOf(const Manifest& manifest,
                              const ManifestRecording& recording,
                              const ManifestConfiguration& configuration) {
  const std::string tracks = "tracks.jsonl";
  // Flags for every command that tracks. The recording's keys describe its data
  // and come last.
  std::vector<std::string> tracking =
      Arguments({{"cameras", recording.cameras},
                 {"detections", recording.detections},
                 {"config", configuration.config},
                 {"set", JoinSets(configuration.set, recording.set)},
                 {"mode", configuration.mode},
                 {"frames", recording.frames}});
  std::vector<TaskStep> steps = {MakeStep("track", tracking, "out", tracks)};
  const auto evaluate = [&](const std::string& protocol,
                            const std::string& output) {
    steps.push_back(
        MakeStep("evaluate",
                 Arguments({{"tracks", tracks},
                            {"ground_truth", recording.ground_truth},
                            {"protocol", protocol},
                            {"frames", recording.frames}}),
                 "json", output));
  };
  if (!recording.ground_truth.empty()) {
    evaluate(recording.protocol, "evaluation.json");
    if (recording.protocol != "identity") evaluate("identity", "identity.json");
  }
  if (manifest.held_out) {
    std::vector<std::string> arguments = tracking;
    arguments.emplace_back("--protocol=held_out_camera");
    steps.push_back(
        MakeStep("evaluate", std::move(arguments), "json", "held_out.json"));
  }
  if (manifest.compare) {
    steps.push_back(MakeStep("compare", tracking, "out", "compare"));
  }
  if (manifest.report) {
    steps.push_back(
        MakeStep("report",
                 Arguments({{"tracks", tracks},
                            {"ground_truth", recording.ground_truth}}),
                 "out", "report.html"));
  }
  return steps;
}

// The path with a checksum of the file; without one for anything but a regular
// file.
std::string ContentMark(const std::string& path) {
  if (path.empty() || !IsFile(path) || IsPipe(path)) return path + "\n";
  return fmt::format("{} {:08x}\n", path, Crc32(ReadBytes(path)));
}

// Files in the task's folder: standard output of all its programs, and standard
// error of the running program.
constexpr const char* kLog = "log.txt";
constexpr const char* kErrors = "errors.txt";

// All programs of a build are in one folder.
std::string ProgramOf(const std::string& command) {
  const std::string path = ProgramPath();
  if (path.empty()) {
    throw std::runtime_error("cannot determine where the programs are");
  }
  return path.substr(0, path.rfind('/') + 1) + "kinegraph-" + command;
}

std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const size_t newline = text.rfind('\n');
  return newline == std::string::npos ? text : text.substr(newline + 1);
}

// Runs a step. Returns its error, or an empty string if it succeeded.
std::string RunStep(const TaskStep& step, const std::string& folder) {
  std::vector<std::string> words = step.arguments;
  words.insert(words.begin(), ProgramOf(step.command));
  const std::string errors = folder + "/" + kErrors;
  const ProcessEnd end = RunInFolder(std::move(words), folder, kLog, kErrors);
  if (end.not_started != 0) {
    throw std::runtime_error("kinegraph-" + step.command +
                             " cannot be started (" +
                             std::string(std::strerror(end.not_started)) + ")");
  }
  const std::string said = IsFile(errors) ? ReadTextFile(errors) : "";
  InputFiles::Forget(errors);
  RemoveFile(errors);
  if (end.well()) return "";
  if (end.signal != 0) {
    return "kinegraph-" + step.command + " was ended by signal " +
           std::to_string(end.signal);
  }
  return said.empty()
             ? "kinegraph-" + step.command +
                   " failed, or could not be executed, without a message"
             : Printable(LastLine(said), 1000);
}

std::string TaskJson(const Task& task) {
  const Machine machine = ThisMachine();
  Json json = {{"kinegraph_task", 1},
               {"take", task.recording},
               {"configuration", task.configuration},
               {"fingerprint", task.fingerprint},
               {"commit", machine.commit},
               {"processor", machine.processor}};
  for (const TaskStep& step : task.steps) {
    json["outputs"].push_back(step.output);
  }
  return DumpJson(json, 1) + "\n";
}

}  // namespace

std::vector<Task> TasksOf(const Manifest& manifest) {
  std::vector<Task> tasks;
  for (const ManifestRecording& recording : manifest.recordings) {
    const std::string recording_marks =
        ContentMark(recording.cameras) + ContentMark(recording.ground_truth);
    for (const ManifestConfiguration& configuration : manifest.configurations) {
      Task task;
      task.recording = recording.name;
      task.configuration = configuration.name;
      task.steps = StepsOf(manifest, recording, configuration);
      std::string inputs = recording_marks + ContentMark(configuration.config);
      for (const TaskStep& step : task.steps) {
        inputs += fmt::format("{} {}\n", step.command,
                              fmt::join(step.arguments, " "));
      }
      task.fingerprint = fmt::format("{:08x}", Crc32(inputs));
      tasks.push_back(std::move(task));
    }
  }
  return tasks;
}

std::string FolderOf(const Task& task, const std::string& out) {
  return out + "/" + task.Name();
}

std::string FailureFile(const Task& task, const std::string& out) {
  return FolderOf(task, out) + ".failed.txt";
}

TaskState StateOf(const Task& task, const std::string& out) {
  const std::string folder = FolderOf(task, out);
  // Snakemake creates the empty folder itself.
  if (!IsFolder(folder) || ListFolder(folder).empty()) {
    return TaskState::kMissing;
  }
  const std::string file = folder + "/task.json";
  if (!IsFile(file)) return TaskState::kOther;
  const Json json = ParseJson(ReadTextFile(file, kMaxSmallFileBytes), file);
  return JsonField(json, file).At("fingerprint").Text() == task.fingerprint
             ? TaskState::kDone
             : TaskState::kOther;
}

namespace {

// Runs the steps one after the other. The folder appears under its name when
// all steps are done; otherwise FailureFile contains the error.
TaskOutcome RunTask(const Task& task, const std::string& out) {
  TaskOutcome outcome;
  try {
    const OutputFolder recording_folder(out + "/" + task.recording);
    AtomicFolder folder(FolderOf(task, out));
    std::string inside = folder.PathOf("");
    inside.pop_back();  // the slash
    for (const TaskStep& step : task.steps) {
      outcome.error = RunStep(step, inside);
      if (!outcome.error.empty()) break;
    }
    if (outcome.error.empty()) {
      WriteTextFile(folder.PathOf("task.json"), TaskJson(task));
      folder.Commit();
      RemoveFile(FailureFile(task, out));
      outcome.done = true;
      return outcome;
    }
  } catch (const std::exception& error) {
    outcome.error = error.what();
  }
  try {
    // If two batches share the work, the other one may have finished first.
    if (StateOf(task, out) == TaskState::kDone) return {true, ""};
    const OutputFolder recording_folder(out + "/" + task.recording);
    WriteTextFile(FailureFile(task, out), outcome.error + "\n");
  } catch (const std::exception&) {  // the caller reports outcome.error
  }
  return outcome;
}

}  // namespace

int RunTasks(
    const std::vector<Task>& tasks, const std::string& out, int jobs,
    const std::function<void(const Task&, const TaskOutcome&)>& report) {
  std::atomic<size_t> next{0};
  std::atomic<int> failed{0};
  std::mutex mutex;
  const auto work = [&] {
    for (size_t i = next++; i < tasks.size(); i = next++) {
      const TaskOutcome outcome = RunTask(tasks[i], out);
      if (!outcome.done) ++failed;
      const std::lock_guard<std::mutex> lock(mutex);
      report(tasks[i], outcome);
    }
  };
  std::vector<std::thread> threads;
  const size_t count =
      std::min(static_cast<size_t>(std::max(jobs, 1)), tasks.size());
  for (size_t t = 1; t < count; ++t) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  return failed;
}

}  // namespace kinegraph
