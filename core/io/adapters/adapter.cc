#include "core/io/adapters/adapter.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/input_files.h"
#include "core/io/files/text_file.h"
#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOwnProgram = "kinegraph-adapters";
constexpr int kRecognise_ms = 30'000;
constexpr int kSilence_ms = 60'000;

// Set before anything is read.
struct Settings {
  std::string given;             // SetAdapter; empty: none
  std::vector<std::string> own;  // SetOwnAdapters; empty: the default
};
Settings& TheSettings() {
  static Settings* const settings = new Settings;
  return *settings;
}

std::vector<std::string> OwnCommand() {
  if (!TheSettings().own.empty()) return TheSettings().own;
  const fs::path beside = fs::path(ProgramPath()).parent_path() / kOwnProgram;
  return {IsFile(beside.string()) ? beside.string() : kOwnProgram};
}

std::string WithoutSlash(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  // The adapter must not take the name for a flag or a URL.
  const bool is_plain =
      path.rfind('-', 0) != 0 &&
      (path.rfind('/', 0) == 0 || path.find(':') == std::string::npos);
  return is_plain ? path : "./" + path;
}

// A pipe whose other end is passed to a program.
struct Pipe {
  Pipe() {
    int both[2];
    if (!MakePipe(both)) throw InputError("no pipe can be made");
    read = both[0];
    write = both[1];
  }
  ~Pipe() {
    Close(&read);
    Close(&write);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  static void Close(int* end) {
    if (*end >= 0) CloseFile(*end);
    *end = -1;
  }
  int read = -1;
  int write = -1;
};

// Reads to the end, or until there are more than `most` bytes; false after
// `silence_ms` without input.
bool ReadAll(int descriptor, int silence_ms, size_t most, std::string* text) {
  char buffer[1 << 14];
  while (HasInput(descriptor, silence_ms)) {
    const int64_t got = ReadSome(descriptor, buffer, sizeof buffer);
    if (got <= 0) return true;
    text->append(buffer, static_cast<size_t>(got));
    if (text->size() > most) return true;
  }
  return false;
}

// A temporary file for a program's standard error.
using ErrorsFile = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

// The last line of a program's standard error that is not empty.
std::string LastLine(std::FILE* file) {
  std::string text;
  std::rewind(file);
  char buffer[1 << 12];
  while (const size_t got = std::fread(buffer, 1, sizeof buffer, file)) {
    text.append(buffer, got);
    if (text.size() > sizeof buffer) text.erase(0, text.size() - sizeof buffer);
  }
  const size_t end = text.find_last_not_of(" \r\n\t");
  if (end == std::string::npos) return "";
  text.resize(end + 1);
  return text.substr(text.find_last_of('\n') + 1);
}

// The error of a program that has ended; empty if it succeeded.
std::string Fault(const ProcessEnd& end, const std::string& name,
                  const std::string& hint, const std::string& said) {
  if (end.not_started != 0) {
    return "requires " + name + ", which cannot be started (" +
           std::strerror(end.not_started) + ")" +
           (hint.empty() ? "" : ": " + hint);
  }
  if (end.signal != 0) {
    return "its adapter (" + name + ") was ended by signal " +
           std::to_string(end.signal) +
           ": the file may be damaged, or too large for the memory";
  }
  if (end.code == 0) return "";
  if (!said.empty()) return said;
  return "its adapter (" + name + ") ended with code " +
         std::to_string(end.code);
}

// Throws InputError; prepends the path unless the message begins with it.
[[noreturn]] void Throw(const std::string& path, const std::string& fault) {
  if (fault.rfind(path, 0) == 0) throw InputError(fault);
  throw InputError(path, "", fault);
}

[[noreturn]] void ThrowSilent(const std::string& path, int silence_ms) {
  throw InputError(path, "",
                   "its adapter has printed nothing for " +
                       std::to_string(silence_ms / 1000) + " s");
}

[[noreturn]] void ThrowEndless(const std::string& path,
                               const std::string& name) {
  throw InputError(path, "", "its adapter (" + name + ") does not end");
}

// Whether kinegraph's adapters read files of this extension in a folder. Other
// files in the folder, such as older results, are not inputs.
bool MayBeInput(const fs::path& file) {
  const std::string extension = file.extension().string();
  for (const char* one : {".csv", ".h5", ".pickle", ".toml"}) {
    if (extension == one) return true;
  }
  return false;
}

// Calls `visit` for the files in a folder and its subfolders, level by level.
// Ends after kMostEntries files and folders, so that a huge tree does not delay
// the command. Skips folders that cannot be listed, which the adapter cannot
// read either, and links to folders.
template <typename Visit>
void ForEachFile(const std::string& path, const Visit& visit) {
  // Visits path/a/b/c/d/FILE, but not path/a/b/c/d/e/FILE. The deepest that
  // kinegraph's adapters read is Caliscope's path/recordings/b/c/d/FILE.
  constexpr int kDeepest = 4;
  constexpr int kMostEntries = 1 << 18;
  int entries = 0;
  std::vector<fs::path> folders = {path};
  for (int depth = 0; depth <= kDeepest; ++depth) {
    std::vector<fs::path> inside;
    for (const fs::path& folder : folders) {
      std::error_code error;
      for (fs::directory_iterator at(folder, error), end; at != end;
           at.increment(error)) {
        if (++entries > kMostEntries) return;
        std::error_code none;
        if (at->is_regular_file(none)) {
          visit(at->path());
        } else if (at->is_directory(none) && !at->is_symlink(none)) {
          inside.push_back(at->path());
        }
      }
    }
    folders = std::move(inside);
  }
}

// Notes the input files, so that they are not overwritten and changes to them
// are detected. In a folder, a user's adapter may read any file, so all files
// of ForEachFile are noted, up to the limit of InputFiles. Returns the size of
// the noted files in bytes.
int64_t NoteInputs(const std::string& path, bool is_own) {
  int64_t size = 0;
  size_t files = 0;
  const auto note = [&](const std::string& file) {
    if (++files > InputFiles::kMaxFiles) return;
    const Descriptor opened(OpenToRead(file));
    if (opened.get() < 0) return;
    InputFiles::Note(opened.get(), file);
    if (const auto status = StatusOf(opened.get())) size += status->size;
  };
  if (!IsFolder(path)) {
    note(path);
    return size;
  }
  ForEachFile(path, [&](const fs::path& file) {
    if (!is_own || MayBeInput(file)) note(file.string());
  });
  return size;
}

std::optional<AdapterKind> ParseKind(const std::string& word) {
  if (word == "cameras") return AdapterKind::kCameras;
  if (word == "detections") return AdapterKind::kDetections;
  if (word == "tracks") return AdapterKind::kTracks;
  return std::nullopt;
}

// Runs a program to its end; nullopt if it had to be killed.
std::optional<ProcessEnd> Run(std::vector<std::string> words,
                              std::string* printed, std::string* said) {
  Pipe pipe;
  const ErrorsFile errors(std::tmpfile(), std::fclose);
  if (errors == nullptr) throw InputError("no temporary file can be made");
  RunningProgram program(std::move(words), -1, pipe.write,
                         DescriptorOf(errors.get()));
  Pipe::Close(&pipe.write);
  constexpr size_t kMost = 1 << 16;
  const bool came = ReadAll(pipe.read, kRecognise_ms, kMost, printed);
  const ProcessEnd end = program.Wait(came ? kRecognise_ms : 0);
  *said = LastLine(errors.get());
  if (program.was_ended()) return std::nullopt;
  return end;
}

// Runs a program with --recognise and parses its answer, such as "detections
// sleap".
std::optional<Adapter> Asked(std::vector<std::string> command,
                             const std::string& path, bool is_own) {
  std::vector<std::string> words = command;
  words.insert(words.end(), {"--recognise", WithoutSlash(path)});
  std::string printed;
  std::string said;
  const auto ended = Run(std::move(words), &printed, &said);
  if (!ended.has_value()) {
    Throw(path, "cannot be recognised: " + command.front() +
                    " did not answer --recognise within " +
                    std::to_string(kRecognise_ms / 1000) + " s");
  }
  const ProcessEnd& end = *ended;
  // A user's program that fails does not recognise the file. kinegraph-adapters
  // fails only on an error. If it is not installed, it recognises nothing: many
  // files can be read without it.
  if (end.not_started != 0 && !is_own) {
    throw InputError(
        "--adapter", command.front(),
        std::string("cannot be started: ") + std::strerror(end.not_started));
  }
  if (end.code != 0 && is_own && !said.empty()) Throw(path, said);
  if (!end.well()) return std::nullopt;
  printed.erase(
      std::min(printed.find_last_not_of(" \r\n") + 1, printed.size()));
  const size_t space = printed.find(' ');
  const auto kind = ParseKind(printed.substr(0, space));
  if (!kind.has_value()) return std::nullopt;
  Adapter adapter = {std::move(command), *kind, "", ""};
  adapter.name = space == std::string::npos ? adapter.command.back()
                                            : printed.substr(space + 1);
  if (is_own) adapter.command.push_back("--format=" + adapter.name);
  return adapter;
}

// Caches a program's answer on a path until the file changes.
std::optional<Adapter> AskedOnce(const std::vector<std::string>& command,
                                 const std::string& path, bool is_own) {
  using Key = std::pair<std::vector<std::string>, std::string>;
  struct Answer {
    std::pair<int64_t, int64_t> changed;
    std::optional<Adapter> adapter;
  };
  static std::mutex mutex;
  static auto* const answers = new std::map<Key, Answer>;
  const auto status = StatusOf(path);
  if (!status.has_value() || status->kind == FileType::kOther) {
    return std::nullopt;  // a pipe cannot be inspected before it is read
  }
  const std::lock_guard<std::mutex> lock(mutex);
  const auto known = answers->find({command, path});
  if (known != answers->end() && known->second.changed == status->changed) {
    return known->second.adapter;
  }
  const std::optional<Adapter> adapter = Asked(command, path, is_own);
  (*answers)[{command, path}] = {status->changed, adapter};
  return adapter;
}

std::optional<Adapter> Only(const std::optional<Adapter>& adapter,
                            AdapterKind kind) {
  if (!adapter.has_value() || adapter->kind != kind) return std::nullopt;
  return adapter;
}

}  // namespace

