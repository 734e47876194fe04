// What `track` decided of clocks, as its cameras.json records it, so that a
// later run repeats the decision; the cameras themselves are the file's.
#ifndef KINEGRAPH_CORE_IO_REFINEMENT_RECORD_H_
#define KINEGRAPH_CORE_IO_REFINEMENT_RECORD_H_

#include <optional>
#include <string>
#include <vector>

namespace kinegraph {

struct RefinementRecord {
  struct Camera {
    std::string name;
    double offset_s = 0.0;  // added to its time of capture
    double drift = 0.0;     // [s/s] of the time since `clock_zero_s`
  };
  double clock_zero_s = 0.0;
  std::vector<Camera> cameras;

  bool has_clocks() const;
};

// nullopt where `path` is not a cameras.json with a record. Throws InputError
// for a record that cannot be read.
std::optional<RefinementRecord> ReadRefinementRecord(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_REFINEMENT_RECORD_H_
