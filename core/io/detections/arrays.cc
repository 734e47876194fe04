// Arrays of all frames: SLEAP's HDF5 and FreeMoCap's NPY.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/binary/hdf5_file.h"
#include "core/io/binary/npz_file.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/names.h"

namespace kinegraph {

// ---- SLEAP ----
// SLEAP's analysis HDF5, a file a view: `tracks` (x, y of each node of each
// track in each frame, NaN where there is none), `point_scores`, `node_names`
// and `edge_inds`. The attribute `dims` tells the order of the axes; files
// without one have track, xy, node, frame. Frames count from 0. In a session of
// sleap-anipose's a view is a folder with one such file.

namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".h5";
constexpr const char* kTracks = "tracks";
constexpr const char* kScores = "point_scores";

struct Axis {
  size_t size = 0;
  size_t step = 0;  // between neighbours
};

// The axes of an array, by SLEAP's names for them.
struct Layout {
  Axis frame, track, node, xy;

  size_t Place(size_t f, size_t t, size_t n) const {
    return f * frame.step + t * track.step + n * node.step;
  }
};

std::vector<std::string> AxesOf(const Hdf5File& file, const std::string& path) {
  const std::string dims = file.Attribute(kTracks, "dims");
  if (dims.empty()) return {"track", "xy", "node", "frame"};
  std::vector<std::string> axes;
  const Json json = ParseJson(dims, path + ": " + kTracks + ".dims");
  for (const Json& axis : json) {
    if (axis.is_string()) axes.push_back(axis.get<std::string>());
  }
  std::vector<std::string> sorted = axes;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != std::vector<std::string>{"frame", "node", "track", "xy"}) {
    throw InputError(path, std::string(kTracks) + ".dims",
                     "expected each of frame, track, node and xy once");
  }
  return axes;
}

// Of `tracks`, or of the scores, which have no axis "xy".
Layout LayoutOf(const std::vector<std::string>& axes,
                const std::vector<size_t>& shape) {
  static const std::map<std::string, Axis Layout::*> kAxes = {
      {"frame", &Layout::frame},
      {"track", &Layout::track},
      {"node", &Layout::node},
      {"xy", &Layout::xy}};
  if (axes.size() != shape.size()) {
    throw InputError("has " + std::to_string(shape.size()) +
                     " axes, expected " + std::to_string(axes.size()));
  }
  Layout layout;
  size_t step = 1;
  for (size_t a = axes.size(); a-- > 0;) {
    if (axes[a] == "xy" && shape[a] != 2) {
      throw InputError("found an axis 'xy' of " + std::to_string(shape[a]) +
                       ", expected frame, track, node and xy of 2");
    }
    layout.*kAxes.at(axes[a]) = {shape[a], step};
    step *= shape[a];
  }
  return layout;
}

// The two nodes of each edge, one after the other: of `edge_inds`, [edges, 2]
// or [2, edges] as MATLAB has it, else of `edge_names`.
std::vector<double> EdgesOf(const Hdf5File& file,
                            const std::vector<std::string>& nodes) {
  if (!file.Has("edge_inds")) {
    std::vector<double> places;
    if (!file.Has("edge_names")) return places;
    for (const std::string& name : file.Texts("edge_names")) {
      places.push_back(static_cast<double>(
          std::find(nodes.begin(), nodes.end(), name) - nodes.begin()));
    }
    return places;
  }
  std::vector<double> stored = file.Numbers("edge_inds");
  const std::vector<size_t> shape = file.Shape("edge_inds");
  if (shape.size() != 2 || shape[1] == 2) return stored;
  std::vector<double> places(stored.size());
  for (size_t e = 0; e < stored.size(); ++e) {
    places[e] = stored[e / 2 + (e % 2) * (stored.size() / 2)];
  }
  return places;
}

std::vector<Bone> SleapBones(const Hdf5File& file,
                             const std::vector<std::string>& nodes) {
  const std::vector<double> ends = EdgesOf(file, nodes);
  const auto count = static_cast<double>(nodes.size());
  for (const double end : ends) {
    if (end >= 0.0 && end < count) continue;
    throw InputError(
        fmt::format("{}: found {}, expected 0 .. {}",
                    file.Has("edge_inds") ? "edge_inds" : "edge_names: node",
                    end, count - 1.0));
  }
  std::vector<Bone> bones;
  for (size_t e = 0; e + 1 < ends.size(); e += 2) {
    bones.push_back({static_cast<int>(ends[e]), static_cast<int>(ends[e + 1])});
  }
  return bones;
}

void SettleSleapSkeleton(const Hdf5File& file, const std::string& path,
                         size_t joint_count, DetectionCollector* collector) {
  Located(path, [&] {
    const std::vector<std::string> names = file.Texts("node_names");
    collector->SettleSkeleton(names, SleapBones(file, names));
  });
  const Skeleton& skeleton = collector->header().skeleton;
  if (skeleton.joints().size() == joint_count) return;
  throw InputError(path, kTracks,
                   "has " + std::to_string(joint_count) +
                       " nodes, expected the " +
                       std::to_string(skeleton.joints().size()) + " of '" +
                       Printable(skeleton.name()) + "'");
}

