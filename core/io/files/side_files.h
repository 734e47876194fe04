// Files beside a result: what `track` writes besides NAME.jsonl.
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

// 32 digits that tell tracks apart, of the bytes of a file or of all files in a
// folder. Throws InputError when they cannot be read.
std::string FingerprintOfTracks(const std::string& path);

// The key by which a JSON object, or the first line of JSON Lines, says of
// which tracks it is. It stands first, so that nothing else need be read.
inline constexpr const char* kFingerprintKey = "tracks_fingerprint";
// The text of a JSON object with that key; as it is without a fingerprint.
std::string WithFingerprint(const std::string& object,
                            const std::string& fingerprint);
// Whether a line of JSON Lines is such an object.
bool IsFingerprintLine(const std::string& line);
// What a file says; empty where it is not there or says nothing.
std::string FingerprintIn(const std::string& path);

// The file of that end beside tracks, if it is theirs; empty where there is
// none and where it is of other tracks: then `notes` gets a line that says so.
std::string SideFileOf(const std::string& tracks_path, const std::string& end,
                       std::vector<std::string>* notes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_SIDE_FILES_H_
