#include "solvers/batch/chunk_pieces.h"

#include <algorithm>

#include "core/geometry/camera_bytes.h"

namespace kinegraph {
namespace {

void PutPrior(const StatePrior& prior, ByteWriter* writer) {
  writer->PutMatrix(prior.A);
  writer->PutMatrix(prior.x0);
  writer->PutMatrix(prior.b);
  writer->PutMatrix(prior.A_stated);
}

void PutPrior(const PersonPrior& prior, ByteWriter* writer) {
  writer->PutSize(static_cast<size_t>(prior.A.rows()));
  writer->PutMatrix(prior.A);
  writer->PutMatrix(prior.x0);
  writer->PutMatrix(prior.b);
  writer->PutMatrix(prior.information);
  writer->PutSize(static_cast<size_t>(prior.stated.rows()));
  writer->PutMatrix(prior.stated);
}

// Cameras by their place among those that `cameras` has come across.
void PutMeasurement(const PixelMeasurement& measurement,
                    std::vector<const Camera*>* cameras, ByteWriter* writer) {
  const auto at =
      std::find(cameras->begin(), cameras->end(), measurement.camera);
  writer->PutSize(static_cast<size_t>(at - cameras->begin()));
  if (at == cameras->end()) {
    cameras->push_back(measurement.camera);
    Put(*measurement.camera, writer);
  }
  writer->PutMatrix(measurement.px);
  writer->PutMatrix(measurement.bias_px);
  writer->Put(measurement.sigma_px);
  writer->Put(measurement.model_sigma_px);
  writer->Put(measurement.information);
  writer->Put(measurement.offset_s);
  writer->Put(measurement.weight);
  writer->Put(measurement.log_confidence);
  writer->Put(measurement.view_slot);
  writer->Put(measurement.gated);
}

void PutChain(const JointChain& chain, std::vector<const Camera*>* cameras,
              ByteWriter* writer) {
  for (const double power : chain.process_noise) writer->Put(power);
  PutPrior(chain.prior, writer);
  for (const State& state : chain.states) writer->PutMatrix(state);
  for (const int32_t first : chain.first) writer->Put(first);
  for (const PixelMeasurement& measurement : chain.measurements) {
    PutMeasurement(measurement, cameras, writer);
  }
}

void PutBone(const BoneConstraint& bone, ByteWriter* writer) {
  writer->Put(bone.a);
  writer->Put(bone.b);
  writer->Put(bone.length_m);
  writer->Put(bone.sigma_m);
  writer->Put(bone.loss);
  writer->Put(bone.loss_scale);
}

}  // namespace

std::string ChunkKey(std::string_view step, const PersonSolver& solver,
                     const Chunk& chunk, const PersonProblem& part) {
  if (!part.user.empty()) return "";
  ByteWriter depends;
  depends.PutText(step);
  solver.PutOptions(&depends);
  depends.PutSize(chunk.own_begin - chunk.begin);
  depends.PutSize(chunk.own_end - chunk.begin);
  depends.PutSize(part.times.size());
  for (const TimeNs time : part.times) depends.Put(time);
  depends.PutSize(part.bones.size());
  for (const BoneConstraint& bone : part.bones) PutBone(bone, &depends);
  PutPrior(part.prior, &depends);
  Fingerprint fingerprint;
  fingerprint.Add(depends.Take());
  std::vector<const Camera*> cameras;
  for (const JointChain& chain : part.joints) {
    ByteWriter joint;
    PutChain(chain, &cameras, &joint);
    fingerprint.Add(joint.bytes());
  }
  return fingerprint.Hex();
}

void Put(const SolveCounts& counts, ByteWriter* writer) {
  for (const auto count : kSolveCounts) writer->Put(counts.*count);
}

void Get(ByteReader* reader, SolveCounts* counts) {
  for (const auto count : kSolveCounts) {
    counts->*count = reader->Get<int64_t>();
  }
}

void Put(const ChunkSolution& solution, ByteWriter* writer) {
  writer->Put(solution.bones_dropped);
  writer->PutSize(solution.joints.size());
  for (const JointOutcome& joint : solution.joints) {
    writer->PutSize(joint.states.size());
    for (const State& state : joint.states) writer->PutMatrix(state);
    writer->PutSize(joint.weights.size());
    for (const double weight : joint.weights) writer->Put(weight);
    for (const char gated : joint.gated) writer->Put(gated);
  }
}

void Get(ByteReader* reader, ChunkSolution* solution) {
  solution->bones_dropped = reader->Get<bool>();
  solution->joints.resize(reader->GetSize(2 * sizeof(uint64_t)));
  for (JointOutcome& joint : solution->joints) {
    joint.states.resize(reader->GetSize(sizeof(State)));
    for (State& state : joint.states) reader->GetMatrix(&state);
    joint.weights.resize(reader->GetSize(sizeof(double) + sizeof(char)));
    for (double& weight : joint.weights) weight = reader->Get<double>();
    joint.gated.resize(joint.weights.size());
    for (char& gated : joint.gated) gated = reader->Get<char>();
  }
}

}  // namespace kinegraph
