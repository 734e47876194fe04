// Alternative interpretations of a calibration: conventions of poses and camera
// matrices, rotated and mirrored images, exchanged views. The reading under
// which the views agree is searched by changing one thing at a time.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>

#include "core/geometry/lens.h"
#include "solvers/scene/hypothesis.h"

namespace kinegraph {
namespace {

// What the pose in the file may mean, and how to correct the camera if so.
struct PoseReading {
  const char* words;
  void (*read)(CameraParameters*);
};
const std::vector<PoseReading>& PoseReadings() {
  static const std::vector<PoseReading> kAll = {
      {"world to camera, as read", [](CameraParameters* /*camera*/) {}},
      {"camera to world",
       [](CameraParameters* camera) {
         camera->t = -(camera->R.transpose() * camera->t);
         camera->R.transposeInPlace();
       }},
      {"the translation is the camera's position in the world",
       [](CameraParameters* camera) { camera->t = -(camera->R * camera->t); }},
      {"what the file gives as the camera's position is the translation from "
       "world to camera",
       [](CameraParameters* camera) {
         camera->t = -(camera->R.transpose() * camera->t);
       }},
      {"the rotation is transposed",
       [](CameraParameters* camera) { camera->R.transposeInPlace(); }},
      {"the rotation is transposed, and the translation is the camera's "
       "position",
       [](CameraParameters* camera) {
         const auto columns = camera->R.transpose();
         camera->t = columns * (columns * camera->t);
         camera->R.transposeInPlace();
       }},
      // The convention of computer graphics.
      {"the camera's y points up and its z backwards",
       [](CameraParameters* camera) {
         const Eigen::Vector3d up(1.0, -1.0, -1.0);
         camera->R = up.asDiagonal() * camera->R;
         camera->t = up.asDiagonal() * camera->t;
       }}};
  return kAll;
}

// What was done to the images before detection: they were rotated, then
// mirrored. Pixels of the images as captured follow from those of the rotated
// images: captured = turn * rotated + offset. (0, 0) is the centre of the first
// pixel.
struct ImageReading {
  const char* words;
  std::array<double, 4> turn;  // by rows
  // Whether the offset is the index of the last column (x) or row (y); else it
  // is 0.
  std::array<bool, 2> from_ends;
  ImageTurn lens;        // rotates the lens; unused if `turn` is the identity
  char mirrored = '\0';  // the axis whose pixels count from the end
};
// All eight orientations of an image.
constexpr std::array<ImageReading, 8> kImages = {
    {{"as taken", {1.0, 0.0, 0.0, 1.0}, {false, false}, ImageTurn::kHalf},
     {"the images were rotated by 90 degrees clockwise",
      {0.0, 1.0, -1.0, 0.0},
      {false, true},
      ImageTurn::kClockwise},
     {"the images were rotated by 180 degrees",
      {-1.0, -0.0, -0.0, -1.0},
      {true, true},
      ImageTurn::kHalf},
     {"the images were rotated by 90 degrees anticlockwise",
      {0.0, -1.0, 1.0, 0.0},
      {true, false},
      ImageTurn::kCounterClockwise},
     {"the images were mirrored",
      {1.0, 0.0, 0.0, 1.0},
      {false, false},
      ImageTurn::kHalf,
      'x'},
     {"y counts from the bottom of the images",
      {1.0, 0.0, 0.0, 1.0},
      {false, false},
      ImageTurn::kHalf,
      'y'},
     {"the images were rotated by 90 degrees clockwise and mirrored",
      {0.0, 1.0, -1.0, 0.0},
      {false, true},
      ImageTurn::kClockwise,
      'x'},
     {"the images were rotated by 90 degrees anticlockwise and mirrored",
      {0.0, -1.0, 1.0, 0.0},
      {true, false},
      ImageTurn::kCounterClockwise,
      'x'}}};
constexpr int kImageAsRead = 0;

struct ImageMap {
  ImageMap(const Camera& camera, int image)
      : turn(Eigen::Map<const Eigen::Matrix<double, 2, 2, Eigen::RowMajor>>(
            kImages[image].turn.data())),
        offset(kImages[image].from_ends[0] ? ImageWidth(camera) - 1.0 : 0.0,
               kImages[image].from_ends[1] ? ImageHeight(camera) - 1.0 : 0.0),
        mirrored(kImages[image].mirrored) {
    if (mirrored == '\0') return;
    // The width or height of the rotated image.
    const bool is_width = (mirrored == 'x') == (turn(0, 0) != 0.0);
    sum_px = (is_width ? ImageWidth(camera) : ImageHeight(camera)) - 1.0;
  }

