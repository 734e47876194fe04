// The measurements of a person's whole recording in less than half their
// memory.
#ifndef KINEGRAPH_SOLVERS_GRAPH_PACKED_MEASUREMENTS_H_
#define KINEGRAPH_SOLVERS_GRAPH_PACKED_MEASUREMENTS_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Frames are appended piece by piece, and any of them unpacked again, bit by
// bit. Chains are [joint]; all have the same frames.
class PackedMeasurements {
 public:
  // Frames of a piece, more or less.
  static constexpr size_t kPieceFrames = 256;

  // Appends frames from .. to - 1 of the chains as a piece. Measurements of one
  // view in one frame share camera and offset.
  void Append(const std::vector<JointChain>& chains, size_t from, size_t to);
  size_t frame_count() const {
    return pieces_.empty() ? 0 : pieces_.back().end;
  }

  // Writes frames begin .. end - 1 as the chains' first and measurements.
  void Unpack(size_t begin, size_t end, std::vector<JointChain>* chains) const;

  // Takes over sigmas, information and bias of the recording's frames begin ..
  // end - 1 from chains that begin with the first of them.
  void ExtractNoise(size_t begin, size_t end,
                    const std::vector<JointChain>& chains);
  // Noise does not change any more. What only learning asks for, modelled
  // sigmas and confidences, is forgotten: sigmas stand for the former.
  void SettleNoise();
  // Takes over what a solve says of a joint's measurements in frames begin ..
  // end - 1, in a row.
  void ExtractWeights(size_t joint_idx, size_t begin, size_t end,
                      const std::vector<double>& weights,
                      const std::vector<char>& gated);
  // From now on there are none in any frame.
  void Clear() { pieces_ = std::vector<Piece>(); }

 private:
  struct Pixel {  // an Eigen vector would be aligned
    double x_px = 0.0;
    double y_px = 0.0;
  };
  struct View {
    const Camera* camera = nullptr;
    double offset_s = 0.0;
  };
  // Frames begin .. end - 1. Values one a measurement: those of a joint in a
  // row, by frame and view.
  struct Piece {
    size_t begin = 0;
    size_t end = 0;
    std::vector<int32_t> first;       // [joint][frame] in a row, and the end
    std::vector<int32_t> first_view;  // [frame], and the end
    std::vector<View> views;          // by frame and slot
    std::vector<int16_t> view_slots;
    std::vector<Pixel> pixels;
    std::vector<double> sigmas_px;
    bool settled = false;
    std::vector<double> information;       // settled: one a joint and frame
    std::vector<double> model_sigmas_px;   // empty: as sigmas_px
    std::vector<float> log_confidences;    // empty: forgotten
    std::vector<Eigen::Vector2f> bias_px;  // empty: none
    std::vector<double> weights;           // empty: not solved
    std::vector<char> gated;               // as weights

    size_t CellOf(size_t joint_idx, size_t frame) const {
      return joint_idx * (end - begin) + frame - begin;
    }
    size_t FirstOf(size_t joint_idx, size_t frame) const {
      return static_cast<size_t>(first[CellOf(joint_idx, frame)]);
    }
    void Reserve(size_t joints, size_t measurements);
    void AddViews(const std::vector<JointChain>& chains, size_t k);
    void Add(const PixelMeasurement& measurement);
    PixelMeasurement At(size_t m, size_t joint_idx, size_t frame) const;
    void Settle();
  };

  // Calls visit(piece, from, to) with the pieces' frames among begin .. end -
  // 1.
  template <typename Pieces, typename Visit>
  static void ForEachPiece(Pieces* pieces, size_t begin, size_t end,
                           const Visit& visit);

  std::vector<Piece> pieces_;  // ascending, without gaps
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_PACKED_MEASUREMENTS_H_
