// FreeMoCap's 2D points, one .npy of the whole recording:
// mediapipe_2dData_numCams_numFrames_numTrackedPoints_pixelXY.npy, an array
// [cameras, frames, points, 2] in pixels of one person, NaN where a point was
// not found (a third number, a depth in older files, is passed over). Views are
// cam_0, cam_1, ... in its order. With MediaPipe's hands and face the first 33
// points are the body.
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/binary/npz_reader.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/text/bulk_json.h"

namespace kinegraph {
namespace {

// Body, hands (21 points each) and the face, without and with its irises.
bool IsMediaPipe(size_t points) {
  return points == 33 || points == 75 || points == 543 || points == 553;
}

Skeleton FreemocapSkeleton(size_t points, const DetectionReadOptions& options) {
  if (options.skeleton.has_value()) {
    const size_t count = options.skeleton->joints().size();
    if (count <= points) return *options.skeleton;
    throw InputError("has " + std::to_string(points) +
                     " points, expected the " + std::to_string(count) +
                     " of '" + options.skeleton->name() + "'");
  }
  if (IsMediaPipe(points)) return MediaPipe33();
  return *DetectorSkeletons(points, "points").front();
}

std::unique_ptr<DetectionSource> OpenFreemocapFile(
    const std::string& path, const DetectionReadOptions& options) {
  const NpzReader reader(path);
  constexpr const char* kOnlyArray = "";
  const std::vector<size_t> shape = reader.At(kOnlyArray, 4).shape;
  const std::vector<double> numbers = reader.Numbers(kOnlyArray, 4);
  const size_t views = shape[0];
  const size_t frames = shape[1];
  const size_t points = shape[2];
  const size_t step = shape[3];
  if (numbers.empty() || (step != 2 && step != 3)) {
    reader.Fail(kOnlyArray, "expected the shape [cameras, frames, points, 2]");
  }
  DetectionHeader header;
  header.skeleton =
      Located(path, [&] { return FreemocapSkeleton(points, options); });
  header.frame_rate_hz = options.frame_rate_hz;
  for (size_t v = 0; v < views; ++v) {
    header.view_names.push_back("cam_" + std::to_string(v));
  }
  DetectionCollector collector(header);
  for (size_t f = 0; f < frames; ++f) {
    const auto frame = static_cast<int64_t>(f) + options.first_frame;
    collector.Touch(frame);
    for (size_t v = 0; v < views; ++v) {
      Detection person;
      const size_t begin = (v * frames + f) * points * step;
      for (size_t j = 0; j < header.skeleton.joints().size(); ++j) {
        const double* at = &numbers[begin + j * step];
        person.joints.push_back(
            MakeKeypoint(at[0], at[1], 1.0, options.zero_confidence));
      }
      if (CountFound(person) == 0) continue;
      collector.Add(frame, v)->joints = std::move(person.joints);
    }
  }
  return collector.Finish();
}

// NumPy's array of four dimensions.
bool RecogniseFreemocap(const DetectionHead& head) {
  if (head.is_folder || head.beginning.compare(0, 6, "\x93NUMPY") != 0) {
    return false;
  }
  const size_t begin = head.beginning.find("'shape': (");
  const size_t end = head.beginning.find(')', begin);
  if (begin == std::string::npos || end == std::string::npos) return false;
  int commas = 0;
  for (size_t at = begin; at < end; ++at) {
    commas += head.beginning[at] == ',' ? 1 : 0;
  }
  return commas == 3;
}

}  // namespace

DetectionFormat FreeMoCapFormat() {
  DetectionFormat format;
  format.name = "freemocap";
  format.layout = "FreeMoCap's 2D points, one NPY of all cameras";
  format.extension = ".npy";
  format.recognise = RecogniseFreemocap;
  format.open = OpenFreemocapFile;
  return format;
}

}  // namespace kinegraph
