#include "core/evaluation/smoothing_balance.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/constants.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kSegmentS = 1.0;
constexpr double kLongestGapS = 0.1;
constexpr double kMostMissing = 0.2;
// A detection farther from the triangulation is of another joint or person.
constexpr double kGateM = 0.25;
// Limit of error / attainable error of the tested estimates, which lack one
// camera. Of the joints above it, 99 % exceed 1.25 with all cameras
// (SmoothingBalance::is_excessive).
constexpr double kExcess = 1.35;
constexpr int64_t kFewest = 4;  // segments

const Vector3d kMissing = Vector3d::Constant(kNan);

void Set(JointTraces* traces, TrackId person, int joint, int64_t frame,
         const Vector3d& point) {
  JointTrace& trace = (*traces)[{person, joint}];
  if (trace.points.empty()) trace.begin = frame;
  trace.points.resize(static_cast<size_t>(frame - trace.begin) + 1, kMissing);
  trace.points.back() = point;
}

template <typename PointOf>
JointTraces TracesOf(const TrackSequence& tracks,
                     const std::vector<FrameRange>& frames,
                     const PointOf& point_of) {
  JointTraces traces;
  for (const TrackFrame& frame : tracks.frames) {
    if (!ContainsFrame(frames, frame.frame)) continue;
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (!person.joints[j].present()) continue;
        const std::optional<Vector3d> point =
            point_of(person.joints[j].position_m);
        if (!point.has_value()) continue;
        Set(&traces, person.id, static_cast<int>(j), frame.frame, *point);
      }
    }
  }
  return traces;
}

const Vector3d& PointAt(const JointTrace& trace, int64_t frame) {
  const int64_t at = frame - trace.begin;
  return at < 0 || at >= static_cast<int64_t>(trace.points.size())
             ? kMissing
             : trace.points[at];
}

// Interpolates missing columns linearly; missing columns at the ends take the
// values of the nearest column.
void FillGaps(const std::vector<bool>& is_there, MatrixXd* signal) {
  const auto count = static_cast<Eigen::Index>(is_there.size());
  Eigen::Index before = -1;
  for (Eigen::Index i = 0; i <= count; ++i) {
    if (i < count && !is_there[i]) continue;
    for (Eigen::Index k = before + 1; k < i; ++k) {
      if (before < 0) {
        signal->col(k) = signal->col(i);
      } else if (i == count) {
        signal->col(k) = signal->col(before);
      } else {
        const double share =
            static_cast<double>(k - before) / static_cast<double>(i - before);
        signal->col(k) =
            (1.0 - share) * signal->col(before) + share * signal->col(i);
      }
    }
    before = i;
  }
}

struct MeanAndVariance {
  double mean = 0.0;
  double variance = 0.0;  // of the mean
};
MeanAndVariance MeanOf(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  MeanAndVariance result;
  for (const double value : values) result.mean += value / count;
  for (const double value : values) {
    const double off = value - result.mean;
    result.variance += off * off / (count * (count - 1.0));
  }
  return result;
}

// One-sided 99 % quantile of Student's t for the mean of `count` values, never
// too small from 4 on (exact: 4.54 for 4, 3.00 for 8, 2.60 for 16, 2.33 for
// many).
double LeastSigmas(int64_t count) {
  return 2.33 + 6.7 / static_cast<double>(count - 1);
}

double RootOf(double square) { return std::sqrt(std::max(0.0, square)); }

}  // namespace

JointTraces WorldTraces(const TrackSequence& tracks,
                        const std::vector<FrameRange>& frames) {
  return TracesOf(tracks, frames, [](const Vector3d& point_m) {
    return std::optional(point_m);
  });
}

JointTraces ImageTraces(const TrackSequence& tracks, const Camera& camera,
                        const std::vector<FrameRange>& frames) {
  return TracesOf(tracks, frames,
                  [&](const Vector3d& point_m) -> std::optional<Vector3d> {
                    const auto pixel = camera.Project(point_m);
                    if (!pixel.has_value()) return std::nullopt;
                    return Vector3d(pixel->x(), pixel->y(),
                                    camera.Depth(point_m) / camera.focal_px());
                  });
}

