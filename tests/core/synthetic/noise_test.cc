#include "core/synthetic/noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "core/base/error.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;

// People who come and go in front of cameras with lens distortion.
const Scene& TestScene() {
  static const Scene kScene = [] {
    SceneOptions options;
    options.seed = 21;
    options.people = 5;
    options.duration_s = 24.0;
    options.motion.visitors = 0.4;
    options.cameras.distortion = {-0.2, 0.05, 0.001, -0.002, 0.01};
    return MakeScene(options);
  }();
  return kScene;
}

// People who stand in view of all cameras throughout.
const Scene& StandingScene() {
  static const Scene kScene = [] {
    SceneOptions options;
    options.seed = 4;
    options.duration_s = 80.0;
    options.motion.walking = options.motion.turning = 0.0;
    options.motion.sitting = options.motion.visitors = 0.0;
    options.motion.area_radius_m = 1.5;
    options.cameras.count = 4;
    return MakeScene(options);
  }();
  return kScene;
}

// One joint of one true person in one image.
struct Sample {
  size_t frame;
  size_t view;
  int person;
  int joint;
  Vector2d truth;
  const Keypoint* found;  // null: no detection of the person or not found
  const DetectionTruth* label;
  const std::vector<Pose3d>* poses;  // of all people in this frame

  std::array<size_t, 4> key() const {
    return {frame, view, static_cast<size_t>(person),
            static_cast<size_t>(joint)};
  }
  bool is_outlier() const {
    return label != nullptr && std::count(label->outliers.begin(),
                                          label->outliers.end(), joint) > 0;
  }
  const Pose3d& pose() const { return (*poses)[static_cast<size_t>(person)]; }
  // Error of the detection, which must exist.
  Vector2d error() const { return found->px - truth; }
};

// Visits every joint of every person whose projection lies in the image, with
// its detection.
void ForEachJoint(const Scene& scene, const DetectionSequence& sequence,
                  const ObservationTruth& truth,
                  const std::function<void(const Sample&)>& visit) {
  for (size_t f = 0; f < sequence.frames.size(); ++f) {
    const DetectionFrame& frame = sequence.frames[f];
    const auto& poses = scene.poses[static_cast<size_t>(frame.frame)];
    for (size_t v = 0; v < frame.views.size(); ++v) {
      for (size_t i = 0; i < poses.size(); ++i) {
        const int person = static_cast<int>(i);
        const DetectionTruth* label = nullptr;
        const Detection* detection = nullptr;
        for (size_t d = truth.frames[f][v].size(); d-- > 0;) {
          if (truth.frames[f][v][d].person != person) continue;
          label = &truth.frames[f][v][d];
          detection = &frame.views[v].detections[d];
        }
        for (size_t j = 0; j < poses[i].size(); ++j) {
          const auto px = scene.cameras[v].Project(poses[i][j].position_m);
          if (!px.has_value() || !IsInImage(scene.cameras[v], *px)) continue;
          const bool found = detection != nullptr && detection->joints[j].found;
          visit({f, v, person, static_cast<int>(j), *px,
                 found ? &detection->joints[j] : nullptr, label, &poses});
        }
      }
    }
  }
}

// Visits the joints of observations that are simulated with these options.
void ForEachJoint(const Scene& scene, const NoiseOptions& options,
                  const std::function<void(const Sample&)>& visit) {
  ObservationTruth truth;
  const DetectionSequence seen = Observe(scene, options, &truth);
  ForEachJoint(scene, seen, truth, visit);
}

// Visits every image: frame, view, detections and their truth.
template <typename Visit>
void ForEachImage(const DetectionSequence& seen, const ObservationTruth& truth,
                  const Visit& visit) {
  for (size_t f = 0; f < seen.frames.size(); ++f) {
    for (size_t v = 0; v < seen.frames[f].views.size(); ++v) {
      visit(f, v, seen.frames[f].views[v].detections, truth.frames[f][v]);
    }
  }
}

// Expects count / n to be `rate` within five standard deviations, with a
// variance `inflation` times that of independent draws.
void ExpectShare(double count, double n, double rate, double inflation = 1.0) {
  EXPECT_NEAR(count / n, rate,
              5.0 * std::sqrt(rate * (1.0 - rate) / n * inflation));
}

