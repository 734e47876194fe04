#include "solvers/scene/view_checks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/evaluation/statistics.h"
#include "solvers/scene/readings.h"

namespace kinegraph {
namespace {

constexpr int kViewFramesToCompare = 40;

// Of a view, with its camera and its people as they are given.
PairAgreement WithOthers(const CameraRig& cameras,
                         const std::vector<ViewPeople>& people, size_t view,
                         const Camera& camera, const ViewPeople& own,
                         const std::vector<int>& frames) {
  PairAgreement all;
  for (size_t v = 0; v < cameras.size(); ++v) {
    if (v == view) continue;
    all.Add(AgreementOf(cameras[v], people[v], camera, own, frames));
  }
  return all;
}

PairAgreement WithOthers(const CameraRig& cameras,
                         const std::vector<ViewPeople>& people, size_t view,
                         const std::vector<int>& frames) {
  return WithOthers(cameras, people, view, cameras[view], people[view], frames);
}

// Of the frame with a number, or -1.
int IndexOfFrame(const std::vector<DetectionFrame>& frames, int64_t number) {
  const auto at = std::lower_bound(
      frames.begin(), frames.end(), number,
      [](const DetectionFrame& f, int64_t n) { return f.frame < n; });
  if (at == frames.end() || at->frame != number) return -1;
  return static_cast<int>(at - frames.begin());
}

// The frame in which a view's files that count `factor` times as fast, their
// numbers too high by `offset`, show what is nearest to frame `number`, and how
// many frames earlier than that it was taken; nullopt where it is nearer to
// another.
struct CountedFrame {
  int64_t number = 0;
  double earlier = 0.0;
};
std::optional<CountedFrame> FrameAtRate(int64_t number, double factor,
                                        double offset) {
  const auto told = static_cast<double>(number);
  CountedFrame shown;
  shown.number = std::llround(factor * told + offset);
  shown.earlier = told - (static_cast<double>(shown.number) - offset) / factor;
  // Of two frames alike the later, as where the recording is read.
  if (shown.earlier >= 0.5 || shown.earlier < -0.5) return std::nullopt;
  return shown;
}

// A view's people as they are where its files count so.
ViewPeople AtRate(const ViewPeople& people,
                  const std::vector<DetectionFrame>& frames,
                  const std::vector<int>& wanted, double factor,
                  double offset) {
  ViewPeople moved;
  moved.frames.resize(people.frames.size());
  for (const int k : wanted) {
    const auto shown =
        FrameAtRate(frames[static_cast<size_t>(k)].frame, factor, offset);
    if (!shown.has_value()) continue;
    const int from = IndexOfFrame(frames, shown->number);
    if (from < 0) continue;
    moved.frames[static_cast<size_t>(k)] =
        people.frames[static_cast<size_t>(from)];
  }
  return moved;
}

// Of the frames looked at.
ViewPeople Mirrored(const ViewPeople& people, const std::vector<int>& frames,
                    const Skeleton& skeleton) {
  ViewPeople mirrored;
  mirrored.frames.resize(people.frames.size());
  const std::vector<int>& joints = skeleton.association_joints();
  std::vector<size_t> partner;
  for (const int joint : joints) {
    const auto at =
        std::find(joints.begin(), joints.end(), skeleton.mirror(joint));
    partner.push_back(static_cast<size_t>(
        (at == joints.end() ? std::find(joints.begin(), joints.end(), joint)
                            : at) -
        joints.begin()));
  }
  for (const int k : frames) {
    const auto at = static_cast<size_t>(k);
    mirrored.frames[at] = people.frames[at];
    for (ViewPeople::Person& person : mirrored.frames[at]) {
      const ViewPeople::Person own = person;
      for (size_t j = 0; j < partner.size(); ++j) {
        person.px[j] = own.px[partner[j]];
        person.found[j] = own.found[partner[j]];
      }
    }
  }
  return mirrored;
}

// Of people in 3D, whether noses and toes lie behind: shoulders, hips and trunk
// tell which way is ahead.
void LookAhead(const std::vector<PlacedPerson>& people,
               const Skeleton& skeleton, ExchangedSides* sides) {
  const auto joint = [&](const PlacedPerson& person, const char* name) {
    const int at = PlaceOf(skeleton, name);
    return at < 0 ? std::nullopt : person.joints[static_cast<size_t>(at)];
  };
  for (const PlacedPerson& person : people) {
    const auto l = joint(person, "l_shoulder"), r = joint(person, "r_shoulder");
    const auto lh = joint(person, "l_hip"), rh = joint(person, "r_hip");
    const auto nose = joint(person, "nose");
    if (!l || !r || !lh || !rh || !nose) continue;
    const Eigen::Vector3d up = (*l + *r - *lh - *rh).normalized();
    const Eigen::Vector3d ahead = ((*l - *r) + (*lh - *rh)).cross(up);
    // Whoever is seen from the side has shoulders of no width.
    const double width = (*l - *r).norm();
    const double trunk = 0.5 * (*l + *r - *lh - *rh).norm();
    if (!(width > 0.3 * trunk) || ahead.norm() == 0.0) continue;
    const double nose_m = (*nose - 0.5 * (*l + *r)).dot(ahead.normalized());
    if (std::abs(nose_m) < 0.1 * trunk) continue;  // who bends the head back
    ++sides->looked_at;
    sides->backwards += nose_m < 0.0 ? 1 : 0;
  }
}

// The agreement of all pairs of views, by whether one of the two is mirrored.
class SidesTable {
 public:
  SidesTable(const CameraRig& cameras, const std::vector<ViewPeople>& people,
             const std::vector<ViewPeople>& mirrored,
             const std::vector<int>& frames)
      : views_(cameras.size()), pairs_(2 * views_ * views_) {
    for (size_t a = 0; a < views_; ++a) {
      for (size_t b = a + 1; b < views_; ++b) {
        At(a, b, 0) =
            AgreementOf(cameras[a], people[a], cameras[b], people[b], frames);
        At(a, b, 1) =
            AgreementOf(cameras[a], people[a], cameras[b], mirrored[b], frames);
      }
    }
  }

