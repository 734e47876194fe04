#include "solvers/cameras/segments.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/base/constants.h"
#include "core/base/median.h"
#include "core/evaluation/statistics.h"
#include "core/geometry/triangulation.h"

namespace kinegraph {
namespace {

template <typename Visit>
void ForEachJoint(DetectionSequence* detections, const Visit& visit) {
  for (DetectionFrame& frame : detections->frames) {
    for (ViewDetections& view : frame.views) {
      for (Detection& detection : view.detections) {
        for (Keypoint& joint : detection.joints) visit(&joint);
      }
    }
  }
}

// A detection matched with a person.
struct SeenView {
  int view = 0;
  const Detection* detection = nullptr;
  TimeNs capture_time = 0;
};
// A frame of a person with the matched detections.
struct SeenFrame {
  TimeNs time = 0;
  std::vector<SeenView> views;
};

std::vector<SeenFrame> FramesOf(const FrozenPerson& person,
                                const DetectionSequence& detections) {
  std::vector<SeenFrame> frames;
  for (const FrozenFrame& frozen : person.frames) {
    const DetectionFrame* frame = FindDetectionFrame(detections, frozen.frame);
    if (frame == nullptr || frozen.detections.empty()) continue;
    SeenFrame seen;
    seen.time = frame->time;
    for (const FrozenDetection& one : frozen.detections) {
      const ViewDetections& view = frame->views[one.view_idx];
      const Detection* detection = FindDetection(view, one.detection_idx);
      if (detection == nullptr) continue;
      seen.views.push_back({one.view_idx, detection, view.capture_time});
    }
    frames.push_back(std::move(seen));
  }
  return frames;
}

// A run of frames of a person, begin .. end - 1, from which the segments of
// joints are made.
struct Run {
  size_t person = 0;
  size_t begin = 0;
  size_t end = 0;
};

// Splits a person's frames into runs that are at most `span` long and have no
// gap of two frame intervals or more.
std::vector<Run> RunsOf(size_t person, const std::vector<SeenFrame>& frames,
                        TimeNs interval, TimeNs span) {
  std::vector<Run> runs;
  for (size_t k = 0; k < frames.size(); ++k) {
    const bool joins = !runs.empty() &&
                       frames[k].time - frames[k - 1].time < 2 * interval &&
                       frames[k].time - frames[runs.back().begin].time <= span;
    if (!joins) runs.push_back({person, k, k});
    runs.back().end = k + 1;
  }
  return runs;
}

// Standard deviation of a detected joint [px] (SegmentOptions::sigma_px).
double JointSigma(const SegmentOptions& options, const Keypoint& joint,
                  const Camera& camera, double depth_m) {
  constexpr double kReferencePxPerMetre = 1000.0 / 4.0;
  const double scale = camera.focal_px() / depth_m / kReferencePxPerMetre;
  const double confidence = std::min(1.0, std::max(0.05, joint.confidence));
  return std::max(options.min_sigma_px,
                  options.sigma_px * scale / std::sqrt(confidence));
}

// Triangulates the joint (DLT) in the frame nearest to the middle in which at
// least two views saw it and their rays determine it.
std::optional<Eigen::Vector3d> StartOf(const CameraRig& cameras,
                                       const std::vector<SeenFrame>& frames,
                                       const Run& run, int joint,
                                       double min_confidence) {
  const size_t middle = (run.begin + run.end) / 2;
  std::vector<size_t> order;
  for (size_t k = run.begin; k < run.end; ++k) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return std::max(a, middle) - std::min(a, middle) <
           std::max(b, middle) - std::min(b, middle);
  });
  for (const size_t k : order) {
    std::vector<PointMeasurement> measurements;
    for (const auto& [view, detection, capture_time] : frames[k].views) {
      const Keypoint& point = detection->joints[joint];
      if (!point.found || point.confidence < min_confidence) continue;
      const auto ideal = cameras[view].Undistort(point.px);
      if (!ideal.has_value()) continue;
      measurements.push_back({&cameras[view], *ideal, 1.0});
    }
    if (measurements.size() < 2) continue;
    TriangulationOptions options;
    options.min_angle_rad = 0.03;  // smaller angles do not determine depth
    const TriangulationResult result =
        TriangulateDlt({measurements.data(), measurements.size()}, options);
    if (result.ok()) return result.point_m;
  }
  return std::nullopt;
}