// Variance inflation of a two-state Markov chain with bursts of `frames` on
// average: (2 - q) / q with the probability q of a new draw (MarkovBursts).
double MarkovInflation(double rate, double frames) {
  const double q = 1.0 / (std::max(frames, 1.0 / (1.0 - rate)) * (1.0 - rate));
  return (2.0 - q) / q;
}

TEST(Noise, NoNoiseGivesExactProjections) {
  const Scene& scene = TestScene();
  ObservationTruth truth;
  const DetectionSequence seen = Observe(scene, NoiseOptions(), &truth);
  ASSERT_EQ(seen.frames.size(), scene.times.size());
  EXPECT_EQ(seen.header.view_names.size(), 5u);
  EXPECT_EQ(seen.header.skeleton, scene.skeleton);
  int64_t joints = 0;
  ForEachJoint(scene, seen, truth, [&](const Sample& sample) {
    ASSERT_NE(sample.found, nullptr);
    ASSERT_EQ(sample.found->px, sample.truth);  // the same bits
    ASSERT_EQ(sample.found->confidence, 1.0);
    ++joints;
  });
  EXPECT_GT(joints, 100000);
  // Nothing else exists: every found joint was visited.
  int64_t found = 0;
  ForEachImage(seen, truth,
               [&](size_t f, size_t v, const auto& detections, const auto&) {
                 EXPECT_EQ(seen.frames[f].time, scene.times[f]);
                 EXPECT_EQ(seen.frames[f].views[v].capture_time,
                           scene.times[f]);
                 for (const Detection& one : detections)
                   found += CountFound(one);
               });
  EXPECT_EQ(found, joints);
}

TEST(Noise, OrderOfDetectionsIsShuffledAndIndexed) {
  ObservationTruth truth;
  const DetectionSequence seen = Observe(TestScene(), NoiseOptions(), &truth);
  int first_is_zero = 0;
  int full = 0;
  ForEachImage(seen, truth,
               [&](size_t, size_t, const auto& detections, const auto& labels) {
                 for (size_t d = 0; d < detections.size(); ++d) {
                   EXPECT_EQ(detections[d].index_in_file, static_cast<int>(d));
                 }
                 const bool has_zero = std::any_of(
                     labels.begin(), labels.end(),
                     [](const auto& label) { return label.person == 0; });
                 if (labels.size() < 3 || !has_zero) return;
                 ++full;
                 first_is_zero += labels[0].person == 0 ? 1 : 0;
               });
  // Each of three to five people is the first detection equally often: between
  // 1/5 and 1/3.
  ASSERT_GT(full, 500);
  EXPECT_GT(first_is_zero, 0.2 * full - 5.0 * std::sqrt(0.16 * full));
  EXPECT_LT(first_is_zero, full / 3.0 + 5.0 * std::sqrt(0.23 * full));
}

// All numbers of detections as one list.
std::vector<double> NumbersOf(const DetectionSequence& seen) {
  std::vector<double> numbers;
  for (const DetectionFrame& frame : seen.frames) {
    numbers.push_back(static_cast<double>(frame.frame));
    numbers.push_back(ToSeconds(frame.time));
    for (const ViewDetections& view : frame.views) {
      for (const Detection& detection : view.detections) {
        for (const Keypoint& joint : detection.joints) {
          if (!joint.found) continue;
          numbers.insert(numbers.end(),
                         {joint.px.x(), joint.px.y(), joint.confidence});
        }
      }
    }
  }
  return numbers;
}

// Compares the mean square of errors with the expected variance.
struct Spread {
  double squares = 0.0;
  double n = 0.0;

  void Add(const Vector2d& error) {
    squares += error.squaredNorm();
    n += 2.0;
  }
  // The variance of the mean of n squares of a Gaussian is 2 sigma^4 / n. The
  // tolerance is five standard deviations.
  void ExpectVariance(double variance) const {
    EXPECT_NEAR(squares / n, variance, 5.0 * variance * std::sqrt(2.0 / n));
  }
};

