#include "solvers/scene/readings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace kinegraph {

const char* Describe(PoseReading reading) {
  switch (reading) {
    case PoseReading::kAsRead:
      return "world to camera, as read";
    case PoseReading::kInverse:
      return "camera to world";
    case PoseReading::kCentre:
      return "the translation is the camera's place in the world";
    case PoseReading::kTranslation:
      return "the camera's place is a translation";
    case PoseReading::kTransposed:
      return "rows of the rotation are columns";
    case PoseReading::kTransposedCentre:
      return "rows of the rotation are columns, and the translation is the "
             "camera's place";
    case PoseReading::kAxesUp:
      return "the camera's y points up and its z backwards";
  }
  return "";
}

const char* Describe(ImageReading reading) {
  switch (reading) {
    case ImageReading::kAsRead:
      return "as taken";
    case ImageReading::kRotated90:
      return "turned by 90 degrees clockwise";
    case ImageReading::kRotated180:
      return "turned by 180 degrees";
    case ImageReading::kRotated270:
      return "turned by 90 degrees anticlockwise";
    case ImageReading::kMirrored:
      return "mirrored";
  }
  return "";
}

double ImageWidth(const Camera& camera) {
  return camera.width_px() > 0 ? camera.width_px() : 2.0 * camera.K()(0, 2);
}

double ImageHeight(const Camera& camera) {
  return camera.height_px() > 0 ? camera.height_px() : 2.0 * camera.K()(1, 2);
}

Camera WithPose(const Camera& camera, PoseReading reading) {
  CameraParameters parameters = camera.parameters();
  const Eigen::Matrix3d R = camera.R();
  const Eigen::Vector3d t = camera.t();
  switch (reading) {
    case PoseReading::kAsRead:
      return camera;
    case PoseReading::kInverse:
      parameters.R = R.transpose();
      parameters.t = -(R.transpose() * t);
      break;
    case PoseReading::kCentre:
      parameters.t = -(R * t);
      break;
    case PoseReading::kTranslation:
      parameters.t = -(R.transpose() * t);
      break;
    case PoseReading::kTransposed:
      parameters.R = R.transpose();
      break;
    case PoseReading::kTransposedCentre:
      parameters.R = R.transpose();
      parameters.t = R.transpose() * (R.transpose() * t);
      break;
    case PoseReading::kAxesUp: {
      const Eigen::Vector3d signs(1.0, -1.0, -1.0);
      parameters.R = signs.asDiagonal() * R;
      parameters.t = signs.asDiagonal() * t;
      break;
    }
  }
  return Camera(parameters);
}

ViewPeople Restored(const ViewPeople& view, ImageReading reading,
                    double width_px, double height_px) {
  ViewPeople restored = view;
  if (reading == ImageReading::kAsRead) return restored;
  for (auto& frame : restored.frames) {
    for (ViewPeople::Person& person : frame) {
      for (Eigen::Vector2d& px : person.px) {
        const Eigen::Vector2d shown = px;
        switch (reading) {
          case ImageReading::kAsRead:
            break;
          case ImageReading::kRotated90:  // (x, y) was shown at (h - 1 - y, x)
            px = Eigen::Vector2d(shown.y(), height_px - 1.0 - shown.x());
            break;
          case ImageReading::kRotated180:
            px = Eigen::Vector2d(width_px - 1.0 - shown.x(),
                                 height_px - 1.0 - shown.y());
            break;
          case ImageReading::kRotated270:  // (x, y) was shown at (y, w - 1 - x)
            px = Eigen::Vector2d(width_px - 1.0 - shown.y(), shown.x());
            break;
          case ImageReading::kMirrored:
            px.x() = width_px - 1.0 - shown.x();
            break;
        }
      }
    }
  }
  return restored;
}

