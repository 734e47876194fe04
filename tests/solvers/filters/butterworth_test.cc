#include "solvers/filters/butterworth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "solvers/filters/segment_filters.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

// Known answers: scipy 1.10.1, numpy 1.24.2; import numpy as np and
// from scipy import signal.

TEST(ButterworthTest, CoefficientsAreScipys) {
  // signal.butter(2, 6, fs=25)
  const auto two = ButterworthLowPass(2, 6.0, 25.0);
  ASSERT_EQ(two.size(), 1u);
  EXPECT_NEAR(two[0].b0, 0.2747268510356349, 1e-15);
  EXPECT_NEAR(two[0].b1, 0.5494537020712698, 1e-15);
  EXPECT_NEAR(two[0].b2, 0.2747268510356349, 1e-15);
  EXPECT_NEAR(two[0].a1, -0.07362384638497856, 1e-15);
  EXPECT_NEAR(two[0].a2, 0.17253125052751803, 1e-15);
  // signal.butter(4, 6, fs=60, output='sos'): the same pairs of poles, in
  // another order, the gain all in the first.
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

TEST(ButterworthTest, EdgesAreScipys) {
  // k = np.arange(30); x = np.sin(0.3 * k) + 0.1 * k + 0.05 * (-1.0) ** k
  // b, a = signal.butter(2, 3, fs=25); signal.filtfilt(b, a, x)[[0,1,15,28,29]]
  const Samples values = testing::Wiggle(30);
  const int places[] = {0, 1, 15, 28, 29};
  const double two[] = {0.049030042131057286, 0.41342134599294955,
                        0.5427299168841767, 3.584898195889903,
                        3.509917261597823};
  Samples filtered = FiltFilt(ButterworthLowPass(2, 3.0, 25.0), values, 9);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(filtered(places[i], 0), two[i], 1e-13) << places[i];
  }
  // The same with butter(3, 3, fs=25), whose padding is 12.
  const double three[] = {0.05086521532429783, 0.4207684664236889,
                          0.5258410308124174, 3.5980078604170975,
                          3.510063379916514};
  filtered = FiltFilt(ButterworthLowPass(3, 3.0, 25.0), values, 12);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(filtered(places[i], 0), three[i], 1e-13) << places[i];
  }
}

TEST(ButterworthTest, CorrectionIsWintersFarBelowTheFrameRate) {
  // Winter gives 0.802 for two passes of order two; prewarping vanishes where
  // the frame rate is high.
  EXPECT_NEAR(6.0 / TwoPassCutoff(2, 6.0, 1e5), 0.802, 5e-4);
}

TEST(ButterworthTest, ResidualAnalysisIsThatOfScipy) {
  // s = 12345, then s = (1103515245 * s + 12345) % 2**31, u = s / 2**31 - 0.5
  // y = sin(2 pi 1.5 t) + 0.5 sin(2 pi 3 t) + 0.1 u, t = i / 100, i < 500
  // f = np.arange(1, 46.0), of each
  //   w = np.tan(np.pi*f/100) / (np.sqrt(2)-1)**0.25
  //   b, a = signal.butter(2, np.arctan(w) / np.pi * 100, fs=100)
  //   R = np.sqrt(np.mean((y - signal.filtfilt(b, a, y))**2))
  // slope, noise = np.polyfit(f[24:], R[24:], 1); where R falls to the noise:
  //   5.1809866955096915
  Samples values(500, 1);
  int64_t state = 12345;
  for (int i = 0; i < 500; ++i) {
    state = (1103515245 * state + 12345) % (int64_t{1} << 31);
    const double u = static_cast<double>(state) / 2147483648.0 - 0.5;
    values(i, 0) = std::sin(2.0 * M_PI * 1.5 * i / 100.0) +
                   0.5 * std::sin(2.0 * M_PI * 3.0 * i / 100.0) + 0.1 * u;
  }
  EXPECT_NEAR(ResidualAnalysisCutoff({}, 100.0, values), 5.1809866955096915,
              1e-9);
  ButterworthOptions chosen;
  chosen.choice = CutoffChoice::kResidualAnalysis;
  ButterworthOptions fixed;
  fixed.cutoff_hz = 5.1809866955096915;
  EXPECT_LT((ZeroPhaseButterworth(chosen, 100.0, values) -
             ZeroPhaseButterworth(fixed, 100.0, values))
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
}

TEST(ButterworthTest, StraightLinesAndShortSignalsPass) {
  // Odd reflection continues a line, so the ends do not bend; shorter signals
  // than the padding take as much as there is.
  for (const int count : {1, 2, 3, 9, 10, 50}) {
    Samples values(count, 2);
    for (int k = 0; k < count; ++k) values.row(k) << 1.0 + 0.2 * k, -3.0;
    const Samples filtered = ZeroPhaseButterworth({}, 25.0, values);
    ASSERT_EQ(filtered.rows(), count);
    EXPECT_TRUE(filtered.allFinite());
    EXPECT_NEAR((filtered.col(1).array() + 3.0).abs().maxCoeff(), 0.0, 1e-14);
    // A pass starts at rest, a line does not: what that bends dies away within
    // the padding of 9, with poles of modulus 0.4 to 0.4^9 = 3e-4.
    if (count < 10) continue;
    EXPECT_LT((filtered - values).cwiseAbs().maxCoeff(), 1e-3) << count;
  }
}

TEST(ButterworthTest, RefusesWhatItCannotDo) {
  JointSegment segment;
  segment.times_s = {0.0, 0.04, 0.08, 0.16, 0.2};  // frame 3 is missing
  segment.positions_m = Samples::Zero(5, 3);
  const SegmentFilter filter = ButterworthFilter({}, 25.0);
  try {
    filter(segment);
    FAIL() << "a dropped frame was accepted";
  } catch (const std::exception& error) {
    EXPECT_STREQ(error.what(),
                 "output.estimator 'butterworth' needs uniform time, found a "
                 "step of 0.0800 s, 0.0800 s into the track, where a frame is "
                 "0.0400 s (allowed: half a frame more or less)");
  }
  // A clock that jitters by up to half a frame is good enough.
  segment.times_s = {0.0, 0.055, 0.08, 0.135, 0.16};
  EXPECT_NO_THROW(filter(segment));
  ButterworthOptions fast;
  fast.cutoff_hz = 12.5;
  EXPECT_THROW(ButterworthFilter(fast, 25.0), std::exception);
}

}  // namespace
}  // namespace kinegraph
