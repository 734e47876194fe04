// A person's problem while its frames come in: a third of the size of the
// problem itself, for takes whose people all wait for the end.
#ifndef KINEGRAPH_SOLVERS_GRAPH_PROBLEM_STORE_H_
#define KINEGRAPH_SOLVERS_GRAPH_PROBLEM_STORE_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/growing_blocks.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Keeps of a frame what Assembler::Append writes: starts at rest, and
// measurements that nothing was learnt of yet. In blocks, which grow without
// being copied and have little room to spare.
class ProblemStore {
 public:
  // `empty` has the joints and no frames.
  explicit ProblemStore(const PersonProblem& empty);

  // Where the next frame is appended: the frame before it, without its
  // measurements, if there is one.
  PersonProblem* newest() { return &newest_; }
  // Of the appended frame in it.
  size_t newest_frame() const { return newest_.times.size() - 1; }
  // Keeps the appended frame.
  void Keep();

  // The whole problem. The store is empty then.
  PersonProblem TakeAll();

 private:
  // Neighbouring measurements that differ by joint, pixel, sigma and confidence
  // alone.
  struct Run {
    const Camera* camera = nullptr;
    double offset_s = 0.0;
    double information = 1.0;
    int16_t view_slot = 0;
    int32_t length = 0;

    bool Fits(const PixelMeasurement& measurement) const;
  };
  struct Pixel {  // an Eigen vector would align it to 32 bytes
    double x_px;
    double y_px;
    double sigma_px;
  };

  void KeepMeasurements();
  void RestoreStates();
  void RestoreMeasurements();

  PersonProblem newest_;
  PersonProblem whole_;  // times, priors, a user's factors; counts as `first`
  GrowingBlocks<Eigen::Vector3d> starts_m_;  // [frame][joint] in a row
  GrowingBlocks<double> process_noise_;      // the same but for the first frame
  GrowingBlocks<Run> runs_;
  GrowingBlocks<Pixel> pixels_;           // of all runs in a row
  GrowingBlocks<float> log_confidences_;  // of the pixels
  GrowingBlocks<uint16_t> joints_;        // of the pixels
  std::vector<int32_t> next_;             // of newest_'s measurements, by joint
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_PROBLEM_STORE_H_
