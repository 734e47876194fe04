#include "core/synthetic/false_people.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/synthetic/sight.h"

namespace kinegraph {

using Eigen::Vector2d;

FalsePeople::FalsePeople(const NoiseOptions& options, const Scene& scene,
                         const Camera& camera, int view_idx)
    : options_(options),
      scene_(scene),
      camera_(camera),
      random_(StreamSeed(options.seed, Stream::kFalsePeople, view_idx, 0)) {}

void FalsePeople::Step(std::vector<LabelledDetection>* detections) {
  if (options_.false_people <= 0.0) return;
  const double life =
      std::max(1.0, options_.false_life_s * scene_.frame_rate_hz);
  alive_.erase(
      std::remove_if(alive_.begin(), alive_.end(),
                     [&](const auto&) { return random_.Chance(1.0 / life); }),
      alive_.end());
  // In the mean as many come as go.
  const double born =
      started_ ? options_.false_people / life : options_.false_people;
  started_ = true;
  for (int64_t n = Poisson(born); n > 0; --n) {
    if (auto figure = Make()) alive_.push_back(std::move(*figure));
  }
  for (const Detection& figure : alive_) {
    LabelledDetection labelled;
    labelled.truth.kind = DetectionKind::kFalse;
    labelled.detection = figure;
    Shake(&labelled.detection);
    detections->push_back(std::move(labelled));
  }
}

// Knuth's method; fine for the small means here.
int64_t FalsePeople::Poisson(double mean) {
  const double limit = std::exp(-mean);
  int64_t count = 0;
  for (double product = random_.Uniform(); product > limit;
       product *= random_.Uniform()) {
    ++count;
  }
  return count;
}

void FalsePeople::Shake(Detection* figure) {
  constexpr double kSigmaPx = 1.5;
  for (Keypoint& joint : figure->joints) {
    const double x = random_.Normal(0.0, kSigmaPx);
    const double y = random_.Normal(0.0, kSigmaPx);
    if (joint.found) joint.px += Vector2d(x, y);
  }
}

// A random person's projection at a random time; empty where it has none.
FalsePeople::MaybePixels FalsePeople::SomePose() {
  MaybePixels joints;
  const auto frame = static_cast<size_t>(
      random_.Index(static_cast<int64_t>(scene_.poses.size())));
  const auto person = static_cast<size_t>(
      random_.Index(static_cast<int64_t>(scene_.people.size())));
  for (const Joint3d& joint : scene_.poses[frame][person]) {
    joints.push_back(camera_.Project(joint.position_m));
  }
  return joints;
}

// 3 to 14 neighbouring joints (as found among false people of Shelf).
std::optional<Detection> FalsePeople::Make() {
  constexpr int kAttempts = 20;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto joints = SomePose();
    const auto wanted = static_cast<size_t>(3 + random_.Index(12));
    std::vector<size_t> order;
    for (size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].has_value()) order.push_back(j);
    }
    if (order.size() < 3) continue;
    const Vector2d anchor = *joints[order[static_cast<size_t>(
        random_.Index(static_cast<int64_t>(order.size())))]];
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
      return (*joints[a] - anchor).squaredNorm() <
             (*joints[b] - anchor).squaredNorm();
    });
    order.resize(std::min(order.size(), wanted));
    Detection figure = Placed(joints, order, anchor);
    if (CountFound(figure) >= 3) return figure;
  }
  return std::nullopt;
}

Detection FalsePeople::Placed(const MaybePixels& joints,
                              const std::vector<size_t>& chosen,
                              const Vector2d& anchor) {
  const double scale = std::exp(random_.Uniform(-0.7, 0.7));
  const ImageBounds image = SizeOf(camera_);
  const double x = random_.Uniform(0.0, image.width_px);
  const double y = random_.Uniform(0.0, image.height_px);
  Detection figure;
  figure.joints.resize(joints.size());
  for (const size_t j : chosen) {
    Keypoint& joint = figure.joints[j];
    joint.px = Vector2d(x, y) + scale * (*joints[j] - anchor);
    joint.found = image.Contains(joint.px);
    constexpr double kConfidence = 0.8;  // of that of true ones, on Shelf
    joint.confidence =
        std::clamp(kConfidence * options_.confidence +
                       options_.confidence_sigma * random_.Normal(),
                   0.05, 1.0);
    if (!joint.found) joint = Keypoint();
  }
  return figure;
}

}  // namespace kinegraph