NoiseOptions Everything() {
  NoiseOptions options;
  options.joints.sigma_px = 3.0;
  options.joints.student_dof = 4.0;
  options.joints.static_share = 0.3;
  options.joints.white_share = 0.1;
  options.joints.correlation_time_s = 0.2;
  options.joints.outlier_rate = 0.05;
  options.joints.outlier_burst_s = 0.2;
  options.joints.outlier_on_other = 0.3;
  options.joints.missing_rate = 0.1;
  options.joints.missing_burst_s = 0.2;
  options.joints.hidden_missing_rate = 0.5;
  options.joints.hidden_noise_factor = 2.0;
  options.confidence = 0.8;
  options.confidence_sigma = 0.1;
  options.noise_spread = 0.3;
  options.missed_rate = 0.05;
  options.missed_burst_s = 0.3;
  options.hidden_missed_rate = 0.7;
  options.false_people = 0.3;
  options.swap_whole_rate = 0.02;
  options.swap_arm_rate = 0.02;
  options.swap_leg_rate = 0.02;
  options.fragment_rate = 0.03;
  options.double_rate = 0.03;
  options.dropped_frame_rate = 0.03;
  options.dropped_view_rate = 0.02;
  options.clock_offset_s = {0.0, 0.01, -0.02};
  options.time_jitter_s = 0.002;
  return options;
}

TEST(Noise, OutputIsDeterminedByTheSeed) {
  NoiseOptions options = Everything();
  const auto numbers = [&options] {
    return NumbersOf(Observe(TestScene(), options, nullptr));
  };
  const std::vector<double> once = numbers();
  EXPECT_EQ(once, numbers());
  options.seed = 2;
  EXPECT_NE(once, numbers());
}

// The random numbers of one kind of noise do not depend on the other kinds:
// added outliers leave all other joints unchanged.
TEST(Noise, KindsOfNoiseDoNotDisturbEachOther) {
  NoiseOptions options;
  options.joints.sigma_px = 2.0;
  options.joints.missing_rate = 0.1;
  std::map<std::array<size_t, 4>, Vector2d> plain;
  ForEachJoint(TestScene(), options, [&](const Sample& sample) {
    if (sample.found != nullptr) plain[sample.key()] = sample.found->px;
  });
  options.joints.outlier_rate = 0.1;
  int64_t same = 0;
  int64_t wrong = 0;
  ForEachJoint(TestScene(), options, [&](const Sample& sample) {
    const auto at = plain.find(sample.key());
    ASSERT_EQ(sample.found != nullptr, at != plain.end());
    if (sample.found == nullptr) return;
    ASSERT_EQ(sample.found->px != at->second, sample.is_outlier());
    (sample.is_outlier() ? wrong : same) += 1;
  });
  EXPECT_GT(same, 0);
  EXPECT_GT(wrong, 0);
}

// Errors of each (person, view, joint) in the frames where it is found.
using Series = std::map<std::array<int, 3>, std::vector<Vector2d>>;

Series ErrorSeries(const Scene& scene, const NoiseOptions& options) {
  Series series;
  ForEachJoint(scene, options, [&](const Sample& sample) {
    auto& errors =
        series[{sample.person, static_cast<int>(sample.view), sample.joint}];
    if (sample.found != nullptr) {
      errors.push_back(sample.error());
    }
  });
  return series;
}

TEST(Noise, WhitePixelNoiseHasTheRequestedSigma) {
  NoiseOptions options;
  options.joints.sigma_px = 4.0;
  Spread spread;
  double products = 0.0;
  for (const auto& [key, errors] : ErrorSeries(TestScene(), options)) {
    for (size_t k = 0; k < errors.size(); ++k) {
      spread.Add(errors[k]);
      if (k > 0) products += errors[k].dot(errors[k - 1]);
    }
  }
  spread.ExpectVariance(16.0);
  // The variance of the mean of n products of independent errors is sigma^4 /
  // n.
  EXPECT_NEAR(products / spread.n, 0.0, 5.0 * 16.0 / std::sqrt(spread.n));
}

