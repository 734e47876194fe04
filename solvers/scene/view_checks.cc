// Hypotheses about the images of individual views, which compete with other
// readings of the calibration and with clocks (Stage::kReadings): frame rates,
// exchanged left and right, scaled and cropped videos.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "core/evaluation/statistics.h"
#include "solvers/scene/hypothesis.h"

namespace kinegraph {
namespace {

// ---- Rates ----

// A view whose files count frames at another rate than those of the other
// views: `factor` times as fast, with numbers too high by `offset`.
struct OtherRate {
  size_t view = 0;
  double rate_hz = 0.0;
  double factor = 1.0;
  double offset = 0.0;
  AgreementGain gain;  // with the others

  struct Shown {
    int64_t number = 0;    // of the view's frame, in its own files
    double earlier = 0.0;  // [frames of the other views]
  };
  // The view's frame nearest in time to frame `wanted` of the other views, and
  // how much earlier than that it was captured; nullopt if it is nearer to
  // another frame.
  std::optional<Shown> At(int64_t wanted) const {
    const auto stated = static_cast<double>(wanted);
    Shown shown;
    shown.number = std::llround(factor * stated + offset);
    shown.earlier =
        stated - (static_cast<double>(shown.number) - offset) / factor;
    // A view's frame midway between two frames belongs to the earlier one, as
    // when the recording is read.
    if (shown.earlier >= 0.5 || shown.earlier < -0.5) return std::nullopt;
    return shown;
  }

  // Index in the files of the view's frame that belongs to frame k, or -1.
  int64_t From(const DetectionSequence& files, size_t k) const {
    const auto shown = At(files.frames[k].frame);
    return shown ? IndexOfFrame(files, shown->number) : -1;
  }

  // The view's people in some of the frames.
  ViewPeople Of(const ViewPeople& people, const DetectionSequence& files,
                const std::vector<int>& wanted) const {
    ViewPeople moved;
    moved.frames.resize(people.frames.size());
    for (const int k : wanted) {
      const int64_t from = From(files, static_cast<size_t>(k));
      if (from < 0) continue;
      moved.frames[k] = people.frames[from];
    }
    return moved;
  }

  DetectionSequence Of(const DetectionSequence& detections) const {
    DetectionSequence moved =
        FramesMoved(detections, [&](size_t v, int64_t k) -> int64_t {
          return v == view ? From(detections, static_cast<size_t>(k)) : k;
        });
    for (DetectionFrame& frame : moved.frames) {
      if (const auto shown = At(frame.frame)) {
        frame.views[view].capture_time -=
            FromSeconds(shown->earlier / detections.header.frame_rate_hz);
      }
    }
    return moved;
  }
};

std::optional<OtherRate> FindOtherRate(const SetUp& set_up) {
  constexpr std::array kRates = {12.0, 12.5, 15.0, 24.0,  25.0,  30.0,  48.0,
                                 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0};
  constexpr int kFrames = 40;
  // Half of the views at twice the rate cannot be distinguished from the other
  // half at half the rate: among equal answers the higher rate is chosen.
  constexpr double kAlike = 0.03;
  const DetectionSequence& files = set_up.detections;
  // Each pair of views is compared in both directions.
  const std::vector<int> frames = FramesToLookAt(
      set_up.ideal, kFrames, 2 * static_cast<int>(kRates.size()));
  std::optional<OtherRate> best;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    const auto with_others = [&](const ViewPeople& own) {
      return set_up.WithOthers(v, set_up.cameras[v], own, frames);
    };
    OtherRate one;
    one.view = v;
    one.gain.before = with_others(set_up.ideal[v]);
    for (const double rate_hz : kRates) {
      one.rate_hz = rate_hz;
      one.factor = rate_hz / files.header.frame_rate_hz;
      if (std::abs(one.factor - 1.0) < 0.02 || one.factor < 0.2 ||
          one.factor > 5.0) {
        continue;
      }
      // Either the first frames of all views are simultaneous, or the frames
      // numbered 0 are.
      const auto first = static_cast<double>(files.frames.front().frame);
      const double together = first - one.factor * first;
      for (const double offset : {together, 0.0}) {
        one.offset = offset;
        one.gain.after = with_others(one.Of(set_up.ideal[v], files, frames));
        // At least three tenths of the people that can be compared at this rate
        // must be compared.
        const double most =
            std::min(1.0, one.factor) * one.gain.before.possible;
        if (one.gain.after.possible >= 0.3 * most && one.gain.is_enough() &&
            (!best.has_value() ||
             one.gain.gain() >
                 best->gain.gain() +
                     (rate_hz > best->rate_hz ? -kAlike : kAlike))) {
          best = one;
        }
        if (together == 0.0) break;
      }
    }
  }
  return best;
}

// ---- Sides ----

// The agreement of the compared pairs of views (ComparedPairs), with and
// without exchanging left and right in one of the two.
class SidesTable {
 public:
  SidesTable(const CameraRig& cameras, const std::vector<ViewPeople>& people,
             const std::vector<ViewPeople>& exchanged,
             const std::vector<int>& frames)
      : views_(cameras.size()), pairs_(views_ * views_) {
    for (const auto& [a, b] : ComparedPairs(views_)) {
      pairs_[a * views_ + b] = {
          AgreementOf(cameras[a], people[a], cameras[b], people[b], frames),
          AgreementOf(cameras[a], people[a], cameras[b], exchanged[b], frames)};
    }
  }

