#include "solvers/scene/view_agreement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/evaluation/statistics.h"
#include "core/geometry/epipolar.h"
#include "core/geometry/triangulation.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

constexpr int kMinJoints = 6;
// Of a person's size. A joint of a detector is off by two or three per cent of
// it; another person by much more.
constexpr double kTolerance = 0.1;

double SizeOf(const ViewPeople::Person& person) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (size_t j = 0; j < person.px.size(); ++j) {
    if (!person.found[j]) continue;
    low = low.cwiseMin(person.px[j]);
    high = high.cwiseMax(person.px[j]);
  }
  return (high - low).norm();
}

// What a person's joints say in another view: their epipolar lines there, and
// by what a residual x_b' F x_a becomes a distance from them, in shares of the
// other person's size.
struct EpipolarLines {
  std::vector<Eigen::Vector3d> lines;
  std::vector<double> per_norm;  // 0 where there is no line
};

EpipolarLines LinesOf(const Eigen::Matrix3d& F,
                      const ViewPeople::Person& person) {
  EpipolarLines result;
  result.lines.resize(person.px.size(), Eigen::Vector3d::Zero());
  result.per_norm.resize(person.px.size(), 0.0);
  for (size_t j = 0; j < person.px.size(); ++j) {
    if (!person.found[j]) continue;
    result.lines[j] = F * person.px[j].homogeneous();
    const double norm = result.lines[j].head<2>().norm();
    if (norm > 0.0) result.per_norm[j] = 1.0 / norm;
  }
  return result;
}

std::vector<EpipolarLines> LinesOf(
    const Eigen::Matrix3d& F, const std::vector<ViewPeople::Person>& people) {
  std::vector<EpipolarLines> lines;
  for (const auto& person : people) lines.push_back(LinesOf(F, person));
  return lines;
}

// Sum of the gains of all common joints over their number.
double PairGain(const EpipolarLines& of_a, const ViewPeople::Person& a,
                const EpipolarLines& of_b, const ViewPeople::Person& b) {
  const double per_a = 0.5 / (kTolerance * a.size_px);
  const double per_b = 0.5 / (kTolerance * b.size_px);
  double sum = 0.0;
  int common = 0;
  for (size_t j = 0; j < a.px.size(); ++j) {
    if (!a.found[j] || !b.found[j]) continue;
    ++common;
    const double residual = std::abs(of_a.lines[j].dot(b.px[j].homogeneous()));
    const double distance =
        residual * (of_b.per_norm[j] * per_a + of_a.per_norm[j] * per_b);
    sum += std::max(0.0, 1.0 - distance);
  }
  return common >= kMinJoints ? sum / common : 0.0;
}

std::optional<Eigen::Vector3d> Triangulated(const Camera& camera_a,
                                            const Eigen::Vector2d& a,
                                            const Camera& camera_b,
                                            const Eigen::Vector2d& b,
                                            double min_angle_rad) {
  const std::array<PointMeasurement, 2> measurements = {
      {{&camera_a, a, 1.0}, {&camera_b, b, 1.0}}};
  TriangulationOptions options;
  options.min_angle_rad = min_angle_rad;
  const TriangulationResult result =
      TriangulateDlt({measurements.data(), measurements.size()}, options);
  if (!result.ok()) return std::nullopt;
  return result.point_m;
}

// Whether two rays come nearest each other in front of both cameras.
bool RaysMeetInFront(const Camera& camera_a, const Eigen::Vector2d& a,
                     const Camera& camera_b, const Eigen::Vector2d& b) {
  const Eigen::Vector3d ray_a = camera_a.RayDirection(a);
  const Eigen::Vector3d ray_b = camera_b.RayDirection(b);
  const Eigen::Vector3d base = camera_b.centre() - camera_a.centre();
  const double cosine = ray_a.dot(ray_b);
  const double along_a = base.dot(ray_a) - cosine * base.dot(ray_b);
  const double along_b = cosine * base.dot(ray_a) - base.dot(ray_b);
  return along_a > 0.0 && along_b > 0.0;
}

// Whether most of a few joints lie in front of both cameras.
bool InFront(const Camera& camera_a, const ViewPeople::Person& a,
             const Camera& camera_b, const ViewPeople::Person& b) {
  constexpr int kLooks = 5;
  int looked = 0;
  int in_front = 0;
  for (size_t j = 0; j < a.px.size() && looked < kLooks; ++j) {
    if (!a.found[j] || !b.found[j]) continue;
    ++looked;
    in_front += RaysMeetInFront(camera_a, a.px[j], camera_b, b.px[j]) ? 1 : 0;
  }
  return 2 * in_front > looked;
}