void SetAdapter(const std::string& program) {
  // The user means a file, so a bare name is not searched in PATH.
  TheSettings().given =
      program.empty() || program.find('/') != std::string::npos
          ? program
          : "./" + program;
}

void SetOwnAdapters(const std::vector<std::string>& command) {
  TheSettings().own = command;
}

std::optional<Adapter> GivenAdapterOf(const std::string& path) {
  if (TheSettings().given.empty()) return std::nullopt;
  return AskedOnce({TheSettings().given}, path, /*is_own=*/false);
}

std::optional<Adapter> AdapterOf(const std::string& path) {
  if (auto given = GivenAdapterOf(path)) return given;
  return AskedOnce(OwnCommand(), path, /*is_own=*/true);
}

std::optional<Adapter> GivenAdapterOf(const std::string& path,
                                      AdapterKind kind) {
  return Only(GivenAdapterOf(path), kind);
}

std::optional<Adapter> AdapterOf(const std::string& path, AdapterKind kind) {
  return Only(AdapterOf(path), kind);
}

Adapter OwnAdapter(const std::string& format, AdapterKind kind) {
  Adapter adapter = {OwnCommand(), kind, format, ""};
  adapter.command.push_back("--format=" + format);
  return adapter;
}

// ---- Reading ----

class AdapterRun::Impl {
 public:
  Impl(const Adapter& adapter, const std::string& path,
       const std::vector<std::string>& options, int silence_ms)
      : path_(WithoutSlash(path)),
        name_(adapter.name),
        hint_(adapter.hint),
        // kinegraph-adapters names the programs in a user's folder by path.
        is_own_(adapter.command.front() != TheSettings().given &&
                adapter.name.find('/') == std::string::npos),
        silence_ms_(silence_ms),
        errors_(std::tmpfile(), std::fclose) {
    if (errors_ == nullptr) {
      throw InputError(path_, "", "no temporary file can be made to read it");
    }
    if (!StatusOf(path_).has_value()) {
      throw InputError(path_, "", "cannot be read");
    }
    const int64_t size = NoteInputs(path_, is_own_);
    if (silence_ms_ < 0) {
      constexpr int64_t kMost_s = 3600;
      silence_ms_ =
          kSilence_ms + 1000 * static_cast<int>(std::min(size >> 20, kMost_s));
    }
    std::vector<std::string> words = adapter.command;
    words.insert(words.end(), options.begin(), options.end());
    words.push_back(path_);
    program_ = std::make_unique<RunningProgram>(
        std::move(words), -1, pipe_.write, DescriptorOf(errors_.get()));
    Pipe::Close(&pipe_.write);
  }