  // The agreement over the pairs with exactly one view in `of`, if left and
  // right are exchanged in the views of `exchanged`.
  PairAgreement Of(const std::vector<char>& exchanged,
                   const std::vector<char>& of) const {
    PairAgreement all;
    for (const auto& [a, b] : ComparedPairs(views_)) {
      if (of[a] == of[b]) continue;
      all.Add(pairs_[a * views_ + b][exchanged[a] != exchanged[b] ? 1 : 0]);
    }
    return all;
  }

  // The views to exchange, found greedily one at a time. A set and its
  // complement are equivalent, so at most half of the views are exchanged.
  std::vector<char> Best() const {
    std::vector<char> exchanged(views_, 0);
    for (size_t round = 0; 2 * (round + 1) <= views_; ++round) {
      size_t best = views_;
      double most = AgreementGain::kLeastGain;
      for (size_t v = 0; v < views_; ++v) {
        std::vector<char> next = exchanged;
        std::vector<char> alone(views_, 0);
        alone[v] = 1;
        next[v] = !next[v];
        const double gain =
            Of(next, alone).score() - Of(exchanged, alone).score();
        if (gain <= most) continue;
        most = gain;
        best = v;
      }
      if (best == views_) break;
      exchanged[best] = !exchanged[best];
    }
    return exchanged;
  }

 private:
  size_t views_;
  std::vector<std::array<PairAgreement, 2>> pairs_;
};

// ---- Images ----

// A view whose video was scaled or cropped before detection: pixel of the
// detections = scale * pixel of the camera + Corner() - offset_px.
struct OtherImage {
  size_t view = 0;
  double scale = 1.0;
  Eigen::Vector2d offset_px = Eigen::Vector2d::Zero();
  AgreementGain gain;  // with the others
  bool scaled() const { return scale != 1.0; }
  bool cropped() const { return !offset_px.isZero(); }

  // The camera with the intrinsics of this image.
  Camera Seen(const Camera& camera) const {
    return Edited(camera, [&](CameraParameters* seen) {
      seen->K.topRows<2>() *= scale;
      seen->K.block<2, 1>(0, 2) += Corner() - offset_px;
      if (seen->width_px <= 0) return;
      for (int* side : {&seen->width_px, &seen->height_px}) {
        *side = static_cast<int>(std::lround(scale * *side));
      }
    });
  }
  // (0, 0) is the centre of the first pixel, but scaling is about its corner.
  Eigen::Vector2d Corner() const {
    return Eigen::Vector2d::Constant(0.5 * (scale - 1.0));
  }
};

// x = scale * p + offset, by least squares: p is the projection of a placed
// joint, x its pixel in the detection.
struct ImageFit {
  double scale = 1.0;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  // mean of p
  Eigen::Vector2d to = Eigen::Vector2d::Zero();    // mean of x
  double size_px = 0.0;                            // of the detection

