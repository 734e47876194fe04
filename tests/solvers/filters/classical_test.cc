#include "solvers/filters/classical.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "core/base/error.h"
#include "solvers/filters/offline_filter.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

using testing::ExpectPlaces;

TEST(CentredGaussianTest, EqualsNumpyInsideAndAtTheEdges) {
  // x is testing::Wiggle(30); sigma 0.05 s at 25 Hz, radius 4 sigmas = 5
  // frames. numpy 1.24.2:
  //   w = np.exp(-.5 * (np.arange(-5, 6) * .04 / .05)**2)
  //   (np.convolve(x, w, 'same') / np.convolve(np.ones(30), w, 'same'))
  //     [[0, 1, 15, 28, 29]]
  // The value at 15 also equals scipy.ndimage.gaussian_filter1d(x, 1.25)[15].
  ExpectPlaces(
      CentredGaussian(0.05, testing::UniformTimes(30), testing::Wiggle(30)),
      {0, 1, 15, 28, 29},
      {0.2874968691802849, 0.4824789590364859, 0.5887899257028587,
       3.619712452956263, 3.597963959257704},
      1e-13);
}

TEST(CentredGaussianTest, WeightsFollowUnevenTimes) {
  // Three values, one of them distant in time: the weights
  // exp(-t^2 / (2 sigma^2)) are computed by hand.
  Samples values(3, 1);
  values << 1.0, 2.0, 4.0;
  const Samples smoothed = CentredGaussian(0.1, {0.0, 0.1, 0.3}, values);
  const double a = std::exp(-0.5);
  const double b = std::exp(-4.5);
  const double c = std::exp(-2.0);
  ExpectPlaces(smoothed, {0, 1, 2},
               {(1.0 + 2.0 * a + 4.0 * b) / (1.0 + a + b),
                (a + 2.0 + 4.0 * c) / (a + 1.0 + c),
                (b + 2.0 * c + 4.0) / (b + c + 1.0)},
               1e-14);
}

// Expected values are computed in Python by algorithm 1 of the filter's paper
// (Casiez et al.; classical.h), with a minimum cut-off of 1, a beta of 0.5 and
// a cut-off of the derivative of 1, for the x and t of each test:
//   a = lambda dt, fc: 1 / (1 + 1 / (2 * np.pi * fc) / dt)
//   y, e = [x[0]], 0.0
//   for i in range(1, len(x)):
//     dt = t[i] - t[i-1]; e += a(dt, 1.0) * ((x[i] - y[-1]) / dt - e)
//     y.append(y[-1] + a(dt, 1.0 + 0.5 * abs(e)) * (x[i] - y[-1]))
const OneEuroOptions kOptions = {1.0, 0.5};

TEST(OneEuroTest, MatchesThePaperAtUnevenTimes) {
  ExpectPlaces(OneEuro(kOptions, testing::UnevenTimes(30), testing::Wiggle(30)),
               {0, 1, 2, 15, 28, 29},
               {0.05, 0.1554015369335859, 0.3848691357996041,
                0.5909494962435787, 3.636285767367925, 3.575896477631622},
               1e-13);
}

TEST(OneEuroTest, IsExponentialSmoothingWithoutBeta) {
  // al = 1 / (1 + 1 / (2 pi 1.5) / 0.04); scipy 1.10.1:
  // signal.lfilter([al], [1, al - 1], x, zi=[x[0] * (1 - al)])[0]
  ExpectPlaces(
      OneEuro({1.5, 0.0}, testing::UniformTimes(30), testing::Wiggle(30)),
      {0, 1, 15, 29},
      {0.05, 0.1309071981198498, 0.7352923114698284, 3.338964092725327}, 1e-13);
  // Frequency response: the real part of a / (1 - (1 - a) e^-iw), because the
  // gain is measured at the crest of the cosine.
  const double ratio = 2.0 * M_PI * 1.5 * 0.04;
  const double a = ratio / (1.0 + ratio);
  const auto times_s = testing::UniformTimes(2001);
  for (const double f : {0.5, 1.5, 5.0}) {
    const auto z = std::polar(1.0, -2.0 * M_PI * f * 0.04);
    const double expected_gain = (a / (1.0 - (1.0 - a) * z)).real();
    const double gain = testing::Gain(
        [&](const Samples& values) {
          return OneEuro({1.5, 0.0}, times_s, values);
        },
        f, 25.0);
    EXPECT_NEAR(gain, expected_gain, 1e-12) << f;
  }
}

