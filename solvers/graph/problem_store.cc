#include "solvers/graph/problem_store.h"

#include <glog/logging.h>

#include <limits>
#include <utility>

namespace kinegraph {

bool ProblemStore::Run::Fits(const PixelMeasurement& measurement) const {
  return measurement.view_slot == view_slot && measurement.camera == camera &&
         measurement.offset_s == offset_s &&
         measurement.information == information;
}

ProblemStore::ProblemStore(const PersonProblem& empty)
    : newest_(empty), whole_(empty), next_(empty.joints.size()) {
  CHECK(empty.times.empty());
  CHECK_LE(empty.joints.size(), std::numeric_limits<uint16_t>::max());
}

void ProblemStore::Keep() {
  const size_t k = newest_frame();
  if (whole_.times.empty()) {
    for (size_t j = 0; j < newest_.joints.size(); ++j) {
      whole_.joints[j].prior = newest_.joints[j].prior;
    }
  }
  for (const JointChain& chain : newest_.joints) {
    starts_m_.Push(chain.states[k].head<3>());
    if (k > 0) process_noise_.Push(chain.process_noise.back());
  }
  KeepMeasurements();
  for (PlacedFactor& placed : newest_.user) {
    for (StateKey& key : placed.keys) key.frame += whole_.times.size() - k;
    whole_.user.push_back(std::move(placed));
  }
  newest_.user.clear();
  whole_.times.push_back(newest_.times.back());
  // What stays is the frame before the next one.
  newest_.times.assign(1, whole_.times.back());
  for (JointChain& chain : newest_.joints) {
    chain.states.erase(chain.states.begin(), chain.states.end() - 1);
    chain.process_noise.clear();
    chain.first.assign(2, 0);
    chain.measurements.clear();
  }
}

// In the order of views, so that those of a view lie together.
void ProblemStore::KeepMeasurements() {
  const size_t k = newest_frame();
  int64_t left = 0;
  for (size_t j = 0; j < newest_.joints.size(); ++j) {
    const JointChain& chain = newest_.joints[j];
    next_[j] = chain.first[k];
    left += chain.first[k + 1] - chain.first[k];
    whole_.joints[j].first.push_back(whole_.joints[j].first.back() +
                                     chain.first[k + 1] - chain.first[k]);
  }
  for (int32_t slot = 0; left > 0; ++slot) {
    for (size_t j = 0; j < newest_.joints.size(); ++j) {
      const JointChain& chain = newest_.joints[j];
      if (next_[j] == chain.first[k + 1]) continue;
      const PixelMeasurement& measurement = chain.measurements[next_[j]];
      if (measurement.view_slot != slot) continue;
      if (runs_.empty() || !runs_.back().Fits(measurement)) {
        runs_.Push({measurement.camera, measurement.offset_s,
                    measurement.information, measurement.view_slot, 0});
      }
      ++runs_.back().length;
      pixels_.Push(
          {measurement.px.x(), measurement.px.y(), measurement.sigma_px});
      log_confidences_.Push(measurement.log_confidence);
      joints_.Push(static_cast<uint16_t>(j));
      ++next_[j];
      --left;
    }
  }
}

void ProblemStore::RestoreStates() {
  const size_t count = whole_.times.size();
  for (JointChain& chain : whole_.joints) {
    chain.states.reserve(count);
    chain.process_noise.reserve(count);
    chain.measurements.reserve(static_cast<size_t>(chain.first.back()));
  }
  for (size_t k = 0; k < count; ++k) {
    for (JointChain& chain : whole_.joints) {
      State& state = chain.states.emplace_back(State::Zero());
      state.head<3>() = starts_m_.front();
      starts_m_.Pop();
      if (k == 0) continue;
      chain.process_noise.push_back(process_noise_.front());
      process_noise_.Pop();
    }
  }
}

// Gives back each block as soon as it was read.
void ProblemStore::RestoreMeasurements() {
  PixelMeasurement measurement;
  for (; !runs_.empty(); runs_.Pop()) {
    const Run& run = runs_.front();
    measurement.camera = run.camera;
    measurement.offset_s = run.offset_s;
    measurement.information = run.information;
    measurement.view_slot = run.view_slot;
    for (int32_t i = 0; i < run.length; ++i) {
      measurement.px = {pixels_.front().x_px, pixels_.front().y_px};
      measurement.sigma_px = pixels_.front().sigma_px;
      measurement.model_sigma_px = measurement.sigma_px;
      measurement.log_confidence = log_confidences_.front();
      whole_.joints[joints_.front()].measurements.push_back(measurement);
      pixels_.Pop();
      log_confidences_.Pop();
      joints_.Pop();
    }
  }
}

PersonProblem ProblemStore::TakeAll() {
  RestoreStates();
  RestoreMeasurements();
  PersonProblem empty;
  empty.joints.resize(whole_.joints.size());
  PersonProblem whole = std::exchange(whole_, empty);
  newest_ = std::move(empty);
  return whole;
}

}  // namespace kinegraph