  Eigen::Vector2d OffsetWith(double other_scale) const {
    return to - other_scale * from;
  }
  bool AgreesWith(const ImageFit& other) const {
    constexpr double kScales = 0.06;  // relative
    constexpr double kPlaces = 0.1;   // of the size
    return std::abs(std::log(scale / other.scale)) < kScales &&
           (OffsetWith(scale) - other.OffsetWith(scale)).norm() <
               kPlaces * other.size_px;
  }
};

// nullopt if there are too few points or they do not fit.
std::optional<ImageFit> FitImage(const Camera& camera,
                                 const PlacedPerson& placed,
                                 const ViewPeople::Person& seen) {
  constexpr Eigen::Index kEnough = 8;
  constexpr double kAlike = 0.06;  // of the size
  const auto joints = static_cast<Eigen::Index>(placed.joints.size());
  Eigen::Matrix2Xd p(2, joints);
  Eigen::Matrix2Xd x(2, joints);
  Eigen::Index count = 0;
  for (size_t j = 0; j < placed.joints.size(); ++j) {
    if (!placed.joints[j].has_value() || !seen.found[j]) continue;
    const auto px = camera.Project(*placed.joints[j]);
    if (!px.has_value()) continue;
    p.col(count) = *px;
    x.col(count++) = seen.px[j];
  }
  if (count < kEnough) return std::nullopt;
  p.conservativeResize(2, count);
  x.conservativeResize(2, count);
  ImageFit fit;
  fit.size_px = seen.size_px;
  fit.from = p.rowwise().mean();
  fit.to = x.rowwise().mean();
  p.colwise() -= fit.from;
  x.colwise() -= fit.to;
  fit.scale = p.cwiseProduct(x).sum() / p.squaredNorm();
  const double rms_px =
      std::sqrt((x - fit.scale * p).squaredNorm() / static_cast<double>(count));
  if (!(fit.scale > 0.1) || !(rms_px <= kAlike * seen.size_px)) {
    return std::nullopt;
  }
  return fit;
}

// Ratios by which videos are usually scaled.
constexpr std::array kRatios = {1.0,       0.5,  2.0, 2.0 / 3.0, 1.5, 0.75,
                                4.0 / 3.0, 0.25, 4.0, 1.0 / 3.0, 3.0};

// The scale or, if it is close to one of kRatios, that ratio.
double SimpleRatio(double scale) {
  // A smaller deviation of log(scale) from 0 is an error of the focal length or
  // of the camera's distance rather than a scaled video.
  constexpr double kFocal = 0.08;
  if (std::abs(std::log(scale)) < kFocal) return 1.0;
  constexpr double kNear = 0.03;
  for (const double ratio : kRatios) {
    if (std::abs(std::log(scale / ratio)) < kNear) return ratio;
  }
  return scale;
}

// The consensus of the largest set of agreeing fits; nullopt if it is too
// small. Shifts of less than `least_shift` of the people's size count as zero.
std::optional<OtherImage> CommonImage(std::vector<ImageFit> fits,
                                      double least_shift) {
  constexpr size_t kMost = 300;
  constexpr size_t kEnough = 10;
  if (fits.size() > kMost) {
    for (size_t i = 0; i < kMost; ++i) fits[i] = fits[i * fits.size() / kMost];
    fits.resize(kMost);
  }
  std::vector<ImageFit> most;
  double size_px = 0.0;
  for (const ImageFit& one : fits) {
    std::vector<ImageFit> agreeing;
    std::copy_if(fits.begin(), fits.end(), std::back_inserter(agreeing),
                 [&](const ImageFit& other) { return one.AgreesWith(other); });
    if (agreeing.size() <= most.size()) continue;
    most = std::move(agreeing);
    size_px = one.size_px;
  }
  if (most.size() < kEnough || 4 * most.size() < fits.size()) {
    return std::nullopt;
  }
  std::vector<double> scales, x, y;
  for (const ImageFit& fit : most) scales.push_back(fit.scale);
  OtherImage image;
  image.scale = SimpleRatio(Quantile(scales, 0.5));
  for (const ImageFit& fit : most) {
    x.push_back(fit.OffsetWith(image.scale).x());
    y.push_back(fit.OffsetWith(image.scale).y());
  }
  image.offset_px =
      image.Corner() - Eigen::Vector2d(Quantile(x, 0.5), Quantile(y, 0.5));
  if (image.offset_px.norm() < least_shift * size_px) {
    image.offset_px.setZero();
  }
  image.offset_px = image.offset_px.array().round();
  return image;
}

// Replaces `best` if the candidate increases the agreement of its view with the
// others enough (AgreementGain::is_enough) and more than `best` does.
void KeepBetter(const SetUp& set_up, const PairAgreement& before,
                OtherImage image, std::optional<OtherImage>* best) {
  const Camera camera = image.Seen(set_up.cameras[image.view]);
  image.gain = {before,
                set_up.WithOthers(image.view, camera,
                                  Undistorted(set_up.raw[image.view], camera),
                                  set_up.frames)};
  if (image.gain.is_enough() &&
      (!best->has_value() || image.gain.gain() > (*best)->gain.gain())) {
    *best = image;
  }
}

// With two views, no third view can confirm the 3D positions of people, so
// common ratios are tried.
std::optional<OtherImage> OtherSizeOfTwo(const SetUp& set_up) {
  std::optional<OtherImage> best;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    for (const double ratio : kRatios) {
      OtherImage image;
      image.view = v;
      image.scale = ratio;
      KeepBetter(set_up, set_up.WithOthers(v), image, &best);
    }
  }
  return best;
}