JointTraces DetectedTraces(const HeldOutSet& set,
                           const DetectionSequence& detections, int view_idx,
                           const Skeleton& skeleton) {
  const JointPairs joints = CommonJoints(detections.header.skeleton, skeleton);
  const std::string& view = detections.header.view_names[view_idx];
  JointTraces traces;
  for (const HeldOutDetection& item : set.detections) {
    if (item.view_name != view) continue;
    const DetectionFrame* frame = FindDetectionFrame(detections, item.frame);
    if (frame == nullptr) continue;
    for (const Detection& detection : frame->views[view_idx].detections) {
      if (detection.index_in_file != item.detection_idx) continue;
      for (const JointPair& joint : joints) {
        const Keypoint& keypoint = detection.joints[joint.a];
        if (!keypoint.found || keypoint.confidence < set.min_confidence) {
          continue;
        }
        Set(&traces, item.person, joint.b, item.frame,
            {keypoint.px.x(), keypoint.px.y(), 0.0});
      }
    }
  }
  return traces;
}

SmoothingSpectra::SmoothingSpectra(double rate_hz)
    : half_(std::max(4,
                     static_cast<int>(std::lround(0.5 * kSegmentS * rate_hz)))),
      longest_(std::max(1, static_cast<int>(kLongestGapS * rate_hz))),
      transform_(2 * half_) {
  for (int bin = 1; bin <= half_; ++bin) {
    band_of_.push_back(
        static_cast<int>(std::floor(2.0 * std::log2(bin) + 1e-9)));
    band_count_ = band_of_.back() + 1;
  }
}

SmoothingSpectra::Segment SmoothingSpectra::SegmentOf(
    const std::array<MatrixXd, 3>& signals) const {
  std::array<Eigen::MatrixXcd, 3> spectra;  // [bins, axes]
  for (size_t k = 0; k < signals.size(); ++k) {
    spectra[k] = transform_(signals[k].transpose());
  }
  const auto& [reference, raw, smoothed] = spectra;
  Segment segment(band_count_);
  for (int bin = 0; bin < half_; ++bin) {
    Band& band = segment[band_of_[bin]];
    for (Eigen::Index axis = 0; axis < reference.cols(); ++axis) {
      const std::complex<double> u = std::conj(reference(bin, axis));
      const std::complex<double> b = raw(bin, axis);
      const std::complex<double> a = smoothed(bin, axis);
      band.motion += (u * b).real();
      band.removed += u * (b - a);
      band.raw += std::norm(b);
      band.smoothed += std::norm(a);
    }
  }
  return segment;
}

void SmoothingSpectra::Add(const JointTraces& reference, const JointTraces& raw,
                           const JointTraces& smoothed,
                           std::optional<int> view) {
  const int64_t length = 2 * half_;
  for (const auto& [key, of_reference] : reference) {
    const auto of_raw = raw.find(key);
    const auto of_smoothed = smoothed.find(key);
    if (of_raw == raw.end() || of_smoothed == smoothed.end()) continue;
    const int64_t end =
        of_reference.begin + static_cast<int64_t>(of_reference.points.size());
    // Segments begin at multiples of half their length, so that every view has
    // the same ones.
    int64_t first =
        (of_reference.begin + half_ - 1) / half_ * static_cast<int64_t>(half_);
    for (; first + length <= end; first += half_) {
      std::vector<bool> is_there(length, true);
      std::array<MatrixXd, 3> signals;
      signals.fill(MatrixXd(view.has_value() ? 2 : 3, length));
      double scale = 0.0;
      int64_t missing = 0;
      int64_t in_a_row = 0;
      bool is_usable = true;
      for (int64_t i = 0; i < length && is_usable; ++i) {
        const Vector3d& u = PointAt(of_reference, first + i);
        const Vector3d& b = PointAt(of_raw->second, first + i);
        const Vector3d& a = PointAt(of_smoothed->second, first + i);
        const double metres = view.has_value() ? b.z() : 1.0;
        const Eigen::Index axes = signals[0].rows();
        const bool there = a.allFinite() && metres * (u - b).head(axes).norm() <
                                                kGateM;  // false for NaN
        in_a_row = there ? 0 : in_a_row + 1;
        missing += there ? 0 : 1;
        is_usable = in_a_row <= longest_ &&
                    static_cast<double>(missing) <=
                        kMostMissing * static_cast<double>(length);
        is_there[i] = there;
        if (!there) continue;
        scale += metres;
        signals[0].col(i) = u.head(axes);
        signals[1].col(i) = b.head(axes);
        signals[2].col(i) = a.head(axes);
      }
      if (!is_usable) continue;
      // The scale is constant within a segment, so that changes of depth do not
      // alter the signals.
      scale /= static_cast<double>(length - missing);
      for (MatrixXd& signal : signals) {
        FillGaps(is_there, &signal);
        signal *= scale;
      }
      segments_[{key.second, key.first, view.value_or(0), first}] =
          SegmentOf(signals);
    }
  }
}