  // Over the pairs of which one view is in `of` and the other is not, with the
  // views of `exchanged` exchanged.
  PairAgreement Of(const std::vector<char>& exchanged,
                   const std::vector<char>& of) const {
    PairAgreement all;
    for (size_t a = 0; a < views_; ++a) {
      for (size_t b = a + 1; b < views_; ++b) {
        if (of[a] == of[b]) continue;
        all.Add(pairs_[(a * views_ + b) * 2 +
                       static_cast<size_t>(exchanged[a] != exchanged[b])]);
      }
    }
    return all;
  }

 private:
  PairAgreement& At(size_t a, size_t b, size_t crossed) {
    return pairs_[(a * views_ + b) * 2 + crossed];
  }
  size_t views_;
  std::vector<PairAgreement> pairs_;
};

// One view after the other, while that helps. One side of a split is as good
// as the other: of the smaller one.
std::vector<char> BestExchange(const SidesTable& table, size_t views) {
  std::vector<char> exchanged(views, 0);
  for (size_t round = 0; 2 * (round + 1) <= views; ++round) {
    size_t best = views;
    double most = AgreementGain::kLeastGain;
    for (size_t v = 0; v < views; ++v) {
      std::vector<char> next = exchanged;
      std::vector<char> alone(views, 0);
      alone[v] = 1;
      next[v] = !next[v];
      const double gain =
          table.Of(next, alone).score() - table.Of(exchanged, alone).score();
      if (gain <= most) continue;
      most = gain;
      best = v;
    }
    if (best == views) break;
    exchanged[best] = !exchanged[best];
  }
  return exchanged;
}

// x = scale * p + offset, by least squares; false where the points say little.
struct Fit2d {
  double scale = 1.0;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  // mean of p
  Eigen::Vector2d to = Eigen::Vector2d::Zero();    // mean of x
  double size_px = 0.0;                            // of the detection
};
std::optional<Fit2d> FitImage(
    const std::vector<std::optional<Eigen::Vector2d>>& placed,
    const ViewPeople::Person& seen) {
  Fit2d fit;
  double count = 0.0;
  for (size_t j = 0; j < placed.size(); ++j) {
    if (!placed[j].has_value() || !seen.found[j]) continue;
    fit.from += *placed[j];
    fit.to += seen.px[j];
    count += 1.0;
  }
  constexpr double kEnough = 8.0;
  if (count < kEnough) return std::nullopt;
  fit.from /= count;
  fit.to /= count;
  double both = 0.0, own = 0.0, squares = 0.0;
  for (int round = 0; round < 2; ++round) {
    for (size_t j = 0; j < placed.size(); ++j) {
      if (!placed[j].has_value() || !seen.found[j]) continue;
      const Eigen::Vector2d p = *placed[j] - fit.from;
      const Eigen::Vector2d x = seen.px[j] - fit.to;
      if (round == 0) {
        both += p.dot(x);
        own += p.squaredNorm();
      } else {
        squares += (x - fit.scale * p).squaredNorm();
      }
    }
    if (!(own > 0.0)) return std::nullopt;
    fit.scale = both / own;
  }
  fit.size_px = seen.size_px;
  constexpr double kAlike = 0.06;  // of the size
  if (!(fit.scale > 0.1) ||
      std::sqrt(squares / count) > kAlike * seen.size_px) {
    return std::nullopt;
  }
  fit.offset = fit.to - fit.scale * fit.from;
  return fit;
}

bool Agree(const Fit2d& a, const Fit2d& b) {
  constexpr double kScales = 0.06;
  constexpr double kPlaces = 0.1;  // of the size
  return std::abs(std::log(a.scale / b.scale)) < kScales &&
         (a.scale * b.from + a.offset - b.to).norm() < kPlaces * b.size_px;
}

// Videos are made smaller or larger by simple ratios.
constexpr std::array kRatios = {1.0,       0.5,  2.0, 2.0 / 3.0, 1.5, 0.75,
                                4.0 / 3.0, 0.25, 4.0, 1.0 / 3.0, 3.0};

double SimpleRatio(double scale) {
  // A focal length is off by so much, or a camera stands nearer.
  constexpr double kFocal = 0.08;
  if (std::abs(std::log(scale)) < kFocal) return 1.0;
  constexpr double kNear = 0.03;
  for (const double ratio : kRatios) {
    if (std::abs(std::log(scale / ratio)) < kNear) return ratio;
  }
  return scale;
}

// The fit that most others agree with, over all of them.
std::optional<Fit2d> CommonFit(std::vector<Fit2d> fits) {
  constexpr size_t kMost = 300;
  if (fits.size() > kMost) {
    for (size_t i = 0; i < kMost; ++i) fits[i] = fits[i * fits.size() / kMost];
    fits.resize(kMost);
  }
  size_t best = 0, most = 0;
  for (size_t i = 0; i < fits.size(); ++i) {
    const auto count = static_cast<size_t>(std::count_if(
        fits.begin(), fits.end(),
        [&](const Fit2d& other) { return Agree(fits[i], other); }));
    if (count > most) {
      most = count;
      best = i;
    }
  }
  constexpr size_t kEnough = 10;
  if (most < kEnough || 4 * most < fits.size()) return std::nullopt;
  std::vector<double> scales, x, y;
  for (const Fit2d& fit : fits) {
    if (Agree(fits[best], fit)) scales.push_back(fit.scale);
  }
  Fit2d common;
  common.scale = SimpleRatio(Quantile(scales, 0.5));
  for (const Fit2d& fit : fits) {
    if (!Agree(fits[best], fit)) continue;
    const Eigen::Vector2d offset = fit.to - common.scale * fit.from;
    x.push_back(offset.x());
    y.push_back(offset.y());
  }
  common.offset = {Quantile(x, 0.5), Quantile(y, 0.5)};
  common.size_px = fits[best].size_px;
  return common;
}

// Two views place nobody whom a third one could see: sizes are tried.
std::optional<OtherImage> OtherSizeOfTwo(const CameraRig& cameras,
                                         const std::vector<ViewPeople>& raw,
                                         const std::vector<ViewPeople>& ideal,
                                         const std::vector<int>& frames) {
  std::optional<OtherImage> best;
  for (size_t v = 0; v < cameras.size(); ++v) {
    for (const double ratio : kRatios) {
      OtherImage image;
      image.view = v;
      image.scale = ratio;
      const Camera camera = WithImage(cameras[v], image);
      image.gain = {WithOthers(cameras, ideal, v, frames),
                    WithOthers(cameras, ideal, v, camera,
                               Undistorted(raw[v], camera), frames)};
      if (image.gain.is_enough() &&
          (!best.has_value() || image.gain.gain() > best->gain.gain())) {
        best = image;
      }
    }
  }
  return best;
}

}  // namespace

std::vector<ShownFrames> FramesShown(const DetectionSequence& detections) {
  std::vector<ShownFrames> shown(detections.header.view_names.size());
  for (const DetectionFrame& frame : detections.frames) {
    for (size_t v = 0; v < shown.size(); ++v) {
      if (frame.views[v].detections.empty()) continue;
      if (!shown[v].any) shown[v].first = frame.frame;
      shown[v].any = true;
      shown[v].last = frame.frame;
    }
  }
  return shown;
}

std::vector<int64_t> FrameOffsets(const std::vector<ShownFrames>& shown) {
  // Views that share frames with one another, and the group with the most; of
  // equal ones that of the first view.
  const auto meets = [&](size_t a, size_t b) {
    return shown[a].any && shown[b].any && shown[a].first <= shown[b].last &&
           shown[b].first <= shown[a].last;
  };
  size_t reference = 0;
  int64_t most = 0;
  for (size_t v = 0; v < shown.size(); ++v) {
    int64_t count = 0;
    for (size_t u = 0; u < shown.size(); ++u) count += meets(u, v) ? 1 : 0;
    if (count > most) {
      most = count;
      reference = v;
    }
  }
  std::vector<int64_t> offsets(shown.size(), 0);
  bool any = false;
  for (size_t v = 0; v < shown.size(); ++v) {
    if (!shown[v].any || meets(v, reference)) continue;
    offsets[v] = shown[v].first - shown[reference].first;
    any = true;
  }
  return any ? offsets : std::vector<int64_t>();
}

DetectionSequence WithFrameOffsets(const DetectionSequence& detections,
                                   const std::vector<int64_t>& offsets) {
  const auto& frames = detections.frames;
  DetectionSequence moved =
      FramesMoved(detections, [&](size_t v, int64_t k) -> int64_t {
        return offsets[v] == 0
                   ? k
                   : IndexOfFrame(frames, frames[static_cast<size_t>(k)].frame +
                                              offsets[v]);
      });
  // The others join the frames of the views that stay.
  moved.frames.erase(std::remove_if(moved.frames.begin(), moved.frames.end(),
                                    [](const DetectionFrame& frame) {
                                      return std::all_of(
                                          frame.views.begin(),
                                          frame.views.end(),
                                          [](const ViewDetections& view) {
                                            return view.detections.empty();
                                          });
                                    }),
                     moved.frames.end());
  return moved;
}

std::optional<OtherRate> FindOtherRate(const CameraRig& cameras,
                                       const std::vector<ViewPeople>& people,
                                       const DetectionSequence& detections,
                                       double frame_rate_hz) {
  constexpr std::array kRates = {12.0, 12.5, 15.0, 24.0,  25.0,  30.0,  48.0,
                                 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0};
  // Half of the views at twice the rate are the others at half of it: of
  // answers alike the faster one is taken.
  constexpr double kAlike = 0.03;
  // Each pair of views is compared from both sides.
  const std::vector<int> frames = FramesToLookAt(
      people, kViewFramesToCompare, 2 * static_cast<int>(kRates.size()));
  std::optional<OtherRate> best;
  for (size_t v = 0; v < cameras.size(); ++v) {
    const PairAgreement before = WithOthers(cameras, people, v, frames);
    for (const double rate_hz : kRates) {
      const double factor = rate_hz / frame_rate_hz;
      if (std::abs(factor - 1.0) < 0.02 || factor < 0.2 || factor > 5.0) {
        continue;
      }
      // The first frames of all belong together, or numbers count from 0.
      const auto first = static_cast<double>(detections.frames.front().frame);
      const double together = first - factor * first;
      for (const double offset : {together, 0.0}) {
        const AgreementGain gain = {
            before, WithOthers(cameras, people, v, cameras[v],
                               AtRate(people[v], detections.frames, frames,
                                      factor, offset),
                               frames)};
        // Most of the frames must have a partner.
        const double most = std::min(1.0, factor) * before.possible;
        if (gain.after.possible >= 0.3 * most && gain.is_enough() &&
            (!best.has_value() ||
             gain.gain() > best->gain.gain() +
                               (rate_hz > best->rate_hz ? -kAlike : kAlike))) {
          best = OtherRate{v, rate_hz, offset, gain};
        }
        if (together == 0.0) break;
      }
    }
  }
  return best;
}

DetectionSequence WithViewRate(const DetectionSequence& detections, size_t view,
                               double factor, double offset) {
  const auto& frames = detections.frames;
  const auto source = [&](int64_t k) {
    return FrameAtRate(frames[static_cast<size_t>(k)].frame, factor, offset);
  };
  DetectionSequence moved =
      FramesMoved(detections, [&](size_t v, int64_t k) -> int64_t {
        if (v != view) return k;
        const auto shown = source(k);
        return shown ? IndexOfFrame(frames, shown->number) : -1;
      });
  for (size_t k = 0; k < moved.frames.size(); ++k) {
    if (const auto shown = source(static_cast<int64_t>(k))) {
      moved.frames[k].views[view].capture_time -=
          FromSeconds(shown->earlier / detections.header.frame_rate_hz);
    }
  }
  return moved;
}

std::optional<ExchangedSides> FindExchangedSides(
    const CameraRig& cameras, const std::vector<ViewPeople>& people,
    const std::vector<int>& frames, const Skeleton& skeleton) {
  const size_t views = cameras.size();
  std::vector<ViewPeople> mirrored;
  for (const ViewPeople& view : people) {
    mirrored.push_back(Mirrored(view, frames, skeleton));
  }
  const SidesTable table(cameras, people, mirrored, frames);
  ExchangedSides sides;
  sides.views = BestExchange(table, views);
  const bool some =
      std::find(sides.views.begin(), sides.views.end(), 1) != sides.views.end();
  if (some) {
    const std::vector<char> none(views, 0);
    sides.gain = {table.Of(none, sides.views),
                  table.Of(sides.views, sides.views)};
    if (!sides.gain.is_enough()) return std::nullopt;
  }
  std::vector<ViewPeople> settled = people;
  for (size_t v = 0; v < views; ++v) {
    if (sides.views[v]) settled[v] = mirrored[v];
  }
  LookAhead(PlacePeople(cameras, settled, frames), skeleton, &sides);
  constexpr int kEnough = 10;
  constexpr double kMost = 0.8;
  if (sides.looked_at >= kEnough && sides.backwards > kMost * sides.looked_at) {
    for (char& view : sides.views) view = !view;
  } else if (!some) {
    return std::nullopt;
  }
  return sides;
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
          detection.joints[static_cast<size_t>(j)] =
              own[static_cast<size_t>(skeleton.mirror(j))];
        }
      }
    }
  }
}