struct Match {
  double gain = 0.0;
  size_t a = 0;
  size_t b = 0;
};

// People of two views who are one person, the best pairs first.
std::vector<Match> MatchPeople(const Eigen::Matrix3d& F, const Camera& camera_a,
                               const std::vector<ViewPeople::Person>& a,
                               const Camera& camera_b,
                               const std::vector<ViewPeople::Person>& b) {
  const std::vector<EpipolarLines> lines_a = LinesOf(F, a);
  const std::vector<EpipolarLines> lines_b = LinesOf(F.transpose(), b);
  std::vector<Match> pairs;
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t k = 0; k < b.size(); ++k) {
      const double gain = PairGain(lines_a[i], a[i], lines_b[k], b[k]);
      if (gain > 0.0 && InFront(camera_a, a[i], camera_b, b[k])) {
        pairs.push_back({gain, i, k});
      }
    }
  }
  std::stable_sort(
      pairs.begin(), pairs.end(),
      [](const Match& x, const Match& y) { return x.gain > y.gain; });
  std::vector<char> used_a(a.size(), 0);
  std::vector<char> used_b(b.size(), 0);
  std::vector<Match> matches;
  for (const Match& pair : pairs) {
    if (used_a[pair.a] || used_b[pair.b]) continue;
    used_a[pair.a] = used_b[pair.b] = 1;
    matches.push_back(pair);
  }
  return matches;
}

// Length of a chain of joints, NaN where one is not there.
double ChainLength(const std::vector<std::optional<Eigen::Vector3d>>& points,
                   const std::vector<int>& chain) {
  double length = 0.0;
  for (size_t i = 0; i + 1 < chain.size(); ++i) {
    if (chain[i] < 0 || chain[i + 1] < 0) return NAN;
    const auto& a = points[static_cast<size_t>(chain[i])];
    const auto& b = points[static_cast<size_t>(chain[i + 1])];
    if (!a.has_value() || !b.has_value()) return NAN;
    length += (*a - *b).norm();
  }
  return length;
}

}  // namespace

std::vector<ViewPeople> PeopleOfViews(const DetectionSequence& detections,
                                      double min_confidence) {
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
          const bool counts = point.found && point.confidence >= min_confidence;
          person.px.push_back(point.px);
          person.found.push_back(counts);
          found += counts ? 1 : 0;
        }
        person.size_px = SizeOf(person);
        if (found >= kMinJoints && person.size_px > 0.0) {
          people.push_back(std::move(person));
        }
      }
    }
  }
  return views;
}

ViewPeople Undistorted(const ViewPeople& view, const Camera& camera) {
  ViewPeople ideal = view;
  if (camera.lens() == nullptr) return ideal;
  for (auto& frame : ideal.frames) {
    for (ViewPeople::Person& person : frame) {
      for (size_t j = 0; j < person.px.size(); ++j) {
        if (!person.found[j]) continue;
        const auto px = camera.Undistort(person.px[j]);
        person.found[j] = px.has_value();
        if (px.has_value()) person.px[j] = *px;
      }
    }
  }
  return ideal;
}

PairAgreement AgreementOf(const Camera& camera_a, const ViewPeople& a,
                          const Camera& camera_b, const ViewPeople& b,
                          const std::vector<int>& frames, int lag) {
  const Eigen::Matrix3d F = FundamentalMatrix(camera_a, camera_b);
  PairAgreement agreement;
  // Two cameras in one place see everything on each other's lines.
  const bool no_lines = F.isZero();
  for (const int k : frames) {
    const int other = k + lag;
    if (other < 0 || other >= static_cast<int>(b.frames.size())) continue;
    const auto& people_a = a.frames[static_cast<size_t>(k)];
    const auto& people_b = b.frames[static_cast<size_t>(other)];
    const size_t possible = std::min(people_a.size(), people_b.size());
    if (possible == 0) continue;
    agreement.possible += static_cast<double>(possible);
    double size_px = 0.0;
    for (const auto& person : people_a) size_px += person.size_px;
    size_px *= kTolerance / static_cast<double>(people_a.size());
    agreement.distance_px += size_px * static_cast<double>(possible);
    if (no_lines) continue;
    for (const Match& match :
         MatchPeople(F, camera_a, people_a, camera_b, people_b)) {
      agreement.gain += match.gain;
      agreement.distance_px -= match.gain * size_px;
      agreement.matched += match.gain > 0.5 ? 1 : 0;
    }
  }
  return agreement;
}

