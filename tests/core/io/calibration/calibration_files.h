// Reads calibrations from texts, and compares cameras.
#ifndef KINEGRAPH_TESTS_CORE_IO_CALIBRATION_CALIBRATION_FILES_H_
#define KINEGRAPH_TESTS_CORE_IO_CALIBRATION_CALIBRATION_FILES_H_

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

// The cameras of a file of this name and content.
inline CameraRig CamerasOf(const std::string& name, const std::string& text,
                           const CameraReadOptions& options = {}) {
  const TemporaryFolder folder;
  return ReadCameras(folder.Write(name, text), options);
}

// The message with which that file is rejected.
inline std::string FaultOf(const std::string& name, const std::string& text,
                           const CameraReadOptions& options = {}) {
  return FaultIn(name, text,
                 [&](const std::string& path) { ReadCameras(path, options); });
}

// Expects each text to be rejected with a message that contains the text given
// with it.
inline void ExpectFaults(const std::string& name, const Faults& faults) {
  ExpectFaultsIn(name, faults,
                 [](const std::string& path) { ReadCameras(path); });
}

// A matrix as OpenCV's programs write it.
inline std::string OpencvMatrix(const std::string& key, const std::string& rows,
                                const std::string& cols,
                                const std::string& data) {
  return key + ": !!opencv-matrix\n  rows: " + rows + "\n  cols: " + cols +
         "\n  dt: d\n  data: [" + data + "]\n";
}

inline std::vector<std::string> NamesOf(const CameraRig& cameras) {
  std::vector<std::string> names;
  for (const Camera& camera : cameras) names.push_back(camera.name());
  return names;
}

// Parameters of the lens; empty for an ideal pinhole.
inline std::vector<double> LensOf(const Camera& camera) {
  return camera.lens() == nullptr ? std::vector<double>()
                                  : camera.lens()->parameters();
}

// Expects this name, size (width, height) and `K` (fx, fy, cx, cy), exactly.
inline void ExpectIntrinsics(const Camera& camera, const std::string& name,
                             const std::vector<int>& size_px,
                             const std::vector<double>& K) {
  EXPECT_EQ(camera.name(), name);
  EXPECT_EQ((std::vector<int>{camera.width_px(), camera.height_px()}), size_px);
  EXPECT_EQ((std::vector<double>{camera.K()(0, 0), camera.K()(1, 1),
                                 camera.K()(0, 2), camera.K()(1, 2)}),
            K);
}

// Expects the same K, R, t and lens; names and sizes are not compared. The
// largest difference of an element may be `tolerance` for R and `tolerance`
// times the largest element for K; that of t may have the length `tolerance`
// times 1 + |t|. Lens terms must be equal.
inline void ExpectSameCameras(const CameraRig& a, const CameraRig& b,
                              double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t c = 0; c < a.size(); ++c) {
    const double K_scale = a[c].K().cwiseAbs().maxCoeff();
    EXPECT_LE((a[c].K() - b[c].K()).cwiseAbs().maxCoeff(), tolerance * K_scale);
    EXPECT_LE((a[c].R() - b[c].R()).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LE((a[c].t() - b[c].t()).norm(), tolerance * (1.0 + a[c].t().norm()))
        << a[c].name();
    EXPECT_EQ(LensOf(a[c]), LensOf(b[c])) << a[c].name();
  }
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_IO_CALIBRATION_CALIBRATION_FILES_H_