// Square root of the weight at a position between the middle (0) and the end
// (1) of a segment: a Hann window, whose centroid hardly depends on the
// sampling times.
double TaperAt(double share) {
  return std::abs(share) < 1.0 ? std::cos(0.5 * kPi * share) : 0.0;
}
constexpr double kLeastTaper = 0.1;

// False if the joint cannot be triangulated or fewer than two views saw it.
bool MakeSegment(const CameraRig& cameras, const std::vector<SeenFrame>& frames,
                 const Run& run, int joint, TimeNs recording_middle,
                 TimeNs interval, const SegmentOptions& options,
                 MotionSegment* segment) {
  const auto start =
      StartOf(cameras, frames, run, joint, options.min_confidence);
  if (!start.has_value()) return false;
  const TimeNs middle = frames[run.begin].time +
                        (frames[run.end - 1].time - frames[run.begin].time) / 2;
  segment->person = static_cast<int>(run.person);
  segment->joint = joint;
  segment->middle_s = ToSeconds(middle - recording_middle);
  segment->state.setZero();
  segment->state.head<3>() = *start;
  std::vector<char> seen(cameras.size(), 0);
  const double reach_s = 0.5 * ToSeconds(frames[run.end - 1].time -
                                         frames[run.begin].time + interval);
  for (size_t k = run.begin; k < run.end; ++k) {
    for (const auto& [view, detection, capture_time] : frames[k].views) {
      const Keypoint& point = detection->joints[joint];
      if (!point.found || point.confidence < options.min_confidence) continue;
      const double depth_m = cameras[view].Depth(*start);
      if (!(depth_m > 0.0)) continue;
      SegmentMeasurement measurement;
      measurement.view_idx = view;
      measurement.time_s = ToSeconds(capture_time - middle);
      measurement.px = point.px;
      measurement.sigma_px = JointSigma(options, point, cameras[view], depth_m);
      if (options.tapered) {
        const double taper = TaperAt(measurement.time_s / reach_s);
        if (taper < kLeastTaper) continue;
        measurement.sigma_px /= taper;
      }
      segment->measurements.push_back(measurement);
      seen[view] = 1;
    }
  }
  return std::count(seen.begin(), seen.end(), 1) >= 2;
}

// Fills SceneSegments::matched and matchable. The people that a view could
// match in a frame are those matched in at least two views, but not more than
// the view has detections.
void CountMatches(const DetectionSequence& detections,
                  const FrozenMatches& matches, SceneSegments* segments) {
  struct Frame {
    int64_t people = 0;            // people matched in at least two views
    std::vector<int64_t> matched;  // [view]
  };
  const auto views = static_cast<size_t>(segments->view_count);
  std::map<int64_t, Frame> by_number;
  for (const FrozenPerson& person : matches.people) {
    for (const FrozenFrame& frame : person.frames) {
      if (frame.detections.size() < 2) continue;
      Frame& counts = by_number[frame.frame];
      ++counts.people;
      counts.matched.resize(views, 0);
      for (const FrozenDetection& one : frame.detections) {
        ++counts.matched[one.view_idx];
      }
    }
  }
  segments->matched.assign(views, 0);
  segments->matchable.assign(views, 0);
  for (const auto& [number, frame] : by_number) {
    const DetectionFrame* seen = FindDetectionFrame(detections, number);
    if (seen == nullptr) continue;
    for (size_t v = 0; v < views; ++v) {
      int others = 0;
      for (size_t u = 0; u < views; ++u) {
        others += u != v && frame.matched[u] > 0 ? 1 : 0;
      }
      if (others < 2) continue;
      segments->matched[v] += frame.matched[v];
      segments->matchable[v] += std::min(
          frame.people, static_cast<int64_t>(seen->views[v].detections.size()));
    }
  }
}