void SmoothingSpectra::Merge(const SmoothingSpectra& other) {
  segments_.insert(other.segments_.begin(), other.segments_.end());
}

SmoothingBalance SmoothingSpectra::OfJoint(int joint) const {
  std::vector<const Segment*> segments;
  for (auto at = segments_.lower_bound({joint, TrackId(), 0, INT64_MIN});
       at != segments_.end() && std::get<0>(at->first) == joint; ++at) {
    segments.push_back(&at->second);
  }
  SmoothingBalance balance;
  balance.segments = static_cast<int64_t>(segments.size());
  if (balance.segments < kFewest) {
    balance.error_m = balance.removed_m = balance.kept_m =
        balance.attainable_m = kNan;
    return balance;
  }
  const auto mean = [&](const auto& of_segment) {
    std::vector<double> values;
    for (const Segment* one : segments) values.push_back(of_segment(*one));
    return MeanOf(values);
  };
  const double least_sigmas = LeastSigmas(balance.segments);
  double error = 0.0;
  double removed = 0.0;
  double attainable = 0.0;
  double uncorrelated = 0.0;  // sum of E[a* a] - |E[u* a]|
  std::vector<double> excess(segments.size(), 0.0);
  for (int b = 0; b < band_count_; ++b) {
    const MeanAndVariance motion =
        mean([b](const Segment& one) { return one[b].motion; });
    const double raw =
        mean([b](const Segment& one) { return one[b].raw; }).mean;
    const MeanAndVariance real =
        mean([b](const Segment& one) { return one[b].removed.real(); });
    const MeanAndVariance imaginary =
        mean([b](const Segment& one) { return one[b].removed.imag(); });
    const double signal = std::max(0.0, motion.mean);
    const double noise = std::max(0.0, raw - signal);
    const double total = signal + noise;
    const double motion_share = total > 0.0 ? signal / total : 0.0;
    const double noise_share = 1.0 - motion_share;
    attainable += motion_share * noise;
    const double smoothed =
        mean([b](const Segment& one) { return one[b].smoothed; }).mean;
    uncorrelated += smoothed - std::abs(std::complex<double>(
                                   motion.mean - real.mean, -imaginary.mean));
    if (signal > 2.0 * std::sqrt(motion.variance)) {
      // The square of an estimate is too large by its variance. A band may
      // come out below 0, so that the sum is right on average.
      removed += (real.mean * real.mean - real.variance +
                  imaginary.mean * imaginary.mean - imaginary.variance) /
                 signal;
    }
    for (size_t i = 0; i < segments.size(); ++i) {
      const Band& band = (*segments[i])[b];
      const double of_error =
          band.smoothed - band.motion + 2.0 * band.removed.real();
      error += of_error / static_cast<double>(segments.size());
      // Linear in the spectra: attainable = (N/(S+N))^2 S + (S/(S+N))^2 N.
      const double of_attainable =
          noise_share * noise_share * band.motion +
          motion_share * motion_share * (band.raw - band.motion);
      excess[i] += of_error - kExcess * kExcess *
                                  (motion.mean > 0.0 ? of_attainable : 0.0);
    }
  }
  removed = std::max(0.0, removed);
  const double kept = std::max(0.0, error - removed);
  balance.error_m = RootOf(error);
  balance.removed_m = RootOf(removed);
  balance.kept_m = RootOf(kept);
  balance.attainable_m = RootOf(attainable);
  if (uncorrelated < 0.5 * (error - attainable)) {
    balance.excess = SmoothingBalance::Excess::kMotionRemoved;
  }
  const MeanAndVariance over = MeanOf(excess);
  balance.is_excessive = over.mean > least_sigmas * std::sqrt(over.variance);
  return balance;
}

SmoothingBalance PooledBalance(const std::vector<SmoothingBalance>& joints) {
  SmoothingBalance sum;
  double weight = 0.0;
  double squares[4] = {};
  for (const SmoothingBalance& one : joints) {
    sum.segments += one.segments;
    if (std::isnan(one.error_m)) continue;
    const auto count = static_cast<double>(one.segments);
    weight += count;
    squares[0] += count * one.error_m * one.error_m;
    squares[1] += count * one.removed_m * one.removed_m;
    squares[2] += count * one.kept_m * one.kept_m;
    squares[3] += count * one.attainable_m * one.attainable_m;
  }
  sum.error_m = std::sqrt(squares[0] / weight);
  sum.removed_m = std::sqrt(squares[1] / weight);
  sum.kept_m = std::sqrt(squares[2] / weight);
  sum.attainable_m = std::sqrt(squares[3] / weight);
  return sum;
}

}  // namespace kinegraph
