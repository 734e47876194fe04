#include "core/system/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>
#include <ctime>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

extern char** environ;

namespace kinegraph {
namespace {

// The argument list of exec, whose elements are not const.
std::vector<char*> Pointers(std::vector<std::string>* words) {
  std::vector<char*> pointers;
  for (std::string& word : *words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

// Replaces the process by a program; returns on failure, with the reason in
// errno. Runs between fork and exec, so it may only call async-signal-safe
// functions.
void Become(char* const* arguments, const char* folder, const char* printed,
            const char* errors, pid_t parent) {
  // The kernel ends the program when its parent dies.
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  if (chdir(folder) != 0) return;
  const int to = open(printed, O_WRONLY | O_CREAT | O_APPEND, 0666);
  const int err = open(errors, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  const int from = open("/dev/null", O_RDONLY);
  if (to < 0 || err < 0 || from < 0 || dup2(from, STDIN_FILENO) < 0 ||
      dup2(to, STDOUT_FILENO) < 0 || dup2(err, STDERR_FILENO) < 0) {
    return;
  }
  execv(arguments[0], arguments);
}

// Starts a program by its name, with these descriptors as its standard streams;
// `input` -1: no input. Returns 0 or the reason of the failure, an errno.
int Start(std::vector<std::string>* words, int input, int output, int errors,
          char* const* environment, pid_t* process) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (input < 0) {
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null",
                                     O_RDONLY, 0);
  } else {
    posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  }
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors, STDERR_FILENO);
  const std::vector<char*> arguments = Pointers(words);
  const int reason = posix_spawnp(process, arguments[0], &actions, nullptr,
                                  arguments.data(), environment);
  posix_spawn_file_actions_destroy(&actions);
  return reason;
}

ProcessEnd EndOf(int status) {
  ProcessEnd end;
  if (WIFEXITED(status)) end.code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  return end;
}

ProcessEnd WaitFor(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno == EINTR) continue;
    ProcessEnd unknown;
    unknown.not_started = errno;
    return unknown;
  }
  return EndOf(status);
}

// The programs of RunningProgram, which EndBySignal ends.
std::mutex programs_mutex;

std::vector<pid_t>& Programs() {
  static std::vector<pid_t>* const programs = new std::vector<pid_t>();
  return *programs;
}

void Forget(pid_t program) {
  auto& programs = Programs();
  programs.erase(std::remove(programs.begin(), programs.end(), program),
                 programs.end());
}

}  // namespace

bool ProcessEnd::broke_pipe() const { return signal == SIGPIPE; }

int ProcessNumber() { return getpid(); }

std::string ProgramPath() {
  char buffer[PATH_MAX];
  const ssize_t length = readlink("/proc/self/exe", buffer, sizeof(buffer));
  return length > 0 ? std::string(buffer, static_cast<size_t>(length)) : "";
}

ProcessEnd RunInFolder(std::vector<std::string> words,
                       const std::string& folder, const char* printed,
                       const char* errors) {
  const std::vector<char*> arguments = Pointers(&words);
  ProcessEnd failed;
  // Carries the child's errno; closed by exec.
  int failure[2];
  if (pipe2(failure, O_CLOEXEC) != 0) {
    failed.not_started = errno;
    return failed;
  }
  const pid_t parent = getpid();
  const pid_t process = fork();
  if (process == 0) {
    Become(arguments.data(), folder.c_str(), printed, errors, parent);
    const int reason = errno;
    [[maybe_unused]] const ssize_t written =
        write(failure[1], &reason, sizeof(reason));
    _exit(127);
  }
  if (process < 0) failed.not_started = errno;
  close(failure[1]);
  int reason = 0;
  ssize_t length = 0;
  do {
    length = read(failure[0], &reason, sizeof(reason));
  } while (process > 0 && length < 0 && errno == EINTR);
  close(failure[0]);
  if (process < 0) return failed;
  const ProcessEnd end = WaitFor(process);
  if (length != sizeof(reason)) return end;
  failed.not_started = reason;
  return failed;
}

ProcessEnd RunWithStreams(std::vector<std::string> words, std::FILE* input,
                          std::FILE* output, std::FILE* errors,
                          const std::string& setting) {
  const std::string name = setting.substr(0, setting.find('=') + 1);
  std::vector<std::string> settings;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string one = *entry;
    if (one.rfind(name, 0) != 0) settings.push_back(one);
  }
  settings.push_back(setting);
  pid_t process = 0;
  ProcessEnd none;
  none.not_started =
      Start(&words, fileno(input), fileno(output), fileno(errors),
            Pointers(&settings).data(), &process);
  return none.not_started != 0 ? none : WaitFor(process);
}

