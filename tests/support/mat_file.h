// Writes files like TUM's actorsGT.mat: the cell array actor3D in a MATLAB 5
// file.
#ifndef KINEGRAPH_TESTS_SUPPORT_MAT_FILE_H_
#define KINEGRAPH_TESTS_SUPPORT_MAT_FILE_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/data/pose.h"

namespace kinegraph::testing {

// For each actor, 14 joints [m] by frame. In the file, frames below frame_count
// without an entry have an empty matrix, as frames without annotation have in
// TUM's file.
using AnnotatedActors = std::vector<std::map<int64_t, Pose3d>>;

// The bytes of the file, uncompressed, little-endian.
std::string ActorsGroundTruth(const AnnotatedActors& actors,
                              int64_t frame_count);

// Parts of such a file: an array of any class with its content; a matrix whose
// entries are all `value`; a cell array; the file around them.
std::string MatArray(uint32_t array_class, int32_t rows, int32_t columns,
                     const std::string& name, const std::string& content);
std::string MatNumbers(int32_t rows, int32_t columns, double value);
std::string MatCell(int32_t rows, int32_t columns,
                    const std::vector<std::string>& entries,
                    const std::string& name = "");
std::string MatFile(const std::string& elements);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_MAT_FILE_H_
