#include "core/evaluation/smoothness.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/constants.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

std::vector<int> BodyJoints(const Skeleton& skeleton) {
  std::vector<int> joints;
  for (const JointPair& pair : CommonBodyJoints(skeleton, skeleton)) {
    joints.push_back(pair.a);
  }
  return joints;
}

const Pose3d* FindPose(const TrackSequence& tracks, int64_t frame, TrackId id) {
  const TrackFrame* at = FindFrame(tracks, frame);
  if (at == nullptr) return nullptr;
  for (const PersonPose& person : at->people) {
    if (person.id == id) return &person.joints;
  }
  return nullptr;
}

// The poses of a person's frames; null where the tracks have none.
std::vector<const Pose3d*> PosesOf(const TrackSequence& tracks,
                                   const PersonFrames& person) {
  std::vector<const Pose3d*> poses;
  for (const int64_t frame : person.frames) {
    poses.push_back(FindPose(tracks, frame, person.id));
  }
  return poses;
}

// Whether `count` frames from `first` on follow each other without a gap.
bool Consecutive(const std::vector<int64_t>& frames, size_t first,
                 size_t count) {
  return first + count <= frames.size() &&
         frames[first + count - 1] - frames[first] ==
             static_cast<int64_t>(count) - 1;
}

// 1, -2, 1 for order 2, up to the sign.
std::vector<double> DifferenceWeights(int order) {
  std::vector<double> weights = {1.0};
  for (int i = 0; i < order; ++i) {
    std::vector<double> next(weights.size() + 1, 0.0);
    for (size_t k = 0; k < weights.size(); ++k) {
      next[k] += weights[k];
      next[k + 1] -= weights[k];
    }
    weights = next;
  }
  return weights;
}

// Power above a frequency of signals of one length.
class HighPassPower {
 public:
  HighPassPower(int length, double rate_hz, double cutoff_hz)
      : window_(length), trend_(length) {
    for (int i = 0; i < length; ++i) {
      window_[i] = 0.5 - 0.5 * std::cos(2.0 * kPi * (i + 0.5) / length);
      trend_[i] = i - 0.5 * (length - 1);
    }
    // The discrete Fourier transform, bins above the cut-off alone.
    const int first =
        static_cast<int>(std::floor(cutoff_hz * length / rate_hz)) + 1;
    const int last = length / 2;
    const int bins = std::max(0, last - first + 1);
    cosine_.resize(bins, length);
    sine_.resize(bins, length);
    bin_weight_.resize(bins);
    for (int b = 0; b < bins; ++b) {
      const int bin = first + b;
      // Two-sided power, folded; the bin at half the rate is there once.
      bin_weight_[b] = 2 * bin == length ? 1.0 : 2.0;
      for (int i = 0; i < length; ++i) {
        const double angle = 2.0 * kPi * bin * i / length;
        cosine_(b, i) = std::cos(angle);
        sine_(b, i) = std::sin(angle);
      }
    }
    scale_ = 1.0 / (length * window_.squaredNorm());
  }

  // Of one coordinate, in its unit squared.
  double operator()(const Eigen::VectorXd& signal) const {
    Eigen::VectorXd rest = signal.array() - signal.mean();
    rest -= trend_ * (trend_.dot(rest) / trend_.squaredNorm());
    rest = rest.cwiseProduct(window_);
    const Eigen::VectorXd real = cosine_ * rest;
    const Eigen::VectorXd imaginary = sine_ * rest;
    return scale_ * bin_weight_.dot(real.cwiseAbs2() + imaginary.cwiseAbs2());
  }

 private:
  Eigen::VectorXd window_, trend_, bin_weight_;
  Eigen::MatrixXd cosine_, sine_;
  double scale_ = 0.0;
};

// Power of one joint over a segment; false when a position is missing.
bool SegmentPower(const std::vector<const Pose3d*>& poses, size_t first,
                  int length, int joint, const HighPassPower& power,
                  double* sum) {
  Eigen::MatrixXd positions(length, 3);
  for (int i = 0; i < length; ++i) {
    const Pose3d* pose = poses[first + static_cast<size_t>(i)];
    if (pose == nullptr || !(*pose)[joint].present()) return false;
    positions.row(i) = (*pose)[joint].position_m.transpose();
  }
  *sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) *sum += power(positions.col(axis));
  return true;
}

}  // namespace

std::vector<PersonFrames> PersonFramesOf(const TrackSequence& tracks) {
  std::map<TrackId, std::vector<int64_t>> frames;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      frames[person.id].push_back(frame.frame);
    }
  }
  std::vector<PersonFrames> people;
  for (auto& [id, of_person] : frames) {
    people.push_back({id, std::move(of_person)});
  }
  return people;
}

std::vector<RatioSeries> DifferenceSeries(
    const TrackSequence& tracks, const std::vector<PersonFrames>& people,
    int order, double rate_hz) {
  const std::vector<int> joints = BodyJoints(tracks.header.skeleton);
  const std::vector<double> weights = DifferenceWeights(order);
  const double scale = std::pow(rate_hz, order);
  std::vector<RatioSeries> all;
  for (const PersonFrames& person : people) {
    const std::vector<const Pose3d*> poses = PosesOf(tracks, person);
    RatioSeries series(person.frames.size());
    for (size_t k = 0; k < series.size(); ++k) {
      if (!Consecutive(person.frames, k, weights.size())) continue;
      for (const int j : joints) {
        Eigen::Vector3d difference = Eigen::Vector3d::Zero();
        bool observed = true;
        for (size_t i = 0; observed && i < weights.size(); ++i) {
          const Pose3d* pose = poses[k + i];
          observed =
              pose != nullptr && (*pose)[j].status == JointStatus::kObserved;
          if (observed) difference += weights[i] * (*pose)[j].position_m;
        }
        if (!observed) continue;
        series[k].sum += scale * difference.norm();
        series[k].weight += 1.0;
      }
    }
    all.push_back(std::move(series));
  }
  return all;
}

std::vector<RatioSeries> PowerSeries(const TrackSequence& tracks,
                                     const std::vector<PersonFrames>& people,
                                     double rate_hz,
                                     const PowerOptions& options) {
  std::vector<RatioSeries> all(people.size());
  if (rate_hz <= 2.0 * options.cutoff_hz) return all;
  // Even, so that segments overlap by exactly half.
  const int half = std::max(
      2, static_cast<int>(std::lround(0.5 * options.segment_s * rate_hz)));
  const int length = 2 * half;
  const std::vector<int> joints = BodyJoints(tracks.header.skeleton);
  const HighPassPower power(length, rate_hz, options.cutoff_hz);
  for (size_t p = 0; p < people.size(); ++p) {
    const PersonFrames& person = people[p];
    const std::vector<const Pose3d*> poses = PosesOf(tracks, person);
    size_t first = 0;
    while (first + static_cast<size_t>(length) <= person.frames.size()) {
      if (!Consecutive(person.frames, first, static_cast<size_t>(length))) {
        ++first;
        continue;
      }
      RatioUnit unit;
      for (const int j : joints) {
        double sum = 0.0;
        if (!SegmentPower(poses, first, length, j, power, &sum)) continue;
        unit.sum += sum;
        unit.weight += 1.0;
      }
      all[p].push_back(unit);
      first += static_cast<size_t>(half);
    }
  }
  return all;
}

}  // namespace kinegraph
