// Skeletons in kinegraph's own files:
// {"name": "coco17", "joints": [...], "bones": [[a, b], ...]}.
#ifndef KINEGRAPH_CORE_IO_TEXT_SKELETON_JSON_H_
#define KINEGRAPH_CORE_IO_TEXT_SKELETON_JSON_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/io/text/bulk_json.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Reads such an object. The InputError that it throws does not name the file;
// the caller adds the name (bulk_json.h).
Skeleton ReadSkeleton(JsonValue value);

// Reads a skeleton that an adapter specifies: the name of a built-in skeleton,
// or an object {"joints", "bones", "name"} of which only "joints" is required.
// Its joints may have labels in any spelling, which are translated to
// kinegraph's names (SkeletonOfLabels). The InputError does not name the file.
Skeleton ReadStatedSkeleton(JsonValue value);

// Reads pairs of joint numbers from `first` to `last`, as indices from 0.
// Throws InputError "KEY: ...", which does not name the file.
std::vector<Bone> ReadBones(JsonValue value, std::string_view key, int first,
                            int last);

std::string SkeletonJson(const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_SKELETON_JSON_H_