  Eigen::Vector2d Unmirrored(Eigen::Vector2d shown) const {
    if (mirrored == 'x') shown.x() = sum_px - shown.x();
    if (mirrored == 'y') shown.y() = sum_px - shown.y();
    return shown;
  }
  Eigen::Vector2d Taken(const Eigen::Vector2d& shown) const {
    return offset + turn * Unmirrored(shown);
  }

  Eigen::Matrix2d turn;
  Eigen::Vector2d offset;
  char mirrored;
  double sum_px = 0.0;  // of a coordinate and its mirror image; 0: not mirrored
};

// The camera that captures the rotated images; mirroring is ignored, because no
// camera captures mirrored images.
Camera Seeing(const Camera& camera, int image) {
  const ImageMap map(camera, image);
  if (map.turn.isIdentity()) return camera;
  return Edited(camera, [&](CameraParameters* seeing) {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = map.turn.transpose();
    seeing->K.block<2, 1>(0, 2) =
        map.turn.transpose() * (camera.K().block<2, 1>(0, 2) - map.offset);
    if (map.turn(0, 0) == 0.0) {
      std::swap(seeing->K(0, 0), seeing->K(1, 1));
      std::swap(seeing->width_px, seeing->height_px);
    }
    seeing->R = turn * camera.R();
    seeing->t = turn * camera.t();
    seeing->lens = Turned(camera.lens(), kImages[image].lens);
  });
}

// A complete reading, as changes relative to the files.
struct Reading {
  int pose = 0;                     // index in PoseReadings()
  double image_scale = 1.0;         // factor of the first two rows of K
  std::vector<int> images;          // index in kImages, one per view
  std::vector<int> camera_of_view;  // permutation
  PairAgreement agreement;          // under this reading, over all views

  explicit Reading(size_t views)
      : images(views, kImageAsRead), camera_of_view(IndicesUpTo(views)) {}
  bool IsAs(const Reading& other) const {
    return pose == other.pose && image_scale == other.image_scale &&
           images == other.images && camera_of_view == other.camera_of_view;
  }
  bool AllImagesAlike() const {
    return std::count(images.begin(), images.end(), images.front()) ==
           static_cast<std::ptrdiff_t>(images.size());
  }
  // Number of changes; readings with fewer changes are more likely.
  int ChangeCount() const {
    int count = (pose != 0) + (image_scale != 1.0);
    const auto turned = static_cast<int>(
        std::count_if(images.begin(), images.end(),
                      [](int image) { return image != kImageAsRead; }));
    count += AllImagesAlike() ? std::min(1, turned) : turned;
    for (size_t v = 0; v < camera_of_view.size(); ++v) {
      count += camera_of_view[v] != static_cast<int>(v);
    }
    return count;
  }
};

// The views' cameras under a reading (images aside).
CameraRig CamerasOf(const CameraRig& cameras, const Reading& reading) {
  CameraRig rig;
  for (const int camera : reading.camera_of_view) {
    rig.push_back(Edited(cameras[camera], [&](CameraParameters* read) {
      PoseReadings()[reading.pose].read(read);
      read->K.topRows<2>() *= reading.image_scale;
    }));
  }
  return rig;
}

// Computes the agreement of the views under readings. Given pose and scale, the
// agreement of a pair of views depends only on the cameras and image readings
// of these two. Readings that differ in one view share most pairs, so each pair
// is computed once.
class ReadingJudge {
 public:
  ReadingJudge(const CameraRig& cameras, const std::vector<ViewPeople>& raw,
               const std::vector<int>& frames)
      : cameras_(cameras),
        frames_(IndicesUpTo(frames.size())),
        shared_(cameras.size()),
        rig_(cameras) {
    for (const ViewPeople& view : raw) {
      ViewPeople& looked_at = raw_.emplace_back();
      for (const int k : frames) {
        looked_at.frames.push_back(view.frames[k]);
      }
    }
  }

