// Checks TRC files by the rules of OpenSim's reader, which is stricter than
// kinegraph's.
#ifndef KINEGRAPH_TESTS_SUPPORT_OPENSIM_TRC_H_
#define KINEGRAPH_TESTS_SUPPORT_OPENSIM_TRC_H_

#include <gtest/gtest.h>

#include <string>

namespace kinegraph::testing {

// Whether OpenSim 4 reads the file, or every .trc of a folder (at least one).
// Its TRCFileAdapter splits at tabs and carriage returns; text after the last
// of them is a cell unless it is empty; each row must have two cells plus three
// per marker, which are empty for a marker that was not seen.
::testing::AssertionResult OpenSimReads(const std::string& path);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_OPENSIM_TRC_H_