std::optional<Camera> Seeing(const Camera& camera, ImageReading reading) {
  if (reading == ImageReading::kAsRead) return camera;
  if (reading == ImageReading::kMirrored) return std::nullopt;
  // (0, 0) is the middle of the first pixel.
  const double width = ImageWidth(camera);
  const double height = ImageHeight(camera);
  CameraParameters parameters = camera.parameters();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  const double cx = camera.K()(0, 2);
  const double cy = camera.K()(1, 2);
  if (reading == ImageReading::kRotated180) {
    turn.topLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
    parameters.K(0, 2) = width - 1.0 - cx;
    parameters.K(1, 2) = height - 1.0 - cy;
  } else {
    const bool clockwise = reading == ImageReading::kRotated90;
    turn << 0.0, clockwise ? -1.0 : 1.0, 0.0,  //
        clockwise ? 1.0 : -1.0, 0.0, 0.0,      //
        0.0, 0.0, 1.0;
    std::swap(parameters.K(0, 0), parameters.K(1, 1));
    parameters.K(0, 2) = clockwise ? height - 1.0 - cy : cy;
    parameters.K(1, 2) = clockwise ? cx : width - 1.0 - cx;
    std::swap(parameters.width_px, parameters.height_px);
  }
  parameters.R = turn * camera.R();
  parameters.t = turn * camera.t();
  parameters.lens = Turned(camera.lens(), reading == ImageReading::kRotated180
                                              ? ImageTurn::kHalf
                                          : reading == ImageReading::kRotated90
                                              ? ImageTurn::kClockwise
                                              : ImageTurn::kCounterClockwise);
  return Camera(parameters);
}

Reading Reading::AsRead(size_t views) {
  Reading reading;
  reading.images.assign(views, ImageReading::kAsRead);
  reading.camera_of_view.resize(views);
  std::iota(reading.camera_of_view.begin(), reading.camera_of_view.end(), 0);
  return reading;
}

bool Reading::operator==(const Reading& other) const {
  return pose == other.pose && image_scale == other.image_scale &&
         images == other.images && camera_of_view == other.camera_of_view;
}

CameraRig CamerasOf(const CameraRig& cameras, const Reading& reading) {
  CameraRig rig;
  for (size_t v = 0; v < cameras.size(); ++v) {
    const Camera& source =
        cameras[static_cast<size_t>(reading.camera_of_view[v])];
    CameraParameters parameters = WithPose(source, reading.pose).parameters();
    parameters.K.topRows<2>() *= reading.image_scale;
    rig.emplace_back(parameters);
  }
  return rig;
}

namespace {

// Readings this near the best fit equally.
constexpr double kEqual = 0.025;

// The agreement of views under readings that share pose and scale. What a
// pair of views agrees to depends on the cameras and image readings of these
// two alone, so that readings that differ in one view share most of their
// pairs; each is computed once.
class PairTable {
 public:
  // `frames` of `raw` are looked at. All must outlive the object.
  PairTable(const CameraRig& cameras, const std::vector<ViewPeople>& raw,
            const std::vector<int>& frames, const Reading& shared)
      : cameras_(cameras), raw_(raw), frames_(frames) {
    Reading plain = Reading::AsRead(cameras.size());
    plain.pose = shared.pose;
    plain.image_scale = shared.image_scale;
    rig_ = CamerasOf(cameras, plain);
  }

  // Of all pairs; nullopt as soon as the score cannot reach `target` any more:
  // people whose pair is not known yet may agree to 1 at best.
  std::optional<PairAgreement> Of(const Reading& reading, double target) {
    const std::vector<size_t> seen = Seen(reading);
    double possible = 0.0;
    double most = 0.0;  // gain that is known or possible
    ForEachPair([&](size_t a, size_t b) {
      const auto known = pairs_.find({seen[a], seen[b]});
      const double people = Possible(a, b);
      possible += people;
      most += known == pairs_.end() ? people : known->second.gain;
      return true;
    });
    // Sums in another order differ by roundings.
    constexpr double kRounding = 1e-9;
    const double least = (target - kRounding) * possible;
    const bool reaches = ForEachPair([&](size_t a, size_t b) {
      if (most < least) return false;
      const auto [pair, is_new] = pairs_.try_emplace({seen[a], seen[b]});
      if (!is_new) return true;
      pair->second = AgreementOf(CameraOf(seen[a]), PeopleOf(seen[a]),
                                 CameraOf(seen[b]), PeopleOf(seen[b]), frames_);
      most += pair->second.gain - pair->second.possible;
      return true;
    });
    if (!reaches) return std::nullopt;
    PairAgreement all;
    ForEachPair([&](size_t a, size_t b) {
      all.Add(pairs_.at({seen[a], seen[b]}));
      return true;
    });
    return all;
  }