TEST(Noise, PixelNoiseDependsOnDepthAndJointClass) {
  NoiseOptions options;
  options.joints.sigma_px = 5.0;
  options.joints.reference_depth_m = 4.0;
  options.by_class[JointClass::kWrist].sigma_px = 6.0;
  const Scene& scene = TestScene();
  Spread wrists, normalised;
  ForEachJoint(scene, options, [&](const Sample& sample) {
    const Eigen::Vector3d& at_m = sample.pose()[sample.joint].position_m;
    if (scene.skeleton.joint_class(sample.joint) == JointClass::kWrist) {
      wrists.Add(sample.error());
    } else {
      normalised.Add(sample.error() * scene.cameras[sample.view].Depth(at_m) /
                     (4.0 * 5.0));
    }
  });
  wrists.ExpectVariance(36.0);
  normalised.ExpectVariance(1.0);
}

// The correlation at lag k is static + slow exp(-k dt / tau), where static and
// slow are shares of the variance.
TEST(Noise, CorrelatedNoiseHasTheRequestedAutocorrelation) {
  for (const double rate : {25.0, 100.0}) {
    SceneOptions scene_options;
    scene_options.people = 4;
    scene_options.duration_s = 40.0;
    scene_options.frame_rate_hz = rate;
    scene_options.motion.visitors = 0.0;
    scene_options.motion.area_radius_m = 1.5;
    const Scene scene = MakeScene(scene_options);
    NoiseOptions options;
    options.joints.sigma_px = 3.0;
    options.joints.static_share = 0.3;
    options.joints.white_share = 0.2;
    options.joints.correlation_time_s = 0.16;
    const Series series = ErrorSeries(scene, options);
    const int step = static_cast<int>(std::lround(rate / 25.0));
    for (const int lag : {1, 4}) {
      double products = 0.0;
      double n = 0.0;
      for (const auto& [key, errors] : series) {
        if (errors.size() < scene.times.size()) continue;  // left the image
        for (size_t k = lag * step; k < errors.size(); ++k) {
          products += errors[k].dot(errors[k - lag * step]) / 9.0;
          n += 2.0;
        }
      }
      const double series_count =
          n / 2.0 / static_cast<double>(scene.times.size() - lag * step);
      ASSERT_GT(series_count, 100);
      const double expected = 0.3 + 0.5 * std::exp(-lag * 0.04 / 0.16);
      // For the standard error, the static part is one draw per series and
      // axis, 0.3 times the spread sqrt(2) of a squared Gaussian; the remainder
      // has about 40 s / (2 * 0.16 s) independent values per series, whose
      // products spread by less than 1 + 2 sqrt(0.3).
      const double draws = 2.0 * series_count;
      const double sigma =
          std::sqrt(0.09 * 2.0 / draws + 2.1 * 2.1 * 2.0 * 0.16 / 40.0 / draws);
      EXPECT_NEAR(products / n, expected, 5.0 * sigma)
          << "lag of " << lag * 0.04 << " s at " << rate << " Hz";
    }
  }
}

TEST(Noise, StudentTailsKeepTheSigma) {
  NoiseOptions options;
  options.joints.sigma_px = 3.0;
  options.joints.student_dof = 5.0;
  // A t distribution with 5 degrees of freedom has the standard deviation
  // sqrt(5/3), and 5 % of it lie beyond 2.5706 (tables).
  const double limit = 2.5706 / std::sqrt(5.0 / 3.0) * 3.0;
  double beyond = 0.0, n = 0.0;
  for (const auto& [key, errors] : ErrorSeries(TestScene(), options)) {
    for (const Vector2d& error : errors) {
      beyond += static_cast<double>((error.array().abs() > limit).count());
      n += 2.0;
    }
  }
  // Both axes share a scale, so a pair may count as one draw: inflation 2.
  ExpectShare(beyond, n, 0.05, 2.0);
}