// A joint that moves 1 m per frame along each axis and is not seen for three
// frames.
JointSegment WithAGap() {
  JointSegment segment;
  segment.times_s = testing::UniformTimes(6);
  segment.positions_m.resize(6, 3);
  for (int k = 0; k < 6; ++k) segment.positions_m.row(k).setConstant(k);
  segment.sampled = {1, 1, 0, 0, 0, 1};
  return segment;
}

TEST(OneEuroTest, IsCausalAndHoldsTheLastValueInGaps) {
  const Samples filtered = OneEuroFilter(kOptions)(WithAGap()).positions_m;
  for (int k = 2; k < 5; ++k) EXPECT_EQ(filtered(k, 0), filtered(1, 0));
  // The sample after the gap comes 0.16 s after the previous sample.
  Samples three(3, 1);
  three << 0.0, 1.0, 5.0;
  EXPECT_EQ(filtered(5, 0), OneEuro(kOptions, {0.0, 0.04, 0.2}, three)(2, 0));
}

TEST(SavitzkyGolayTest, EqualsScipyInsideAndAtTheEdges) {
  // scipy 1.10.1: signal.savgol_filter(x, 9, 3)[[0, 1, 15, 28, 29]] and
  // signal.savgol_filter(x, 7, 2)[...], x = testing::Wiggle(30).
  const Samples values = testing::Wiggle(30);
  ExpectPlaces(SavitzkyGolay(9, 3, values), {0, 1, 15, 28, 29},
               {0.01894161481667722, 0.4160661716163582, 0.5409140977964515,
                3.654991074386889, 3.529989961071933},
               1e-13);
  ExpectPlaces(SavitzkyGolay(7, 2, values), {0, 1, 15, 28, 29},
               {0.01376051334216093, 0.4214895372267477, 0.5138416298102059,
                3.649968437031076, 3.531730723922287},
               1e-13);
}

TEST(SavitzkyGolayTest, PolynomialsAreUnchangedAndShortSignalsFittedWhole) {
  for (const int count : {1, 2, 4, 5, 8, 9, 30}) {
    Samples values(count, 1);
    for (int k = 0; k < count; ++k) {
      values(k, 0) = 1.0 - 0.3 * k + 0.02 * k * k - 1e-3 * k * k * k;
    }
    EXPECT_LT((SavitzkyGolay(9, 3, values) - values).cwiseAbs().maxCoeff(),
              1e-12)
        << count;
  }
}

TEST(SavitzkyGolayTest, WindowsAreOddNumbersOfFrames) {
  SavitzkyGolayOptions options;  // 0.36 s, order 3
  EXPECT_EQ(SavitzkyGolayLength(options, 25.0), 9);
  EXPECT_EQ(SavitzkyGolayLength(options, 60.0), 21);   // 21.6
  EXPECT_EQ(SavitzkyGolayLength(options, 120.0), 43);  // 43.2
  options.window_s = 0.0;
  EXPECT_EQ(SavitzkyGolayLength(options, 25.0), 5);  // order 3 needs four
  options.window_s = 1e12;  // one polynomial for any signal
  EXPECT_GT(SavitzkyGolayLength(options, 25.0), 100'000'000);
}

// A ramp with two spikes.
Samples Spiky() {
  Samples values(12, 1);
  values << 0.0, 0.1, 0.2, 5.0, 0.4, 0.5, 0.6, 0.7, -3.0, 0.9, 1.0, 1.1;
  return values;
}

void ExpectColumn(const Samples& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.rows(), static_cast<Eigen::Index>(expected.size()));
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(found(static_cast<Eigen::Index>(i), 0), expected[i], 1e-14)
        << i;
  }
}

TEST(MovingMedianTest, EqualsScipyInsideAndUsesShorterWindowsAtTheEdges) {
  // z is the ramp with spikes. Inside: scipy.signal.medfilt(z, 5). Everywhere:
  // [np.median(z[max(0, i-2):i+3]) for i in range(12)], numpy 1.24.2.
  ExpectColumn(MovingMedian(0.2, WindowSide::kCentred,
                            testing::UniformTimes(12), Spiky()),
               {0.1, 0.15, 0.2, 0.4, 0.5, 0.6, 0.5, 0.6, 0.7, 0.9, 0.95, 1.0});
}

TEST(MovingMedianTest, TrailingWindowsUseNoLaterSamples) {
  // 0.12 s at 25 Hz: the value and the two previous values.
  ExpectColumn(MovingMedian(0.12, WindowSide::kTrailing,
                            testing::UniformTimes(12), Spiky()),
               {0.0, 0.05, 0.1, 0.2, 0.4, 0.5, 0.5, 0.6, 0.6, 0.7, 0.9, 1.0});
}

