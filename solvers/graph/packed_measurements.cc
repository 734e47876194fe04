#include "solvers/graph/packed_measurements.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

namespace kinegraph {

void PackedMeasurements::Piece::Reserve(size_t joints, size_t measurements) {
  first.reserve(joints * (end - begin) + 1);
  first_view.reserve(end - begin + 1);
  view_slots.reserve(measurements);
  pixels.reserve(measurements);
  sigmas_px.reserve(measurements);
  information.reserve(measurements);
  model_sigmas_px.reserve(measurements);
  log_confidences.reserve(measurements);
}

// Of the chains' frame `k`.
void PackedMeasurements::Piece::AddViews(const std::vector<JointChain>& chains,
                                         size_t k) {
  const size_t before = views.size();
  for (const JointChain& chain : chains) {
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      const PixelMeasurement& measurement = chain.measurements[m];
      const size_t at = before + static_cast<size_t>(measurement.view_slot);
      if (views.size() <= at) views.resize(at + 1);
      View& view = views[at];
      if (view.camera == nullptr) {
        view = {measurement.camera, measurement.offset_s};
      }
      CHECK(view.camera == measurement.camera &&
            view.offset_s == measurement.offset_s);
    }
  }
}

void PackedMeasurements::Piece::Add(const PixelMeasurement& measurement) {
  view_slots.push_back(measurement.view_slot);
  pixels.push_back({measurement.px.x(), measurement.px.y()});
  sigmas_px.push_back(measurement.sigma_px);
  information.push_back(measurement.information);
  model_sigmas_px.push_back(measurement.model_sigma_px);
  log_confidences.push_back(measurement.log_confidence);
}

PixelMeasurement PackedMeasurements::Piece::At(size_t m, size_t joint_idx,
                                               size_t frame) const {
  PixelMeasurement measurement;
  measurement.px = {pixels[m].x_px, pixels[m].y_px};
  measurement.sigma_px = sigmas_px[m];
  measurement.information =
      settled ? information[CellOf(joint_idx, frame)] : information[m];
  measurement.view_slot = view_slots[m];
  const View& view = views[static_cast<size_t>(first_view[frame - begin]) +
                           static_cast<size_t>(view_slots[m])];
  measurement.camera = view.camera;
  measurement.offset_s = view.offset_s;
  measurement.model_sigma_px =
      model_sigmas_px.empty() ? measurement.sigma_px : model_sigmas_px[m];
  if (!log_confidences.empty()) {
    measurement.log_confidence = log_confidences[m];
  }
  if (!bias_px.empty()) measurement.bias_px = bias_px[m];
  if (!weights.empty()) {
    measurement.weight = weights[m];
    measurement.gated = gated[m] != 0;
  }
  return measurement;
}

void PackedMeasurements::Append(const std::vector<JointChain>& chains,
                                size_t from, size_t to) {
  if (from == to) return;
  Piece piece;
  piece.begin = frame_count();
  piece.end = piece.begin + to - from;
  size_t count = 0;
  for (const JointChain& chain : chains) {
    count += static_cast<size_t>(chain.first[to] - chain.first[from]);
  }
  piece.Reserve(chains.size(), count);
  for (size_t k = from; k < to; ++k) {
    piece.first_view.push_back(static_cast<int32_t>(piece.views.size()));
    piece.AddViews(chains, k);
  }
  piece.views.shrink_to_fit();
  for (const JointChain& chain : chains) {
    for (size_t k = from; k < to; ++k) {
      piece.first.push_back(static_cast<int32_t>(piece.pixels.size()));
      for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
        piece.Add(chain.measurements[m]);
      }
    }
  }
  piece.first.push_back(static_cast<int32_t>(piece.pixels.size()));
  if (piece.model_sigmas_px == piece.sigmas_px) {
    piece.model_sigmas_px = std::vector<double>();
  }
  pieces_.push_back(std::move(piece));
}