TEST(Noise, OutliersHaveTheRequestedRateSizeAndFlag) {
  for (const double burst_s : {0.0, 0.2}) {
    NoiseOptions options;
    options.joints.sigma_px = 1.0;
    options.joints.outlier_rate = 0.1;
    options.joints.outlier_burst_s = burst_s;
    const Scene& scene = TestScene();
    double n = 0.0, far = 0.0;
    ForEachJoint(scene, options, [&](const Sample& sample) {
      ASSERT_NE(sample.found, nullptr);
      const bool flagged = sample.is_outlier();
      const double error = sample.error().norm();
      // The added Gaussian noise of 1 px exceeds 7 px with probability 2e-11.
      ASSERT_EQ(error > 15.0, flagged);
      if (flagged) {
        ASSERT_GT(error, 30.0 - 7.0);
        ASSERT_LT(error, 200.0 + 7.0);
      }
      n += 1.0;
      far += flagged ? 1.0 : 0.0;
    });
    ExpectShare(far, n, 0.1, burst_s > 0.0 ? 5.0 : 1.0);
  }
}

TEST(Noise, OutlierBurstsLastFiveFramesAtTheSamePlace) {
  NoiseOptions options;
  options.joints.outlier_rate = 0.1;
  options.joints.outlier_burst_s = 0.2;
  const Series series = ErrorSeries(StandingScene(), options);
  int five = 0;
  int all = 0;
  for (const auto& [key, errors] : series) {
    int run = 0;
    for (size_t k = 1; k < errors.size(); ++k) {
      // People stand: the displacement repeats to rounding unless it flips at
      // the image's border.
      const bool same =
          errors[k].norm() > 1.0 && (errors[k] - errors[k - 1]).norm() < 1e-6;
      if (same) ++run;
      if (!same && run > 0) {
        ++all;
        five += run + 1 == 5 ? 1 : 0;
        run = 0;
      }
    }
  }
  // The other bursts are cut by the ends of the recording or by the border.
  ASSERT_GT(all, 1000);
  EXPECT_GT(five, 0.97 * all);
}

TEST(Noise, OutliersLieOnAnotherPerson) {
  NoiseOptions options;
  options.joints.outlier_rate = 0.2;
  options.joints.outlier_on_other = 1.0;
  const Scene& scene = StandingScene();
  int64_t on_other = 0;
  int64_t outliers = 0;
  ForEachJoint(scene, options, [&](const Sample& sample) {
    if (!sample.is_outlier()) return;
    ++outliers;
    const auto& poses = *sample.poses;
    for (size_t i = 0; i < poses.size(); ++i) {
      if (static_cast<int>(i) == sample.person || poses[i].empty()) continue;
      const auto px =
          scene.cameras[sample.view].Project(poses[i][sample.joint].position_m);
      if (px.has_value() && (*px - sample.found->px).norm() < 1e-9) ++on_other;
    }
  });
  // Outliers lie on another person if one is within a person's size in the
  // image, which is mostly so for four people within a circle with a radius of
  // 1.5 m.
  EXPECT_GT(on_other, 0.5 * static_cast<double>(outliers));
}

TEST(Noise, JointsAreMissingAtTheRequestedRate) {
  for (const double burst_s : {0.0, 0.32}) {
    NoiseOptions options;
    options.joints.missing_rate = 0.15;
    options.joints.missing_burst_s = burst_s;
    double n = 0.0;
    double missing = 0.0;
    ForEachJoint(TestScene(), options, [&](const Sample& sample) {
      n += 1.0;
      missing += sample.found == nullptr ? 1.0 : 0.0;
    });
    ExpectShare(missing, n, 0.15, MarkovInflation(0.15, burst_s * 25.0));
  }
}

TEST(Noise, HiddenJointsAreMissingAndNoisier) {
  // With this rate exactly the joints hidden by another body are missing.
  NoiseOptions hide;
  hide.joints.hidden_missing_rate = 1.0;
  std::set<std::array<size_t, 4>> hidden;
  int64_t all = 0;
  ForEachJoint(TestScene(), hide, [&](const Sample& sample) {
    ++all;
    if (sample.found == nullptr) hidden.insert(sample.key());
  });
  const double share =
      static_cast<double>(hidden.size()) / static_cast<double>(all);
  // Of five people within a circle with a radius of 3 m, some occlude others,
  // most do not.
  EXPECT_GT(share, 0.02);
  EXPECT_LT(share, 0.35);

  NoiseOptions blur;
  blur.joints.sigma_px = 2.0;
  blur.joints.hidden_noise_factor = 5.0;
  Spread seen, behind;
  ForEachJoint(TestScene(), blur, [&](const Sample& sample) {
    ASSERT_NE(sample.found, nullptr);
    const bool is_behind = hidden.count(sample.key()) > 0;
    (is_behind ? behind : seen).Add(sample.error());
    // kHiddenConfidence in noise.cc is 0.9.
    ASSERT_EQ(sample.found->confidence, is_behind ? 0.9 : 1.0);
  });
  seen.ExpectVariance(4.0);
  behind.ExpectVariance(100.0);
}

