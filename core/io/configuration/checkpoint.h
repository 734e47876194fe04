// Results of pieces of work, kept in a file beside the result while a long run
// is under way, so that one that was ended goes on.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_CHECKPOINT_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_CHECKPOINT_H_

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/piece_store.h"

namespace kinegraph {

// A piece is known by the fingerprint (core/base/bytes.h) of everything that
// its result depends on, so a changed input is a miss and never a wrong result.
// Another build refuses the file. Every piece stands in the file with its
// length and checksum: what a kill has cut off is not there. Safe in threads.
//
//   Checkpoint checkpoint(out + ".checkpoint", build, resume, 10.0);
//   for (piece : work) {
//     auto bytes = checkpoint.Find(key);
//     if (!bytes) checkpoint.Add(key, *(bytes = Compute(piece)));
//   }
//   WriteResult();
//   checkpoint.Remove();
class Checkpoint final : public PieceStore {
 public:
  Checkpoint() = default;  // remembers nothing
  // Nothing is written before `quiet_s` have passed: short work leaves no file
  // behind. With `resume` pieces of an earlier run are found; throws InputError
  // when the file is none, is of another build, or is in use. Without, the
  // file is begun anew. Where none can be written, nothing is kept (trouble()).
  Checkpoint(const std::string& path, const std::string& build, bool resume,
             double quiet_s);
  ~Checkpoint() override;
  Checkpoint(const Checkpoint&) = delete;
  Checkpoint& operator=(const Checkpoint&) = delete;

  bool keeps() const { return !path_.empty(); }
  std::optional<std::string> Find(const std::string& key) override;
  void Add(const std::string& key, std::string value) override;
  // The work is complete.
  void Remove();

  int64_t found_count() const { return found_; }
  // Why nothing is kept, in a few words; empty: all is well.
  std::string trouble();

 private:
  struct Place {
    int64_t offset = 0;
    size_t size = 0;
    uint32_t checksum = 0;
  };

  void ReadExisting();
  bool OpenFile(bool resume);
  bool CanBeUsed(bool resume);
  void Append(const std::string& key, const std::string& value);
  void GiveUp(const std::string& why);

  std::string path_;
  std::string head_;
  double quiet_s_ = 0.0;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point synced_;
  std::mutex mutex_;
  int descriptor_ = -1;
  // Ours, still locked, with nothing added any more.
  int given_up_ = -1;
  std::string given_up_path_;
  int64_t end_ = 0;
  int64_t found_ = 0;
  std::string trouble_;
  std::map<std::string, Place> places_;
  // Added before anything was written.
  std::vector<std::pair<std::string, std::string>> waiting_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_CHECKPOINT_H_