// `least_shift`: see CommonImage.
std::optional<OtherImage> FindOtherImage(const SetUp& set_up,
                                         double least_shift) {
  const CameraRig& cameras = set_up.cameras;
  if (cameras.size() < 3) return OtherSizeOfTwo(set_up);
  const std::vector<PlacedPerson> people =
      PlacePeople(cameras, set_up.ideal, set_up.frames);
  std::optional<OtherImage> best;
  for (size_t v = 0; v < cameras.size(); ++v) {
    const PairAgreement before = set_up.WithOthers(v);
    // A view that agrees better than the average was neither scaled nor
    // cropped.
    if (before.score() > set_up.agreement.score()) continue;
    std::vector<ImageFit> fits;
    for (const PlacedPerson& person : people) {
      if (person.view_a == v || person.view_b == v) continue;
      const auto frame = static_cast<size_t>(person.frame);
      for (const auto& seen : set_up.raw[v].frames[frame]) {
        if (const auto fit = FitImage(cameras[v], person, seen)) {
          fits.push_back(*fit);
        }
      }
    }
    auto image = CommonImage(std::move(fits), least_shift);
    if (!image.has_value()) continue;
    image->view = v;
    if (image->scaled() || image->cropped()) {
      KeepBetter(set_up, before, *image, &best);
    }
  }
  return best;
}

}  // namespace

bool AMovedImageHelps(const SetUp& set_up) {
  return FindOtherImage(set_up, 0.0).has_value();
}

std::optional<Answer> AskForOtherRate(const SetUp& set_up) {
  if (set_up.AgreeAlready()) return std::nullopt;
  const auto rate = FindOtherRate(set_up);
  if (!rate.has_value()) return std::nullopt;
  std::string keys = "input.view_frame_rate." + set_up.ViewName(rate->view) +
                     "=" + fmt::format("{:.4g}", rate->rate_hz);
  // The key takes whole frames; if the offset is fractional, the numbers of all
  // views are made to begin at 0.
  const bool whole = rate->offset == std::round(rate->offset);
  const int64_t first = set_up.detections.frames.front().frame;
  for (size_t v = 0; rate->offset != 0.0 && v < set_up.cameras.size(); ++v) {
    if (whole && v != rate->view) continue;
    keys += ";input.view_frame_offset." + set_up.ViewName(v) + "=" +
            std::to_string(whole ? std::llround(rate->offset) : first);
  }
  Answer answer = AnswerWith(Found(
      "view_rate", set_up.CameraName(rate->view), rate->gain,
      rate->offset == 0.0 ? "--set=" + keys : "'--set=" + keys + "'",
      fmt::format("its frame numbers count at {:.4g} Hz, those of the "
                  "other views at {:.4g} Hz",
                  rate->rate_hz, set_up.detections.header.frame_rate_hz)));
  answer.detections = rate->Of(set_up.detections);
  answer.score = set_up.ScoreOf(set_up.cameras, *answer.detections);
  return answer;
}

std::string ExchangeSidesFlag(const std::vector<char>& views,
                              const std::vector<std::string>& names) {
  std::string list;
  for (size_t v = 0; v < views.size(); ++v) {
    if (views[v]) list += (list.empty() ? "\"" : ",\"") + names[v] + "\"";
  }
  return "'--set=detections.exchange_sides=[" + list + "]'";
}

