// The processor time of the test, for upper bounds on cost: unlike wall time it
// does not grow when other programs keep the machine busy.
#ifndef KINEGRAPH_TESTS_SUPPORT_PROCESSOR_TIME_H_
#define KINEGRAPH_TESTS_SUPPORT_PROCESSOR_TIME_H_

#include <ctime>

namespace kinegraph::testing {

class ProcessorTime {
 public:
  ProcessorTime() : start_(std::clock()) {}
  double Seconds() const {
    return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC;
  }

 private:
  std::clock_t start_;
};

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_PROCESSOR_TIME_H_