  // The caller owns the descriptor from here on.
  int TakeOutput() { return std::exchange(pipe_.read, -1); }
  int silence_ms() const { return silence_ms_; }

  void Finish() {
    ThrowItsFault(/*reader_stopped=*/false);
    if (program_->was_ended()) ThrowEndless(path_, name_);
    NoteInputs(path_, is_own_);
  }

  void ThrowItsFault(bool reader_stopped) {
    // A program normally exits soon after its last output.
    constexpr int kEnd_ms = 2000;
    const ProcessEnd end = program_->Wait(kEnd_ms);
    if (program_->was_ended()) return;
    // The reader stopped because of an error of its own, which it throws; only
    // this broke the pipe.
    if (reader_stopped && end.broke_pipe()) return;
    const std::string fault = Fault(end, name_, hint_, LastLine(errors_.get()));
    if (!fault.empty()) Throw(path_, fault);
  }

 private:
  const std::string path_;
  const std::string name_;
  const std::string hint_;
  const bool is_own_;
  int silence_ms_;
  const ErrorsFile errors_;
  Pipe pipe_;
  std::unique_ptr<RunningProgram> program_;
};

AdapterRun::AdapterRun(const Adapter& adapter, const std::string& path,
                       const std::vector<std::string>& options, int silence_ms)
    : impl_(std::make_unique<Impl>(adapter, path, options, silence_ms)) {}