// A common factor of all sigmas, from the median of the squared norms of
// residuals: 2 log 2 for 2D Gaussian errors, reduced by the degrees of freedom
// of the states. Never zero, because residuals are divided by it.
double NoiseScale(const CameraRig& cameras,
                  const std::vector<CameraChange>& changes,
                  const std::vector<MotionSegment>& segments) {
  std::vector<double> norms;
  double free = 0.0;
  double count = 0.0;
  for (const MotionSegment& segment : segments) {
    free += kSegmentSize;
    for (const SegmentMeasurement& measurement : segment.measurements) {
      count += 2.0;
      const auto residual = SegmentResidual(
          cameras[measurement.view_idx], changes[measurement.view_idx], segment,
          segment.state, measurement, 1.0);
      if (residual.has_value()) norms.push_back(residual->squaredNorm());
    }
  }
  if (norms.empty() || count <= free) return 1.0;
  constexpr double kLeast = 1e-6;
  const double left = std::max(0.2, (count - free) / count);
  return std::max(
      kLeast, std::sqrt(Quantile(norms, 0.5) / (2.0 * std::log(2.0)) / left));
}

// Root mean square of the standard deviations of a segment's velocity
// components [m/s], at a noise scale of 1.
double VelocitySigma(const CameraRig& cameras, const MotionSegment& segment,
                     const SegmentOptions& options) {
  Eigen::Matrix<double, kSegmentSize, kSegmentSize> information =
      PriorInformation(options).asDiagonal();
  information.topLeftCorner<3, 3>().diagonal().array() += kPositionInformation;
  const std::vector<CameraChange> no_change = NoChanges(cameras.size());
  for (const SegmentTerm& term :
       TermsOf(cameras, no_change, segment, segment.state, 1.0)) {
    information.noalias() += term.by_state.transpose() * term.by_state;
  }
  Eigen::Matrix<double, kSegmentSize, 3> of_velocity =
      Eigen::Matrix<double, kSegmentSize, 3>::Zero();
  of_velocity.middleRows<3>(3).setIdentity();
  const double variance =
      information.ldlt().solve(of_velocity).middleRows<3>(3).trace() / 3.0;
  return std::sqrt(variance);
}

// Coordinate of each segment along the direction in which people move most [m],
// relative to the mean position of its joint.
std::vector<double> PlacesOf(const std::vector<MotionSegment>& segments) {
  std::map<int, std::pair<Eigen::Vector3d, double>> of_joint;
  for (const MotionSegment& segment : segments) {
    auto& [sum, count] =
        of_joint.try_emplace(segment.joint, Eigen::Vector3d::Zero(), 0.0)
            .first->second;
    sum += PositionOf(segment);
    count += 1.0;
  }
  std::vector<Eigen::Vector3d> moved;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const MotionSegment& segment : segments) {
    const auto& [sum, count] = of_joint.at(segment.joint);
    moved.push_back(PositionOf(segment) - sum / count);
    spread += moved.back() * moved.back().transpose();
  }
  const Eigen::Vector3d along =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(
          2);
  std::vector<double> places;
  for (const Eigen::Vector3d& one : moved) places.push_back(along.dot(one));
  return places;
}

int ViewCount(const MotionSegment& segment) {
  std::set<int> views;
  for (const SegmentMeasurement& m : segment.measurements) {
    views.insert(m.view_idx);
  }
  return static_cast<int>(views.size());
}

