// The filters compared with independent implementations: reference.py created
// reference.json with SciPy, statsmodels, cvxopt and NumPy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solvers/filters/classical.h"
#include "solvers/filters/cutoff.h"
#include "solvers/filters/loess.h"
#include "solvers/filters/penalised.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

// For signals with an amplitude of about one; rounding errors are about 1e-12.
constexpr double kSame = 1e-9;
// For results of a search: near a minimum the score is flat, so its location is
// known only to the square root of machine precision.
constexpr double kSameMinimum = 1e-6;

nlohmann::json Table() {
  return nlohmann::json::parse(testing::ContentOf(
      testing::ProjectFile("tests/solvers/filters/reference.json")));
}

Samples MatrixOf(const nlohmann::json& rows) {
  Samples values(rows.size(), rows[0].size());
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t c = 0; c < rows[i].size(); ++c) {
      values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) =
          rows[i][c];
    }
  }
  return values;
}

struct Case {
  std::vector<double> times;
  std::vector<char> sampled;
  Samples values;
  // Only the sampled times.
  std::vector<double> sample_times;
  Samples samples;
};

Case CaseOf(const nlohmann::json& json) {
  Case one;
  one.times = json.at("times").get<std::vector<double>>();
  one.values = MatrixOf(json.at("values"));
  one.samples = one.values;
  for (const int flag : json.at("sampled").get<std::vector<int>>()) {
    if (flag == 1) {
      one.samples.row(static_cast<Eigen::Index>(one.sample_times.size())) =
          one.values.row(static_cast<Eigen::Index>(one.sampled.size()));
      one.sample_times.push_back(one.times[one.sampled.size()]);
    }
    one.sampled.push_back(static_cast<char>(flag));
  }
  one.samples.conservativeResize(
      static_cast<Eigen::Index>(one.sample_times.size()), Eigen::NoChange);
  return one;
}

using FilterOf = std::function<Samples(const Case&)>;

FilterOf Whittaker(int order, double lambda) {
  return [=](const Case& one) {
    return MakeWhittaker(order, one.times, one.sampled, one.values)
        ->Fit(lambda);
  };
}
FilterOf WhittakerByGcv(int order) {
  return [=](const Case& one) {
    const auto curve = MakeWhittaker(order, one.times, one.sampled, one.values);
    return curve->Fit(curve->BestLambda());
  };
}
Samples Quintic(const Case& one) {
  return MakeQuinticSpline(one.times, one.sampled, one.values)->Fit(300.0);
}
Samples QuinticByGcv(const Case& one) {
  const auto curve = MakeQuinticSpline(one.times, one.sampled, one.values);
  return curve->Fit(curve->BestLambda());
}
Samples Cubic(const Case& one) {
  return MakeCubicSpline(one.times, one.sampled, one.values)->Fit(40.0);
}
FilterOf LoessOf(int neighbours, int degree, int iterations) {
  return [=](const Case& one) {
    return Loess(neighbours, degree, iterations, one.sample_times, one.samples,
                 one.times);
  };
}
FilterOf Trend(double lambda) {
  return [=](const Case& one) {
    return TrendFilter(lambda, one.times, one.values);
  };
}
Samples OneEuroBothWays(const Case& one) {
  OneEuroOptions options = {2.0, 1.5};
  options.zero_phase = true;
  return OneEuro(options, one.times, one.values);
}
FilterOf Recursive(LowPass (*make)(const ButterworthOptions&, double),
                   int order, bool correct, FilterSignal on) {
  return [=](const Case& one) {
    ButterworthOptions options;
    options.order = order;
    options.correct_cutoff = correct;
    options.on = on;
    return make(options, 25.0).filter(4.0, one.values);
  };
}