TEST(Noise, ConfidenceDeterminesTheNoise) {
  NoiseOptions options;
  options.joints.sigma_px = 3.0;
  options.confidence = 0.4;
  options.noise_spread = 0.3;
  Spread normalised, all;
  ForEachJoint(TestScene(), options, [&](const Sample& sample) {
    const double c = sample.found->confidence;
    const Vector2d error = sample.error();
    all.Add(error);
    // sigma^2 = 9 * 0.4 / c, except where it is clamped.
    if (c < 1.0 && c > 0.05) normalised.Add(error * std::sqrt(c / (9.0 * 0.4)));
  });
  normalised.ExpectVariance(1.0);
  // The mean square remains sigma_px^2. The log-normal factor f of sigma_px has
  // E f^2 = 1 and E f^4 = exp(4 s^2), where s is noise_spread, so a squared
  // error in units of sigma_px^2 has the variance 3 exp(4 s^2) - 1; both axes
  // share f, hence twice that.
  const double variance = 2.0 * (3.0 * std::exp(4.0 * 0.09) - 1.0);
  EXPECT_NEAR(all.squares / all.n, 9.0,
              5.0 * 9.0 * std::sqrt(variance / all.n));
}

TEST(Noise, MissedPeopleFalsePeopleFragmentsAndDoublesAreLabelled) {
  NoiseOptions options;
  options.missed_rate = 0.1;
  options.missed_burst_s = 0.2;
  options.false_people = 0.5;
  options.fragment_rate = 0.05;
  options.double_rate = 0.04;
  const Scene& scene = StandingScene();
  ObservationTruth truth;
  const DetectionSequence seen = Observe(scene, options, &truth);
  double person_views = 0.0, missed = 0.0, split = 0.0, twice = 0.0;
  double nobody = 0.0, images = 0.0;
  ForEachImage(
      seen, truth,
      [&](size_t, size_t, const auto& detections, const auto& labels) {
        images += 1.0;
        ASSERT_EQ(labels.size(), detections.size());
        std::map<int, std::map<DetectionKind, int>> kinds;  // by person
        for (size_t d = 0; d < labels.size(); ++d) {
          const DetectionTruth& label = labels[d];
          ++kinds[label.person][label.kind];
          const auto found = [&](const char* joint) {
            return detections[d].joints[scene.skeleton.IndexOf(joint)].found;
          };
          if (label.kind == DetectionKind::kFalse) {
            EXPECT_EQ(label.person, -1);
            EXPECT_EQ(NoteOf(label), "false_positive");
            EXPECT_GE(CountFound(detections[d]), 3);
            nobody += 1.0;
          } else if (label.kind == DetectionKind::kUpperPart) {
            EXPECT_EQ(NoteOf(label), "fragment_upper");
            EXPECT_TRUE(found("nose") && !found("l_hip"));
          } else if (label.kind == DetectionKind::kLowerPart) {
            EXPECT_EQ(NoteOf(label), "fragment_lower");
            EXPECT_TRUE(found("l_hip") && !found("nose"));
          }
        }
        for (int i = 0; i < 4; ++i) {
          person_views += 1.0;
          auto& of = kinds[i];
          const int whole = of[DetectionKind::kPerson];
          const int upper = of[DetectionKind::kUpperPart];
          const int second = of[DetectionKind::kDouble];
          EXPECT_EQ(upper, of[DetectionKind::kLowerPart]);
          EXPECT_LE(whole + upper, 1);
          EXPECT_LE(second, whole);
          missed += whole + upper == 0 ? 1.0 : 0.0;
          split += upper;
          twice += second;
        }
      });
  ExpectShare(missed, person_views, 0.1, MarkovInflation(0.1, 5.0));
  ExpectShare(split, person_views, 0.9 * 0.05);
  ExpectShare(twice, person_views, 0.9 * 0.95 * 0.04);
  // The number of false people is Poisson-distributed. Each lasts 6 frames on
  // average, which inflates the variance by up to 2 * 6.
  EXPECT_NEAR(nobody / images, 0.5, 5.0 * std::sqrt(0.5 * 12.0 / images));
}