bool IsLower(JointClass joint_class) {
  return joint_class == JointClass::kHip || joint_class == JointClass::kKnee ||
         joint_class == JointClass::kAnkle || joint_class == JointClass::kFoot;
}

// Whether each segment is in the first half. Joints are assigned in pairs,
// because skeletons alternate left and right, so that each half has both sides.
std::vector<bool> FirstHalf(const SceneSegments& scene, Halving halving) {
  const std::vector<MotionSegment>& segments = scene.segments;
  std::map<int, int> ranks;
  for (const MotionSegment& segment : segments) ranks[segment.joint] = 0;
  int rank = 0;
  for (auto& entry : ranks) entry.second = rank++;
  std::vector<double> places;
  if (halving == Halving::kPlaces) places = PlacesOf(segments);
  const double middle = places.empty() ? 0.0 : Quantile(places, 0.5);
  std::vector<bool> first;
  for (size_t s = 0; s < segments.size(); ++s) {
    const auto joint = static_cast<size_t>(segments[s].joint);
    first.push_back(halving == Halving::kBody ? IsLower(scene.classes[joint])
                    : halving == Halving::kPlaces ? places[s] < middle
                    : halving == Halving::kPeople ? segments[s].person % 2 == 0
                    : halving == Halving::kTime
                        ? s < segments.size() / 2
                        : ranks[segments[s].joint] / 2 % 2 == 0);
  }
  return first;
}

}  // namespace

SegmentState PriorInformation(const SegmentOptions& options) {
  SegmentState prior = SegmentState::Zero();
  prior.segment<3>(3).setConstant(1.0 /
                                  std::pow(options.velocity_sigma_mps, 2));
  prior.segment<3>(6).setConstant(1.0 /
                                  std::pow(options.acceleration_sigma_mps2, 2));
  return prior;
}

std::optional<Eigen::Vector2d> SegmentResidual(
    const Camera& camera, const CameraChange& change,
    const MotionSegment& segment, const SegmentState& state,
    const SegmentMeasurement& measurement, double noise_scale,
    Eigen::Matrix<double, 2, kSegmentSize>* by_state,
    Eigen::Matrix<double, 2, kChangeSize>* by_change) {
  const double recording_s = segment.middle_s + measurement.time_s;
  const double tau =
      measurement.time_s + change[kOffsetAt] + change[kDriftAt] * recording_s;
  const Eigen::Vector3d velocity = state.segment<3>(3);
  const Eigen::Vector3d acceleration = state.segment<3>(6);
  const Eigen::Vector3d point =
      state.head<3>() + tau * velocity + 0.5 * tau * tau * acceleration;
  const bool wants_jacobian = by_state != nullptr || by_change != nullptr;
  Matrix23d by_point;
  const auto image = ProjectChanged(
      camera, change, point, wants_jacobian ? &by_point : nullptr, by_change);
  if (!image.has_value()) return std::nullopt;
  const double inverse = 1.0 / (measurement.sigma_px * noise_scale);
  if (wants_jacobian) by_point *= inverse;
  if (by_state != nullptr) {
    by_state->leftCols<3>() = by_point;
    by_state->middleCols<3>(3) = tau * by_point;
    by_state->rightCols<3>() = 0.5 * tau * tau * by_point;
  }
  if (by_change != nullptr) {
    *by_change *= inverse;
    by_change->col(kOffsetAt) = by_point * (velocity + tau * acceleration);
    by_change->col(kDriftAt) = recording_s * by_change->col(kOffsetAt);
  }
  return inverse * (*image - measurement.px);
}

