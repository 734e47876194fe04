// Fuzz targets: one per reader and per format (calibrations that kinegraph can
// write share two), three that write accepted input in every format, one that
// runs the pipeline on a scene, and some for the data and side files of the
// report's page. Each takes any bytes and returns whether they were valid;
// readers must reject invalid input with InputError or OptionError. Anything
// else ends the program, which the fuzzer reports.
#ifndef KINEGRAPH_TESTS_FUZZ_TARGETS_H_
#define KINEGRAPH_TESTS_FUZZ_TARGETS_H_

#include <functional>
#include <string>
#include <vector>

namespace kinegraph::testing {

struct FuzzTarget {
  std::string name;
  std::function<bool(const std::string& bytes)> run;
};

// The target that runs a reader on one file of any bytes.
FuzzTarget OfReader(const std::string& name,
                    void (*read)(const std::string& path));

const std::vector<FuzzTarget>& FuzzTargets();
// The targets that need more than core/io.
std::vector<FuzzTarget> RunTargets();

// Throws std::out_of_range for an unknown name.
const FuzzTarget& FindFuzzTarget(const std::string& name);

// Valid inputs of a target, from the project's own writers or written by hand.
std::vector<std::string> FuzzSeeds(const std::string& target);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_FUZZ_TARGETS_H_