TEST(MovingMedianTest, KeepsStepsAndRemovesImpulses) {
  const auto times_s = testing::UniformTimes(21);
  const Samples step = testing::Step(21, 10);
  EXPECT_EQ(MovingMedian(0.2, WindowSide::kCentred, times_s, step), step);
  // Two ones among five values are removed; three are the majority and stay.
  Samples burst = Samples::Zero(21, 1);
  burst.middleRows(10, 2).setOnes();
  EXPECT_EQ(MovingMedian(0.2, WindowSide::kCentred, times_s, burst).norm(),
            0.0);
  burst(12, 0) = 1.0;
  EXPECT_EQ(MovingMedian(0.2, WindowSide::kCentred, times_s, burst), burst);
}

TEST(MovingMedianTest, WindowIsATimeNotANumberOfSamples) {
  Samples values(5, 1);
  values << 1.0, 9.0, 2.0, 7.0, 3.0;
  // Within 0.1 s: {1 9}, {1 9 2}, {9 2}, {7 3}, {7 3}.
  ExpectColumn(MovingMedian(0.2, WindowSide::kCentred,
                            {0.0, 0.1, 0.2, 0.5, 0.55}, values),
               {5.0, 2.0, 5.5, 5.0, 5.0});
}

TEST(HampelFilterTest, ReplacesOnlyOutliers) {
  // m, s: np.median and 1.482602218505602 * median |w - m| of
  // w = z[max(0, i-3):i+4]; z[i] becomes m where |z[i] - m| > 3 s.
  ExpectColumn(HampelFilter(0.28, 3.0, WindowSide::kCentred,
                            testing::UniformTimes(12), Spiky()),
               {0.0, 0.1, 0.2, 0.4, 0.4, 0.5, 0.6, 0.7, 0.7, 0.9, 1.0, 1.1});
}

TEST(HampelFilterTest, AnyDeviationAmongEqualValuesIsAnOutlier) {
  EXPECT_EQ(HampelFilter(0.28, 3.0, WindowSide::kCentred,
                         testing::UniformTimes(21), testing::Impulse(21, 10))
                .norm(),
            0.0);
}

TEST(HampelMedianTest, AppliesHampelThenMedian) {
  ExpectColumn(HampelMedian({}, testing::UniformTimes(12), Spiky()),
               {0.1, 0.15, 0.2, 0.4, 0.4, 0.5, 0.6, 0.7, 0.7, 0.9, 0.95, 1.0});
}

TEST(HampelMedianTest, TrailingWindowHoldsTheLastValueInGaps) {
  HampelMedianOptions options;
  options.median_window_s = 0.0;  // each value itself
  options.hampel_threshold = 1e9;
  ExpectColumn(HampelMedianFilter(options)(WithAGap()).positions_m.col(0),
               {0.0, 1.0, 2.0, 3.0, 4.0, 5.0});
  options.side = WindowSide::kTrailing;
  options.median_window_s = 0.01;
  ExpectColumn(HampelMedianFilter(options)(WithAGap()).positions_m.col(0),
               {0.0, 1.0, 1.0, 1.0, 1.0, 5.0});
}

// Expected values are from scipy 1.10.1 and numpy 1.24.2, after
// import numpy as np; from scipy import signal.

TEST(ButterworthTest, CoefficientsMatchScipy) {
  // signal.butter(2, 6, fs=25)
  const auto two = ButterworthLowPass(2, 6.0, 25.0);
  ASSERT_EQ(two.size(), 1u);
  EXPECT_NEAR(two[0].b0, 0.2747268510356349, 1e-15);
  EXPECT_NEAR(two[0].b1, 0.5494537020712698, 1e-15);
  EXPECT_NEAR(two[0].b2, 0.2747268510356349, 1e-15);
  EXPECT_NEAR(two[0].a1, -0.07362384638497856, 1e-15);
  EXPECT_NEAR(two[0].a2, 0.17253125052751803, 1e-15);
  // signal.butter(4, 6, fs=60, output='sos') has the same pairs of poles in
  // another order, with the whole gain in the first section.
  const auto four = ButterworthLowPass(4, 6.0, 60.0);
  ASSERT_EQ(four.size(), 2u);
  EXPECT_NEAR(four[1].a1, -1.0485995763626117, 1e-14);
  EXPECT_NEAR(four[1].a2, 0.2961403575616696, 1e-14);
  EXPECT_NEAR(four[0].a1, -1.320913430819426, 1e-14);
  EXPECT_NEAR(four[0].a2, 0.6327387928852762, 1e-14);
  EXPECT_NEAR(four[0].b0 * four[1].b0, 0.004824343357716231, 1e-15);
  // signal.butter(3, 3, fs=25, output='sos')
  const auto three = ButterworthLowPass(3, 3.0, 25.0);
  ASSERT_EQ(three.size(), 2u);
  EXPECT_NEAR(three[0].a1, -1.0861699924155113, 1e-14);
  EXPECT_NEAR(three[0].a2, 0.4900092425892617, 1e-14);
  EXPECT_NEAR(three[1].a1, -0.4327386422474259, 1e-14);
  EXPECT_NEAR(three[0].b0 * three[1].b0, 0.02863530017091789, 1e-15);
}

