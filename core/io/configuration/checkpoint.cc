#include "core/io/configuration/checkpoint.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/io/binary/npz_file.h"
#include "core/system/file.h"

namespace kinegraph {
namespace {

constexpr size_t kKeyBytes = 32;  // as Fingerprint::Hex gives it
constexpr size_t kRecordHead = kKeyBytes + sizeof(uint64_t) + sizeof(uint32_t);
constexpr const char* kInUse = "is in use by another run";

}  // namespace

Checkpoint::Checkpoint(const std::string& path, const std::string& build,
                       bool resume, double quiet_s)
    : path_(path),
      head_("kinegraph checkpoint 1\n" + FingerprintOf(build) + "\n"),
      quiet_s_(quiet_s),
      start_(std::chrono::steady_clock::now()) {
  if (!resume) return;
  // Nothing was kept: no file, or one killed between its making and its head.
  const auto status = StatusOf(path);
  if (!status.has_value()) return;
  if (status->kind == FileKind::kRegular && status->size == 0) return;
  if (!OpenFile(/*resume=*/true)) throw InputError(path, "", trouble_);
  ReadExisting();
}

Checkpoint::~Checkpoint() {
  if (descriptor_ >= 0) CloseFile(descriptor_);
  if (given_up_ >= 0) CloseFile(given_up_);
}

// Locked, so that two runs never write into one another's.
bool Checkpoint::OpenFile(bool resume) {
  const int made = resume ? -1 : OpenNew(path_);
  descriptor_ = made >= 0 ? made : OpenToUpdate(path_);
  if (descriptor_ < 0) {
    trouble_ = "cannot be opened: " + std::string(std::strerror(errno));
    return false;
  }
  if (CanBeUsed(resume)) return true;
  // An empty one would be left of a file system that refuses.
  if (made >= 0 && trouble_ != kInUse) RemoveFile(path_);
  CloseFile(descriptor_);
  descriptor_ = -1;
  return false;
}

bool Checkpoint::CanBeUsed(bool resume) {
  const auto status = StatusOf(descriptor_);
  if (!status.has_value()) {
    trouble_ = "cannot be opened: " + std::string(std::strerror(errno));
    return false;
  }
  std::string head;
  const bool regular = status->kind == FileKind::kRegular;
  const bool ours = regular && ReadAt(descriptor_, 0, head_.size(), &head) &&
                    head.compare(0, 23, head_, 0, 23) == 0;
  if (!regular || (status->size > 0 && !ours)) {
    trouble_ = "is no checkpoint of kinegraph";
    return false;
  }
  const LockOutcome lock = LockFile(descriptor_);
  if (lock == LockOutcome::kInUse) {
    trouble_ = kInUse;
  } else if (lock == LockOutcome::kFailed) {
    trouble_ = "cannot be locked: " + std::string(std::strerror(errno));
  } else if (resume && head != head_) {
    trouble_ =
        "was made by another build or on another kind of processor; without "
        "--resume the run begins anew";
  }
  return trouble_.empty();
}

void Checkpoint::ReadExisting() {
  const auto status = StatusOf(descriptor_);
  if (!status.has_value()) return;
  end_ = static_cast<int64_t>(head_.size());
  std::string bytes;
  while (ReadAt(descriptor_, end_, kRecordHead, &bytes)) {
    ByteReader reader(std::string_view(bytes).substr(kKeyBytes));
    Place place;
    const auto size = reader.Get<uint64_t>();
    place.checksum = reader.Get<uint32_t>();
    place.offset = end_ + static_cast<int64_t>(kRecordHead);
    if (size > static_cast<uint64_t>(status->size - place.offset)) break;
    place.size = static_cast<size_t>(size);
    places_[bytes.substr(0, kKeyBytes)] = place;
    end_ = place.offset + static_cast<int64_t>(place.size);
  }
  // What was cut off makes room.
  if (!Truncate(descriptor_, end_)) GiveUp(std::strerror(errno));
}

std::optional<std::string> Checkpoint::Find(const std::string& key) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto at = places_.find(key);
  if (at == places_.end() || descriptor_ < 0) return std::nullopt;
  std::string value;
  if (!ReadAt(descriptor_, at->second.offset, at->second.size, &value) ||
      Crc32(value) != at->second.checksum) {
    places_.erase(at);  // then it is computed
    return std::nullopt;
  }
  ++found_;
  return value;
}

void Checkpoint::Add(const std::string& key, std::string value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (path_.empty() || key.size() != kKeyBytes || places_.count(key) > 0) {
    return;
  }
  waiting_.emplace_back(key, std::move(value));
  const std::chrono::duration<double> age =
      std::chrono::steady_clock::now() - start_;
  if (descriptor_ < 0) {
    if (age.count() < quiet_s_) return;
    if (!OpenFile(/*resume=*/false)) {
      GiveUp(trouble_);
      return;
    }
    if (!Truncate(descriptor_, 0) || !WriteAt(descriptor_, 0, head_)) {
      GiveUp(std::strerror(errno));
      return;
    }
    end_ = static_cast<int64_t>(head_.size());
  }
  const auto waiting = std::exchange(waiting_, {});
  for (const auto& [name, bytes] : waiting) {
    if (descriptor_ >= 0) Append(name, bytes);
  }
}

void Checkpoint::Append(const std::string& key, const std::string& value) {
  const uint32_t checksum = Crc32(value);
  ByteWriter head;
  head.PutSize(value.size());
  head.Put(checksum);
  const int64_t offset = end_ + static_cast<int64_t>(kRecordHead);
  // A killed program loses nothing; a power cut at most the last second.
  const auto now = std::chrono::steady_clock::now();
  const bool sync = now - synced_ > std::chrono::seconds(1);
  if (!WriteAt(descriptor_, end_, key + head.bytes()) ||
      !WriteAt(descriptor_, offset, value) ||
      (sync && !SyncData(descriptor_))) {
    GiveUp(std::strerror(errno));
    return;
  }
  if (sync) synced_ = now;
  places_[key] = {offset, value.size(), checksum};
  end_ = offset + static_cast<int64_t>(value.size());
}

// A checkpoint is a help: without it the work goes on all the same. What is
// in the file already stays good until the work is complete.
void Checkpoint::GiveUp(const std::string& why) {
  trouble_ = why;
  if (descriptor_ >= 0) {
    Truncate(descriptor_, end_);
    given_up_ = std::exchange(descriptor_, -1);
    given_up_path_ = path_;
  }
  path_.clear();
  places_.clear();
  waiting_.clear();
}

void Checkpoint::Remove() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (descriptor_ >= 0) {
    RemoveFile(path_);
    CloseFile(std::exchange(descriptor_, -1));
  }
  if (given_up_ >= 0) {
    RemoveFile(given_up_path_);
    CloseFile(std::exchange(given_up_, -1));
  }
  path_.clear();
  places_.clear();
  waiting_.clear();
}

std::string Checkpoint::trouble() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return trouble_;
}

}  // namespace kinegraph
