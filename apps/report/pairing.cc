#include "apps/report/pairing.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

// A person and a detection with fewer common joints are not compared. If the
// skeletons share fewer joints, all of those are required.
constexpr int kMinSharedJoints = 3;
// Without matches, a detection farther away than this fraction of the image
// diagonal belongs to another person.
constexpr double kGateShare = 0.05;
constexpr double kGateUnknownSizePx = 50.0;

double GatePx(const Camera& camera) {
  if (camera.width_px() == 0) return kGateUnknownSizePx;
  return kGateShare * std::hypot(camera.width_px(), camera.height_px());
}

int PositionOf(const ViewDetections& seen, int index_in_file) {
  for (size_t d = 0; d < seen.detections.size(); ++d) {
    if (seen.detections[d].index_in_file == index_in_file) {
      return static_cast<int>(d);
    }
  }
  return -1;
}

// For each person of `tracks`, the number of frames in which each identity of
// `lead` is nearest.
std::map<TrackId, std::map<TrackId, int>> Votes(const TrackSequence& tracks,
                                                const TrackSequence& lead) {
  constexpr double kGateM = 0.5;  // two people are rarely closer together
  std::map<TrackId, std::map<TrackId, int>> votes;
  for (const TrackFrame& frame : tracks.frames) {
    const TrackFrame* at = FindFrame(lead, frame.frame);
    if (at == nullptr) continue;
    for (const PersonPose& person : frame.people) {
      const auto here = MeanPosition(person.joints);
      double nearest = kGateM;
      std::optional<TrackId> same;
      for (const PersonPose& other : at->people) {
        const auto there = MeanPosition(other.joints);
        if (!here.has_value() || !there.has_value()) continue;
        const double distance = (*here - *there).norm();
        if (distance >= nearest) continue;
        nearest = distance;
        same = other.id;
      }
      if (same.has_value()) ++votes[person.id][*same];
    }
  }
  return votes;
}

}  // namespace

DetectionPairing::DetectionPairing(const TrackHeader& tracks,
                                   const DetectionHeader& detections,
                                   const CameraRig& cameras)
    : cameras_(cameras),
      joint_map_(MapByName(detections.skeleton, tracks.skeleton)),
      min_shared_joints_(std::clamp(
          static_cast<int>(std::count_if(joint_map_.begin(), joint_map_.end(),
                                         [](int joint) { return joint >= 0; })),
          1, kMinSharedJoints)) {
  const auto& names = detections.view_names;
  for (const std::string& name : tracks.view_names) {
    const auto at = std::find(names.begin(), names.end(), name);
    view_of_track_view_.push_back(
        at == names.end() ? -1 : static_cast<int>(at - names.begin()));
  }
}

std::optional<double> DetectionPairing::Residual(const PersonPose& person,
                                                 const Detection& detection,
                                                 const ViewMatch* match,
                                                 int view) const {
  double sum_px = 0.0;
  int count = 0;
  for (size_t j = 0; j < person.joints.size(); ++j) {
    if (joint_map_[j] < 0 || !person.joints[j].present()) continue;
    const Keypoint& seen = detection.joints[static_cast<size_t>(joint_map_[j])];
    if (!seen.found) continue;
    if (match != nullptr && j < match->weights.size() &&
        match->weights[j].value_or(0.0) <= 0.0) {
      continue;  // rejected
    }
    const auto px = cameras_[static_cast<size_t>(view)].Project(
        person.joints[j].position_m);
    if (!px.has_value()) continue;
    sum_px += (*px - seen.px).norm();
    ++count;
  }
  if (count < min_shared_joints_) return std::nullopt;
  return sum_px / count;
}

void DetectionPairing::PairNearest(
    const TrackFrame& tracks, const ViewDetections& seen, int view,
    std::vector<std::vector<ViewPair>>* pairs) const {
  const double gate_px = GatePx(cameras_[static_cast<size_t>(view)]);
  std::vector<std::tuple<double, size_t, size_t>> candidates;
  for (size_t p = 0; p < tracks.people.size(); ++p) {
    for (size_t d = 0; d < seen.detections.size(); ++d) {
      const auto residual =
          Residual(tracks.people[p], seen.detections[d], nullptr, view);
      if (residual.has_value() && *residual < gate_px) {
        candidates.emplace_back(*residual, p, d);
      }
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> taken(seen.detections.size(), false);
  for (const auto& [residual, p, d] : candidates) {
    ViewPair& pair = (*pairs)[p][static_cast<size_t>(view)];
    if (taken[d] || pair.detection >= 0) continue;
    taken[d] = true;
    pair = {static_cast<int>(d), residual};
  }
}

std::vector<std::vector<ViewPair>> DetectionPairing::Pair(
    const TrackFrame& tracks, const DetectionFrame& seen) const {
  std::vector<std::vector<ViewPair>> pairs(
      tracks.people.size(), std::vector<ViewPair>(cameras_.size()));
  const bool has_matches =
      std::any_of(tracks.people.begin(), tracks.people.end(),
                  [](const PersonPose& p) { return !p.matches.empty(); });
  if (!has_matches) {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      PairNearest(tracks, seen.views[v], static_cast<int>(v), &pairs);
    }
    return pairs;
  }
  for (size_t p = 0; p < tracks.people.size(); ++p) {
    for (const ViewMatch& match : tracks.people[p].matches) {
      const int view = ViewOf(match.view_idx);
      if (view < 0) continue;
      const ViewDetections& in_view = seen.views[static_cast<size_t>(view)];
      ViewPair& pair = pairs[p][static_cast<size_t>(view)];
      pair.detection = PositionOf(in_view, match.detection_idx);
      if (pair.detection < 0) continue;
      pair.residual_px =
          Residual(tracks.people[p],
                   in_view.detections[static_cast<size_t>(pair.detection)],
                   &match, view);
    }
  }
  return pairs;
}

Colours::Colours(const TrackSequence& tracks, const TrackSequence* lead,
                 const Colours* lead_colours) {
  std::map<TrackId, std::map<TrackId, int>> votes;
  if (lead != nullptr) votes = Votes(tracks, *lead);
  int next = lead_colours == nullptr
                 ? 0
                 : static_cast<int>(lead_colours->colour_.size());
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      if (colour_.count(person.id) > 0) continue;
      ids_.push_back(person.id);
      const auto& of_person = votes[person.id];
      const auto best = std::max_element(
          of_person.begin(), of_person.end(),
          [](const auto& a, const auto& b) { return a.second < b.second; });
      colour_[person.id] = lead_colours == nullptr || best == of_person.end()
                               ? next++
                               : lead_colours->colour_.at(best->first);
    }
  }
}

}  // namespace kinegraph
