#include "solvers/noise/bias_learner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/constants.h"
#include "solvers/factors/jacobian.h"

namespace kinegraph {
namespace {

// Strength of the prior at zero, in independent observations of mean weight, by
// class: large where the bias was small compared with the noise of real
// detections.
double RidgeOf(JointClass joint_class) {
  // head trunk shoulder elbow wrist hip knee ankle foot other
  constexpr std::array<double, kJointClassCount> kRidges = {
      100.0, 20.0, 10.0, 150.0, 100.0, 10.0, 20.0, 300.0, 300.0, 100.0};
  return kRidges[static_cast<size_t>(joint_class)];
}

// 0.975 quantile of Student's t; accurate to 0.06 from five degrees of freedom
// on.
double LimitOfStudent(double degrees_of_freedom) {
  return 1.96 + 2.5 / (degrees_of_freedom - 0.5);
}

int64_t FloorDivide(TimeNs time, TimeNs step) {
  return time >= 0 ? time / step : -((-time + step - 1) / step);
}

// Adds a view to the sums of its joint, except for the terms of a shift of its
// images (AddShift).
void AddView(const BiasView& view, double independent, BiasSums* sums) {
  const auto& features = view.direction.features;
  const Eigen::Vector2d across = view.per_sigma * view.direction.across_px;
  const Eigen::Vector2d along = view.per_sigma * view.direction.along_px;
  const Eigen::Vector2d r = view.per_sigma * view.residual_px;
  // Across and along are perpendicular and have equal length.
  const double weight = along.squaredNorm();
  const Eigen::Matrix<double, kViewFeatureCount, kViewFeatureCount> outer =
      weight * features * features.transpose();
  sums->A.topLeftCorner<kViewFeatureCount, kViewFeatureCount>() += outer;
  sums->A.bottomRightCorner<kViewFeatureCount, kViewFeatureCount>() += outer;
  sums->g.head<kViewFeatureCount>() += features * across.dot(r);
  sums->g.tail<kViewFeatureCount>() += features * along.dot(r);
  const Matrix23d by_body =
      view.per_sigma * view.jacobian * view.direction.body;
  sums->offset.topRows<kViewFeatureCount>() +=
      features * (across.transpose() * by_body);
  sums->offset.bottomRows<kViewFeatureCount>() +=
      features * (along.transpose() * by_body);
  sums->feature_squares += weight * features.cwiseAbs2();
  sums->weight += weight;
  sums->square += r.squaredNorm();
  ++sums->observations;
  sums->independent += independent;
}

// Adds the terms of a shift of the view's images.
void AddShift(const BiasView& view, BiasSums* sums) {
  const auto at = static_cast<size_t>(view.view_idx);
  if (sums->views.size() <= at) sums->views.resize(at + 1);
  BiasSums::OfView& of_view = sums->views[at];
  const auto& features = view.direction.features;
  const double weight = view.per_sigma * view.per_sigma;
  of_view.cross.topRows<kViewFeatureCount>() +=
      weight * features * view.direction.across_px.transpose();
  of_view.cross.bottomRows<kViewFeatureCount>() +=
      weight * features * view.direction.along_px.transpose();
  of_view.pull += weight * view.residual_px;
  of_view.weight += weight;
}

void AddShifts(const std::vector<BiasSums::OfView>& from,
               std::vector<BiasSums::OfView>* to) {
  to->resize(std::max(to->size(), from.size()));
  for (size_t v = 0; v < from.size(); ++v) {
    (*to)[v].cross += from[v].cross;
    (*to)[v].pull += from[v].pull;
    (*to)[v].weight += from[v].weight;
  }
}

// Reduction of the sum of squares.
double GainOf(const BiasSums& sums, const BiasVector& bias) {
  return 2.0 * sums.g.dot(bias) - bias.dot(sums.A * bias);
}

}  // namespace

BiasSums& BiasSums::operator+=(const BiasSums& other) {
  A += other.A;
  g += other.g;
  offset += other.offset;
  feature_squares += other.feature_squares;
  weight += other.weight;
  square += other.square;
  observations += other.observations;
  looks += other.looks;
  independent += other.independent;
  AddShifts(other.views, &views);
  return *this;
}

void AddViews(const std::vector<BiasView>& views, double independent,
              BiasSums* sums) {
  if (views.size() < 2) return;
  ++sums->looks;
  for (const BiasView& view : views) {
    AddView(view, independent, sums);
    AddShift(view, sums);
  }
}

double IndependentShare(const ErrorCorrelation& correlation, double period_s) {
  const double others = std::expm1(period_s / correlation.time_s);
  return 1.0 / (1.0 + 2.0 * correlation.share / others);
}

BiasVector SolveBias(const BiasSums& sums, double ridge) {
  if (sums.observations == 0) return BiasVector::Zero();
  // The prior counts as `ridge` independent observations, each with the mean
  // weight of an independent observation and, for every feature, the weighted
  // mean square (at least 1e-4).
  const double mean_weight = sums.weight / sums.independent;
  BiasVector diagonal;
  for (int i = 0; i < kViewFeatureCount; ++i) {
    const double square = sums.feature_squares[i] / sums.weight;
    diagonal[i] = ridge * mean_weight * std::max(square, 1e-4);
    diagonal[i + kViewFeatureCount] = diagonal[i];
  }
  auto regular = sums.A;
  regular.diagonal() += diagonal;
  const Eigen::LDLT<decltype(regular)> factor(regular);
  BiasVector bias = factor.solve(sums.g);
  const Eigen::Matrix<double, kBiasSize, 3> pull = factor.solve(sums.offset);
  const Eigen::Matrix3d stiffness = sums.offset.transpose() * pull;
  bias -= pull * stiffness.ldlt().solve(sums.offset.transpose() * bias);
  return bias.allFinite() ? bias : BiasVector::Zero();
}

BiasSeries::BiasSeries(const BiasJoints& joints, int view_count)
    : names_(joints.names()),
      classes_(joints.classes()),
      azimuths_(static_cast<size_t>(view_count)) {}

void BiasSeries::Add(TimeNs time, const std::vector<BiasSums>& sums) {
  std::vector<BiasSums>& block = blocks_[FloorDivide(time, block_ns_)];
  block.resize(classes_.size());
  for (size_t i = 0; i < sums.size(); ++i) {
    if (sums[i].observations > 0) block[i] += sums[i];
  }
  while (blocks_.size() > kMostBlocks) JoinNeighbours();
}

void BiasSeries::JoinNeighbours() {
  block_ns_ *= 2;
  std::map<int64_t, std::vector<BiasSums>> joined;
  for (auto& [key, from] : blocks_) {
    std::vector<BiasSums>& to = joined[FloorDivide(key, 2)];
    to.resize(classes_.size());
    for (size_t i = 0; i < to.size(); ++i) to[i] += from[i];
  }
  blocks_ = std::move(joined);
}

void BiasSeries::Add(const BiasSeries& other) {
  while (block_ns_ < other.block_ns_) JoinNeighbours();
  for (const auto& [key, block] : other.blocks_) {
    Add(key * other.block_ns_, block);
  }
  for (size_t v = 0; v < azimuths_.size(); ++v) {
    for (size_t i = 0; i < azimuths_[v].size(); ++i) {
      azimuths_[v][i] += other.azimuths_[v][i];
    }
  }
}

void BiasSeries::AddAzimuth(int view_idx, double azimuth) {
  const double share = (azimuth + kPi) / (2.0 * kPi);
  const int sector =
      std::clamp(static_cast<int>(share * kSectors), 0, kSectors - 1);
  ++azimuths_[view_idx][sector];
}

std::vector<WeightedValue> BiasSeries::SectorsSeen() const {
  std::vector<WeightedValue> seen;
  for (const auto& sectors : azimuths_) {
    const int64_t total =
        std::accumulate(sectors.begin(), sectors.end(), int64_t{0});
    if (total == 0) continue;
    const int64_t few = total / (10 * kSectors);
    seen.emplace_back(
        std::count_if(sectors.begin(), sectors.end(),
                      [few](int64_t count) { return count > few; }),
        1.0);
  }
  return seen;
}

void BiasSeries::RemoveShifts() {
  std::vector<BiasSums::OfView> all;
  for (const auto& [key, block] : blocks_) {
    for (const BiasSums& sums : block) AddShifts(sums.views, &all);
  }
  for (auto& [key, block] : blocks_) {
    for (BiasSums& sums : block) {
      for (size_t v = 0; v < sums.views.size(); ++v) {
        const BiasSums::OfView& view = sums.views[v];
        if (!(view.weight > 0.0)) continue;
        const Eigen::Vector2d shift_px = all[v].pull / all[v].weight;
        sums.g -= view.cross * shift_px;
        sums.square += shift_px.dot(view.weight * shift_px - 2.0 * view.pull);
      }
    }
  }
  shifts_away_ = true;
}

ViewBias::OfJoint BiasSeries::FitJoint(size_t name_idx, bool always) const {
  const double ridge = RidgeOf(classes_[name_idx]);
  BiasSums halves[2];
  for (const auto& [key, block] : blocks_) {
    halves[key & 1] += block[name_idx];
  }
  BiasSums all = halves[0];
  all += halves[1];
  ViewBias::OfJoint result;
  result.observations = all.observations;
  // If a shift explains all residuals, only rounding errors may remain.
  if (all.observations == 0 || !(all.square > 0.0)) return result;
  const BiasVector bias = SolveBias(all, ridge);
  for (int i = 0; i < kViewFeatureCount; ++i) {
    result.across_m[i] = bias[i];
    result.along_m[i] = bias[i + kViewFeatureCount];
  }
  const BiasVector of_half[2] = {SolveBias(halves[0], ridge),
                                 SolveBias(halves[1], ridge)};
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (const auto& [key, block] : blocks_) {
    if (block[name_idx].observations == 0) continue;
    const double gain =
        GainOf(block[name_idx], of_half[1 - (key & 1)]) / all.square;
    sum += gain;
    squares += gain * gain;
    ++count;
  }
  result.gain = sum;
  constexpr int kFewestBlocks = 6;
  if (count < kFewestBlocks) {
    result.used = always;
    return result;
  }
  // Standard error of the sum over blocks.
  const double n = count;
  result.gain_error =
      std::sqrt(std::max(0.0, (squares - sum * sum / n) * n / (n - 1.0)));
  // With a smaller gain the bias is less than a tenth of the errors' size, and
  // the error of its estimate is as large.
  constexpr double kLeastGain = 0.01;
  result.used = always || sum > std::max(kLeastGain, LimitOfStudent(n - 1.0) *
                                                         result.gain_error);
  return result;
}

ViewBias BiasSeries::Fit(bool always) const {
  ViewBias bias;
  // Range of viewing directions of the median camera, and the required range:
  // 180 degrees if shifts of the cameras could be confused with a bias. With
  // shifts removed, 360 degrees divided by the number of cameras, at least 90.
  const std::vector<WeightedValue> seen = SectorsSeen();
  if (!seen.empty()) {
    bias.azimuth_deg = WeightedQuantile(seen, 0.5) * 360.0 / kSectors;
  }
  const double least_deg =
      shifts_away_ ? std::max(90.0, 360.0 / static_cast<double>(seen.size()))
                   : 180.0;
  for (size_t i = 0; i < classes_.size(); ++i) {
    ViewBias::OfJoint& joint = bias.joints.emplace_back(FitJoint(i, always));
    joint.joint = names_[i];
    joint.used = joint.used && bias.azimuth_deg >= least_deg;
  }
  return bias;
}

ViewBias BiasSeries::FitSolved(bool always) const {
  ViewBias bias = Fit(always);
  for (size_t i = 0; i < bias.joints.size(); ++i) {
    double numbers = 0.0;
    double absorbed = 0.0;
    for (const auto& [key, block] : blocks_) {
      numbers += 2.0 * static_cast<double>(block[i].observations);
      absorbed += 3.0 * static_cast<double>(block[i].looks);
    }
    if (!(numbers > 0.0)) continue;
    // A position absorbs 3 of the 2 n numbers of n views: with two or more
    // views at least a quarter remains.
    const double larger = numbers / (numbers - absorbed);
    for (double& coefficient : bias.joints[i].across_m) coefficient *= larger;
    for (double& coefficient : bias.joints[i].along_m) coefficient *= larger;
  }
  return bias;
}

namespace {

// The views of a joint in frame `k` of a solution.
std::vector<BiasView> ViewsOf(const BiasJoints& joints,
                              const CameraRig& cameras,
                              const PersonProblem& solved, size_t k,
                              int joint_idx, const BodyStance& stance) {
  const JointChain& chain = solved.joints[joint_idx];
  std::vector<BiasView> views;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& seen = chain.measurements[m];
    if (seen.gated || seen.weight <= 0.0) continue;
    Eigen::Vector3d point_m;
    PointAt(chain.states[k].data(), seen.offset_s, point_m.data());
    BiasView view;
    const auto image = seen.camera->Project(point_m, &view.jacobian);
    const auto direction =
        DirectionOf(joints, stance, joint_idx, point_m, *seen.camera);
    if (!image.has_value() || !direction.has_value()) continue;
    view.view_idx = static_cast<int>(seen.camera - cameras.data());
    view.direction = *direction;
    view.residual_px = seen.px - *image;
    view.per_sigma = std::sqrt(seen.weight * seen.information) / seen.sigma_px;
    views.push_back(view);
  }
  return views;
}

}  // namespace

