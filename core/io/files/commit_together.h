// Several files that appear as one result.
#ifndef KINEGRAPH_CORE_IO_FILES_COMMIT_TOGETHER_H_
#define KINEGRAPH_CORE_IO_FILES_COMMIT_TOGETHER_H_

#include <string>
#include <vector>

namespace kinegraph {

// While it lives, files and folders that this thread commits (AtomicFile,
// AtomicFolder) wait beside their names. Commit() renames them, the first one
// last: whoever finds that one has all of them. Destroyed without Commit(), it
// leaves nothing of them.
//
//   CommitTogether together;
//   WriteTracks(path, ...);
//   WriteSummary(beside, FingerprintOfTracks(together.WaitingAt(path)));
//   together.Commit();
class CommitTogether {
 public:
  CommitTogether();
  ~CommitTogether();
  CommitTogether(const CommitTogether&) = delete;
  CommitTogether& operator=(const CommitTogether&) = delete;

  // Where a file or folder that waits can be read; `path` itself where none
  // does.
  std::string WaitingAt(const std::string& path) const;
  // A file of an earlier result, which goes when this one appears.
  void RemoveOld(const std::string& path) { old_.push_back(path); }
  // Throws std::runtime_error, and takes back what it did, when the system
  // refuses.
  void Commit();

  // For AtomicFile and AtomicFolder: false where nothing waits and they rename
  // by themselves. `path` as the caller named it.
  static bool Take(const std::string& path, const std::string& temporary,
                   const std::string& target);

 private:
  struct Waiting {
    std::string path;
    std::string temporary;
    std::string target;
  };
  void TakeBack(size_t renamed);

  CommitTogether* const outer_;
  std::vector<Waiting> waiting_;
  std::vector<std::string> old_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_COMMIT_TOGETHER_H_