// Unsampled frames on both sides of each sample give finite differences of the
// curve.
TEST(ReferenceTest, QuinticDerivativesEqualDifferencesOfTheCurve) {
  constexpr double kH = 1e-3;
  std::vector<double> times;
  std::vector<char> sampled;
  Samples values(3 * 20, 1);
  for (int k = 0; k < 20; ++k) {
    const double t = 0.04 * k + 0.01 * std::sin(k);
    for (int side = -1; side <= 1; ++side) {
      values(static_cast<Eigen::Index>(times.size()), 0) = std::cos(5.0 * k);
      times.push_back(t + side * kH);
      sampled.push_back(side == 0 ? 1 : 0);
    }
  }
  const auto curve = MakeQuinticSpline(times, sampled, values);
  CurveDerivatives derivatives;
  const Samples f = curve->Fit(0.1, &derivatives);
  EXPECT_EQ(f, curve->Fit(0.1));
  double velocity = 0.0;
  double acceleration = 0.0;
  // The ends are left out: they have samples on one side only.
  for (Eigen::Index k = 4; k < 56; k += 3) {
    const double first = (f(k + 1) - f(k - 1)) / (2.0 * kH);
    const double second = (f(k + 1) - 2.0 * f(k) + f(k - 1)) / (kH * kH);
    velocity = std::max(velocity, std::abs(first));
    acceleration = std::max(acceleration, std::abs(second));
    // Differences are off by h^2 / 6 times the third and h^2 / 12 times the
    // fourth derivative, which are at most (2 pi 12.5 Hz)^2 = 6200 times the
    // first and the second: by 0.1 % of these, which are up to about 50 and
    // 2000.
    EXPECT_NEAR(derivatives.first(k), first, 2e-3 * 50.0);
    EXPECT_NEAR(derivatives.second(k), second, 2e-3 * 2000.0);
  }
  // Much more than the tolerance.
  EXPECT_GT(velocity, 5.0);
  EXPECT_GT(acceleration, 200.0);
  derivatives = {};
  MakeWhittaker(2, times, sampled, values)->Fit(1.0, &derivatives);
  EXPECT_EQ(derivatives.first.rows(), 0);
}

TEST(ReferenceTest, FiltersMatchTheReference) {
  constexpr FilterSignal kPosition = FilterSignal::kPosition;
  const struct {
    const char* name;
    FilterOf run;
    double tolerance;
  } kCases[] = {
      {"whittaker_hp", Whittaker(2, 40.0), kSame},
      {"whittaker_2", Whittaker(2, 40.0), kSame},
      {"whittaker_3", Whittaker(3, 300.0), kSame},
      {"whittaker_2_uneven", Whittaker(2, 40.0), kSame},
      {"whittaker_3_uneven", Whittaker(3, 300.0), kSame},
      {"whittaker_2_gap", Whittaker(2, 40.0), kSame},
      {"whittaker_3_gcv", WhittakerByGcv(3), kSameMinimum},
      {"whittaker_2_gap_gcv", WhittakerByGcv(2), kSameMinimum},
      {"quintic", Quintic, kSame},
      {"quintic_uneven", Quintic, kSame},
      {"quintic_gap", Quintic, kSame},
      {"quintic_gcv", QuinticByGcv, kSameMinimum},
      {"cubic", Cubic, kSame},
      {"lowess", LoessOf(11, 1, 0), kSame},
      {"lowess_robust", LoessOf(15, 1, 3), kSame},
      {"lowess_uneven", LoessOf(12, 1, 2), kSame},
      {"loess_2", LoessOf(13, 2, 0), kSame},
      {"loess_2_robust", LoessOf(15, 2, 2), kSame},
      {"loess_1_two_columns", LoessOf(11, 1, 3), kSame},
      {"loess_2_gap", LoessOf(13, 2, 1), kSame},
      {"trend", Trend(0.2), kSame},
      {"trend_wave", Trend(0.02), kSame},
      {"trend_uneven", Trend(0.1), kSame},
      {"one_euro_zero_phase", OneEuroBothWays, kSame},
      {"butterworth", Recursive(ZeroPhaseButterworth, 2, true, kPosition),
       kSame},
      {"butterworth_speed",
       Recursive(ZeroPhaseButterworth, 2, true, FilterSignal::kSpeed), kSame},
      {"critically_damped_2",
       Recursive(ZeroPhaseCriticallyDamped, 2, true, kPosition), kSame},
      {"critically_damped_3",
       Recursive(ZeroPhaseCriticallyDamped, 3, true, kPosition), kSame},
      {"critically_damped_a_pass",
       Recursive(ZeroPhaseCriticallyDamped, 2, false, kPosition), kSame}};
  const nlohmann::json table = Table();
  const nlohmann::json& cases = table.at("cases");
  EXPECT_EQ(cases.size(), std::size(kCases));
  for (const auto& [name, run, tolerance] : kCases) {
    const Samples expected = MatrixOf(cases.at(name).at("expected"));
    const Samples found = run(CaseOf(cases.at(name)));
    const double difference = (found - expected).cwiseAbs().maxCoeff();
    EXPECT_LT(difference, tolerance) << name;
    RecordProperty(name, std::to_string(difference * 1e12) + "e-12");
  }
}

