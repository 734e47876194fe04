#include "core/io/detections/deeplabcut_recording.h"

#include <algorithm>
#include <tuple>

#include "core/base/error.h"
#include "core/data/box.h"
#include "core/io/detections/format.h"
#include "core/io/files/text_file.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

size_t DeepLabCutPlaceOf(const std::string& name,
                         std::vector<std::string>* names) {
  const auto at = std::find(names->begin(), names->end(), name);
  const auto place = static_cast<size_t>(at - names->begin());
  if (at == names->end()) names->push_back(name);
  return place;
}

void Check(DeepLabCutColumns* columns) {
  if (columns->people.empty()) throw InputError("expected columns x and y");
  for (std::vector<KeypointColumns>& joints : columns->people) {
    joints.resize(columns->labels.size());
    for (size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].x >= 0 && joints[j].y >= 0) continue;
      throw InputError("bodypart '" + Printable(columns->labels[j]) +
                       "': expected the coords x and y of every individual");
    }
  }
}

// Of the box around all that the detectors found.
double SizeOf(const std::vector<std::vector<Keypoint>>& said) {
  Eigen::AlignedBox2d box;
  for (const std::vector<Keypoint>& joints : said) {
    box.extend(BoxAround(joints));
  }
  return DiagonalPx(box);
}

Keypoint FuseJoint(const std::vector<std::vector<Keypoint>>& said, size_t j,
                   int detectors, double apart_px) {
  Keypoint best;
  Eigen::Vector2d sum_px = Eigen::Vector2d::Zero();
  double weight_sum = 0.0;
  for (const std::vector<Keypoint>& joints : said) {
    const Keypoint& joint = joints[j];
    if (!joint.found) continue;
    // Of confidences that are all 0 each counts the same.
    const double weight = std::max(joint.confidence, 1e-12);
    sum_px += weight * joint.px;
    weight_sum += weight;
    if (!best.found || joint.confidence > best.confidence) best = joint;
  }
  if (!best.found) return best;
  const Eigen::Vector2d mean_px = sum_px / weight_sum;
  double confidence_sum = 0.0;
  for (const std::vector<Keypoint>& joints : said) {
    const Keypoint& joint = joints[j];
    if (!joint.found) continue;
    if ((joint.px - best.px).norm() > apart_px) {
      best.confidence /= detectors;
      return best;
    }
    confidence_sum += joint.confidence;
  }
  best.px = mean_px;
  best.confidence = confidence_sum / detectors;
  return best;
}

}  // namespace

DeepLabCutColumns FindDeepLabCutColumns(
    const std::vector<std::string>& individuals,
    const std::vector<std::string>& parts,
    const std::vector<std::string>& coords, size_t first) {
  DeepLabCutColumns columns;
  std::vector<std::string> people;
  for (size_t c = first; c < coords.size(); ++c) {
    const size_t person =
        DeepLabCutPlaceOf(individuals.empty() ? "" : individuals[c], &people);
    const size_t joint = DeepLabCutPlaceOf(parts[c], &columns.labels);
    if (columns.people.size() <= person) columns.people.emplace_back();
    std::vector<KeypointColumns>& joints = columns.people[person];
    if (joints.size() <= joint) joints.resize(joint + 1);
    const int place = static_cast<int>(c);
    if (coords[c] == "x") joints[joint].x = place;
    if (coords[c] == "y") joints[joint].y = place;
    if (coords[c] == "likelihood") joints[joint].confidence = place;
  }
  Check(&columns);
  return columns;
}

bool DeepLabCutRecording::Place::operator<(const Place& other) const {
  return std::tie(frame, view_idx, person) <
         std::tie(other.frame, other.view_idx, other.person);
}

void DeepLabCutRecording::Add(int64_t frame, size_t view_idx, size_t person,
                              std::vector<Keypoint> joints) {
  const bool is_there =
      std::any_of(joints.begin(), joints.end(),
                  [](const Keypoint& joint) { return joint.found; });
  if (!is_there) return;
  if (detectors_ > 1) {
    waiting_[{frame, view_idx, person}].push_back(std::move(joints));
    return;
  }
  collector_.Add(frame, view_idx)->joints = std::move(joints);
}

std::unique_ptr<DetectionSource> DeepLabCutRecording::Finish() {
  constexpr double kApart = 0.05;
  for (const auto& [place, said] : waiting_) {
    const double apart_px = kApart * SizeOf(said);
    std::vector<Keypoint>& joints =
        collector_.Add(place.frame, place.view_idx)->joints;
    for (size_t j = 0; j < said.front().size(); ++j) {
      joints.push_back(FuseJoint(said, j, detectors_, apart_px));
    }
  }
  return collector_.Finish();
}

std::unique_ptr<DetectionSource> OpenDeepLabCut(
    const std::string& path, const DetectionReadOptions& options,
    const std::string& extension,
    void (*read)(const std::string& file, size_t view_idx,
                 const DetectionReadOptions& options,
                 DeepLabCutRecording* recording)) {
  std::vector<std::string> detectors = {path};
  if (IsFolder(path)) {
    const std::vector<std::string> folders = FoldersIn(path);
    if (!folders.empty()) detectors = folders;
  }
  std::vector<std::vector<std::pair<std::string, std::string>>> files;
  for (const std::string& detector : detectors) {
    files.push_back(ListViewFiles(detector, extension));
  }
  DetectionHeader header = HeaderOfViews(files.front(), options);
  DeepLabCutRecording recording(header, static_cast<int>(detectors.size()));
  for (size_t d = 0; d < files.size(); ++d) {
    if (HeaderOfViews(files[d], options).view_names != header.view_names) {
      throw InputError(detectors[d], "",
                       "has other views than " + detectors.front() +
                           ", expected the same ones of every detector");
    }
    for (size_t v = 0; v < files[d].size(); ++v) {
      read(files[d][v].second, v, options, &recording);
    }
  }
  return recording.Finish();
}

}  // namespace kinegraph
