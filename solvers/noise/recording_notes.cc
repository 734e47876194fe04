#include "solvers/noise/recording_notes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace kinegraph {
namespace {

double WeightedMean(double mean, double weight, double value, double added) {
  return mean + (value - mean) * added / (weight + added);
}

// Adds `from` to the running geometric means of `to`.
void AddClass(const LearntNoise::OfClass& from, LearntNoise::OfClass* to) {
  if (from.joints_seen == 0) return;
  if (to->joints_seen == 0) {
    *to = from;
    return;
  }
  const auto before = static_cast<double>(to->joints_seen);
  const auto added = static_cast<double>(from.joints_seen);
  const auto mean = [&](double a, double b) {
    if (!(a > 0.0 && b > 0.0)) return std::max(a, b);
    return std::exp(WeightedMean(std::log(a), before, std::log(b), added));
  };
  to->sigma_px = mean(to->sigma_px, from.sigma_px);
  to->process_noise = mean(to->process_noise, from.process_noise);
  // 0: a person whose motion was not measured.
  to->least_process_noise =
      to->least_process_noise > 0.0 && from.least_process_noise > 0.0
          ? std::min(to->least_process_noise, from.least_process_noise)
          : std::max(to->least_process_noise, from.least_process_noise);
  to->greatest_process_noise =
      std::max(to->greatest_process_noise, from.greatest_process_noise);
  to->joints_seen += from.joints_seen;
}

// Throws if a learnt value is not finite or, except for the confidence power,
// negative, which is an internal error.
void RequireFinite(const LearntNoise& learnt) {
  const auto require = [](double value, const char* what) {
    if (std::isfinite(value) && value >= 0.0) return;
    throw std::logic_error(
        std::string(
            "the noise learnt from the recording is negative or not finite: ") +
        what +
        "; this is a bug in kinegraph, please report it with the recording");
  };
  require(learnt.correlation.share, "error_share");
  require(learnt.correlation.time_s, "error_time_s");
  require(std::abs(learnt.confidence_power), "confidence_power");
  for (const LearntNoise::OfClass& one : learnt.classes) {
    if (one.joints_seen == 0) continue;
    require(one.sigma_px, "sigma_px");
    require(one.process_noise, "process_noise");
    require(one.least_process_noise, "least_process_noise");
    require(one.greatest_process_noise, "greatest_process_noise");
  }
}

int64_t JointsSeen(const LearntNoise& learnt) {
  int64_t count = 0;
  for (const LearntNoise::OfClass& one : learnt.classes) {
    count += one.joints_seen;
  }
  return count;
}

void AddPerson(const LearntNoise& from, LearntNoise* to) {
  const auto before = static_cast<double>(JointsSeen(*to));
  const auto added = static_cast<double>(JointsSeen(from));
  if (added == 0.0) return;
  to->correlation.share = WeightedMean(to->correlation.share, before,
                                       from.correlation.share, added);
  to->correlation.time_s = WeightedMean(to->correlation.time_s, before,
                                        from.correlation.time_s, added);
  to->confidence_power =
      WeightedMean(to->confidence_power, before, from.confidence_power, added);
  for (int c = 0; c < kJointClassCount; ++c) {
    AddClass(from.classes[c], &to->classes[c]);
  }
}

}  // namespace

RecordingNotes::RecordingNotes(const GraphOptions& options)
    : options_(options) {
  if (options.view_bias != ViewBiasUse::kOff) {
    view_bias_ = options.given_view_bias;
  }
}

void RecordingNotes::ExpectAnotherPass() {
  expects_another_pass_ = true;
  learns_view_bias_ =
      options_.view_bias != ViewBiasUse::kOff && view_bias_ == nullptr;
}

std::shared_ptr<BiasSeries> RecordingNotes::NewSeries(const BiasJoints& joints,
                                                      int view_count) {
  if (!learns_view_bias_) return nullptr;
  const std::lock_guard<std::mutex> lock(mutex_);
  series_.push_back(std::make_shared<BiasSeries>(joints, view_count));
  return series_.back();
}

void RecordingNotes::BeginPass() {
  const std::lock_guard<std::mutex> lock(mutex_);
  people_.clear();
  expects_another_pass_ = learns_view_bias_ = false;
  if (series_.empty()) return;
  BiasSeries& all = *series_.front();
  for (size_t i = 1; i < series_.size(); ++i) all.Add(*series_[i]);
  all.RemoveShifts();
  view_bias_ = std::make_shared<ViewBias>(
      all.FitSolved(options_.view_bias == ViewBiasUse::kOn));
  series_.clear();
  if (!view_bias_->empty()) solved_.clear();
}

void RecordingNotes::Keep(std::shared_ptr<const SolvedPerson> person) {
  const std::lock_guard<std::mutex> lock(mutex_);
  solved_.push_back(std::move(person));
}

std::vector<std::shared_ptr<const SolvedPerson>> RecordingNotes::SolvedPeople()
    const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return solved_;
}

void RecordingNotes::Forget(const SolvedPerson* person) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto is_it = [&](const auto& one) { return one.get() == person; };
  solved_.erase(std::remove_if(solved_.begin(), solved_.end(), is_it),
                solved_.end());
}

std::shared_ptr<LearntNoise> RecordingNotes::NewPerson() {
  const std::lock_guard<std::mutex> lock(mutex_);
  // Merges people whose tracks have ended, so that memory stays bounded in a
  // live stream.
  constexpr size_t kMany = 1024;
  if (people_.size() >= kMany) {
    std::vector<std::shared_ptr<LearntNoise>> kept;
    kept.push_back(std::make_shared<LearntNoise>());
    for (auto& person : people_) {
      if (person.use_count() == 1) {
        AddPerson(*person, kept.front().get());
      } else {
        kept.push_back(std::move(person));
      }
    }
    people_ = std::move(kept);
  }
  people_.push_back(std::make_shared<LearntNoise>());
  return people_.back();
}

LearntNoise RecordingNotes::Noise() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  LearntNoise all;
  for (const auto& person : people_) AddPerson(*person, &all);
  RequireFinite(all);
  return all;
}

}  // namespace kinegraph