TEST(ButterworthTest, EqualsScipyInsideAndAtTheEdges) {
  // k = np.arange(30); x = np.sin(0.3 * k) + 0.1 * k + 0.05 * (-1.0) ** k
  // b, a = signal.butter(2, 3, fs=25); signal.filtfilt(b, a, x)[[0,1,15,28,29]]
  const Samples values = testing::Wiggle(30);
  ExpectPlaces(FiltFilt(ButterworthLowPass(2, 3.0, 25.0), values, 9),
               {0, 1, 15, 28, 29},
               {0.049030042131057286, 0.41342134599294955, 0.5427299168841767,
                3.584898195889903, 3.509917261597823},
               1e-13);
  // butter(3, 3, fs=25), whose padding is 12.
  ExpectPlaces(FiltFilt(ButterworthLowPass(3, 3.0, 25.0), values, 12),
               {0, 1, 15, 28, 29},
               {0.05086521532429783, 0.4207684664236889, 0.5258410308124174,
                3.5980078604170975, 3.510063379916514},
               1e-13);
}

TEST(ButterworthTest, CutoffCorrectionMatchesWinterFarBelowTheFrameRate) {
  // Winter gives 0.802 for two passes of order two; at high frame rates
  // prewarping has no effect.
  EXPECT_NEAR(6.0 / TwoPassCutoff(2, 6.0, 1e5), 0.802, 5e-4);
}

TEST(ButterworthTest, ResidualAnalysisMatchesScipy) {
  // s = 12345, then s = (1103515245 * s + 12345) % 2**31, u = s / 2**31 - 0.5
  // y = sin(2 pi 1.5 t) + 0.5 sin(2 pi 3 t) + 0.1 u, t = i / 100, i < 500
  // f = np.arange(1, 46.0), for each f
  //   w = np.tan(np.pi*f/100) / (np.sqrt(2)-1)**0.25
  //   b, a = signal.butter(2, np.arctan(w) / np.pi * 100, fs=100)
  //   R = np.sqrt(np.mean((y - signal.filtfilt(b, a, y))**2))
  // slope, noise = np.polyfit(f[24:], R[24:], 1); R falls to the noise at
  //   5.1809866955096915
  Samples values(500, 1);
  int64_t state = 12345;
  for (int i = 0; i < 500; ++i) {
    state = (1103515245 * state + 12345) % (int64_t{1} << 31);
    const double u = static_cast<double>(state) / 2147483648.0 - 0.5;
    values(i, 0) = std::sin(2.0 * M_PI * 1.5 * i / 100.0) +
                   0.5 * std::sin(2.0 * M_PI * 3.0 * i / 100.0) + 0.1 * u;
  }
  const LowPass low_pass = ZeroPhaseButterworth({}, 100.0);
  EXPECT_NEAR(ChooseCutoff(CutoffChoice::kWinter, low_pass, values),
              5.1809866955096915, 1e-9);
  ButterworthOptions options;
  options.choice = CutoffChoice::kWinter;
  JointSegment segment;
  segment.times_s = testing::UniformTimes(500, 100.0);
  segment.positions_m = values;
  const SegmentEstimate chosen = ButterworthFilter(options, 100.0)(segment);
  ASSERT_EQ(chosen.cutoffs_hz.size(), 1u);
  EXPECT_NEAR(chosen.cutoffs_hz[0], 5.1809866955096915, 1e-9);
  EXPECT_EQ(chosen.positions_m, low_pass.filter(chosen.cutoffs_hz[0], values));
}

