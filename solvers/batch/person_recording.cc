#include "solvers/batch/person_recording.h"

#include <algorithm>
#include <utility>

namespace kinegraph {
namespace {

template <typename T>
void AppendFrom(const std::vector<T>& from, size_t begin, std::vector<T>* to) {
  to->insert(to->end(), from.begin() + static_cast<std::ptrdiff_t>(begin),
             from.end());
}

void ReserveFrames(size_t count, PersonProblem* graph) {
  graph->times.reserve(count);
  for (JointChain& chain : graph->joints) {
    chain.states.reserve(count);
    chain.process_noise.reserve(count);
    chain.first.reserve(count + 1);
  }
}

// Appends frames `from` .. of `piece`, which continue the recording.
void AppendPiece(size_t from, PersonProblem* piece,
                 PersonRecording* recording) {
  PersonProblem& graph = recording->graph;
  recording->measurements.Append(piece->joints, from, piece->times.size());
  for (size_t j = 0; j < graph.joints.size(); ++j) {
    const JointChain& chain = piece->joints[j];
    JointChain& whole = graph.joints[j];
    if (graph.times.empty()) whole.prior = chain.prior;
    AppendFrom(chain.states, from, &whole.states);
    AppendFrom(chain.process_noise, 0, &whole.process_noise);
    const int32_t before = whole.first.back() - chain.first[from];
    for (size_t k = from; k < piece->times.size(); ++k) {
      whole.first.push_back(before + chain.first[k + 1]);
    }
  }
  for (PlacedFactor& placed : piece->user) {
    for (StateKey& key : placed.keys) {
      key.frame += static_cast<int>(graph.times.size() - from);
    }
    graph.user.push_back(std::move(placed));
  }
  AppendFrom(piece->times, from, &graph.times);
}

// What stays of a piece is the frame before the next one.
void KeepLastFrame(PersonProblem* piece) {
  piece->times.assign(1, piece->times.back());
  piece->user.clear();
  for (JointChain& chain : piece->joints) {
    chain.states.erase(chain.states.begin(), chain.states.end() - 1);
    chain.process_noise.clear();
    chain.first.assign(2, 0);
    chain.measurements.clear();
  }
}

}  // namespace

PersonProblem PersonRecording::Part(size_t begin, size_t end) const {
  const auto at = [](const auto& values, size_t k) {
    return values.begin() + static_cast<std::ptrdiff_t>(k);
  };
  PersonProblem part;
  part.times.assign(at(graph.times, begin), at(graph.times, end));
  part.joints.resize(graph.joints.size());
  for (size_t j = 0; j < graph.joints.size(); ++j) {
    const JointChain& whole = graph.joints[j];
    JointChain& chain = part.joints[j];
    if (begin == 0) chain.prior = whole.prior;
    chain.states.assign(at(whole.states, begin), at(whole.states, end));
    if (end == begin) continue;
    chain.process_noise.assign(at(whole.process_noise, begin),
                               at(whole.process_noise, end - 1));
  }
  measurements.Unpack(begin, end, &part.joints);
  return part;
}

bool PersonRecording::Next(Piece* piece) const {
  if (piece->end == frame_count()) return false;
  piece->begin = piece->end;
  piece->end =
      std::min(piece->begin + PackedMeasurements::kPieceFrames, frame_count());
  piece->part = Part(piece->begin, std::min(piece->end + 1, frame_count()));
  return true;
}

void PersonRecording::ForEachPiece(
    const std::function<void(const Piece&)>& visit) const {
  Piece piece;
  while (Next(&piece)) visit(piece);
}

void PersonRecording::ChangeNoise(const std::function<void(Piece*)>& visit) {
  Piece piece;
  while (Next(&piece)) {
    visit(&piece);
    measurements.ExtractNoise(piece.begin, piece.end, piece.part.joints);
  }
}

PersonRecording AssembleRecording(PackedFrames* frames, Assembler* assembler,
                                  std::vector<FrameRecord>* records) {
  PersonRecording recording;
  recording.graph = assembler->EmptyProblem();
  ReserveFrames(frames->size(), &recording.graph);
  records->reserve(frames->size());
  PersonProblem piece = assembler->EmptyProblem();
  EstimatorFrame frame;
  while (!frames->empty()) {
    const size_t from = piece.times.size();  // 1 but for the first piece
    while (!frames->empty() &&
           piece.times.size() < from + PackedMeasurements::kPieceFrames) {
      frames->Pop(&frame);
      records->push_back(assembler->Append(frame, &piece));
    }
    AppendPiece(from, &piece, &recording);
    KeepLastFrame(&piece);
  }
  return recording;
}

}  // namespace kinegraph