std::vector<SegmentTerm> TermsOf(const CameraRig& cameras,
                                 const std::vector<CameraChange>& changes,
                                 const MotionSegment& segment,
                                 const SegmentState& state,
                                 double noise_scale) {
  std::vector<SegmentTerm> terms;
  terms.reserve(segment.measurements.size());
  for (const SegmentMeasurement& measurement : segment.measurements) {
    SegmentTerm term;
    term.view = static_cast<size_t>(measurement.view_idx);
    const auto residual = SegmentResidual(
        cameras[term.view], changes[term.view], segment, state, measurement,
        noise_scale, &term.by_state, &term.by_change);
    if (!residual.has_value()) continue;
    term.residual = *residual;
    term.weight =
        EvaluateLoss(kSceneLoss, kSceneLossScale, residual->squaredNorm())
            .first;
    terms.push_back(term);
  }
  return terms;
}

bool SolveSegment(const CameraRig& cameras,
                  const std::vector<CameraChange>& changes,
                  const MotionSegment& segment, double noise_scale,
                  const SegmentOptions& options, SegmentState* state) {
  // The loss is nearly convex around a triangulated start, so a few steps
  // suffice.
  constexpr int kMaxIterations = 8;
  constexpr double kStepM = 1e-5;
  const SegmentState prior = PriorInformation(options);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Eigen::Matrix<double, kSegmentSize, kSegmentSize> H = prior.asDiagonal();
    SegmentState g = prior.cwiseProduct(*state);
    Eigen::Matrix<double, 2, kSegmentSize> J;
    for (const SegmentMeasurement& measurement : segment.measurements) {
      const auto r = SegmentResidual(
          cameras[measurement.view_idx], changes[measurement.view_idx], segment,
          *state, measurement, noise_scale, &J, nullptr);
      if (!r.has_value()) continue;
      const double weight =
          EvaluateLoss(kSceneLoss, kSceneLossScale, r->squaredNorm()).first;
      H.noalias() += weight * J.transpose() * J;
      g.noalias() += weight * J.transpose() * *r;
    }
    // With one view the depth is undetermined.
    H.topLeftCorner<3, 3>().diagonal().array() += kPositionInformation;
    const SegmentState step = H.ldlt().solve(g);
    if (!step.allFinite()) return false;
    *state -= step;
    if (step.head<3>().norm() < kStepM) break;
  }
  return true;
}

const Detection* FindDetection(const ViewDetections& view, int index_in_file) {
  for (const Detection& detection : view.detections) {
    if (detection.index_in_file == index_in_file) return &detection;
  }
  return nullptr;
}

DetectionSequence WithUsualConfidences(DetectionSequence detections) {
  constexpr double kUsual = 0.6;
  std::vector<double> confidences;
  ForEachJoint(&detections, [&](const Keypoint* joint) {
    if (joint->found) confidences.push_back(joint->confidence);
  });
  if (confidences.empty()) return detections;
  const double median = Median(std::move(confidences));
  if (!(median > 0.0 && median < kUsual)) return detections;
  ForEachJoint(&detections,
               [&](Keypoint* joint) { joint->confidence *= kUsual / median; });
  return detections;
}

TimeNs FrameIntervalOf(const DetectionSequence& detections) {
  std::vector<double> gaps;
  for (size_t k = 1; k < detections.frames.size(); ++k) {
    gaps.push_back(static_cast<double>(detections.frames[k].time -
                                       detections.frames[k - 1].time));
  }
  if (gaps.empty()) return FromSeconds(1.0);
  return static_cast<TimeNs>(Quantile(gaps, 0.5));
}