TEST(Noise, SwapsExchangeSidesAndAreLabelled) {
  NoiseOptions options;
  options.swap_whole_rate = 0.05;
  options.swap_arm_rate = 0.06;
  options.swap_leg_rate = 0.07;
  const Scene& scene = StandingScene();
  std::map<Swap, double> counts;
  double n = 0.0;
  ForEachJoint(scene, options, [&](const Sample& sample) {
    const JointClass c = scene.skeleton.joint_class(sample.joint);
    const Swap swap = sample.label->swap;
    if (sample.joint == 0) {
      n += 1.0;
      counts[swap] += 1.0;
    }
    const bool arm = c == JointClass::kElbow || c == JointClass::kWrist;
    const bool leg = c == JointClass::kKnee || c == JointClass::kAnkle;
    const bool exchanged = swap == Swap::kWhole ||
                           (swap == Swap::kArm && arm) ||
                           (swap == Swap::kLeg && leg);
    const int source =
        exchanged ? scene.skeleton.mirror(sample.joint) : sample.joint;
    const Pose3d& pose = sample.pose();
    const auto px = scene.cameras[sample.view].Project(pose[source].position_m);
    ASSERT_NE(sample.found, nullptr);
    ASSERT_EQ(sample.found->px, *px);
  });
  ExpectShare(counts[Swap::kWhole], n, 0.05);
  ExpectShare(counts[Swap::kArm], n, 0.95 * 0.06);
  ExpectShare(counts[Swap::kLeg], n, 0.95 * 0.94 * 0.07);
  EXPECT_EQ(NoteOf({0, DetectionKind::kPerson, Swap::kArm, {}}), "swap_arm");
  EXPECT_EQ(NoteOf({0, DetectionKind::kUpperPart, Swap::kWhole, {}}),
            "swap_whole+fragment_upper");
}

// Expects every found joint at the projection of its true position at the time
// time_of(f, v) of its frame and view.
template <typename TimeOf>
void ExpectSeenAt(const Scene& scene, const DetectionSequence& seen,
                  const ObservationTruth& truth, const TimeOf& time_of) {
  ForEachImage(
      seen, truth,
      [&](size_t f, size_t v, const auto& detections, const auto& labels) {
        for (size_t d = 0; d < detections.size(); ++d) {
          const Pose3d pose =
              PersonAt(*scene.people[labels[d].person], time_of(f, v));
          for (size_t j = 0; j < pose.size(); ++j) {
            if (!detections[d].joints[j].found) continue;
            ASSERT_EQ(detections[d].joints[j].px,
                      *scene.cameras[v].Project(pose[j].position_m));
          }
        }
      });
}

TEST(Noise, ClockOffsetsShiftTheSampledTime) {
  const Scene& scene = TestScene();
  NoiseOptions options;
  options.clock_offset_s = {0.0, 0.35, -0.4};
  const auto offset = [](size_t v) -> TimeNs {
    return v == 1 ? 350000000 : (v == 2 ? -400000000 : 0);
  };
  for (const bool tell_times : {true, false}) {
    options.tell_times = tell_times;
    ObservationTruth truth;
    const DetectionSequence seen = Observe(scene, options, &truth);
    ExpectSeenAt(scene, seen, truth, [&](size_t f, size_t v) {
      return scene.times[f] + offset(v);
    });
    ForEachImage(seen, truth,
                 [&](size_t f, size_t v, const auto&, const auto&) {
                   EXPECT_EQ(seen.frames[f].time, scene.times[f]);
                   EXPECT_EQ(seen.frames[f].views[v].capture_time,
                             scene.times[f] + (tell_times ? offset(v) : 0));
                 });
  }
}

