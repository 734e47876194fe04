// Gaussian kernel smoother over past and future.
#ifndef KINEGRAPH_SOLVERS_FILTERS_CENTRED_GAUSSIAN_H_
#define KINEGRAPH_SOLVERS_FILTERS_CENTRED_GAUSSIAN_H_

#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Mean of the values weighted by exp(-dt^2 / (2 sigma^2)), over those within
// four sigmas (Nadaraya 1964, Watson 1964). Time need not be uniform; at the
// ends the weights are those of the values there are.
Samples CentredGaussian(double sigma_s, const std::vector<double>& times_s,
                        const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_CENTRED_GAUSSIAN_H_
