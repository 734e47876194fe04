// Files and folders that appear under their names only when they are complete.
#ifndef KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_
#define KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_

#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace kinegraph {

// Writes a temporary file beside the final name; Commit() flushes it to disk
// and renames it. If destroyed without Commit(), the target is unchanged and no
// temporary file remains. The name may refer to:
//   a regular file     replaced, its permissions kept; refused when it is
//                      read-only or was read by this command (input_files.h)
//   a symbolic link    stays a link; its target is replaced or created
//   a pipe, a terminal, /dev/null, an open file (/dev/stdout, /dev/fd/3)
//                      written directly, without a temporary file
//   a folder, a block device
//                      refused
//
//   AtomicFile file(path);
//   file.Write(header);
//   for (...) file.Write(line);
//   file.Commit();
class AtomicFile {
 public:
  // Throws InputError for refused targets, and if the folder is missing or not
  // writable.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Buffered write. Throws std::runtime_error (one line, naming the file) on
  // failure, for instance if the disk is full.
  void Write(const char* data, size_t size);
  void Write(const std::string& text) { Write(text.data(), text.size()); }

  // Writes buffered data, for the reader of a pipe.
  void Flush();

  // Makes the file appear. Nothing may be written afterwards. Throws like
  // Write, and InputError if this command has read the target meanwhile.
  void Commit();

  const std::string& path() const { return path_; }

 private:
  std::string path_;       // as the caller named it, for messages
  std::string target_;     // with symbolic links resolved
  std::string temporary_;  // empty: written directly
  std::FILE* file_ = nullptr;
};

// Writes a text as a file. Throws what AtomicFile throws.
void WriteTextFile(const std::string& path, const std::string& text);

// Whether `path` refers to standard output. If so, nothing else may be printed
// to it.
bool IsStandardOutput(const std::string& path);

// Whether `path` refers to standard output, a pipe or a device, for which no
// side files can be written.
bool IsStream(const std::string& path);

// Files are written into a temporary folder beside the final name; Commit()
// renames it. If destroyed without Commit(), nothing remains. A folder that is
// not empty is never replaced, because it may contain other data.
//
//   AtomicFolder folder(path);
//   WriteSomething(folder.PathOf("a.txt"));
//   folder.Commit();
class AtomicFolder {
 public:
  // Throws InputError if `path` exists and is not an empty folder, or if no
  // folder can be created beside it.
  explicit AtomicFolder(const std::string& path);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  // Path at which to write a file or folder of the result.
  std::string PathOf(const std::string& name) const {
    return temporary_ + "/" + name;
  }

  // Makes the folder appear. Throws std::runtime_error on failure.
  void Commit();

 private:
  std::string target_;
  std::string temporary_;
  bool committed_ = false;
};

// A folder to which files are written one by one; it may already exist and
// contain other files. Created folders that remain empty are removed on
// destruction.
class OutputFolder {
 public:
  // Creates the folder and its parents. Throws InputError naming `path` if one
  // cannot be created or is a file.
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
  std::vector<std::string> made_;  // outermost first
};

// Throws InputError naming `what` ("view") if `name` is not a valid file name:
// empty, hidden, with a slash or a control character, or longer than 200 bytes.
void CheckFileName(const std::string& name, const std::string& what);

// Several files or folders that appear as one result. They are written under
// their own names into temporary folders beside the targets. Commit() renames
// the main file, the one requested first, after all others: if it is new, they
// are new, too. If destroyed without Commit(), nothing remains. A process that
// is killed between two renames leaves the old main file beside new others;
// callers therefore store a fingerprint of the main file in each of the others
// (side_files.h).
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

  // Path at which to write the file that will appear as `path`; the same on
  // every call. For a stream or an open file (/dev/fd/3) it is `path` itself.
  // Throws what the constructors of AtomicFile and AtomicFolder throw, so call
  // it before the computation.
  std::string Aside(const std::string& path);
  std::string FolderAside(const std::string& path);

  // Marks a file of an earlier result, which Commit() removes before it
  // renames.
  void RemoveOld(const std::string& path);

  // Makes the files appear; targets for which no file was written remain
  // unchanged. Throws std::runtime_error on failure, and InputError if this
  // command has read a target meanwhile.
  void Commit();

 private:
  struct Waiting {
    std::string path;  // as the caller named it, for messages
    std::string temporary;
    std::string target;
  };
  std::string AsideOf(const std::string& path, const std::string& target);

  std::vector<Waiting> waiting_;
  std::map<std::string, std::string> aside_;  // by folder
  std::vector<std::string> old_;
};

// For a program that is about to end: removes the temporary files and folders
// of all objects above. Afterwards these can neither create nor rename files;
// attempts block forever.
void RemovePartialFilesForGood();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_