TEST(ButterworthTest, ConstantsAndLongStraightLinesAreUnchanged) {
  // Odd reflection continues a line, so the ends do not bend; signals shorter
  // than the padding use all available samples.
  for (const int count : {1, 2, 3, 9, 10, 50}) {
    Samples values(count, 2);
    for (int k = 0; k < count; ++k) values.row(k) << 1.0 + 0.2 * k, -3.0;
    const Samples filtered = ZeroPhaseButterworth({}, 25.0).filter(6.0, values);
    ASSERT_EQ(filtered.rows(), count);
    EXPECT_TRUE(filtered.allFinite());
    EXPECT_NEAR((filtered.col(1).array() + 3.0).abs().maxCoeff(), 0.0, 1e-14);
    // A pass starts in the steady state of a constant, not of a line. The poles
    // have a modulus of 0.4, so over the padding of 9 values the resulting bend
    // decays by 0.4^9 = 3e-4.
    if (count < 10) continue;
    EXPECT_LT((filtered - values).cwiseAbs().maxCoeff(), 1e-3) << count;
  }
}

TEST(UniformTimeTest, FiltersThatNeedItRefuseUnevenTimes) {
  JointSegment segment;
  segment.positions_m = Samples::Zero(5, 3);
  for (const auto& [name, filter] :
       {std::pair<std::string, SegmentFilter>{"butterworth",
                                              ButterworthFilter({}, 25.0)},
        {"savitzky_golay", SavitzkyGolayFilter({}, 25.0)}}) {
    segment.times_s = {0.0, 0.04, 0.08, 0.16, 0.2};  // frame 3 is missing
    try {
      filter(segment);
      FAIL() << name << " accepted a dropped frame";
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(),
                "output.estimator '" + name +
                    "' needs uniform frame times, found a step of 0.0800 s, "
                    "0.0800 s after the start of the track, expected 0.0400 s "
                    "(give or take half a frame)");
    }
    // Steps that differ from a frame by less than half a frame are accepted.
    segment.times_s = {0.0, 0.055, 0.08, 0.135, 0.16};
    EXPECT_NO_THROW(filter(segment)) << name;
  }
}

// `filter` over samples at `rate_hz`.
Samples FilterAt(double rate_hz, const SegmentFilter& filter) {
  JointSegment segment;
  segment.times_s = testing::UniformTimes(60, rate_hz);
  segment.positions_m = testing::Wiggle(60).replicate(1, 3);
  segment.sampled.assign(60, 1);
  return filter(segment).positions_m;
}

double Greatest(const Samples& difference) {
  return difference.cwiseAbs().maxCoeff();
}

// A detector that runs on every third frame of a recording at 60 Hz.
TEST(OwnRateTest, PenalisedCurvesUseTheRateOfTheirSegment) {
  WhittakerOptions options;
  for (const CutoffChoice choice :
       {CutoffChoice::kWinter, CutoffChoice::kJackson, CutoffChoice::kYu}) {
    options.smoothness.choice = choice;
    EXPECT_LT(Greatest(FilterAt(20.0, WhittakerFilter(options, 60.0)) -
                       FilterAt(20.0, WhittakerFilter(options, 20.0))),
              1e-9);
  }
  // A cut-off above half the segment's rate hardly smooths.
  options.smoothness.choice = CutoffChoice::kFixed;
  options.smoothness.cutoff_hz = 20.0;
  EXPECT_LT(Greatest(FilterAt(20.0, WhittakerFilter(options, 60.0)) -
                     testing::Wiggle(60).replicate(1, 3)),
            0.1);
}

// Steps within half a nominal frame are accepted.
TEST(OwnRateTest, UniformFiltersUseTheRateOfTheirSegment) {
  const auto difference = [](const SegmentFilter& nominal,
                             const SegmentFilter& own) {
    return Greatest(FilterAt(33.0, nominal) - FilterAt(33.0, own));
  };
  EXPECT_LT(
      difference(ButterworthFilter({}, 25.0), ButterworthFilter({}, 33.0)),
      1e-9);
  EXPECT_LT(difference(CriticallyDampedFilter({}, 25.0),
                       CriticallyDampedFilter({}, 33.0)),
            1e-9);
  EXPECT_LT(
      difference(SavitzkyGolayFilter({}, 25.0), SavitzkyGolayFilter({}, 33.0)),
      1e-9);
  // A cut-off too high for the segment becomes 45 % of its rate.
  ButterworthOptions high;
  high.cutoff_hz = 12.0;
  ButterworthOptions highest;
  highest.cutoff_hz = 0.45 * 18.0;
  EXPECT_LT(Greatest(FilterAt(18.0, ButterworthFilter(high, 25.0)) -
                     FilterAt(18.0, ButterworthFilter(highest, 18.0))),
            1e-9);
}

}  // namespace
}  // namespace kinegraph