TEST(ReferenceTest, RulesChooseTheCutoffsOfTheReference) {
  const nlohmann::json table = Table();
  const Samples moves = MatrixOf(table.at("moves"));
  const LowPass low_pass =
      ZeroPhaseButterworth(ButterworthOptions(), table.at("rate"));
  const std::map<std::string, CutoffChoice> kRules = {
      {"winter", CutoffChoice::kWinter},  {"challis", CutoffChoice::kChallis},
      {"yu", CutoffChoice::kYu},          {"jackson", CutoffChoice::kJackson},
      {"gcv", CutoffChoice::kGcv},        {"power95", CutoffChoice::kPower95},
      {"power99", CutoffChoice::kPower99}};
  for (const auto& [name, rule] : kRules) {
    const nlohmann::json& rules = table.at("rules");
    const auto by_axis = ChooseCutoffs(rule, CutoffPer::kAxis, low_pass, moves);
    const auto by_joint =
        ChooseCutoffs(rule, CutoffPer::kJoint, low_pass, moves);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(by_axis[c], rules.at(std::string(1, "xyz"[c])).at(name), 1e-9)
          << name;
      EXPECT_NEAR(by_joint[c], rules.at("all").at(name), 1e-9) << name;
    }
  }
}

// Compares all numbers of two JSON values.
void ExpectAlike(const nlohmann::json& found, const nlohmann::json& expected,
                 const std::string& where) {
  ASSERT_EQ(found.size(), expected.size()) << where;
  if (!expected.is_structured()) {
    // The location of a minimum is known to the square root of the precision of
    // its function: with another BLAS it differed by 1e-6 (relative). The limit
    // is ten times that.
    const double number = expected.get<double>();
    EXPECT_NEAR(found.get<double>(), number,
                1e-5 * std::max(1.0, std::abs(number)))
        << where;
    return;
  }
  for (const auto& [key, value] : expected.items()) {
    if (expected.is_object()) {
      ExpectAlike(found.at(key), value, where + "/" + key);
    } else {
      ExpectAlike(found.at(std::stoul(key)), value, where);
    }
  }
}

TEST(ReferenceTest, TableEqualsTheOutputOfTheScript) {
  if (std::system("/usr/bin/python3 -c 'import cvxopt, scipy, statsmodels.api' "
                  "2>/dev/null") != 0) {
    GTEST_SKIP() << "needs python3-cvxopt, python3-scipy, python3-statsmodels";
  }
  const testing::TemporaryFolder folder;
  const std::string made = folder.path() / "made.json";
  const std::string script =
      testing::ProjectFile("tests/solvers/filters/reference.py");
  ASSERT_EQ(std::system(
                ("/usr/bin/python3 '" + script + "' > '" + made + "'").c_str()),
            0);
  ExpectAlike(nlohmann::json::parse(testing::ContentOf(made)), Table(), "");
}

}  // namespace
}  // namespace kinegraph