void AddBiasResiduals(const BiasJoints& joints, const CameraRig& cameras,
                      double frame_rate_hz, const ErrorCorrelation& correlation,
                      const PersonProblem& solved, BiasSeries* series) {
  // Errors of neighbouring frames are correlated: ten samples per second
  // contain nearly all the information.
  constexpr double kPeriodS = 0.1;
  // As close to the period as the frame times permit.
  const TimeNs least_step = FromSeconds(kPeriodS - 0.5 / frame_rate_hz);
  const double independent = IndependentShare(correlation, kPeriodS);
  std::optional<TimeNs> last_used;
  for (size_t k = 0; k < solved.times.size(); ++k) {
    const TimeNs time = solved.times[k];
    if (last_used.has_value() && time - *last_used < least_step) continue;
    const auto stance = joints.StanceOf([&](int j) {
      return std::optional<Eigen::Vector3d>(
          solved.joints[j].states[k].head<3>());
    });
    if (!stance.has_value()) continue;
    last_used = time;
    std::vector<BiasSums> sums(joints.names().size());
    for (int j = 0; j < static_cast<int>(solved.joints.size()); ++j) {
      const auto views = ViewsOf(joints, cameras, solved, k, j, *stance);
      AddViews(views, independent, &sums[joints.IndexOf(j)]);
      if (views.size() < 2) continue;  // ignored by AddViews
      for (const BiasView& view : views) {
        series->AddAzimuth(view.view_idx, view.direction.azimuth);
      }
    }
    series->Add(time, sums);
  }
}