AdapterRun::~AdapterRun() = default;
int AdapterRun::TakeOutput() { return impl_->TakeOutput(); }
int AdapterRun::silence_ms() const { return impl_->silence_ms(); }
void AdapterRun::Finish() { impl_->Finish(); }
void AdapterRun::ThrowItsFault() {
  impl_->ThrowItsFault(/*reader_stopped=*/true);
}

std::string OutputOf(const Adapter& adapter, const std::string& path) {
  AdapterRun run(adapter, path);
  const Descriptor output(run.TakeOutput());
  std::string text;
  if (!ReadAll(output.get(), run.silence_ms(), kMaxSmallFileBytes, &text)) {
    ThrowSilent(path, run.silence_ms());
  }
  if (text.size() > kMaxSmallFileBytes) {
    throw InputError(path, "", "its adapter prints more than 64 MiB");
  }
  run.Finish();
  return text;
}

// ---- Writing ----

std::string WriteByAdapter(
    const std::string& format, const std::string& path,
    const std::function<void(const std::string& lines)>& write,
    int silence_ms) {
  const ErrorsFile errors(std::tmpfile(), std::fclose);
  if (errors == nullptr) {
    throw InputError(path, "", "no temporary file can be made to write it");
  }
  Pipe input;
  Pipe output;
  std::vector<std::string> words = OwnCommand();
  words.push_back("--write=" + format);
  RunningProgram program(std::move(words), input.read, output.write,
                         DescriptorOf(errors.get()));
  Pipe::Close(&input.read);
  Pipe::Close(&output.write);
  std::string bytes;
  const auto throw_its_fault = [&](const ProcessEnd& end) {
    const std::string fault =
        Fault(end, kOwnProgram, "", LastLine(errors.get()));
    if (!fault.empty()) Throw(path, fault);
  };
  try {
    const BrokenPipesAreErrors broken_pipes_are_errors;
    // The program reads all input before it prints, so this cannot deadlock.
    write(FolderOfOpenFiles() + "/" + std::to_string(input.write));
  } catch (const std::exception&) {
    // If the program has ended, the pipe broke because of its error.
    constexpr int kMoment_ms = 200;
    const ProcessEnd end = program.Wait(kMoment_ms);
    if (!program.was_ended()) throw_its_fault(end);
    throw;
  }
  Pipe::Close(&input.write);
  constexpr size_t kMost = size_t{4} << 30;
  const bool came = ReadAll(output.read, silence_ms, kMost, &bytes);
  if (bytes.size() > kMost) {
    throw InputError(path, "", "its adapter prints more than 4 GiB");
  }
  const ProcessEnd end =
      program.Wait(came ? std::min(silence_ms, kSilence_ms) : 0);
  if (!program.was_ended()) throw_its_fault(end);
  if (!came) ThrowSilent(path, silence_ms);
  if (program.was_ended()) ThrowEndless(path, kOwnProgram);
  return bytes;
}

}  // namespace kinegraph