  void Judge(Reading* reading) {
    if (reading->pose != shared_.pose ||
        reading->image_scale != shared_.image_scale) {
      shared_.pose = reading->pose;
      shared_.image_scale = reading->image_scale;
      rig_ = CamerasOf(cameras_, shared_);
      people_.clear();
      pairs_.clear();
    }
    std::vector<size_t> seen;  // by view: index of its camera and image reading
    for (size_t v = 0; v < raw_.size(); ++v) {
      const auto camera = static_cast<size_t>(reading->camera_of_view[v]);
      seen.push_back((v * raw_.size() + camera) * kImages.size() +
                     static_cast<size_t>(reading->images[v]));
    }
    reading->agreement = PairAgreement();
    for (const auto& [a, b] : ComparedPairs(seen.size())) {
      const auto [pair, is_new] = pairs_.try_emplace({seen[a], seen[b]});
      if (is_new) {
        pair->second =
            AgreementOf(CameraOf(seen[a]), PeopleOf(seen[a]), CameraOf(seen[b]),
                        PeopleOf(seen[b]), frames_);
      }
      reading->agreement.Add(pair->second);
    }
  }

 private:
  const Camera& CameraOf(size_t seen) const {
    return rig_[seen / kImages.size() % raw_.size()];
  }

  const ViewPeople& PeopleOf(size_t seen) {
    const auto [people, is_new] = people_.try_emplace(seen);
    if (is_new) {
      const size_t v = seen / kImages.size() / raw_.size();
      const ImageMap map(CameraOf(seen),
                         static_cast<int>(seen % kImages.size()));
      ViewPeople taken = raw_[v];
      for (auto& frame : taken.frames) {
        for (ViewPeople::Person& person : frame) {
          for (Eigen::Vector2d& px : person.px) px = map.Taken(px);
        }
      }
      people->second = Undistorted(std::move(taken), CameraOf(seen));
    }
    return people->second;
  }

