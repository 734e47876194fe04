// Levenberg-Marquardt damping: none while steps lower the cost.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_DAMPING_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_DAMPING_H_

namespace kinegraph {

class Damping {
 public:
  // Multiple of the system's diagonal that is added to it.
  double value() const { return value_; }

  // Whether a step from `old_cost` to `new_cost` counts as progress; near a
  // minimum rounding may raise the cost by a part in 1e12.
  bool Accepts(double old_cost, double new_cost) const {
    return new_cost <= old_cost + 1e-12 * (1.0 + old_cost);
  }
  void Lower() { value_ = value_ > 1e-6 ? 0.1 * value_ : 0.0; }
  // False when raising it further is hopeless.
  bool Raise() {
    value_ = value_ > 0.0 ? 10.0 * value_ : 1e-4;
    return value_ < 1e10;
  }

 private:
  double value_ = 0.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_DAMPING_H_
