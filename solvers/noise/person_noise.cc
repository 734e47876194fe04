#include "solvers/noise/person_noise.h"

#include <algorithm>
#include <cmath>

#include "solvers/graph/assembler.h"

namespace kinegraph {
namespace {

// Variance assumed before the first point is triangulated: (1 cm)^2.
constexpr double kUnknownVariance_m2 = 1e-4;

}  // namespace

PersonNoise::PersonNoise(const SceneModel& scene, const GraphOptions& options)
    : scene_(scene),
      options_(options),
      triangulator_(scene.cameras),
      confidences_(options.confidence_power, scene.frame_rate_hz),
      correlations_(scene.skeleton.joint_count(),
                    static_cast<int>(scene.cameras.size()),
                    scene.frame_rate_hz),
      groups_(scene.skeleton),
      last_variance_m2_(scene.skeleton.joint_count(), kUnknownVariance_m2),
      chains_(kJointClassCount, LevelChain(0.0)) {
  by_class_.scale.fill(1.0);
  by_class_.points.fill(1.0);
  by_class_.lag.fill(1.0);
  for (int j = 0; j < joint_count(); ++j) {
    banks_.emplace_back(UsualProcessNoise(scene.skeleton.joint_class(j)));
    present_[ClassOf(j)] = true;
  }
  if (options_.pixel_noise_from == NoiseFrom::kRecording) {
    correlation_ = correlations_.Fit();
  } else if (options_.correlation_time_s > 0.0) {
    // The share of CorrelationLearner's prior.
    correlation_ = {0.9, options_.correlation_time_s};
  }
}

bool PersonNoise::Load(const PersonProblem& problem, size_t k, int joint_idx,
                       size_t place) {
  const size_t at = place * static_cast<size_t>(joint_count()) +
                    static_cast<size_t>(joint_idx);
  const JointChain& chain = problem.joints[joint_idx];
  return at < starts_.size() ? triangulator_.LoadAgain(chain, k, starts_[at])
                             : triangulator_.Load(chain, k);
}

void PersonNoise::LearnPixels(const PersonProblem& problem, size_t k) {
  const bool looks_at_confidences =
      !knows_confidences_ && confidences_.BeginFrame(problem.times[k]);
  for (int j = 0; j < joint_count(); ++j) {
    if (triangulator_.Load(problem.joints[j], k)) {
      const JointClass joint_class = scene_.skeleton.joint_class(j);
      scales_.Add(joint_class, triangulator_.residuals());
      if (looks_at_confidences) {
        confidences_.Add(
            joint_class, triangulator_.views(), triangulator_.log_confidences(),
            triangulator_.start().position_m, triangulator_.weighting());
      }
    }
    starts_.push_back(triangulator_.start());
  }
}

void PersonNoise::LearnRecordingsPixels(const PersonProblem& recording) {
  const auto learn = [&] {
    for (size_t k = 0; k < recording.times.size(); ++k) {
      LearnPixels(recording, k);
    }
  };
  learn();
  triangulator_.set_weighting(confidences_.Fit());
  knows_confidences_ = true;
  if (triangulator_.weighting().added_power == 0.0) return;
  // The weighting changes the points and the size of their errors.
  scales_ = NoiseScales();
  starts_.clear();
  learn();
}

void PersonNoise::RefreshScales() {
  for (int c = 0; c < kJointClassCount; ++c) {
    by_class_.scale[c] = scales_.Scale(static_cast<JointClass>(c));
  }
}

void PersonNoise::LearnCorrelation(const PersonProblem& problem, size_t k,
                                   size_t place) {
  for (int j = 0; j < joint_count(); ++j) {
    if (!Load(problem, k, j, place)) continue;
    correlations_.Add(j, problem.times[k], by_class_.scale[ClassOf(j)],
                      triangulator_.residuals());
  }
}

std::vector<LevelChain::Vector> PersonNoise::Count(
    const std::vector<Levels>& evidence) {
  std::vector<LevelChain::Vector> likelihoods;
  for (int g = 0; g < groups_.size(); ++g) {
    Levels& of_class = evidence_[static_cast<int>(groups_.joint_class(g))];
    for (int i = 0; i < kLevelCount; ++i) of_class[i] += evidence[g][i];
    likelihoods.push_back(Likelihood(evidence[g]));
  }
  return likelihoods;
}

// Triangulates the joints of frame `k`, adds their evidence and keeps the
// frame.
void PersonNoise::Locate(const PersonProblem& problem, size_t k, size_t place) {
  Frame& frame = frames_.emplace_back();
  std::vector<Levels> evidence(static_cast<size_t>(groups_.size()));
  frame.time = problem.times[k];
  frame.variance_m2.reserve(static_cast<size_t>(joint_count()));
  for (int j = 0; j < joint_count(); ++j) {
    std::optional<FramePoint> point;
    if (Load(problem, k, j, place)) {
      point = triangulator_.Robust(by_class_.scale[ClassOf(j)]);
    }
    if (keeps_points_) {
      auto& kept = points_.emplace_back();
      kept.setConstant(std::nanf(""));
      if (point.has_value()) {
        if (!origin_m_.has_value()) origin_m_ = point->position_m;
        kept.col(0) = (point->position_m - *origin_m_).cast<float>();
        kept.col(1) = point->covariance_m2.diagonal().cast<float>();
      }
    }
    if (point.has_value()) {
      last_variance_m2_[j] = point->covariance_m2.trace() / 3.0;
    }
    frame.variance_m2.push_back(last_variance_m2_[j]);
    banks_[j].Add(frame.time, point, correlation_,
                  &evidence[groups_.of_joint(j)]);
  }
  likelihoods_.push_back(Count(evidence));
}

// Also runs the filters backwards in time and averages the log-evidence: a
// filter detects a rise of the level only after some frames, and a delayed
// level makes the smoother lag.
void PersonNoise::LookBack() {
  std::vector<FilterBank> banks;
  banks.reserve(static_cast<size_t>(joint_count()));
  for (int j = 0; j < joint_count(); ++j) {
    banks.emplace_back(UsualProcessNoise(scene_.skeleton.joint_class(j)));
  }
  for (size_t k = frames_.size(); k-- > 0;) {
    std::vector<Levels> evidence(static_cast<size_t>(groups_.size()));
    for (int j = 0; j < joint_count(); ++j) {
      const auto& kept = points_[k * banks.size() + static_cast<size_t>(j)];
      std::optional<FramePoint> point;
      if (kept.allFinite()) {
        point.emplace();
        point->position_m = kept.col(0).cast<double>();
        point->covariance_m2 = kept.col(1).cast<double>().asDiagonal();
      }
      banks[j].Add(-frames_[k].time, point, correlation_,
                   &evidence[groups_.of_joint(j)]);
    }
    const std::vector<LevelChain::Vector> back = Count(evidence);
    for (int g = 0; g < groups_.size(); ++g) {
      LevelChain::Vector& seen = likelihoods_[k][g];
      seen = seen.cwiseProduct(back[g]).cwiseSqrt();
    }
  }
  for (Levels& of_class : evidence_) {
    for (double& level : of_class) level *= 0.5;
  }
}

void PersonNoise::LearnRecording(const PersonProblem& recording) {
  const size_t frames = recording.times.size();
  if (options_.pixel_noise_from == NoiseFrom::kRecording) {
    LearnRecordingsPixels(recording);
    RefreshScales();
    for (size_t k = 0; k < frames; ++k) LearnCorrelation(recording, k, k);
    correlation_ = correlations_.Fit();
  }
  keeps_points_ = true;
  for (size_t k = 0; k < frames; ++k) Locate(recording, k, k);
  LookBack();
  starts_ = std::vector<FrameTriangulator::Start>();
  covariance_factors_.emplace(correlation_, 1.0 / scene_.frame_rate_hz);
}

void PersonNoise::AddFrame(const PersonProblem& problem, size_t k,
                           Refit refit) {
  const bool learns = options_.pixel_noise_from == NoiseFrom::kRecording;
  const bool fits = learns && refit == Refit::kNow;
  if (fits) triangulator_.set_weighting(confidences_.Fit());
  if (learns) LearnPixels(problem, k);
  if (fits) {
    RefreshScales();
    // Frames without a fit are skipped, because at high frame rates the others
    // contain nearly all the information.
    LearnCorrelation(problem, k, 0);
  }
  Locate(problem, k, 0);
  starts_.clear();
  if (fits) correlation_ = correlations_.Fit();
}

LevelChain::Vector PersonNoise::Foresee(int group, TimeNs time) {
  LevelChain& chain = chains_[static_cast<int>(groups_.joint_class(group))];
  if (belief_.empty()) return chain.stationary();
  return chain.Transition(time - belief_time_) * belief_[group];
}

void PersonNoise::DropFirstFrame() {
  const Frame& first = frames_.front();
  std::vector<LevelChain::Vector> belief;
  for (int g = 0; g < groups_.size(); ++g) {
    belief.push_back(Believe(Foresee(g, first.time), likelihoods_.front()[g]));
  }
  belief_ = std::move(belief);
  belief_time_ = first.time;
  frames_.erase(frames_.begin());
  likelihoods_.erase(likelihoods_.begin());
}

double PersonNoise::FrameSeconds(size_t k) const {
  if (frames_.size() < 2) return 1.0 / scene_.frame_rate_hz;
  const size_t end = std::max<size_t>(k, 1);
  return ToSeconds(frames_[end].time - frames_[end - 1].time);
}

// ln of the group's level relative to the typical power, in every kept frame.
std::vector<double> PersonNoise::LevelsOf(int group) {
  std::vector<TimeNs> times;
  std::vector<LevelChain::Vector> seen;
  for (size_t k = 0; k < frames_.size(); ++k) {
    times.push_back(frames_[k].time);
    seen.push_back(likelihoods_[k][group]);
  }
  return SmoothLevels(Foresee(group, times[0]), times, seen,
                      &chains_[static_cast<int>(groups_.joint_class(group))]);
}

// Large noise masks slow motion: a head that bobs in walking appears at rest,
// and the evidence, from a model without bobbing, is overconfident about this.
// But a person's joints move together, and the motion of limbs is too large to
// be masked. Therefore a joint's level relative to its typical level is at
// least the mean over the person's joint classes, as far as this does not raise
// the smoother's crossover frequency (information.h) above the frequency up to
// which noise may mask motion.
double PersonNoise::ProcessNoiseOf(int joint_idx, size_t k, double level,
                                   double activity) const {
  // In gait, trunk and head have nearly all their motion below this frequency;
  // such recordings are commonly filtered at 3 to 6 Hz.
  constexpr double kHides_hz = 2.5;
  const double usual =
      UsualProcessNoise(scene_.skeleton.joint_class(joint_idx));
  const double hidden =
      ProcessNoiseOfCrossover(correlation_, FrameSeconds(k),
                              frames_[k].variance_m2[joint_idx], kHides_hz);
  return std::max(usual * std::exp(level),
                  std::min(usual * std::exp(activity), hidden));
}

void PersonNoise::FindLevels() {
  for (int c = 0; c < kJointClassCount; ++c) {
    if (!present_[c]) continue;
    const double level = RecordingLevel(evidence_[c]);
    if (level == by_class_.level[c]) continue;
    by_class_.level[c] = level;
    chains_[c] = LevelChain(level);
  }
}

void PersonNoise::FindProcessNoise() {
  std::vector<std::vector<double>> levels;
  std::vector<double> activity(frames_.size(), 0.0);  // mean over classes
  const auto classes =
      static_cast<double>(std::count(present_.begin(), present_.end(), true));
  for (int g = 0; g < groups_.size(); ++g) {
    levels.push_back(LevelsOf(g));
    const double share = groups_.share_of_class(g) / classes;
    for (size_t k = 0; k < frames_.size(); ++k) {
      activity[k] += share * levels[g][k];
    }
  }
  for (int j = 0; j < joint_count(); ++j) {
    for (size_t k = 0; k < frames_.size(); ++k) {
      frames_[k].process_noise[j] =
          ProcessNoiseOf(j, k, levels[groups_.of_joint(j)][k], activity[k]);
    }
  }
}

void PersonNoise::FindLag() {
  const auto joints = static_cast<size_t>(joint_count());
  std::array<LagLearner, kJointClassCount> learners;
  std::vector<LagSample> samples(frames_.size());
  for (size_t j = 0; j < joints; ++j) {
    for (size_t k = 0; k < frames_.size(); ++k) {
      const double variance_m2 = frames_[k].variance_m2[j];
      const double q = frames_[k].process_noise[j];
      const double before = k > 0 ? frames_[k - 1].process_noise[j] : q;
      samples[k] = {ToSeconds(frames_[k].time - frames_.front().time),
                    points_[k * joints + j].col(0).cast<double>(), variance_m2,
                    std::max(before, q),
                    covariance_factors_->LeftoverAt(q, variance_m2)};
    }
    learners[ClassOf(static_cast<int>(j))].Add(samples);
  }
  for (int c = 0; c < kJointClassCount; ++c) {
    const LagLearner::Ratios ratios = learners[c].Fit();
    by_class_.points[c] = ratios.noise;
    by_class_.lag[c] = ratios.lag;
  }
}

AppliedNoise PersonNoise::ExtractApplied() {
  return {std::move(frames_), Learnt(), by_class_, triangulator_.weighting()};
}

void PersonNoise::Adopt(const AppliedNoise& noise,
                        const std::vector<size_t>& frame_of,
                        const std::vector<TimeNs>& times) {
  taken_over_ = true;
  by_class_ = noise.by_class;
  for (int c = 0; c < kJointClassCount; ++c) {
    chains_[c] = LevelChain(by_class_.level[c]);
  }
  correlation_ = noise.learnt.correlation;
  triangulator_.set_weighting(noise.weighting);
  covariance_factors_.emplace(correlation_, 1.0 / scene_.frame_rate_hz);
  frames_.clear();
  if (noise.frames.empty()) return;  // nothing was learnt
  for (size_t k = 0; k < frame_of.size(); ++k) {
    frames_.push_back(noise.frames[frame_of[k]]);
    frames_.back().time = times[k];
    frames_.back().divisors.clear();  // recomputed identically
  }
}

void PersonNoise::LearnMotionAgain(const PersonProblem& recording, size_t from,
                                   size_t to, size_t begin, size_t end) {
  PersonNoise there(scene_, options_);
  there.by_class_ = by_class_;
  there.chains_ = chains_;
  there.correlation_ = correlation_;
  there.triangulator_.set_weighting(triangulator_.weighting());
  there.keeps_points_ = true;
  for (size_t k = from; k < to; ++k) {
    there.Locate(recording, k, k - from);
    there.frames_.back().process_noise = frames_[k].process_noise;
  }
  if (options_.process_noise_from == NoiseFrom::kRecording) {
    there.LookBack();
    there.FindProcessNoise();
  }
  for (size_t k = begin; k < end; ++k) {
    frames_[k] = std::move(there.frames_[k - from]);
  }
}

void PersonNoise::Apply(PersonProblem* problem) {
  ApplyProcessNoise(problem);
  ApplyPixelNoise(problem);
}

void PersonNoise::ApplyProcessNoise(PersonProblem* problem) {
  const bool learns = options_.process_noise_from == NoiseFrom::kRecording;
  if (!taken_over_) {
    for (Frame& frame : frames_) {
      frame.process_noise.resize(static_cast<size_t>(joint_count()));
      for (int j = 0; j < joint_count() && !learns; ++j) {
        frame.process_noise[j] = options_.process_noise[ClassOf(j)];
      }
    }
    if (learns) {
      FindLevels();
      FindProcessNoise();
    }
  }
  if (keeps_points_ && options_.pixel_noise_from == NoiseFrom::kRecording) {
    FindLag();
  }
  if (keeps_points_) {  // no longer needed, nor data derived from them
    points_ = decltype(points_)();
    likelihoods_ = decltype(likelihoods_)();
    keeps_points_ = false;
  }
  if (!learns) return;
  for (int j = 0; j < joint_count(); ++j) {
    const int c = ClassOf(j);
    for (size_t k = 1; k < frames_.size(); ++k) {
      // An interval has the greater process noise of its two frames.
      const double q = std::max(frames_[k - 1].process_noise[j],
                                frames_[k].process_noise[j]);
      problem->joints[j].process_noise[k - 1] = q;
      least_[c] = least_[c] > 0.0 ? std::min(least_[c], q) : q;
      greatest_[c] = std::max(greatest_[c], q);
    }
  }
}

void PersonNoise::ApplyPixelNoise(PersonProblem* problem) {
  if (options_.pixel_noise_from != NoiseFrom::kRecording) return;
  for (size_t k = 0; k < frames_.size(); ++k) {
    Frame& frame = frames_[k];
    frame.divisors.resize(static_cast<size_t>(joint_count()), 0.0);
    const double frame_s = FrameSeconds(k);
    for (int j = 0; j < joint_count(); ++j) {
      JointChain& chain = problem->joints[j];
      const int32_t first = chain.first[k];
      const int32_t stop = chain.first[k + 1];
      if (first == stop) continue;
      const double scale = kLearntWidening * by_class_.scale[ClassOf(j)];
      double& divisor = frame.divisors[j];
      divisor =
          InformationDivisor(correlation_, frame_s, frame.process_noise[j],
                             frame.variance_m2[j], divisor);
      const double information = kLearntWidening * kLearntWidening / divisor;
      for (int32_t m = first; m < stop; ++m) {
        PixelMeasurement& measurement = chain.measurements[m];
        measurement.sigma_px =
            scale * measurement.model_sigma_px *
            triangulator_.weighting().SigmaFactor(measurement.log_confidence);
        measurement.information = information;
      }
    }
  }
}

double PersonNoise::CovarianceFactorOf(int joint_idx, size_t k, bool observed) {
  if (options_.pixel_noise_from != NoiseFrom::kRecording) return 1.0;
  const double frame_s = FrameSeconds(k);
  const double process_noise = frames_[k].process_noise[joint_idx];
  const double variance_m2 = frames_[k].variance_m2[joint_idx];
  // Times are rounded to nanoseconds.
  constexpr double kRoundingS = 2e-9;
  const bool steady =
      covariance_factors_.has_value() &&
      std::abs(frame_s - covariance_factors_->frame_s()) <= kRoundingS;
  const double factor =
      steady
          ? covariance_factors_->At(process_noise, variance_m2)
          : CovarianceFactor(correlation_, frame_s, process_noise, variance_m2);
  if (!observed) return factor;
  const int c = ClassOf(joint_idx);
  return by_class_.points[c] * (factor - kLagShare) +
         kLagShare * by_class_.lag[c];
}

LearntNoise PersonNoise::Learnt() const {
  LearntNoise learnt;
  const ConfidenceWeighting& weighting = triangulator_.weighting();
  for (int c = 0; c < kJointClassCount; ++c) {
    if (!present_[c]) continue;
    LearntNoise::OfClass& of_class = learnt.classes[c];
    of_class.joints_seen = scales_.count(static_cast<JointClass>(c));
    of_class.sigma_px =
        options_.sigma_px[c] * by_class_.scale[c] * weighting.SigmaFactor(0.0);
    of_class.process_noise = UsualProcessNoise(static_cast<JointClass>(c)) *
                             std::exp(by_class_.level[c]);
    of_class.least_process_noise = least_[c];
    of_class.greatest_process_noise = greatest_[c];
  }
  learnt.correlation = correlation_;
  learnt.confidence_power = options_.confidence_power + weighting.added_power;
  return learnt;
}

}  // namespace kinegraph
