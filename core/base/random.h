// Seeded random numbers that are the same on every platform (the distributions
// of <random> are not).
#ifndef KINEGRAPH_CORE_BASE_RANDOM_H_
#define KINEGRAPH_CORE_BASE_RANDOM_H_

#include <cstdint>
#include <random>

namespace kinegraph {

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}

  // Uniform in [0, 1), 53 bits.
  double Uniform();
  double Uniform(double low, double high);
  // Uniform over 0 .. count - 1; count > 0.
  int64_t Index(int64_t count);
  // Standard normal, polar method.
  double Normal();
  double Normal(double mean, double sigma);
  // True with the given probability.
  bool Chance(double probability) { return Uniform() < probability; }
  // Gamma distribution with `shape` > 0 and scale 1, after Marsaglia and Tsang
  // (2000).
  double Gamma(double shape);
  // A seed for an independent stream.
  uint64_t Fork() { return engine_(); }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_RANDOM_H_
