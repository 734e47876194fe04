#include "core/tracking/second_pass.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"

namespace kinegraph {

SecondPass::SecondPass(SceneModel scene, const Skeleton& detection_skeleton,
                       const TrackerOptions& options,
                       EstimatorFactory estimator)
    : scene_(std::move(scene)),
      options_(WithScaledGates(options.At(scene_.frame_rate_hz), scene_.cameras,
                               scene_.frame_rate_hz)),
      make_estimator_(std::move(estimator)),
      epipolar_(scene_.cameras),
      observations_(scene_.cameras, detection_skeleton, scene_.skeleton,
                    options_.life.min_found_joints),
      matcher_(options_.association, scene_.skeleton.association_joints()),
      reconstructor_(scene_.cameras, epipolar_, options_.reconstruction,
                     scene_.skeleton),
      matches_(scene_.cameras.size()) {}

void SecondPass::Process(const DetectionFrame& frame,
                         const TrackFrame& first_pass) {
  TrackFrame& written = frames_.emplace_back();
  written.frame = frame.frame;
  written.time = frame.time;
  // Stays where the second pass finds nobody.
  written.people = first_pass.people;
  observations_.Prepare(frame);
  targets_.clear();
  for (const PersonPose& person : first_pass.people) {
    targets_.push_back({&person.joints, 1.0});
  }
  for (size_t v = 0; v < matches_.size(); ++v) {
    matcher_.Match(targets_, observations_.OfView(v), scene_.cameras[v],
                   &matches_[v]);
  }
  for (size_t t = 0; t < targets_.size(); ++t) {
    AddPerson(frame, first_pass.people[t], t);
  }
}

void SecondPass::AddPerson(const DetectionFrame& frame,
                           const PersonPose& person, size_t target) {
  used_views_.clear();
  for (size_t v = 0; v < matches_.size(); ++v) {
    const int match = matches_[v][target];
    if (match < 0) continue;
    used_views_.push_back({&observations_.OfView(v)[match], 0.0});
  }
  work_.frame = frame.frame;
  work_.time = frame.time;
  if (used_views_.empty()) {
    work_.views.clear();
    work_.inlier_views.assign(person.joints.size(), 0);
    work_.triangulated.assign(person.joints.size(), 0);
  } else {
    reconstructor_.Update(used_views_, person.joints, &reconstruction_);
    FillEstimatorFrame(used_views_, reconstruction_, true, &work_);
  }
  // The smoothed pose is the start wherever nothing was triangulated.
  work_.has_initial = true;
  work_.initial = person.joints;
  for (size_t j = 0; j < person.joints.size(); ++j) {
    if (work_.triangulated[j]) work_.initial[j] = reconstruction_.pose[j];
  }
  std::unique_ptr<Estimator>& estimator = estimators_[person.id];
  if (estimator == nullptr) estimator = make_estimator_(scene_);
  estimator->Add(work_);
}

std::vector<TrackFrame> SecondPass::Finish(int threads) {
  std::vector<TrackId> ids;
  for (const auto& [id, estimator] : estimators_) ids.push_back(id);
  std::vector<std::vector<FinalPose>> finals(ids.size());
  ParallelFor(threads, static_cast<int>(ids.size()), [&](int i) {
    Estimator& estimator = *estimators_.at(ids[i]);
    estimator.Finish();
    estimator.TakeFinals(&finals[i]);
  });
  for (size_t i = 0; i < ids.size(); ++i) {
    auto at = frames_.begin();
    for (FinalPose& final_pose : finals[i]) {
      at = std::lower_bound(
          at, frames_.end(), final_pose.frame,
          [](const TrackFrame& f, int64_t n) { return f.frame < n; });
      CHECK(at != frames_.end() && at->frame == final_pose.frame);
      if (CountPresent(final_pose.person.joints) == 0) continue;
      final_pose.person.id = ids[i];
      const auto person =
          std::find_if(at->people.begin(), at->people.end(),
                       [&](const PersonPose& one) { return one.id == ids[i]; });
      CHECK(person != at->people.end());
      *person = std::move(final_pose.person);
    }
  }
  estimators_.clear();
  return std::move(frames_);
}

}  // namespace kinegraph
