// SLEAP's analysis HDF5, a file a view: `tracks` (x, y of each node of each
// track in each frame, NaN where there is none), `point_scores`, `node_names`
// and `edge_inds`. The attribute `dims` tells the order of the axes; files
// without one have track, xy, node, frame. Frames count from 0. In a session of
// sleap-anipose's a view is a folder with one such file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/binary/hdf5_file.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".h5";
constexpr const char* kTracks = "tracks";
constexpr const char* kScores = "point_scores";

// Steps between neighbours along each axis.
struct Layout {
  size_t frames = 0;
  size_t people = 0;
  size_t joints = 0;
  size_t frame_step = 0;
  size_t person_step = 0;
  size_t joint_step = 0;
  size_t xy_step = 0;
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
  if (axes.size() != shape.size()) {
    throw InputError("has " + std::to_string(shape.size()) +
                     " axes, expected " + std::to_string(axes.size()));
  }
  Layout layout;
  size_t step = 1;
  for (size_t a = axes.size(); a-- > 0;) {
    if (axes[a] == "frame") {
      layout.frames = shape[a];
      layout.frame_step = step;
    } else if (axes[a] == "track") {
      layout.people = shape[a];
      layout.person_step = step;
    } else if (axes[a] == "node") {
      layout.joints = shape[a];
      layout.joint_step = step;
    } else if (axes[a] == "xy" && shape[a] == 2) {
      layout.xy_step = step;
    } else {
      throw InputError("found an axis '" + Printable(axes[a]) + "' of " +
                       std::to_string(shape[a]) +
                       ", expected frame, track, node and xy of 2");
    }
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
  const std::vector<double> stored = file.Numbers("edge_inds");
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

class SleapReader {
 public:
  SleapReader(const DetectionHeader& header,
              const DetectionReadOptions& options)
      : zero_confidence_(options.zero_confidence), collector_(header) {}

  void ReadFile(const std::string& path, size_t view_idx) {
    ReadHdf5(path, [&](const Hdf5File& file) { Read(file, path, view_idx); });
  }

  std::unique_ptr<DetectionSource> Finish() { return collector_.Finish(); }

 private:
  void Read(const Hdf5File& file, const std::string& path, size_t view_idx) {
    const std::vector<std::string> axes = AxesOf(file, path);
    const Layout tracks = Located(
        path, [&] { return std::string(kTracks); },
        [&] { return LayoutOf(axes, file.Shape(kTracks)); });
    const std::vector<double> px = file.Numbers(kTracks);
    SettleSkeleton(file, path, tracks.joints);
    std::vector<double> scores;
    Layout of_scores;
    if (file.Has(kScores)) {
      std::vector<std::string> fewer = axes;
      fewer.erase(std::remove(fewer.begin(), fewer.end(), "xy"), fewer.end());
      scores = file.Numbers(kScores);
      of_scores = Located(
          path, [&] { return std::string(kScores); },
          [&] { return LayoutOf(fewer, file.Shape(kScores)); });
      if (scores.size() * 2 != px.size() || of_scores.frames != tracks.frames ||
          of_scores.people != tracks.people) {
        throw InputError(path, kScores, "does not fit the tracks");
      }
    }
    if (px.empty()) return;  // nobody, however many frames it claims
    for (size_t f = 0; f < tracks.frames; ++f) {
      collector_.Touch(static_cast<int64_t>(f));
      for (size_t p = 0; p < tracks.people; ++p) {
        AddPerson(px, tracks, scores, of_scores, f, p, view_idx);
      }
    }
  }

  void SettleSkeleton(const Hdf5File& file, const std::string& path,
                      size_t joint_count) {
    Located(path, [&] {
      const std::vector<std::string> names = file.Texts("node_names");
      collector_.SettleSkeleton(names, SleapBones(file, names));
    });
    const Skeleton& skeleton = collector_.header().skeleton;
    if (skeleton.joints().size() == joint_count) return;
    throw InputError(path, kTracks,
                     "has " + std::to_string(joint_count) +
                         " nodes, expected the " +
                         std::to_string(skeleton.joints().size()) + " of '" +
                         Printable(skeleton.name()) + "'");
  }

  void AddPerson(const std::vector<double>& px, const Layout& tracks,
                 const std::vector<double>& scores, const Layout& of_scores,
                 size_t f, size_t p, size_t view_idx) {
    std::vector<Keypoint> joints;
    bool is_there = false;
    for (size_t j = 0; j < tracks.joints; ++j) {
      const size_t at = f * tracks.frame_step + p * tracks.person_step +
                        j * tracks.joint_step;
      const double score =
          scores.empty()
              ? 1.0
              : scores[f * of_scores.frame_step + p * of_scores.person_step +
                       j * of_scores.joint_step];
      joints.push_back(MakeKeypoint(px[at], px[at + tracks.xy_step], score,
                                    zero_confidence_));
      is_there = is_there || joints.back().found;
    }
    if (!is_there) return;
    collector_.Add(static_cast<int64_t>(f), view_idx)->joints =
        std::move(joints);
  }

  const ZeroConfidence zero_confidence_;
  DetectionCollector collector_;
};

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

std::vector<std::string> AnalysesIn(const fs::path& folder) {
  std::vector<std::string> files;
  for (const std::string& name : ListFolder(folder.string())) {
    const std::string path = (folder / name).string();
    if (name.front() != '.' && IsAnalysis(path)) files.push_back(path);
  }
  return files;
}

// A session of sleap-anipose's: a folder a camera with one analysis in it.
// Pairs of view and file, as ListViewFiles gives them.
std::vector<std::pair<std::string, std::string>> SessionFiles(
    const std::string& path) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const std::string& name : ListFolder(path)) {
    const fs::path inside = fs::path(path) / name;
    if (name.front() == '.' || !IsFolder(inside.string())) continue;
    const std::vector<std::string> analyses = AnalysesIn(inside);
    if (analyses.empty()) continue;
    if (analyses.size() > 1) {
      throw InputError(inside.string(), "",
                       "holds " + std::to_string(analyses.size()) +
                           " analyses, expected one a camera");
    }
    files.emplace_back(name, analyses.front());
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return NaturalLess(a.first, b.first);
  });
  return files;
}

std::unique_ptr<DetectionSource> OpenSleapFile(
    const std::string& path, const DetectionReadOptions& options) {
  if (!IsFolder(path) || !AnalysesIn(path).empty()) {
    return OpenViewFiles<SleapReader>(path, options, kExtension);
  }
  const auto files = SessionFiles(path);
  if (files.empty()) throw InputError(path, "", "holds no analysis of SLEAP's");
  SleapReader reader(HeaderOfViews(files, options), options);
  for (size_t v = 0; v < files.size(); ++v) reader.ReadFile(files[v].second, v);
  return reader.Finish();
}

// HDF5 with SLEAP's data sets.
bool RecogniseSleap(const DetectionHead& head) {
  if (!head.is_folder) {
    return head.HasKey("node_names") && head.HasKey(kTracks);
  }
  return !AnalysesIn(head.path).empty() ||
         (head.has_folders && !SessionFiles(head.path).empty());
}

}  // namespace

DetectionFormat SleapFormat() {
  DetectionFormat format;
  format.name = "sleap";
  format.layout =
      "analysis HDF5, a file a view, or sleap-anipose's folder a camera";
  format.extension = kExtension;
  format.files = DetectionFormat::Files::kFileAView;
  format.recognise = RecogniseSleap;
  format.open = OpenSleapFile;
  return format;
}

}  // namespace kinegraph
