#include "solvers/scene/view_agreement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "core/data/box.h"
#include "core/evaluation/statistics.h"
#include "core/geometry/epipolar.h"
#include "core/geometry/triangulation.h"
#include "core/skeleton/anthropometry.h"
#include "core/skeleton/body_joints.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

constexpr int kMinJoints = 6;  // or all joints of smaller skeletons
// Epipolar distance at which a joint gains nothing, as a fraction of the
// person's size. A detector's joints have errors of two or three per cent;
// another person is much farther away.
constexpr double kTolerance = 0.1;

double SizeOf(const ViewPeople::Person& person) {
  Eigen::AlignedBox2d box;
  for (size_t j = 0; j < person.px.size(); ++j) {
    if (person.found[j]) box.extend(person.px[j]);
  }
  return DiagonalPx(box);
}

// The people of a frame, prepared for comparison with those of another view:
// one row per joint, seven columns per person.
class ComparedPeople {
 public:
  ComparedPeople() = default;
  ComparedPeople(const Eigen::Matrix3d& F,
                 const std::vector<ViewPeople::Person>& people) {
    const auto joints = static_cast<Eigen::Index>(
        people.empty() ? 0 : people.front().px.size());
    columns_.setZero(joints,
                     kColumns * static_cast<Eigen::Index>(people.size()));
    for (size_t i = 0; i < people.size(); ++i) {
      auto own = columns_.middleCols<kColumns>(At(i));
      for (Eigen::Index j = 0; j < joints; ++j) {
        const auto joint = static_cast<size_t>(j);
        if (!people[i].found[joint]) continue;
        own.row(j).head<3>() << people[i].px[joint].transpose().array(), 1.0;
      }
      for (int k = 0; k < 3; ++k) {
        own.col(3 + k) =
            F(k, 0) * own.col(0) + F(k, 1) * own.col(1) + F(k, 2) * own.col(2);
      }
      const auto norm = (own.col(3).square() + own.col(4).square()).sqrt();
      own.col(6) = (norm > 0.0).select(norm.inverse(), 0.0);
    }
  }

  // Columns: x, y, 1; the joint's epipolar line a, b, c in the other view; and
  // the factor that converts a residual x_b' F x_a to the distance from that
  // line, 0 if there is no line. All are 0 if the joint was not found.
  auto Of(size_t person) const {
    return columns_.middleCols<kColumns>(At(person));
  }

 private:
  static constexpr int kColumns = 7;
  static Eigen::Index At(size_t person) {
    return kColumns * static_cast<Eigen::Index>(person);
  }
  Eigen::ArrayXXd columns_;
};

// Mean gain of the common joints of two people, given as ComparedPeople::Of
// returns them; 0 if these are too few.
template <typename Columns>
double PairGain(const Columns& a, double size_a, const Columns& b,
                double size_b) {
  const double common = (a.col(2) * b.col(2)).sum();
  if (common < std::min(kMinJoints, static_cast<int>(a.rows()))) return 0.0;
  const double per_a = 0.5 / (kTolerance * size_a);
  const double per_b = 0.5 / (kTolerance * size_b);
  return ((1.0 -
           (a.col(3) * b.col(0) + a.col(4) * b.col(1) + a.col(5) * b.col(2))
                   .abs() *
               (b.col(6) * per_a + a.col(6) * per_b))
              .max(0.0) *
          a.col(2) * b.col(2))
             .sum() /
         common;
}

// People of one frame of a view.
using People = std::vector<ViewPeople::Person>;

// Whether, for most of a few joints, the points of closest approach of the two
// rays lie in front of both cameras.
bool InFront(const Camera& camera_a, const ViewPeople::Person& a,
             const Camera& camera_b, const ViewPeople::Person& b) {
  constexpr int kLooks = 5;
  const Eigen::Vector3d base = camera_b.centre() - camera_a.centre();
  int looked = 0;
  int in_front = 0;
  for (size_t j = 0; j < a.px.size() && looked < kLooks; ++j) {
    if (!a.found[j] || !b.found[j]) continue;
    ++looked;
    const Eigen::Vector3d ray_a = camera_a.RayDirection(a.px[j]);
    const Eigen::Vector3d ray_b = camera_b.RayDirection(b.px[j]);
    const double cosine = ray_a.dot(ray_b);
    const double along_a = base.dot(ray_a) - cosine * base.dot(ray_b);
    const double along_b = cosine * base.dot(ray_a) - base.dot(ray_b);
    in_front += along_a > 0.0 && along_b > 0.0 ? 1 : 0;
  }
  return 2 * in_front > looked;
}

