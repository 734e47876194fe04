// Side files of tracks: the files that `track` writes besides NAME.jsonl.
#ifndef KINEGRAPH_CORE_IO_FILES_SIDE_FILES_H_
#define KINEGRAPH_CORE_IO_FILES_SIDE_FILES_H_

#include <array>
#include <string>
#include <vector>

namespace kinegraph {

inline constexpr const char* kSummaryEnd = ".summary.json";
inline constexpr const char* kIdentityEnd = ".identity.jsonl";
inline constexpr const char* kCamerasEnd = ".cameras.json";
inline constexpr const char* kBiasEnd = ".bias.json";
inline constexpr std::array<const char*, 4> kSideFileEnds = {
    kSummaryEnd, kIdentityEnd, kCamerasEnd, kBiasEnd};

// The path of a side file: "out/take.summary.json" for ".summary.json" and the
// tracks "out/take.jsonl" or the folder "out/take".
std::string BesideTracks(const std::string& tracks_path,
                         const std::string& end);

// 32 hexadecimal digits that identify tracks, computed from the bytes of a file
// or from the names and bytes of all files in a folder. Throws InputError if
// they cannot be read.
std::string FingerprintOfTracks(const std::string& path);

// The key by which a JSON object, or the first line of JSON Lines, identifies
// the tracks to which it belongs. It is the first key, so that the rest need
// not be read.
inline constexpr const char* kFingerprintKey = "tracks_fingerprint";
// Adds that key to the text of a JSON object, unless the fingerprint is empty.
std::string WithFingerprint(const std::string& object,
                            const std::string& fingerprint);
// Whether a line of JSON Lines begins with that key.
bool IsFingerprintLine(const std::string& line);
// The fingerprint in a file; empty if there is none.
std::string FingerprintIn(const std::string& path);

// The path of the side file with that suffix, if it belongs to the tracks.
// Empty if it does not exist; empty with a note in `notes` if it belongs to
// other tracks or does not specify its tracks.
std::string SideFileOf(const std::string& tracks_path, const std::string& end,
                       std::vector<std::string>* notes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_SIDE_FILES_H_
