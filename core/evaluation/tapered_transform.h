// Fourier transform of a segment of a motion, for power spectra.
#ifndef KINEGRAPH_CORE_EVALUATION_TAPERED_TRANSFORM_H_
#define KINEGRAPH_CORE_EVALUATION_TAPERED_TRANSFORM_H_

#include <Eigen/Core>

namespace kinegraph {

// Welch (1967): a segment is detrended, tapered by a Hann window and
// transformed. The squared magnitudes of the bins 1 .. length / 2 sum, on
// average, to the mean square of the detrended segment (positive and negative
// frequencies together).
class TaperedTransform {
 public:
  // `length` >= 2 samples; computes the bins `first` .. length / 2, `first` >=
  // 1. Bin k has the frequency k rate / length.
  explicit TaperedTransform(int length, int first = 1);

  int length() const { return static_cast<int>(trend_.size()); }
  // `signals`: one row per sample, one column per signal. The result has one
  // row per bin.
  Eigen::MatrixXcd operator()(Eigen::MatrixXd signals) const;

 private:
  Eigen::VectorXd trend_;
  Eigen::MatrixXcd fourier_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_TAPERED_TRANSFORM_H_
