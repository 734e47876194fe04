#include "core/io/files/side_files.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "core/base/error.h"
#include "core/io/files/folder_entry.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// A 128-bit hash of contents (not cryptographic): FNV-1a, and a second hash
// with an addition, a multiplication and a shift per byte, which is unlikely to
// collide for the same contents as the first.
class Fingerprint {
 public:
  void Add(std::string_view bytes) {
    for (const char c : bytes) {
      const auto byte = static_cast<unsigned char>(c);
      a_ = (a_ ^ byte) * 0x100000001b3u;
      b_ = (b_ + byte + 1) * 0xd6e8feb86659fd93u;
      b_ ^= b_ >> 29;
    }
  }

  std::string Hex() const {  // 32 digits
    char text[33];
    std::snprintf(text, sizeof(text), "%016llx%016llx",
                  static_cast<unsigned long long>(a_),
                  static_cast<unsigned long long>(b_));
    return text;
  }

 private:
  uint64_t a_ = 0xcbf29ce484222325u;
  uint64_t b_ = 0x9e3779b97f4a7c15u;
};

// The value of kFingerprintKey if it is the first key of the text's object;
// otherwise empty.
std::string FingerprintAtHead(const std::string& text) {
  constexpr size_t kDigits = 32;
  constexpr const char* kSpace = " \t\r\n";
  const std::string key = std::string("\"") + kFingerprintKey + "\"";
  size_t at = text.find_first_not_of(kSpace);
  if (at == std::string::npos || text[at] != '{') return "";
  at = text.find_first_not_of(kSpace, at + 1);
  if (at == std::string::npos || text.compare(at, key.size(), key) != 0) {
    return "";
  }
  at = text.find('"', at + key.size());
  if (at == std::string::npos) return "";
  const size_t end = text.find('"', at + 1);
  return end == at + 1 + kDigits ? text.substr(at + 1, kDigits) : "";
}

}  // namespace

std::string BesideTracks(const std::string& tracks_path,
                         const std::string& end) {
  const std::string path =
      tracks_path.substr(0, tracks_path.find_last_not_of('/') + 1);
  const size_t folder = path.find_last_of('/') + 1;  // npos + 1 is 0
  const size_t dot = path.find_last_of('.');
  const bool has_extension = dot != std::string::npos && dot > folder;
  return (has_extension ? path.substr(0, dot) : path) + end;
}

std::string FingerprintOfTracks(const std::string& path) {
  Fingerprint fingerprint;
  const auto add = [&](std::string_view bytes) { fingerprint.Add(bytes); };
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    ForEachBlock(path, add);
    return fingerprint.Hex();
  }
  std::vector<fs::path> files;
  ForEachEntry(path, [&](const fs::directory_entry& entry) {
    const fs::file_type type = entry.status(error).type();
    if (type == fs::file_type::none) {  // unknown; a dangling link is not_found
      throw InputError(entry.path().string(), "",
                       "cannot be read: " + error.message());
    }
    if (type == fs::file_type::regular) files.push_back(entry.path());
  });
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    fingerprint.Add(file.filename().string() + '\0');
    ForEachBlock(file.string(), add);
  }
  return fingerprint.Hex();
}

std::string WithFingerprint(const std::string& object,
                            const std::string& fingerprint) {
  if (fingerprint.empty()) return object;
  const size_t begin = object.find('{') + 1;
  const bool is_empty =
      object.find_first_not_of(" \n", begin) == object.find('}', begin);
  return object.substr(0, begin) + "\"" + kFingerprintKey + "\": \"" +
         fingerprint + "\"" + (is_empty ? "" : ", ") + object.substr(begin);
}

bool IsFingerprintLine(const std::string& line) {
  return !FingerprintAtHead(line).empty();
}

std::string FingerprintIn(const std::string& path) {
  try {
    return FingerprintAtHead(FirstBytes(path, 256));
  } catch (const InputError&) {
    return "";
  }
}

std::string SideFileOf(const std::string& tracks_path, const std::string& end,
                       std::vector<std::string>* notes) {
  const std::string path = BesideTracks(tracks_path, end);
  if (!IsFile(path)) return "";
  const std::string found = FingerprintIn(path);
  if (!found.empty() && found == FingerprintOfTracks(tracks_path)) return path;
  notes->push_back(path +
                   (found.empty() ? ": does not specify its tracks"
                                  : ": belongs to other tracks") +
                   ", and is ignored; run `kinegraph track` again to write it");
  return "";
}

}  // namespace kinegraph