struct Match {
  double gain = 0.0;
  size_t a = 0;
  size_t b = 0;
};

// Matches people of two views one-to-one, best pairs first.
std::vector<Match> MatchPeople(const Camera& camera_a, const People& a,
                               const ComparedPeople& of_a,
                               const Camera& camera_b, const People& b,
                               const ComparedPeople& of_b) {
  std::vector<Match> likely;
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t k = 0; k < b.size(); ++k) {
      const double gain =
          PairGain(of_a.Of(i), a[i].size_px, of_b.Of(k), b[k].size_px);
      if (gain > 0.0) likely.push_back({gain, i, k});
    }
  }
  std::stable_sort(likely.begin(), likely.end(),
                   [](const Match& one, const Match& other) {
                     return one.gain > other.gain;
                   });
  std::vector<char> taken_a(a.size(), 0);
  std::vector<char> taken_b(b.size(), 0);
  std::vector<Match> matches;
  for (const Match& one : likely) {
    if (taken_a[one.a] || taken_b[one.b] ||
        !InFront(camera_a, a[one.a], camera_b, b[one.b])) {
      continue;
    }
    taken_a[one.a] = taken_b[one.b] = 1;
    matches.push_back(one);
  }
  return matches;
}

// Bounds the work, because each person is compared with each person of another
// view.
void KeepMostSeen(std::vector<ViewPeople::Person>* people) {
  constexpr size_t kMostPeople = 100;
  if (people->size() <= kMostPeople) return;
  const auto joints = [](const ViewPeople::Person& person) {
    return std::count(person.found.begin(), person.found.end(), 1);
  };
  std::stable_sort(
      people->begin(), people->end(),
      [&](const auto& a, const auto& b) { return joints(a) > joints(b); });
  people->resize(kMostPeople);
}

// Selects as many of the frames as yield enough people.
std::vector<int> FramesToPlace(const std::vector<ViewPeople>& ideal,
                               const std::vector<int>& frames) {
  constexpr size_t kEnoughPlaced = 1500;
  size_t most = 0;
  for (const auto& [a, b] : ComparedPairs(ideal.size())) {
    for (const int k : frames) {
      most += std::min(ideal[a].frames[k].size(), ideal[b].frames[k].size());
    }
  }
  if (most <= kEnoughPlaced) return frames;
  return Evenly(frames,
                std::max<size_t>(1, frames.size() * kEnoughPlaced / most));
}

}  // namespace

std::vector<ViewPeople> PeopleOfViews(const DetectionSequence& detections) {
  const std::vector<int>& joints =
      detections.header.skeleton.association_joints();
  std::vector<ViewPeople> views(detections.header.view_names.size());
  for (const DetectionFrame& frame : detections.frames) {
    for (size_t v = 0; v < views.size(); ++v) {
      auto& people = views[v].frames.emplace_back();
      for (const Detection& detection : frame.views[v].detections) {
        ViewPeople::Person person;
        int found = 0;
        for (const int j : joints) {
          const Keypoint& point = detection.joints[j];
          const bool counts =
              point.found && point.confidence >= kMinJointConfidence;
          person.px.push_back(point.px);
          person.found.push_back(counts);
          found += counts ? 1 : 0;
        }
        person.size_px = SizeOf(person);
        if (found >= std::min(kMinJoints, static_cast<int>(joints.size())) &&
            person.size_px > 0.0) {
          people.push_back(std::move(person));
        }
      }
      KeepMostSeen(&people);
    }
  }
  return views;
}

std::vector<int> IndicesUpTo(size_t count) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

std::vector<int> Evenly(const std::vector<int>& frames, size_t count) {
  if (frames.size() <= count) return frames;
  std::vector<int> chosen;
  for (size_t i = 0; i < count; ++i) {
    chosen.push_back(frames[frames.size() * i / count]);
  }
  return chosen;
}

DetectionSequence FramesOf(const DetectionSequence& detections,
                           const std::vector<int>& frames) {
  DetectionSequence some;
  some.header = detections.header;
  for (const int k : frames) {
    some.frames.push_back(detections.frames[k]);
  }
  return some;
}

int64_t IndexOfFrame(const DetectionSequence& detections, int64_t number) {
  const DetectionFrame* at = FindDetectionFrame(detections, number);
  return at == nullptr ? -1 : at - detections.frames.data();
}

