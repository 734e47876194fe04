#ifndef KINEGRAPH_CORE_BASE_MEDIAN_H_
#define KINEGRAPH_CORE_BASE_MEDIAN_H_

#include <vector>

namespace kinegraph {

// The value in the middle, the greater one of two: always one that was there.
// 0 without values.
double Median(std::vector<double> values);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_MEDIAN_H_