 private:
  // Calls `visit` until it is false.
  template <typename Visit>
  bool ForEachPair(const Visit& visit) const {
    for (size_t a = 0; a < raw_.size(); ++a) {
      for (size_t b = a + 1; b < raw_.size(); ++b) {
        if (!visit(a, b)) return false;
      }
    }
    return true;
  }

  // A number for each view with its camera and its images, as they are read.
  std::vector<size_t> Seen(const Reading& reading) const {
    std::vector<size_t> seen;
    for (size_t v = 0; v < raw_.size(); ++v) {
      const auto camera = static_cast<size_t>(reading.camera_of_view[v]);
      seen.push_back((v * raw_.size() + camera) * kImageReadingCount +
                     static_cast<size_t>(reading.images[v]));
    }
    return seen;
  }

  const Camera& CameraOf(size_t seen) const {
    return rig_[seen / kImageReadingCount % raw_.size()];
  }

  const ViewPeople& PeopleOf(size_t seen) {
    const auto [people, is_new] = people_.try_emplace(seen);
    if (is_new) {
      const size_t v = seen / kImageReadingCount / raw_.size();
      const auto image = static_cast<ImageReading>(seen % kImageReadingCount);
      people->second =
          Undistorted(Restored(raw_[v], image, ImageWidth(cameras_[v]),
                               ImageHeight(cameras_[v])),
                      CameraOf(seen));
    }
    return people->second;
  }

  // People that could be matched under any reading.
  double Possible(size_t a, size_t b) const {
    size_t possible = 0;
    for (const int k : frames_) {
      possible += std::min(raw_[a].frames[static_cast<size_t>(k)].size(),
                           raw_[b].frames[static_cast<size_t>(k)].size());
    }
    return static_cast<double>(possible);
  }

  const CameraRig& cameras_;
  const std::vector<ViewPeople>& raw_;
  const std::vector<int>& frames_;
  CameraRig rig_;
  std::map<size_t, ViewPeople> people_;
  std::map<std::pair<size_t, size_t>, PairAgreement> pairs_;
};

// All ways to give the cameras to the views, where they are few; else those
// that exchange two.
std::vector<std::vector<int>> Permutations(size_t views) {
  std::vector<int> identity(views);
  std::iota(identity.begin(), identity.end(), 0);
  std::vector<std::vector<int>> permutations;
  constexpr size_t kAllUpTo = 5;
  if (views <= kAllUpTo) {
    std::vector<int> order = identity;
    while (std::next_permutation(order.begin(), order.end())) {
      permutations.push_back(order);
    }
    return permutations;
  }
  for (size_t a = 0; a < views; ++a) {
    for (size_t b = a + 1; b < views; ++b) {
      std::vector<int> order = identity;
      std::swap(order[a], order[b]);
      permutations.push_back(order);
    }
  }
  return permutations;
}

class Search {
 public:
  Search(const CameraRig& cameras, const std::vector<ViewPeople>& raw,
         const std::vector<int>& frames)
      : cameras_(cameras), raw_(raw) {
    for (const ViewPeople& view : raw) {
      ViewPeople& looked_at = looked_at_.emplace_back();
      for (const int k : frames) {
        looked_at.frames.push_back(view.frames[static_cast<size_t>(k)]);
      }
    }
    frames_.resize(frames.size());
    std::iota(frames_.begin(), frames_.end(), 0);
  }

  ReadingScore Score(const Reading& reading) const {
    std::vector<ReadingScore> scores;
    PairTable table = Table(reading);
    Add(reading, 0.0, &table, &scores);
    return scores.front();
  }

  // Everything that differs from `from` in one thing and scores `target` or
  // more.
  std::vector<ReadingScore> Neighbours(const Reading& from,
                                       double target) const {
    std::vector<ReadingScore> scores;
    const auto add_apart = [&](const Reading& next) {
      PairTable table = Table(next);
      Add(next, target, &table, &scores);
    };
    for (int p = 0; p < kPoseReadingCount; ++p) {
      Reading next = from;
      next.pose = static_cast<PoseReading>(p);
      if (!(next == from)) add_apart(next);
    }
    for (const double factor : Scales()) {
      Reading next = from;
      next.image_scale *= factor;
      add_apart(next);
    }
    PairTable table = Table(from);
    AddImages(from, target, &table, &scores);
    for (const std::vector<int>& order : Permutations(cameras_.size())) {
      Reading next = from;
      next.camera_of_view = order;
      if (!(next == from)) Add(next, target, &table, &scores);
    }
    return scores;
  }

