// OpenSim's reading of TRC files, which is stricter than ours.
#ifndef KINEGRAPH_TESTS_SUPPORT_OPENSIM_TRC_H_
#define KINEGRAPH_TESTS_SUPPORT_OPENSIM_TRC_H_

#include <gtest/gtest.h>

#include <string>

namespace kinegraph::testing {

// Whether OpenSim 4 reads the file, or every .trc of a folder (at least one).
// Its TRCFileAdapter splits at tabulators and carriage returns; what follows
// the last of them is a cell only where it is not empty; each row must have two
// cells and three a marker, of which empty ones are a marker that is not seen.
::testing::AssertionResult OpenSimReads(const std::string& path);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_OPENSIM_TRC_H_