void ReadAnalysis(const Hdf5File& file, const std::string& path,
                  size_t view_idx, const DetectionReadOptions& options,
                  DetectionCollector* collector) {
  const auto layout_of = [&](const char* name,
                             const std::vector<std::string>& axes) {
    return Located(
        path, [&] { return std::string(name); },
        [&] { return LayoutOf(axes, file.Shape(name)); });
  };
  const std::vector<std::string> axes = AxesOf(file, path);
  const Layout tracks = layout_of(kTracks, axes);
  const std::vector<double> px = file.Numbers(kTracks);
  SettleSleapSkeleton(file, path, tracks.node.size, collector);
  std::vector<double> scores;
  Layout of_scores;
  if (file.Has(kScores)) {
    std::vector<std::string> fewer = axes;
    fewer.erase(std::remove(fewer.begin(), fewer.end(), "xy"), fewer.end());
    scores = file.Numbers(kScores);
    of_scores = layout_of(kScores, fewer);
    if (scores.size() * 2 != px.size() ||
        of_scores.frame.size != tracks.frame.size ||
        of_scores.track.size != tracks.track.size) {
      throw InputError(path, kScores, "does not fit the tracks");
    }
  }
  if (px.empty()) return;  // nobody, however many frames it claims
  for (size_t f = 0; f < tracks.frame.size; ++f) {
    const auto frame = static_cast<int64_t>(f);
    collector->Touch(frame);
    for (size_t p = 0; p < tracks.track.size; ++p) {
      std::vector<Keypoint> joints;
      for (size_t j = 0; j < tracks.node.size; ++j) {
        const size_t at = tracks.Place(f, p, j);
        const double score =
            scores.empty() ? 1.0 : scores[of_scores.Place(f, p, j)];
        joints.push_back(MakeKeypoint(px[at], px[at + tracks.xy.step], score,
                                      options.zero_confidence));
      }
      collector->AddFound(frame, view_idx, std::move(joints));
    }
  }
}

void ReadSleapFile(const std::string& path, size_t view_idx,
                   const DetectionReadOptions& options,
                   DetectionCollector* collector) {
  ReadHdf5(path, [&](const Hdf5File& file) {
    ReadAnalysis(file, path, view_idx, options, collector);
  });
}

bool IsAnalysis(const std::string& path) {
  if (fs::path(path).extension() != kExtension || !IsFile(path)) return false;
  try {
    bool is_analysis = false;
    ReadHdf5(path, [&](const Hdf5File& file) {
      is_analysis = file.Has("node_names") && file.Has(kTracks);
    });
    return is_analysis;
  } catch (const InputError&) {
    return false;  // another kind of file, which has a word of its own to say
  }
}

std::vector<std::string> AnalysesIn(const std::string& folder) {
  std::vector<std::string> files;
  for (const std::string& name : ListFolder(folder)) {
    const std::string path = (fs::path(folder) / name).string();
    if (name.front() != '.' && IsAnalysis(path)) files.push_back(path);
  }
  return files;
}

// A session of sleap-anipose's: a folder a camera with one analysis in it.
NamedPaths SessionFiles(const std::string& path) {
  NamedPaths files;
  for (const auto& [name, folder] : ListViewFolders(path)) {
    const std::vector<std::string> analyses = AnalysesIn(folder);
    if (analyses.empty()) continue;
    if (analyses.size() > 1) {
      throw InputError(folder, "",
                       "holds " + std::to_string(analyses.size()) +
                           " analyses, expected one a camera");
    }
    files.emplace_back(name, analyses.front());
  }
  return files;
}

}  // namespace

// HDF5 with SLEAP's data sets.
bool RecogniseSleap(const DetectionHead& head) {
  if (!head.is_folder) {
    return head.HasKey("node_names") && head.HasKey(kTracks);
  }
  return !AnalysesIn(head.path).empty() ||
         (head.has_folders && !SessionFiles(head.path).empty());
}

std::unique_ptr<DetectionSource> OpenSleap(
    const std::string& path, const DetectionReadOptions& options) {
  const bool is_session = IsFolder(path) && AnalysesIn(path).empty();
  const NamedPaths files =
      is_session ? SessionFiles(path) : ListViewFiles(path, kExtension);
  if (files.empty()) throw InputError(path, "", "holds no analysis of SLEAP's");
  return ReadViews(files, options, ReadSleapFile);
}

// ---- FreeMoCap ----
// FreeMoCap's 2D points, one .npy of the whole recording:
// mediapipe_2dData_numCams_numFrames_numTrackedPoints_pixelXY.npy, an array
// [cameras, frames, points, 2] in pixels of one person, NaN where a point was
// not found (a third number, a depth in older files, is passed over). Views are
// cam_0, cam_1, ... in its order. With MediaPipe's hands and face the first 33
// points are the body.

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

}  // namespace

std::unique_ptr<DetectionSource> OpenFreemocap(
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
  std::vector<std::string> names;
  for (size_t v = 0; v < views; ++v) {
    names.push_back("cam_" + std::to_string(v));
  }
  const Skeleton skeleton =
      Located(path, [&] { return FreemocapSkeleton(points, options); });
  DetectionCollector collector(HeaderOf(names, options, skeleton));
  for (size_t f = 0; f < frames; ++f) {
    const auto frame = static_cast<int64_t>(f) + options.first_frame;
    collector.Touch(frame);
    for (size_t v = 0; v < views; ++v) {
      std::vector<Keypoint> joints;
      const size_t begin = (v * frames + f) * points * step;
      for (size_t j = 0; j < skeleton.joints().size(); ++j) {
        const double* at = &numbers[begin + j * step];
        joints.push_back(
            MakeKeypoint(at[0], at[1], 1.0, options.zero_confidence));
      }
      collector.AddFound(frame, v, std::move(joints));
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
  const std::string shape = head.beginning.substr(begin, end - begin);
  return std::count(shape.begin(), shape.end(), ',') == 3;
}

}  // namespace kinegraph