  const CameraRig& cameras_;
  std::vector<ViewPeople> raw_;  // in the examined frames
  std::vector<int> frames_;      // all indices of raw_'s frames
  Reading shared_;               // pose and scale of the cached pairs
  CameraRig rig_;
  std::map<size_t, ViewPeople> people_;
  std::map<std::pair<size_t, size_t>, PairAgreement> pairs_;
};

// All assignments of cameras to views if there are few views; else all
// exchanges of two cameras.
std::vector<std::vector<int>> Permutations(size_t views) {
  constexpr size_t kAllUpTo = 5;
  std::vector<int> order = IndicesUpTo(views);
  std::vector<std::vector<int>> permutations;
  if (views <= kAllUpTo) {
    while (std::next_permutation(order.begin(), order.end())) {
      permutations.push_back(order);
    }
    return permutations;
  }
  for (size_t a = 0; a < views; ++a) {
    for (size_t b = a + 1; b < views; ++b) {
      permutations.push_back(order);
      std::swap(permutations.back()[a], permutations.back()[b]);
    }
  }
  return permutations;
}

// Possible scale factors of the camera matrices, judged by the first camera.
std::vector<double> ImageScales(const SetUp& set_up) {
  std::vector<double> factors = {0.25,      1.0 / 3.0, 0.5, 2.0 / 3.0, 0.75,
                                 4.0 / 3.0, 1.5,       2.0, 3.0,       4.0};
  const Camera& camera = set_up.cameras.front();
  const double width = ImageWidth(camera);
  if (camera.focal_px() < 20.0) {  // normalised by the width
    double reach = 1.0;
    for (const auto& frame : set_up.raw.front().frames) {
      for (const auto& person : frame) {
        for (const auto& px : person.px) reach = std::max(reach, px.x());
      }
    }
    factors.push_back(camera.width_px() > 0 ? camera.width_px() : reach);
  } else if (width > 0.0 && camera.focal_px() > 50.0 * width) {
    factors.push_back(1.0 / width);
  }
  return factors;
}

// All readings that differ from `from` in one respect.
std::vector<Reading> Neighbours(const SetUp& set_up, const Reading& from) {
  std::vector<Reading> all;
  const auto add = [&](const auto& change) {
    Reading next = from;
    change(&next);
    if (!next.IsAs(from)) all.push_back(std::move(next));
  };
  for (int pose = 0; pose < static_cast<int>(PoseReadings().size()); ++pose) {
    add([&](Reading* next) { next->pose = pose; });
  }
  for (const double factor : ImageScales(set_up)) {
    add([&](Reading* next) { next->image_scale *= factor; });
  }
  for (int image = 1; image < static_cast<int>(kImages.size()); ++image) {
    add([&](Reading* next) {
      next->images.assign(next->images.size(), image);
    });
    for (size_t v = 0; v < from.images.size(); ++v) {
      add([&](Reading* next) { next->images[v] = image; });
    }
  }
  for (const std::vector<int>& order : Permutations(from.images.size())) {
    add([&](Reading* next) { next->camera_of_view = order; });
  }
  return all;
}

// Whether, on a few of the frames, any reading might agree much better; if none
// comes close, the remaining frames are not examined.
bool SomeMayBeBetter(const SetUp& set_up) {
  constexpr size_t kFew = 8;
  constexpr double kChance = 0.06;  // random error of their agreement
  const std::vector<int> few = Evenly(set_up.frames, kFew);
  ReadingJudge judge(set_up.cameras, set_up.raw, few);
  Reading as_read(set_up.cameras.size());
  judge.Judge(&as_read);
  const double needed =
      AgreementGain::Needed(as_read.agreement.score()) - kChance;
  for (Reading& one : Neighbours(set_up, as_read)) {
    judge.Judge(&one);
    if (one.agreement.score() >= needed) return true;
  }
  return false;
}

// If the views agree much better under another reading than under `as_read`:
// the best reading and those within kEqual of it, the simplest first. A reading
// may differ in two respects, which are found one after the other.
std::vector<Reading> BetterReadings(const SetUp& set_up, Reading* as_read) {
  constexpr double kEqual = 0.025;
  constexpr int kRounds = 2;
  ReadingJudge judge(set_up.cameras, set_up.raw, set_up.frames);
  judge.Judge(as_read);
  std::vector<Reading> better;
  for (int round = 0; round < kRounds; ++round) {
    const Reading& from = better.empty() ? *as_read : better.front();
    std::vector<Reading> next = Neighbours(set_up, from);
    for (Reading& one : next) judge.Judge(&one);
    std::stable_sort(next.begin(), next.end(),
                     [](const Reading& a, const Reading& b) {
                       return a.agreement.score() > b.agreement.score();
                     });
    const double best = next.front().agreement.score();
    if (best < AgreementGain::Needed(from.agreement.score())) break;
    next.erase(std::find_if(next.begin(), next.end(),
                            [&](const Reading& one) {
                              return one.agreement.score() < best - kEqual;
                            }),
               next.end());
    std::stable_sort(next.begin(), next.end(),
                     [](const Reading& a, const Reading& b) {
                       return a.ChangeCount() < b.ChangeCount();
                     });
    better = std::move(next);
  }
  return better;
}

// Adds a finding for each change of a reading; `alike` readings fit equally.
void AddWords(const SetUp& set_up, const Reading& as_read,
              const Reading& reading, size_t alike,
              std::vector<Finding>* findings) {
  const auto say = [&](const char* kind, const std::string& camera,
                       const std::string& fix, const std::string& what) {
    findings->push_back(
        Found(kind, camera, {as_read.agreement, reading.agreement}, fix, what));
    findings->back().confidence = Shared(findings->back().confidence, alike);
  };
  if (reading.pose != 0) {
    say("convention", "", kUseCorrected,
        std::string("the views agree better if the poses are read as: ") +
            PoseReadings()[reading.pose].words);
  }
  if (reading.image_scale != 1.0) {
    say("intrinsics", "", kUseCorrected,
        fmt::format("the views agree better with the camera matrix multiplied "
                    "by {:.4g}",
                    reading.image_scale));
  }
  const CameraRig cameras = CamerasOf(set_up.cameras, reading);
  std::vector<std::string> mirrors(cameras.size());
  bool turned = false;
  for (size_t v = 0; v < mirrors.size(); ++v) {
    const ImageMap map(cameras[v], reading.images[v]);
    turned = turned || !map.turn.isIdentity();
    if (map.mirrored == '\0') continue;
    mirrors[v] = MirrorText(map.mirrored, map.sum_px);
  }
  const std::string mirror_fix =
      MirrorFlag(mirrors, set_up.input.detections.header.view_names);
  for (size_t v = 0; v < mirrors.size(); ++v) {
    const int image = reading.images[v];
    if (image == kImageAsRead) continue;
    say("image", reading.AllImagesAlike() ? "" : set_up.CameraName(v),
        mirror_fix.empty() ? kUseCorrected
        : turned           ? kUseCorrected + (" " + mirror_fix)
                           : mirror_fix,
        kImages[image].words);
    if (reading.AllImagesAlike()) break;
  }
  std::string map;
  std::string names;
  for (size_t v = 0; v < reading.camera_of_view.size(); ++v) {
    const auto camera = static_cast<size_t>(reading.camera_of_view[v]);
    if (camera == v) continue;
    map += (map.empty() ? "'--set=cameras.map." : ";cameras.map.") +
           set_up.ViewName(v) + "=" + set_up.CameraName(camera);
    names += (names.empty() ? "" : ", ") + set_up.ViewName(v) +
             " was recorded by " + set_up.CameraName(camera);
  }
  if (!map.empty()) say("swapped_views", "", map + "'", names);
}

}  // namespace

double ImageWidth(const Camera& camera) {
  return camera.width_px() > 0 ? camera.width_px() : 2.0 * camera.K()(0, 2);
}

double ImageHeight(const Camera& camera) {
  return camera.height_px() > 0 ? camera.height_px() : 2.0 * camera.K()(1, 2);
}

std::optional<Answer> AskForOtherReading(const SetUp& set_up) {
  if (set_up.AgreeAlready() || !SomeMayBeBetter(set_up)) return std::nullopt;
  Reading as_read(set_up.cameras.size());
  const std::vector<Reading> better = BetterReadings(set_up, &as_read);
  if (better.empty()) return std::nullopt;
  Answer answer;
  for (const Reading& reading : better) {
    AddWords(set_up, as_read, reading, better.size(), &answer.findings);
  }
  const Reading& reading = better.front();
  answer.score = reading.agreement.score();
  answer.cameras = CamerasOf(set_up.cameras, reading);
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    Camera& camera = (*answer.cameras)[v];
    const ImageMap map(camera, reading.images[v]);
    camera = Seeing(camera, reading.images[v]);
    if (map.mirrored == '\0') continue;
    if (!answer.detections.has_value()) answer.detections = set_up.detections;
    for (DetectionFrame& frame : answer.detections->frames) {
      for (Detection& detection : frame.views[v].detections) {
        for (Keypoint& joint : detection.joints) {
          joint.px = map.Unmirrored(joint.px);
        }
      }
    }
  }
  return answer;
}

}  // namespace kinegraph