Camera WithImage(const Camera& camera, const OtherImage& image) {
  CameraParameters parameters = camera.parameters();
  // (0, 0) is the middle of the first pixel, so that scales are about its
  // corner.
  parameters.K.topRows<2>() *= image.scale;
  const double corner = 0.5 * (image.scale - 1.0);
  parameters.K(0, 2) += corner - image.offset_px.x();
  parameters.K(1, 2) += corner - image.offset_px.y();
  if (parameters.width_px > 0) {
    const Eigen::Vector2d size =
        image.scale *
        Eigen::Vector2d(parameters.width_px, parameters.height_px);
    parameters.width_px = static_cast<int>(std::lround(size.x()));
    parameters.height_px = static_cast<int>(std::lround(size.y()));
  }
  return Camera(parameters);
}

std::optional<OtherImage> FindOtherImage(const CameraRig& cameras,
                                         const std::vector<ViewPeople>& raw,
                                         const std::vector<int>& frames) {
  std::vector<ViewPeople> ideal;
  for (size_t v = 0; v < raw.size(); ++v) {
    ideal.push_back(Undistorted(raw[v], cameras[v]));
  }
  if (cameras.size() < 3) return OtherSizeOfTwo(cameras, raw, ideal, frames);
  const double all = AgreementOfAll(cameras, ideal, frames).score();
  const std::vector<PlacedPerson> people = PlacePeople(cameras, ideal, frames);
  std::optional<OtherImage> best;
  for (size_t v = 0; v < cameras.size(); ++v) {
    const PairAgreement before = WithOthers(cameras, ideal, v, frames);
    // Where a view agrees nobody scaled it.
    if (before.score() > all) continue;
    std::vector<Fit2d> fits;
    for (const PlacedPerson& person : people) {
      if (person.view_a == v || person.view_b == v) continue;
      std::vector<std::optional<Eigen::Vector2d>> placed;
      for (const auto& joint : person.joints) {
        placed.push_back(joint.has_value() ? cameras[v].Project(*joint)
                                           : std::nullopt);
      }
      for (const auto& seen :
           raw[v].frames[static_cast<size_t>(person.frame)]) {
        if (const auto fit = FitImage(placed, seen)) fits.push_back(*fit);
      }
    }
    const auto common = CommonFit(std::move(fits));
    if (!common.has_value()) continue;
    OtherImage image;
    image.view = v;
    image.scale = common->scale;
    const double corner = 0.5 * (image.scale - 1.0);
    constexpr double kLeastShift = 0.15;
    image.offset_px = Eigen::Vector2d(corner, corner) - common->offset;
    // Less is within what detectors are off by.
    if (image.offset_px.norm() < kLeastShift * common->size_px) {
      image.offset_px.setZero();
    }
    image.offset_px = image.offset_px.array().round();
    if (!image.scaled() && !image.cropped()) continue;
    const Camera camera = WithImage(cameras[v], image);
    image.gain = {before, WithOthers(cameras, ideal, v, camera,
                                     Undistorted(raw[v], camera), frames)};
    if (image.gain.is_enough() &&
        (!best.has_value() || image.gain.gain() > best->gain.gain())) {
      best = image;
    }
  }
  return best;
}

}  // namespace kinegraph
