// Files of HDF5 as SLEAP and DeepLabCut write them, and as nobody should.
#ifndef KINEGRAPH_TESTS_SUPPORT_HDF5_FILES_H_
#define KINEGRAPH_TESTS_SUPPORT_HDF5_FILES_H_

#include <cstdint>
#include <string>
#include <vector>

namespace kinegraph::testing {

struct SleapFile {
  // Attribute `dims` of `tracks`, and its sides.
  std::vector<std::string> axes = {"frame", "track", "node", "xy"};
  std::vector<uint64_t> sides = {3, 1, 3, 2};
  // A data set without it claims its numbers and has none.
  bool has_numbers = true;
  std::vector<std::string> nodes = {"snout", "left_ear", "tail"};
  std::vector<int64_t> edges = {0, 1, 0, 2};
  std::vector<uint64_t> edge_sides = {2, 2};
  // As SLEAP writes it: so many other sets stand between tracks and names.
  int other_sets = 0;
  uint64_t claimed_nodes = 0;  // instead of `nodes`, each of 1000 bytes
};

// The bytes of the file: number i of the tracks is 10 + i.
std::string SleapHdf5(const SleapFile& content = SleapFile());

struct DeepLabCutFile {
  // Names of the columns as Python's pickle has them in protocol 0; empty: x, y
  // and likelihood of one bodypart.
  std::string pickled;
  uint64_t width = 3;  // numbers a frame
};

// The bytes of the file: three frames, whose number i is 10 + i.
std::string DeepLabCutHdf5(const DeepLabCutFile& content = DeepLabCutFile());

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_HDF5_FILES_H_
