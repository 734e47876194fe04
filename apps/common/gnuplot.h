// The program that draws plots.
#ifndef KINEGRAPH_APPS_COMMON_GNUPLOT_H_
#define KINEGRAPH_APPS_COMMON_GNUPLOT_H_

#include <string>

namespace kinegraph {

// What gnuplot prints, given `script` and no settings of the user's. Throws
// std::runtime_error where it is not installed or fails.
std::string RunGnuplot(const std::string& script);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_GNUPLOT_H_
