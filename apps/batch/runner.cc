#include "apps/batch/runner.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "apps/common/machine.h"
#include "apps/common/program_path.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/input_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// What a task's programs print, and what the last one complained about.
constexpr const char* kLog = "log.txt";
constexpr const char* kErrors = "errors.txt";

std::string FolderOf(const Task& task, const std::string& out) {
  return out + "/" + task.take + "/" + task.configuration;
}

std::string FailureFile(const Task& task, const std::string& out) {
  return FolderOf(task, out) + ".failed.txt";
}

// The programs of one build stand in one folder.
std::string ProgramOf(const std::string& command) {
  const std::string path = ProgramPath();
  if (path.empty()) throw std::runtime_error("cannot tell where programs are");
  return path.substr(0, path.rfind('/') + 1) + "kinegraph-" + command;
}

// Between fork and exec only what a handler of signals may do.
[[noreturn]] void Become(char* const* arguments, const char* folder,
                         pid_t parent) {
  // A batch that is killed takes its programs along.
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  if (chdir(folder) != 0) _exit(127);
  const int to = open(kLog, O_WRONLY | O_CREAT | O_APPEND, 0666);
  const int err = open(kErrors, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  const int from = open("/dev/null", O_RDONLY);
  if (to < 0 || err < 0 || from < 0 || dup2(from, STDIN_FILENO) < 0 ||
      dup2(to, STDOUT_FILENO) < 0 || dup2(err, STDERR_FILENO) < 0) {
    _exit(127);
  }
  execv(arguments[0], arguments);
  _exit(127);
}

std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const size_t newline = text.rfind('\n');
  return newline == std::string::npos ? text : text.substr(newline + 1);
}

// The error of a step, or nothing.
std::string RunStep(const TaskStep& step, const std::string& folder) {
  std::vector<std::string> words = step.arguments;
  words.insert(words.begin(), ProgramOf(step.command));
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string errors = folder + "/" + kErrors;
  const pid_t parent = getpid();
  const pid_t process = fork();
  if (process < 0) throw std::runtime_error("no process can be started");
  if (process == 0) {
    Become(arguments.data(), folder.c_str(), parent);
  }
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  const std::string said = IsFile(errors) ? ReadTextFile(errors) : "";
  InputFiles::Forget(errors);
  unlink(errors.c_str());
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  if (WIFSIGNALED(status)) {
    return "kinegraph-" + step.command + " was ended by signal " +
           std::to_string(WTERMSIG(status));
  }
  return said.empty() ? "kinegraph-" + step.command + " failed without a word"
                      : Printable(LastLine(said), 1000);
}

void WriteText(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

std::string TaskJson(const Task& task) {
  const Machine machine = ThisMachine();
  Json json = {{"kinegraph_task", 1},
               {"take", task.take},
               {"configuration", task.configuration},
               {"fingerprint", task.fingerprint},
               {"commit", machine.commit},
               {"processor", machine.processor}};
  for (const TaskStep& step : task.steps) {
    json["outputs"].push_back(step.output);
  }
  return json.dump(1) + "\n";
}

}  // namespace

TaskState StateOf(const Task& task, const std::string& out) {
  const std::string folder = FolderOf(task, out);
  // Snakemake makes the folder itself, empty.
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

TaskOutcome RunTask(const Task& task, const std::string& out) {
  TaskOutcome outcome;
  try {
    const OutputFolder take_folder(out + "/" + task.take);
    AtomicFolder folder(FolderOf(task, out));
    std::string inside = folder.PathOf("");
    inside.pop_back();  // the slash
    for (const TaskStep& step : task.steps) {
      outcome.error = RunStep(step, inside);
      if (!outcome.error.empty()) break;
    }
    if (outcome.error.empty()) {
      WriteText(folder.PathOf("task.json"), TaskJson(task));
      folder.Commit();
      unlink(FailureFile(task, out).c_str());
      outcome.done = true;
      return outcome;
    }
  } catch (const std::exception& error) {
    outcome.error = error.what();
  }
  // Where two batches share the work, the other one may have been first.
  if (StateOf(task, out) == TaskState::kDone) return {true, ""};
  try {
    const OutputFolder take_folder(out + "/" + task.take);
    WriteText(FailureFile(task, out), outcome.error + "\n");
  } catch (const std::exception&) {  // it is told below all the same
  }
  return outcome;
}

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