ViewPeople Undistorted(ViewPeople view, const Camera& camera) {
  if (camera.lens() == nullptr) return view;
  for (auto& frame : view.frames) {
    for (ViewPeople::Person& person : frame) {
      for (size_t j = 0; j < person.px.size(); ++j) {
        if (!person.found[j]) continue;
        const auto px = camera.Undistort(person.px[j]);
        person.found[j] = px.has_value();
        if (px.has_value()) person.px[j] = *px;
      }
    }
  }
  return view;
}

std::vector<ViewPeople> Undistorted(std::vector<ViewPeople> views,
                                    const CameraRig& cameras) {
  for (size_t v = 0; v < views.size(); ++v) {
    views[v] = Undistorted(std::move(views[v]), cameras[v]);
  }
  return views;
}

std::vector<ViewPeople> IdealPeople(const DetectionSequence& detections,
                                    const CameraRig& cameras) {
  return Undistorted(PeopleOfViews(detections), cameras);
}

std::vector<PairAgreement> AgreementsOf(const Camera& camera_a,
                                        const ViewPeople& a,
                                        const Camera& camera_b,
                                        const ViewPeople& b,
                                        const std::vector<int>& frames,
                                        const std::vector<int>& lags) {
  const Eigen::Matrix3d F = FundamentalMatrix(camera_a, camera_b);
  const Eigen::Matrix3d F_back = F.transpose();
  // Caches frames already compared at another lag.
  std::unordered_map<int, ComparedPeople> known_a;
  std::unordered_map<int, ComparedPeople> known_b;
  std::vector<PairAgreement> agreements;
  agreements.reserve(lags.size());
  for (const int lag : lags) {
    PairAgreement& agreement = agreements.emplace_back();
    for (const int k : frames) {
      const int other = k + lag;
      if (other < 0 || other >= static_cast<int>(b.frames.size())) continue;
      const People& people_a = a.frames[k];
      const People& people_b = b.frames[other];
      const size_t possible = std::min(people_a.size(), people_b.size());
      if (possible == 0) continue;
      agreement.possible += static_cast<double>(possible);
      double size_px = 0.0;
      for (const auto& person : people_a) size_px += person.size_px;
      size_px *= kTolerance / static_cast<double>(people_a.size());
      agreement.distance_px += size_px * static_cast<double>(possible);
      // Coincident cameras have no epipolar lines.
      if (F.isZero()) continue;
      const auto [of_a, new_a] = known_a.try_emplace(k);
      if (new_a) of_a->second = ComparedPeople(F, people_a);
      const auto [of_b, new_b] = known_b.try_emplace(other);
      if (new_b) of_b->second = ComparedPeople(F_back, people_b);
      for (const Match& match : MatchPeople(camera_a, people_a, of_a->second,
                                            camera_b, people_b, of_b->second)) {
        agreement.gain += match.gain;
        agreement.distance_px -= match.gain * size_px;
      }
    }
  }
  return agreements;
}

PairAgreement AgreementOf(const Camera& camera_a, const ViewPeople& a,
                          const Camera& camera_b, const ViewPeople& b,
                          const std::vector<int>& frames, int lag) {
  return AgreementsOf(camera_a, a, camera_b, b, frames, {lag}).front();
}

std::vector<std::pair<size_t, size_t>> ComparedPairs(size_t view_count) {
  constexpr size_t kAllUpTo = 9;
  constexpr size_t kSteps = 4;
  std::vector<std::pair<size_t, size_t>> pairs;
  for (size_t a = 0; a < view_count; ++a) {
    for (size_t b = a + 1; view_count <= kAllUpTo && b < view_count; ++b) {
      pairs.emplace_back(a, b);
    }
    for (size_t i = 0; view_count > kAllUpTo && i < kSteps; ++i) {
      const size_t step = 1 + i * ((view_count - 1) / 2 - 1) / (kSteps - 1);
      pairs.push_back(std::minmax(a, (a + step) % view_count));
    }
  }
  return pairs;
}

double ComparisonsOfAll(const std::vector<ViewPeople>& views,
                        const std::vector<int>& frames) {
  double comparisons = 0.0;
  for (const auto& [a, b] : ComparedPairs(views.size())) {
    for (const int k : frames) {
      const auto at = static_cast<size_t>(k);
      comparisons += static_cast<double>(views[a].frames[at].size() *
                                         views[b].frames[at].size());
    }
  }
  return comparisons;
}