 private:
  PairTable Table(const Reading& shared) const {
    return PairTable(cameras_, looked_at_, frames_, shared);
  }

  static void Add(const Reading& reading, double target, PairTable* table,
                  std::vector<ReadingScore>* scores) {
    const std::optional<PairAgreement> agreement = table->Of(reading, target);
    if (!agreement.has_value()) return;
    scores->push_back({reading, *agreement});
  }

  std::vector<double> Scales() const {
    std::vector<double> factors = {0.25,      1.0 / 3.0, 0.5, 2.0 / 3.0, 0.75,
                                   4.0 / 3.0, 1.5,       2.0, 3.0,       4.0};
    for (const Camera& camera : cameras_) {
      const double width = ImageWidth(camera);
      // K of coordinates divided by the image's width.
      if (camera.focal_px() < 20.0) {
        double reach = 1.0;
        for (const auto& frame : raw_[0].frames) {
          for (const auto& person : frame) {
            for (const auto& px : person.px) reach = std::max(reach, px.x());
          }
        }
        factors.push_back(camera.width_px() > 0 ? camera.width_px() : reach);
      } else if (width > 0.0 && camera.focal_px() > 50.0 * width) {
        factors.push_back(1.0 / width);
      }
      break;  // one K tells
    }
    return factors;
  }

  void AddImages(const Reading& from, double target, PairTable* table,
                 std::vector<ReadingScore>* scores) const {
    for (int i = 1; i < kImageReadingCount; ++i) {
      const auto image = static_cast<ImageReading>(i);
      Reading all = from;
      all.images.assign(all.images.size(), image);
      if (!(all == from)) Add(all, target, table, scores);
      for (size_t v = 0; v < from.images.size(); ++v) {
        Reading one = from;
        one.images[v] = image;
        if (!(one == from)) Add(one, target, table, scores);
      }
    }
  }

  const CameraRig& cameras_;
  const std::vector<ViewPeople>& raw_;
  std::vector<ViewPeople> looked_at_;  // the frames of `raw` that count
  std::vector<int> frames_;            // all of these
};

// How many things a reading changes: the fewer, the likelier.
int ChangeCount(const Reading& reading) {
  int count = reading.pose != PoseReading::kAsRead;
  count += reading.image_scale != 1.0;
  int images = 0;
  for (const ImageReading image : reading.images) {
    images += image != ImageReading::kAsRead;
  }
  const bool all_alike =
      std::all_of(reading.images.begin(), reading.images.end(),
                  [&](ImageReading i) { return i == reading.images.front(); });
  count += all_alike ? (images > 0 ? 1 : 0) : images;
  for (size_t v = 0; v < reading.camera_of_view.size(); ++v) {
    count += reading.camera_of_view[v] != static_cast<int>(v);
  }
  return count;
}

void SortBest(std::vector<ReadingScore>* scores) {
  std::stable_sort(scores->begin(), scores->end(),
                   [](const ReadingScore& a, const ReadingScore& b) {
                     return a.score() > b.score();
                   });
}

}  // namespace

ReadingSearch SearchReadings(const CameraRig& cameras,
                             const std::vector<ViewPeople>& raw,
                             const std::vector<int>& frames) {
  const Search search(cameras, raw, frames);
  ReadingSearch result;
  result.as_read = search.Score(Reading::AsRead(cameras.size()));
  ReadingScore best = result.as_read;
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds; ++round) {
    const double enough = AgreementGain::Needed(best.score());
    std::vector<ReadingScore> scores =
        search.Neighbours(best.reading, enough - kEqual);
    SortBest(&scores);
    if (scores.empty() || scores.front().score() < enough) break;
    result.better.clear();
    for (const ReadingScore& score : scores) {
      if (score.score() >= scores.front().score() - kEqual) {
        result.better.push_back(score);
      }
    }
    // Of what fits equally, the simplest comes first.
    std::stable_sort(result.better.begin(), result.better.end(),
                     [](const ReadingScore& a, const ReadingScore& b) {
                       return ChangeCount(a.reading) < ChangeCount(b.reading);
                     });
    best = result.better.front();
  }
  return result;
}

}  // namespace kinegraph
