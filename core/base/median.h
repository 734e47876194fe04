#ifndef KINEGRAPH_CORE_BASE_MEDIAN_H_
#define KINEGRAPH_CORE_BASE_MEDIAN_H_

#include <vector>

namespace kinegraph {

// The middle value, for an even number the greater of the middle two: always
// one of `values`. 0 if empty.
double Median(std::vector<double> values);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_MEDIAN_H_
