// Skeletons inside our own files:
// {"name": "coco17", "joints": [...], "bones": [[a, b], ...]}.
#ifndef KINEGRAPH_CORE_IO_TEXT_SKELETON_JSON_H_
#define KINEGRAPH_CORE_IO_TEXT_SKELETON_JSON_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/io/text/bulk_json.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Throws InputError without a file (bulk_json.h).
Skeleton ReadSkeleton(JsonValue value);

// A skeleton as stated by an adapter: the name of a built-in one, or {"joints":
// labels in any spelling, "bones": pairs, if there are any}, under our names
// (SkeletonOfLabels). Throws as ReadSkeleton.
Skeleton ReadStatedSkeleton(JsonValue value);

// Pairs of joints counted from `first` to `last`, as indices from 0. Throws
// InputError "KEY: ..." without a file.
std::vector<Bone> ReadBones(JsonValue value, std::string_view key, int first,
                            int last);

std::string SkeletonJson(const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_SKELETON_JSON_H_