std::vector<int> FramesToLookAt(const std::vector<ViewPeople>& views,
                                int count) {
  std::vector<int> candidates;
  const size_t frames = views.empty() ? 0 : views[0].frames.size();
  for (size_t k = 0; k < frames; ++k) {
    int seeing = 0;
    for (const ViewPeople& view : views) seeing += !view.frames[k].empty();
    if (seeing >= 2) candidates.push_back(static_cast<int>(k));
  }
  if (static_cast<int>(candidates.size()) <= count) return candidates;
  std::vector<int> chosen;
  for (int i = 0; i < count; ++i) {
    const size_t at =
        candidates.size() * static_cast<size_t>(i) / static_cast<size_t>(count);
    chosen.push_back(candidates[at]);
  }
  return chosen;
}

PairAgreement AgreementOfAll(const CameraRig& cameras,
                             const std::vector<ViewPeople>& ideal,
                             const std::vector<int>& frames) {
  PairAgreement all;
  for (size_t a = 0; a < cameras.size(); ++a) {
    for (size_t b = a + 1; b < cameras.size(); ++b) {
      const PairAgreement pair =
          AgreementOf(cameras[a], ideal[a], cameras[b], ideal[b], frames);
      all.Add(pair);
    }
  }
  return all;
}

std::vector<PlacedPerson> PlacePeople(const CameraRig& cameras,
                                      const std::vector<ViewPeople>& ideal,
                                      const std::vector<int>& frames,
                                      int without_view) {
  constexpr double kMinAngleRad = 0.2;
  constexpr double kMinGain = 0.5;
  std::vector<PlacedPerson> placed;
  for (size_t a = 0; a < cameras.size(); ++a) {
    for (size_t b = a + 1; b < cameras.size(); ++b) {
      const Eigen::Matrix3d F = FundamentalMatrix(cameras[a], cameras[b]);
      if (F.isZero() || static_cast<int>(a) == without_view ||
          static_cast<int>(b) == without_view) {
        continue;
      }
      for (const int k : frames) {
        const auto& people_a = ideal[a].frames[static_cast<size_t>(k)];
        const auto& people_b = ideal[b].frames[static_cast<size_t>(k)];
        for (const Match& match :
             MatchPeople(F, cameras[a], people_a, cameras[b], people_b)) {
          if (match.gain < kMinGain) continue;
          const auto& one = people_a[match.a];
          const auto& other = people_b[match.b];
          PlacedPerson& person = placed.emplace_back();
          person.frame = k;
          person.joints.resize(one.px.size());
          for (size_t j = 0; j < one.px.size(); ++j) {
            if (!one.found[j] || !other.found[j]) continue;
            person.joints[j] = Triangulated(cameras[a], one.px[j], cameras[b],
                                            other.px[j], kMinAngleRad);
          }
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
  // Shoulder, hip, knee and ankle of a standing person stand 0.818, 0.530,
  // 0.285 and 0.039 of the stature above the ground (Drillis and Contini,
  // "Body segment parameters", 1966): the chain is 0.779 of it.
  constexpr double kChainOfStature = 0.779;
  const auto place = [&](const std::string& name) {
    return PlaceOf(skeleton, name);
  };
  std::vector<double> statures;
  for (const PlacedPerson& person : PlacePeople(cameras, ideal, frames)) {
    for (const std::string side : {"l_", "r_"}) {
      const double length = ChainLength(
          person.joints, {place(side + "shoulder"), place(side + "hip"),
                          place(side + "knee"), place(side + "ankle")});
      if (std::isfinite(length)) statures.push_back(length / kChainOfStature);
    }
  }
  Stature stature;
  stature.count = static_cast<int>(statures.size());
  if (!statures.empty()) stature.median_m = Quantile(statures, 0.5);
  return stature;
}

int PlaceOf(const Skeleton& skeleton, const std::string& joint_name) {
  const std::vector<int>& counted = skeleton.association_joints();
  const auto at =
      std::find(counted.begin(), counted.end(), skeleton.IndexOf(joint_name));
  return at == counted.end() ? -1 : static_cast<int>(at - counted.begin());
}

}  // namespace kinegraph