void ExchangeSides(const std::vector<char>& views,
                   DetectionSequence* detections) {
  const Skeleton& skeleton = detections->header.skeleton;
  for (DetectionFrame& frame : detections->frames) {
    for (size_t v = 0; v < views.size(); ++v) {
      if (!views[v]) continue;
      for (Detection& detection : frame.views[v].detections) {
        const std::vector<Keypoint> own = detection.joints;
        for (int j = 0; j < skeleton.joint_count(); ++j) {
          detection.joints[j] = own[skeleton.mirror(j)];
        }
      }
    }
  }
}

ExchangedSides FindExchangedSides(const CameraRig& cameras,
                                  DetectionSequence seen) {
  const std::vector<int> frames = IndicesUpTo(seen.frames.size());
  ExchangedSides found;
  found.people = IdealPeople(seen, cameras);
  ExchangeSides(std::vector<char>(cameras.size(), 1), &seen);
  const std::vector<ViewPeople> mirrored = IdealPeople(seen, cameras);
  const SidesTable table(cameras, found.people, mirrored, frames);
  found.views = table.Best();
  found.gain = {table.Of(std::vector<char>(cameras.size(), 0), found.views),
                table.Of(found.views, found.views)};
  for (size_t v = 0; v < cameras.size(); ++v) {
    if (found.views[v]) found.people[v] = mirrored[v];
  }
  return found;
}

std::string MirrorText(char axis, double sum_px) {
  return fmt::format("{}{:g}", axis, sum_px);
}

std::string MirrorFlag(const std::vector<std::string>& mirrors,
                       const std::vector<std::string>& names) {
  std::string keys;
  for (size_t v = 0; v < mirrors.size(); ++v) {
    if (mirrors[v].empty()) continue;
    keys += (keys.empty() ? "'--set=" : ";") +
            ("detections.mirror_px." + names[v]) + "=" + mirrors[v];
  }
  return keys.empty() ? keys : keys + "'";
}

std::vector<std::string> FromTheBottom(const CameraRig& cameras) {
  std::vector<std::string> mirrors;
  for (const Camera& camera : cameras) {
    mirrors.push_back(MirrorText('y', ImageHeight(camera) - 1.0));
  }
  return mirrors;
}

Noses NosesOf(const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
              const Skeleton& skeleton) {
  const size_t frames = ideal.empty() ? 0 : ideal.front().frames.size();
  Noses noses;
  for (const PlacedPerson& person :
       PlacePeople(cameras, ideal, IndicesUpTo(frames))) {
    const auto joint = [&](const char* name) {
      return PlacedJoint(person, skeleton, name);
    };
    const auto l = joint("l_shoulder"), r = joint("r_shoulder");
    const auto lh = joint("l_hip"), rh = joint("r_hip");
    const auto nose = joint("nose");
    if (!l || !r || !lh || !rh || !nose) continue;
    // Shoulders, hips and trunk determine the forward direction.
    const Eigen::Vector3d up = (*l + *r - *lh - *rh).normalized();
    const Eigen::Vector3d ahead = ((*l - *r) + (*lh - *rh)).cross(up);
    // Shoulders placed close together do not determine it.
    const double trunk = 0.5 * (*l + *r - *lh - *rh).norm();
    if (!((*l - *r).norm() > 0.3 * trunk) || ahead.norm() == 0.0) continue;
    const double nose_m = (*nose - 0.5 * (*l + *r)).dot(ahead.normalized());
    if (std::abs(nose_m) < 0.1 * trunk) continue;  // the head is tilted back
    ++noses.looked_at;
    noses.backwards += nose_m < 0.0 ? 1 : 0;
  }
  return noses;
}

bool StandOnHeads(const DetectionSequence& seen) {
  constexpr int kEnough = 10;
  constexpr double kNearlyAll = 0.9;
  const Skeleton& skeleton = seen.header.skeleton;
  const auto middle = [&](const Detection& one, const std::string& part) {
    const int l = skeleton.IndexOf("l_" + part);
    const int r = skeleton.IndexOf("r_" + part);
    std::optional<Eigen::Vector2d> px;
    if (l >= 0 && r >= 0 && one.joints[l].found && one.joints[r].found) {
      px = 0.5 * (one.joints[l].px + one.joints[r].px);
    }
    return px;
  };
  int upright = 0;
  int on_heads = 0;
  for (const DetectionFrame& frame : seen.frames) {
    for (const ViewDetections& view : frame.views) {
      for (const Detection& one : view.detections) {
        const auto shoulders = middle(one, "shoulder");
        const auto hips = middle(one, "hip");
        if (!shoulders || !hips) continue;
        const Eigen::Vector2d trunk = *hips - *shoulders;
        if (std::abs(trunk.y()) <= std::abs(trunk.x())) continue;
        ++(trunk.y() > 0.0 ? upright : on_heads);
      }
    }
  }
  return on_heads >= kEnough && on_heads > kNearlyAll * (upright + on_heads);
}