template <typename Pieces, typename Visit>
void PackedMeasurements::ForEachPiece(Pieces* pieces, size_t begin, size_t end,
                                      const Visit& visit) {
  auto piece = std::upper_bound(
      pieces->begin(), pieces->end(), begin,
      [](size_t frame, const Piece& one) { return frame < one.end; });
  for (; piece != pieces->end() && piece->begin < end; ++piece) {
    visit(*piece, std::max(begin, piece->begin), std::min(end, piece->end));
  }
}

void PackedMeasurements::Unpack(size_t begin, size_t end,
                                std::vector<JointChain>* chains) const {
  for (size_t j = 0; j < chains->size(); ++j) {
    JointChain& chain = (*chains)[j];
    chain.first.assign(1, 0);
    chain.first.reserve(end - begin + 1);
    chain.measurements.clear();
    size_t count = 0;
    ForEachPiece(&pieces_, begin, end,
                 [&](const Piece& piece, size_t from, size_t to) {
                   count += piece.FirstOf(j, to) - piece.FirstOf(j, from);
                 });
    chain.measurements.reserve(count);
    ForEachPiece(&pieces_, begin, end,
                 [&](const Piece& piece, size_t from, size_t to) {
                   for (size_t k = from; k < to; ++k) {
                     const size_t stop = piece.FirstOf(j, k + 1);
                     for (size_t m = piece.FirstOf(j, k); m < stop; ++m) {
                       chain.measurements.push_back(piece.At(m, j, k));
                     }
                     chain.first.push_back(
                         static_cast<int32_t>(chain.measurements.size()));
                   }
                 });
    chain.first.resize(end - begin + 1, chain.first.back());
  }
}

void PackedMeasurements::ExtractNoise(size_t begin, size_t end,
                                      const std::vector<JointChain>& chains) {
  for (size_t j = 0; j < chains.size(); ++j) {
    auto measurement = chains[j].measurements.begin();
    ForEachPiece(&pieces_, begin, end,
                 [&](Piece& piece, size_t from, size_t to) {
                   CHECK(!piece.settled);
                   if (piece.model_sigmas_px.empty()) {
                     piece.model_sigmas_px = piece.sigmas_px;
                   }
                   const size_t stop = piece.FirstOf(j, to);
                   for (size_t m = piece.FirstOf(j, from); m < stop;
                        ++m, ++measurement) {
                     piece.sigmas_px[m] = measurement->sigma_px;
                     piece.information[m] = measurement->information;
                     if (piece.bias_px.empty()) {
                       if (measurement->bias_px == Eigen::Vector2f::Zero())
                         continue;
                       piece.bias_px.assign(piece.pixels.size(),
                                            Eigen::Vector2f::Zero());
                     }
                     piece.bias_px[m] = measurement->bias_px;
                   }
                 });
  }
}

// Where all views of a joint have the same information in every frame, it is
// kept once a frame.
void PackedMeasurements::Piece::Settle() {
  model_sigmas_px = std::vector<double>();
  log_confidences = std::vector<float>();
  std::vector<double> of_cells(first.size() - 1, 1.0);
  for (size_t cell = 0; cell < of_cells.size(); ++cell) {
    const auto from = information.begin() + first[cell];
    const auto to = information.begin() + first[cell + 1];
    if (from == to) continue;
    of_cells[cell] = *from;
    if (std::any_of(from, to, [&](double one) { return one != *from; })) return;
  }
  settled = true;
  information = std::move(of_cells);
}

void PackedMeasurements::SettleNoise() {
  for (Piece& piece : pieces_) piece.Settle();
}

void PackedMeasurements::ExtractWeights(size_t joint_idx, size_t begin,
                                        size_t end,
                                        const std::vector<double>& weights,
                                        const std::vector<char>& gated) {
  size_t next = 0;
  ForEachPiece(&pieces_, begin, end, [&](Piece& piece, size_t from, size_t to) {
    if (piece.weights.empty()) {
      piece.weights.assign(piece.pixels.size(), 0.0);
      piece.gated.assign(piece.pixels.size(), 0);
    }
    const size_t stop = piece.FirstOf(joint_idx, to);
    for (size_t m = piece.FirstOf(joint_idx, from); m < stop; ++m, ++next) {
      piece.weights[m] = weights[next];
      piece.gated[m] = gated[next];
    }
  });
}

}  // namespace kinegraph
