// Files and folders that appear under their names only when they are complete.
#ifndef KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_
#define KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_

#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace kinegraph {

// Writes beside the final name; Commit() brings the bytes to the disk and
// renames. Destroyed without Commit(), it leaves the final name as it was and
// nothing beside it. What the name may lead to:
//   a regular file     replaced, its permissions kept; refused when it is
//                      read-only or was read by this command (input_files.h)
//   a symbolic link    stays a link; what it names is replaced or made
//   a pipe, a terminal, /dev/null, an open file (/dev/stdout, /dev/fd/3)
//                      written directly, as the bytes come
//   a folder, a block device
//                      refused
//
//   AtomicFile file(path);
//   file.Write(header);
//   for (...) file.Write(line);
//   file.Commit();
class AtomicFile {
 public:
  // Throws InputError for what is refused, and when the folder is missing or
  // may not be written.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Buffered. Throws std::runtime_error (one line, naming the file) when the
  // system refuses, for instance on a full disk.
  void Write(const char* data, size_t size);
  void Write(const std::string& text) { Write(text.data(), text.size()); }

  // Hands over what is buffered: a reader of a pipe has it then.
  void Flush();

  // Makes the file appear. Nothing may be written afterwards.
  void Commit();

  const std::string& path() const { return path_; }

 private:
  std::string path_;       // as the caller named it, for messages
  std::string target_;     // with symbolic links resolved
  std::string temporary_;  // empty: written directly
  std::FILE* file_ = nullptr;
};

// A whole text as a file. Throws as AtomicFile does.
void WriteTextFile(const std::string& path, const std::string& text);

// Whether what is written to `path` arrives on standard output, where nothing
// else may then be printed.
bool IsStandardOutput(const std::string& path);

// Whether `path` leads to standard output, a pipe or a device, beside which no
// other file can stand.
bool IsStream(const std::string& path);

// Files are written into a folder beside the final name, which Commit()
// renames. Destroyed without Commit(), it leaves nothing. A folder that holds
// files already is never replaced: who knows what else is in it.
//
//   AtomicFolder folder(path);
//   WriteSomething(folder.PathOf("a.txt"));
//   folder.Commit();
class AtomicFolder {
 public:
  // Throws InputError when `path` is there and is no empty folder, or when no
  // folder can be made beside it.
  explicit AtomicFolder(const std::string& path);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  // Where a file or folder of the result is to be written.
  std::string PathOf(const std::string& name) const {
    return temporary_ + "/" + name;
  }

  // Makes the folder appear. Throws std::runtime_error when it cannot.
  void Commit();

 private:
  std::string target_;
  std::string temporary_;
  bool committed_ = false;
};

// A folder that is filled file by file and may be there already, with other
// things in it. Of the folders that had to be made, those in which nothing was
// put are gone when the object dies.
class OutputFolder {
 public:
  // Makes the folder and those above it. Throws InputError naming `path`.
  explicit OutputFolder(const std::string& path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  std::string PathOf(const std::string& name) const {
    return path_ + "/" + name;
  }

 private:
  void RemoveEmpty();

  const std::string path_;
  std::vector<std::string> made_;  // from the outermost on
};

// Throws InputError naming `what` ("view") when `name` cannot be the name of a
// file: empty, hidden, with a slash or a control character, or too long.
void CheckFileName(const std::string& name, const std::string& what);

// Several files or folders that appear as one result. They are written under
// their own names in a folder beside them; Commit() renames them, the first one
// last, so that whoever finds a new one there finds the rest of its result.
// Destroyed without Commit(), it leaves nothing. A process that is killed
// between two renames leaves new files beside the old first one, which is why
// each of them carries a fingerprint of the first (side_files.h).
//
//   AtomicFiles files;
//   WriteTracks(files.Aside(path), ...);
//   WriteSummary(files.Aside(beside), FingerprintOfTracks(files.Aside(path)));
//   files.Commit();
class AtomicFiles {
 public:
  AtomicFiles() = default;
  ~AtomicFiles();
  AtomicFiles(const AtomicFiles&) = delete;
  AtomicFiles& operator=(const AtomicFiles&) = delete;

  // Where what appears as `path` is to be written; the same place each time. A
  // stream has no place aside and is returned as it is. Throws as the
  // constructors of AtomicFile and AtomicFolder, so the first call belongs
  // before the work.
  std::string Aside(const std::string& path);
  std::string FolderAside(const std::string& path);

  // A file of an earlier result: it goes before anything is renamed.
  void RemoveOld(const std::string& path);

  // A name under which nothing was written stays as it was. Throws
  // std::runtime_error when the system refuses.
  void Commit();

 private:
  struct Waiting {
    std::string path;  // as the caller named it, for messages
    std::string temporary;
    std::string target;
  };
  std::string AsideOf(const std::string& path, const std::string& target);

  std::vector<Waiting> waiting_;
  std::map<std::string, std::string> aside_;  // by the folder it is in
  std::vector<std::string> old_;
};

// For a program that must end now: removes all that is being written and does
// not have its final name yet. No file is made or renamed any more; who tries
// waits for ever.
void RemovePartialFilesForGood();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_