namespace {

// The body's orientation in the nearest frame to `k` that determines it; null
// if there is none nearby.
const BodyStance* NearestStance(
    const std::vector<TimeNs>& times,
    const std::vector<std::optional<BodyStance>>& stances, size_t k) {
  constexpr double kLongest_s = 0.3;  // in which a body hardly rotates
  const BodyStance* nearest = nullptr;
  double least_s = kLongest_s;
  const auto consider = [&](size_t i) {
    const double away_s = std::abs(ToSeconds(times[i] - times[k]));
    if (away_s > least_s) return false;
    if (!stances[i].has_value()) return true;
    nearest = &*stances[i];
    least_s = away_s;
    return false;
  };
  for (size_t i = k; i < times.size() && consider(i);) ++i;
  for (size_t i = k; i > 0 && consider(i - 1);) --i;
  return nearest;
}

}  // namespace

void WriteBias(const BiasJoints& joints, const ViewBias& bias,
               const std::vector<FrameRecord>& records,
               PersonProblem* recording) {
  const ViewBias ordered = InOrderOf(joints.names(), bias);
  std::vector<std::optional<BodyStance>> stances;
  for (size_t k = 0; k < records.size(); ++k) {
    stances.push_back(
        joints.StanceOf([&](int j) -> std::optional<Eigen::Vector3d> {
          const auto joint = static_cast<size_t>(j);
          if (!records[k].triangulated[joint]) return std::nullopt;
          return Eigen::Vector3d(recording->joints[joint].states[k].head<3>());
        }));
  }
  for (size_t k = 0; k < records.size(); ++k) {
    const BodyStance* stance = NearestStance(recording->times, stances, k);
    if (stance == nullptr) continue;
    for (size_t j = 0; j < recording->joints.size(); ++j) {
      const int joint_idx = static_cast<int>(j);
      const ViewBias::OfJoint& of_joint =
          ordered.joints[joints.IndexOf(joint_idx)];
      if (!of_joint.used) continue;
      JointChain& chain = recording->joints[j];
      const Eigen::Vector3d point_m = chain.states[k].head<3>();
      for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
        PixelMeasurement& measurement = chain.measurements[m];
        const auto direction = DirectionOf(joints, *stance, joint_idx, point_m,
                                           *measurement.camera);
        if (!direction.has_value()) continue;
        measurement.bias_px = BiasOf(of_joint, *direction).cast<float>();
      }
    }
  }
}

}  // namespace kinegraph