RunningProgram::RunningProgram(std::vector<std::string> words, int input,
                               int output, int errors) {
  pid_t process = 0;
  end_.not_started = Start(&words, input, output, errors, environ, &process);
  if (end_.not_started != 0) return;
  process_ = process;
  const std::lock_guard<std::mutex> lock(programs_mutex);
  Programs().push_back(static_cast<pid_t>(process_));
}

RunningProgram::~RunningProgram() { Wait(0); }

ProcessEnd RunningProgram::Wait(int most_ms) {
  const auto process = static_cast<pid_t>(process_);
  for (int waited_ms = 0; process_ != 0; ++waited_ms) {
    int status = 0;
    pid_t ended = 0;
    {
      // After waitpid the system may give the process number to another
      // program, which EndBySignal must not end.
      const std::lock_guard<std::mutex> lock(programs_mutex);
      ended = waitpid(process, &status, WNOHANG);
      if (ended != 0 && !(ended < 0 && errno == EINTR)) Forget(process);
    }
    if (ended == process) {
      end_ = EndOf(status);
      process_ = 0;
    } else if (ended < 0 && errno != EINTR) {
      // Its exit code is lost: something else in this process waited for it.
      end_.not_started = errno;
      process_ = 0;
    } else if (waited_ms >= most_ms) {
      kill(process, SIGKILL);
      const std::lock_guard<std::mutex> lock(programs_mutex);
      end_ = WaitFor(process);
      Forget(process);
      was_ended_ = true;
      process_ = 0;
    } else {
      const timespec moment = {0, 1'000'000};
      nanosleep(&moment, nullptr);
    }
  }
  return end_;
}

std::string FirstLineOf(const std::string& command) {
  const auto close = [](std::FILE* pipe) { pclose(pipe); };
  const std::unique_ptr<std::FILE, decltype(close)> pipe(
      popen(command.c_str(), "r"), close);
  char line[256] = "";
  if (pipe == nullptr ||
      std::fgets(line, sizeof(line), pipe.get()) == nullptr) {
    return "";
  }
  std::string text = line;
  text.erase(text.find_last_not_of("\r\n") + 1);
  return text;
}

void KeepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // glibc's maximum
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
}

int64_t ThreadCpuNs() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

// Signal handlers may call few functions, so the handler only writes the
// signal's number to a pipe.
int signal_pipe[2] = {-1, -1};

void PassOn(int signal_number) {
  const int reason = errno;
  const auto number = static_cast<unsigned char>(signal_number);
  // A full pipe already contains a signal.
  [[maybe_unused]] const ssize_t written = write(signal_pipe[1], &number, 1);
  errno = reason;
}

}  // namespace

void CatchSignals(const std::function<void()>& thread) {
  std::signal(SIGXFSZ, SIG_IGN);
  if (pipe2(signal_pipe, O_CLOEXEC | O_NONBLOCK) != 0) return;
  fcntl(signal_pipe[0], F_SETFL, 0);  // reading blocks
  try {
    std::thread(thread).detach();
  } catch (const std::system_error&) {
    return;  // without a thread the signals keep their default action
  }
  for (const int number : kSignals) {
    struct sigaction present {};
    sigaction(number, nullptr, &present);
    if (present.sa_handler != SIG_DFL) continue;
    struct sigaction action {};
    action.sa_handler = PassOn;
    action.sa_flags = SA_RESTART;
    sigaction(number, &action, nullptr);
  }
}

int NextSignal() {
  unsigned char number = 0;
  while (read(signal_pipe[0], &number, 1) != 1) {
    if (errno != EINTR) return 0;
  }
  return number;
}

const char* SignalName(int number) {
  switch (number) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    default:
      return "SIGHUP";
  }
}

void EndBySignal(int number) {
  {
    const std::lock_guard<std::mutex> lock(programs_mutex);
    for (const pid_t program : Programs()) kill(program, SIGTERM);
  }
  std::signal(number, SIG_DFL);
  // Any thread may receive the signal, whose default action ends the process;
  // until then this thread waits.
  kill(getpid(), number);
  while (true) pause();
}

}  // namespace kinegraph
