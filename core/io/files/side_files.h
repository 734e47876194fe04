// Side files of a result: the files that `track` writes besides NAME.jsonl.
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

// "out/take.jsonl" or the folder "out/take", ".summary.json" ->
// "out/take.summary.json".
std::string BesideTracks(const std::string& tracks_path,
                         const std::string& end);

// 32 digits that identify tracks, from the bytes of a file or of all files in a
// folder. Throws InputError if they cannot be read.
std::string FingerprintOfTracks(const std::string& path);

// The key by which a JSON object, or the first line of JSON Lines, identifies
// its tracks. It comes first, so that the rest need not be read.
inline constexpr const char* kFingerprintKey = "tracks_fingerprint";
// The text of a JSON object with that key; unchanged without a fingerprint.
std::string WithFingerprint(const std::string& object,
                            const std::string& fingerprint);
// Whether a line of JSON Lines is such an object.
bool IsFingerprintLine(const std::string& line);
// The fingerprint in a file; empty if there is none.
std::string FingerprintIn(const std::string& path);

// The file with that suffix beside tracks, if it belongs to them; empty if it
// does not exist or belongs to other tracks: then `notes` gets a line about it.
std::string SideFileOf(const std::string& tracks_path, const std::string& end,
                       std::vector<std::string>* notes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_SIDE_FILES_H_