TEST(Noise, DroppedFramesLeaveOtherFramesUnchanged) {
  const Scene& scene = TestScene();
  NoiseOptions options;
  options.joints.sigma_px = 1.0;
  const DetectionSequence all = Observe(scene, options, nullptr);
  options.dropped_frame_rate = 0.2;
  options.drop_burst_s = 0.12;
  ObservationTruth truth;
  const DetectionSequence seen = Observe(scene, options, &truth);
  ASSERT_EQ(truth.frames.size(), seen.frames.size());
  const auto lost =
      static_cast<double>(scene.times.size() - seen.frames.size());
  ExpectShare(lost, static_cast<double>(scene.times.size()), 0.2,
              MarkovInflation(0.2, 3.0));
  // The remaining frames are unchanged.
  DetectionSequence kept = all;
  kept.frames.clear();
  for (const DetectionFrame& frame : seen.frames) {
    kept.frames.push_back(all.frames[static_cast<size_t>(frame.frame)]);
  }
  EXPECT_EQ(NumbersOf(seen), NumbersOf(kept));
  const TrackSequence tracks = TruthFor(scene, seen);
  ASSERT_EQ(tracks.frames.size(), seen.frames.size());
  EXPECT_EQ(tracks.frames.back().frame, seen.frames.back().frame);
}

TEST(Noise, DroppedViewsHaveNoDetections) {
  NoiseOptions options;
  options.dropped_view_rate = 0.1;
  ObservationTruth truth;
  const DetectionSequence seen = Observe(StandingScene(), options, &truth);
  double empty = 0.0, n = 0.0;
  ForEachImage(seen, truth,
               [&](size_t, size_t, const auto& detections, const auto&) {
                 n += 1.0;
                 empty += detections.empty() ? 1.0 : 0.0;
               });
  EXPECT_EQ(n, 4.0 * static_cast<double>(seen.frames.size()));
  ExpectShare(empty, n, 0.1);
}

TEST(Noise, JitteredTimesAreReportedAndTruthFollows) {
  const Scene& scene = TestScene();
  NoiseOptions options;
  options.time_jitter_s = 0.005;
  ObservationTruth truth;
  const DetectionSequence seen = Observe(scene, options, &truth);
  ExpectSeenAt(scene, seen, truth,
               [&](size_t f, size_t) { return seen.frames[f].time; });
  const TrackSequence tracks = TruthFor(scene, seen);
  double squares = 0.0;
  for (size_t f = 0; f < seen.frames.size(); ++f) {
    const double jitter = ToSeconds(seen.frames[f].time - scene.times[f]);
    squares += jitter * jitter;
    if (f > 0) {
      EXPECT_GT(seen.frames[f].time, seen.frames[f - 1].time);
    }
    for (const PersonPose& person : tracks.frames[f].people) {
      const Pose3d pose =
          PersonAt(*scene.people[person.id.value()], seen.frames[f].time);
      ASSERT_EQ(person.joints[0].position_m, pose[0].position_m);
    }
  }
  const double n = static_cast<double>(seen.frames.size());
  EXPECT_NEAR(squares / n, 0.005 * 0.005,
              5.0 * 0.005 * 0.005 * std::sqrt(2.0 / n));
}

TEST(Noise, ErrorsNameInvalidOptions) {
  const auto expect = [](const char* key, auto set) {
    NoiseOptions options;
    set(&options);
    try {
      Observe(TestScene(), options, nullptr);
      ADD_FAILURE() << key;
    } catch (const OptionError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(key));
    }
  };
  expect("static_share", [](NoiseOptions* options) {
    options->joints.static_share = options->joints.white_share = 0.7;
  });
  expect("student_dof", [](auto* o) { o->joints.student_dof = 1.5; });
  expect("clock_offset", [](auto* o) { o->clock_offset_s.assign(6, 0.0); });
  expect("missed_rate", [](auto* o) { o->missed_rate = 1.5; });
  expect("outlier_min", [](auto* o) { o->joints.outlier_min_px = 300.0; });
}

}  // namespace
}  // namespace kinegraph