std::vector<int> FramesToLookAt(const std::vector<ViewPeople>& views, int count,
                                int repeats) {
  constexpr double kMostComparisons = 4e6;
  constexpr double kFewestFrames = 2.0;
  std::vector<int> candidates;
  const size_t frames = views.empty() ? 0 : views[0].frames.size();
  for (size_t k = 0; k < frames; ++k) {
    int seeing = 0;
    for (const ViewPeople& view : views) seeing += !view.frames[k].empty();
    if (seeing >= 2) candidates.push_back(static_cast<int>(k));
  }
  if (candidates.empty()) return candidates;
  const double a_frame = repeats * ComparisonsOfAll(views, candidates) /
                         static_cast<double>(candidates.size());
  return Evenly(
      candidates,
      static_cast<size_t>(std::min<double>(
          count, std::max(kFewestFrames, kMostComparisons / a_frame))));
}

PairAgreement AgreementOfAll(const CameraRig& cameras,
                             const std::vector<ViewPeople>& ideal,
                             const std::vector<int>& frames) {
  PairAgreement all;
  for (const auto& [a, b] : ComparedPairs(cameras.size())) {
    all.Add(AgreementOf(cameras[a], ideal[a], cameras[b], ideal[b], frames));
  }
  return all;
}

std::vector<PlacedPerson> PlacePeople(const CameraRig& cameras,
                                      const std::vector<ViewPeople>& ideal,
                                      const std::vector<int>& frames) {
  constexpr double kMinGain = 0.5;
  TriangulationOptions options;
  options.min_angle_rad = 0.2;
  const std::vector<int> looked_at = FramesToPlace(ideal, frames);
  std::vector<PlacedPerson> placed;
  for (const auto& [a, b] : ComparedPairs(cameras.size())) {
    const Eigen::Matrix3d F = FundamentalMatrix(cameras[a], cameras[b]);
    if (F.isZero()) continue;
    for (const int k : looked_at) {
      const People& people_a = ideal[a].frames[k];
      const People& people_b = ideal[b].frames[k];
      for (const Match& match : MatchPeople(
               cameras[a], people_a, ComparedPeople(F, people_a), cameras[b],
               people_b, ComparedPeople(F.transpose(), people_b))) {
        if (match.gain < kMinGain) continue;
        const auto& one = people_a[match.a];
        const auto& other = people_b[match.b];
        PlacedPerson& person = placed.emplace_back();
        person.frame = k;
        person.view_a = a;
        person.view_b = b;
        person.joints.resize(one.px.size());
        for (size_t j = 0; j < one.px.size(); ++j) {
          if (!one.found[j] || !other.found[j]) continue;
          const std::array<PointMeasurement, 2> seen = {
              {{&cameras[a], one.px[j], 1.0}, {&cameras[b], other.px[j], 1.0}}};
          const TriangulationResult point =
              TriangulateDlt({seen.data(), seen.size()}, options);
          if (point.ok()) person.joints[j] = point.point_m;
        }
      }
    }
  }
  return placed;
}

Stature StatureOf(const CameraRig& cameras,
                  const std::vector<ViewPeople>& ideal,
                  const std::vector<int>& frames, const Skeleton& skeleton) {
  if (!IsHuman(skeleton)) return {};
  std::vector<double> statures;
  for (const PlacedPerson& person : PlacePeople(cameras, ideal, frames)) {
    const auto joint = [&](const std::string& name) {
      return PlacedJoint(person, skeleton, name);
    };
    for (const std::string side : {"l_", "r_"}) {
      const auto shoulder = joint(side + "shoulder"), hip = joint(side + "hip");
      const auto knee = joint(side + "knee"), ankle = joint(side + "ankle");
      if (!shoulder || !hip || !knee || !ankle) continue;
      statures.push_back(((*shoulder - *hip).norm() + (*hip - *knee).norm() +
                          (*knee - *ankle).norm()) /
                         kAnkleToShoulderShare);
    }
  }
  Stature stature;
  stature.count = static_cast<int>(statures.size());
  if (!statures.empty()) stature.median_m = Quantile(statures, 0.5);
  return stature;
}

Stature StatureOf(const CameraRig& cameras, const DetectionSequence& recording,
                  int frames) {
  const std::vector<ViewPeople> people = IdealPeople(recording, cameras);
  return StatureOf(cameras, people, FramesToLookAt(people, frames),
                   recording.header.skeleton);
}

std::optional<Eigen::Vector3d> PlacedJoint(const PlacedPerson& person,
                                           const Skeleton& skeleton,
                                           const std::string& name) {
  const std::vector<int>& compared = skeleton.association_joints();
  const auto at =
      std::find(compared.begin(), compared.end(), skeleton.IndexOf(name));
  return at == compared.end() ? std::nullopt
                              : person.joints[at - compared.begin()];
}

}  // namespace kinegraph