SceneSegments MakeSegments(const CameraRig& cameras,
                           const DetectionSequence& detections,
                           const FrozenMatches& matches,
                           const SegmentOptions& options) {
  SceneSegments result;
  result.view_count = static_cast<int>(cameras.size());
  CountMatches(detections, matches, &result);
  if (detections.frames.empty()) return result;
  const TimeNs first = detections.frames.front().time;
  const TimeNs last = detections.frames.back().time;
  result.span_s = ToSeconds(last - first);
  const TimeNs recording_middle = first + (last - first) / 2;
  const TimeNs interval = FrameIntervalOf(detections);
  result.frame_s = ToSeconds(interval);
  const TimeNs span = FromSeconds(options.span_s);
  std::vector<std::vector<SeenFrame>> people;
  std::vector<Run> runs;
  for (size_t p = 0; p < matches.people.size(); ++p) {
    people.push_back(FramesOf(matches.people[p], detections));
    for (const Run& run : RunsOf(p, people.back(), interval, span)) {
      runs.push_back(run);
    }
  }
  std::stable_sort(runs.begin(), runs.end(), [&](const Run& a, const Run& b) {
    return people[a.person][a.begin].time < people[b.person][b.begin].time;
  });
  const Skeleton& skeleton = detections.header.skeleton;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    result.classes.push_back(skeleton.joint_class(j));
  }
  const std::vector<int>& joints = skeleton.association_joints();
  if (runs.empty() || joints.empty()) return result;
  const std::vector<CameraChange> no_change = NoChanges(cameras.size());
  // Segments are spread evenly over runs and joints.
  const double all = static_cast<double>(runs.size() * joints.size());
  const double step = std::max(1.0, all / options.max_segments);
  for (double at = 0.0; at < all; at += step) {
    const auto index = static_cast<size_t>(at);
    const Run& run = runs[index / joints.size()];
    // The shift by 3 per run varies the joints from run to run.
    const int joint =
        joints[(index * 7 + index / joints.size() * 3) % joints.size()];
    MotionSegment segment;
    if (!MakeSegment(cameras, people[run.person], run, joint, recording_middle,
                     interval, options, &segment) ||
        !SolveSegment(cameras, no_change, segment, 1.0, options,
                      &segment.state)) {
      continue;
    }
    segment.velocity_sigma_mps = VelocitySigma(cameras, segment, options);
    result.segments.push_back(std::move(segment));
  }
  result.noise_scale = NoiseScale(cameras, no_change, result.segments);
  return result;
}

bool MoveEnough(const SceneSegments& segments) {
  constexpr double kLeastSpeedMps = 0.3;
  constexpr double kLeastSigmas = 5.0;
  constexpr double kShare = 0.9;
  if (segments.segments.empty()) return false;
  std::vector<double> speeds_mps;
  std::vector<double> sigmas;
  for (const MotionSegment& segment : segments.segments) {
    speeds_mps.push_back(segment.state.segment<3>(3).norm());
    sigmas.push_back(speeds_mps.back() /
                     (segment.velocity_sigma_mps * segments.noise_scale));
  }
  return Quantile(std::move(speeds_mps), kShare) >= kLeastSpeedMps &&
         Quantile(std::move(sigmas), kShare) >= kLeastSigmas;
}

double BinLength(const SceneSegments& segments) {
  return std::clamp(segments.span_s / 20.0, 0.2, 1.0);
}

int64_t BinOf(const SceneSegments& segments, const MotionSegment& segment) {
  return static_cast<int64_t>(
      std::floor(segment.middle_s / BinLength(segments)));
}

double PlacesApart(const SceneSegments& scene) {
  std::vector<MotionSegment> in_enough_views;
  for (const MotionSegment& segment : scene.segments) {
    if (ViewCount(segment) >= std::min(3, scene.view_count)) {
      in_enough_views.push_back(segment);
    }
  }
  if (in_enough_views.empty()) return 0.0;
  const std::vector<double> places = PlacesOf(in_enough_views);
  return Quantile(places, 0.75) - Quantile(places, 0.25);
}

SceneSegments HalfOf(const SceneSegments& segments, Halving halving, int half) {
  const auto in_first = FirstHalf(segments, halving);
  SceneSegments part = segments;
  part.segments.clear();
  for (size_t s = 0; s < segments.segments.size(); ++s) {
    if (in_first[s] == (half == 0)) {
      part.segments.push_back(segments.segments[s]);
    }
  }
  return part;
}

}  // namespace kinegraph