// Left and right exchanged in some or all views.
std::optional<Answer> AskForSides(const SetUp& set_up) {
  const DetectionSequence seen = FramesOf(set_up.detections, set_up.frames);
  const ExchangedSides found = FindExchangedSides(set_up.cameras, seen);
  if (found.any() && !found.gain.is_enough()) return std::nullopt;
  const Noses noses =
      NosesOf(set_up.cameras, found.people, set_up.detections.header.skeleton);
  std::vector<char> exchanged = found.views;
  if (noses.are_backwards()) {
    for (char& view : exchanged) view = !view;
  } else if (!found.any()) {
    return std::nullopt;
  }
  const std::vector<std::string>& names =
      set_up.input.detections.header.view_names;
  const std::string fix = ExchangeSidesFlag(exchanged, names);
  Answer answer;
  const bool all = std::count(exchanged.begin(), exchanged.end(), 0) == 0;
  if (all) {
    const std::string evidence =
        fmt::format("noses are behind the shoulders in {} of {} people",
                    noses.backwards, noses.looked_at);
    answer =
        StandOnHeads(seen)
            ? AnswerWith({"image", "", 0.9, 0.0, 0.0,
                          "kinegraph calibrate RECORDING " +
                              MirrorFlag(FromTheBottom(set_up.cameras), names) +
                              " --out=cameras.json",
                          "y counts from the bottom of the images, and the "
                          "calibration was made with such images, so the "
                          "reconstruction is mirrored: people are upside down "
                          "in the images, and " +
                              evidence})
            : AnswerWith({"sides", "", 0.9, 0.0, 0.0, fix,
                          "left and right are exchanged: " + evidence});
  }
  for (size_t v = 0; v < exchanged.size(); ++v) {
    if (all || !exchanged[v]) continue;
    answer.findings.push_back(
        Found("sides", set_up.CameraName(v), found.gain, fix,
              "left and right are exchanged in this view"));
  }
  answer.detections = set_up.detections;
  ExchangeSides(exchanged, &*answer.detections);
  answer.score = set_up.ScoreOf(set_up.cameras, *answer.detections);
  return answer;
}

// A video scaled or cropped before detection.
std::optional<Answer> AskForOtherImage(const SetUp& set_up) {
  if (set_up.AgreeAlready()) return std::nullopt;
  // Fraction of the people's size; detectors' errors are smaller.
  constexpr double kLeastShift = 0.15;
  const auto image = FindOtherImage(set_up, kLeastShift);
  if (!image.has_value()) return std::nullopt;
  const Camera& camera = set_up.cameras[image->view];
  // A slightly rotated camera has the same effect; a shift of more than a tenth
  // of the image's width is too large for an unnoticed rotation.
  const double share = image->offset_px.norm() / ImageWidth(camera);
  const bool either = !image->scaled() && share <= 0.1;
  std::string what;
  if (either) {
    what = fmt::format(
        "the data fit better with its image shifted by ({:+.0f}, {:+.0f}) px: "
        "the video was cropped or the camera rotated",
        -image->offset_px.x(), -image->offset_px.y());
  } else if (image->scaled()) {
    what = fmt::format(
        "its video is {:.4g} times as large as the calibration's image",
        image->scale);
  }
  if (image->cropped() && !either) {
    what += (what.empty() ? "its video" : ", and") +
            fmt::format(" begins at pixel ({:.0f}, {:.0f}) of ",
                        image->offset_px.x(), image->offset_px.y()) +
            (image->scaled() ? "the scaled image" : "the calibration's image");
  }
  const char* kind = either             ? "shift"
                     : image->cropped() ? "crop"
                                        : "image_size";
  Answer answer = AnswerWith(Found(kind, set_up.CameraName(image->view),
                                   image->gain, kUseCorrected, what));
  answer.cameras = set_up.cameras;
  (*answer.cameras)[image->view] = image->Seen(camera);
  answer.score = set_up.ScoreOf(*answer.cameras, set_up.detections);
  return answer;
}

}  // namespace kinegraph
