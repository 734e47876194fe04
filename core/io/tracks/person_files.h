// Formats with a file a person: a folder of person_3.trc, person_4_Anna.trc.
// For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_PERSON_FILES_H_
#define KINEGRAPH_CORE_IO_TRACKS_PERSON_FILES_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/data/person_names.h"
#include "core/data/pose.h"

namespace kinegraph {

// A number that can be an identity.
std::optional<TrackId> PersonIdOf(std::string_view text);

// "person_3_Anna-Lena"; what may not stand in the name of a file, and the
// underscore, which parts it, are hyphens.
std::string PersonLabel(int64_t id, const PersonNames& names);

// What each is called: the name, else "person_3"; people of one name get their
// identity too, so that all are told apart.
std::vector<std::string> PersonTitles(const std::vector<int64_t>& ids,
                                      const PersonNames& names);

struct PersonFile {
  std::string path;
  TrackId id;
};

// The one file that `path` is, or those of that extension in a folder, whose
// ids are the numbers after the last "person_" (ours) or "_P" (Pose2Sim) of
// their names where every name has its own, else 0, 1, 2 in the order of the
// names. Throws InputError for a folder without such files.
std::vector<PersonFile> ListPersonFiles(const std::string& path,
                                        const std::string& extension);

// The names that stand in the files' names: "person_3_Anna.trc" is Anna's.
PersonNames NamesOfPersonFiles(const std::string& path,
                               const std::string& extension);

// Everybody of whom a file is to be written: one person alone when `path` ends
// in the extension. Throws InputError when there is nobody, or are several.
std::vector<int64_t> PeopleToWrite(const std::string& path,
                                   const std::string& extension,
                                   const TrackSequence& tracks);

// Calls `write_file` for everybody: with `path` itself when it ends in the
// extension, else with files in the folder `path`, which appears when all are
// there.
void WritePersonFiles(
    const std::string& path, const std::string& extension,
    const std::vector<int64_t>& ids, const PersonNames& names,
    const std::function<void(const std::string& file, TrackId id)>& write_file);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_PERSON_FILES_H_
