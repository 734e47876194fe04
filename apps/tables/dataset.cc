#include "apps/tables/dataset.h"

#include <algorithm>
#include <string>
#include <utility>

#include "apps/common/config_folder.h"
#include "core/base/error.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {
namespace {

Dataset Shelf(const std::string& name, const std::string& note,
              const std::string& detections, const std::string& config,
              const std::string& set) {
  return {"Shelf, " + name,
          note,
          "shelf/calibration.json",
          detections,
          "shelf/tum/actorsGT.mat",
          config,
          set,
          {},
          ShelfProtocol()};
}

// The authors' runs begin three frames before the first scored one; here the
// first frame is repeated instead.
constexpr const char* kWarmUp = "input.repeat_first_frame=3";
// Like the authors, treats zeros as positions; repeats the first frame.
constexpr const char* kFilledSet =
    "detections.zero_confidence=position;input.repeat_first_frame=3";
// Estimator, bones, backfill and second pass of configs/offline.toml, as
// overrides of the configuration for Campus.
constexpr const char* kBatchSet =
    "output.estimator=batch;graph.bones=true;tracking.backfill=true;"
    "tracking.second_pass=true";

// The joints filter of Chu et al. in the front end of Chen et al.
constexpr const char* kFilterSet = "reconstruction.joints_filter=true";
// A common variant of Chen et al.: a detection is compared with the projection
// of the track's 3D joints, not with the joints last matched in that view.
constexpr const char* kProjectedSet = "association.target_2d=projected";

constexpr const char* kFromReal = "the OpenPose detections of data/shelf";

std::vector<Method> ShelfMethods() {
  return {
      {"paper mode, text", "paper/shelf.toml", ""},
      {"paper mode, text, warmed up", "paper/shelf.toml", kWarmUp},
      {"paper mode, authors' code", "paper/shelf_authors_code.toml", kWarmUp},
      {kChen, "paper/chen_shelf.toml", ""},
      {kChenWithFilter, "paper/chen_shelf.toml", kFilterSet},
      {"†Chen et al., projected target", "paper/chen_shelf.toml",
       kProjectedSet},
      {"graph mode, window", "graph/shelf.toml", ""},
      {"graph mode, batch offline", "offline.toml",
       "skeleton=coco17;input.frame_rate=25"},
  };
}

std::vector<Method> FilledShelfMethods() {
  return {
      {"paper mode, authors' code", "paper/shelf_authors_code.toml", kWarmUp},
      {"paper mode, text", "paper/shelf.toml", kFilledSet},
      {kChen, "paper/chen_shelf.toml", kFilledSet},
      {kChenWithFilter, "paper/chen_shelf.toml",
       JoinSets(kFilledSet, kFilterSet)},
  };
}

std::vector<Method> CampusMethods() {
  return {
      {"paper mode, text", "paper/campus.toml", ""},
      {"paper mode, authors' code", "paper/campus_authors_code.toml", ""},
      {kChen, "paper/chen_campus.toml", ""},
      {kChenWithFilter, "paper/chen_campus.toml", kFilterSet},
      {"†Chen et al., projected target", "paper/chen_campus.toml",
       kProjectedSet},
      {"graph mode, window", "graph/campus.toml", ""},
      {"graph mode, batch offline", "graph/campus.toml", kBatchSet},
  };
}

// Results of other programs on Shelf, as published or obtained by running these
// programs.
std::vector<ResultFile> ShelfResults() {
  const std::string filled = ShelfFilled().name;
  const std::string of_joints =
      "its input is joints and pair scores instead of grouped persons; ";
  return {
      {"Chu et al., their own program",
       "shelf/reference/paper_code_shelf_warm3.json", filled, "", filled},
      {"Chu et al., their own program, no joints filter in the update of "
       "tracks",
       "shelf/reference/paper_code_shelf_warm3_nojf_conf.json", filled, "",
       filled},
      {"4D association, January 2021", "shelf/raw/skel.txt", kFromReal,
       of_joints + "eyes not estimated", ""},
      {"4D association, June 2020", "shelf/raw/skel_202006.txt", kFromReal,
       of_joints + "eyes not estimated", ""},
      {"4D association, run here on Linux",
       "shelf/peers/4da_linux_O3_SKEL19.json", kFromReal,
       of_joints + "its nose serves as eyes", ""},
      {"Pose2Sim, multi-person", "shelf/peers/p2s_multi.json", ShelfReal().name,
       "13 joints; its nose serves as ears, so head conversions that use ears "
       "(voxelpose, 4d) misjudge it",
       ""}};
}

// Programs for one person, given the detections of actor 0.
std::vector<ResultFile> ShelfSinglePersonResults() {
  const std::pair<const char*, const char*> kFiles[] = {
      {"aniposelib, triangulate", "anipose_triangulate"},
      {"aniposelib, optim_points, 12 bones", "anipose_optim_default_bones"},
      {"aniposelib, the anipose program's weights",
       "anipose_optim_c03_program_config_scores"},
      {"Pose2Sim, triangulation", "p2s_tri_raw"},
      {"Pose2Sim, Hampel and Butterworth", "p2s_hampel_butterworth"},
      {"Pose2Sim, Hampel and Kalman", "p2s_hampel_kalman"},
      {"Pose2Sim, Hampel and GCV spline", "p2s_hampel_gcv_spline"},
      {"Pose2Sim, Hampel and One-Euro", "p2s_hampel_one_euro"}};
  std::vector<ResultFile> results;
  for (const auto& [method, file] : kFiles) {
    results.push_back({method, std::string("shelf/peers/") + file + ".json",
                       "detections of actor 0, chosen with the authors' track",
                       "", ""});
  }
  return results;
}

Benchmark DevelopersShelf() {
  Benchmark shelf;
  shelf.set = BenchmarkSet::kShelf;
  shelf.ground_truth = ShelfReal().ground_truth;
  shelf.recordings = {{ShelfReal(), ShelfMethods()},
                      {ShelfFilled(), FilledShelfMethods()}};
  shelf.results = ShelfResults();
  for (const size_t row : {2, 3}) {
    shelf.own_rules.push_back(
        {shelf.results[row], "shelf/raw/gt.txt", FourDAssociationProtocol(),
         "people matched one-to-one by 14 joints and the middle of the hips, "
         "its own head conversion, errors strictly less than half the length, "
         "unmatched actors skipped, stored zeros counted as positions"});
  }
  shelf.single_person = ShelfSinglePersonResults();
  return shelf;
}

Benchmark DevelopersCampus() {
  Benchmark campus;
  campus.set = BenchmarkSet::kCampus;
  campus.ground_truth = CampusModelled("clean").ground_truth;
  for (const char* level : {"clean", "typical", "hard"}) {
    campus.recordings.push_back({CampusModelled(level), CampusMethods()});
  }
  campus.results = {{"Chen et al., their published tracks",
                     "campus/result_3d.json",
                     "Chen et al.'s own detections, which are not public",
                     "their head conversion was tuned on this set", ""}};
  return campus;
}

// The first of `names` in `folder` (relative to `root`), as a path relative to
// `root`.
std::optional<std::string> FirstOf(const std::string& root,
                                   const std::string& folder,
                                   const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    std::string path = folder;
    if (!path.empty() && !name.empty()) path += "/";
    path += name;
    if (IsFile(root + "/" + path) || IsFolder(root + "/" + path)) return path;
  }
  return std::nullopt;
}

// The path of a calibration: a single file, or the folder with P0.txt.
std::optional<std::string> FindCalibration(const std::string& root,
                                           const std::string& folder) {
  for (const char* name : {"", "Calibration", "calibration"}) {
    const auto sub = FirstOf(root, folder, {name});
    if (sub && FirstOf(root, *sub, {"P0.txt"})) return sub;
  }
  return FirstOf(root, folder,
                 {"cameras.json", "calibration.json", "Calib.toml"});
}

// An official download (docs/official_data.md); nullopt if no folder has one of
// the names, or if it has no actorsGT.mat. Throws InputError if it has no
// calibration or no detections.
std::optional<Benchmark> OfficialSet(const std::string& root, BenchmarkSet set,
                                     const std::vector<std::string>& names) {
  const auto folder = FirstOf(root, "", names);
  if (!folder) return std::nullopt;
  const auto truth = FirstOf(root, *folder, {"actorsGT.mat"});
  if (!truth) return std::nullopt;
  const auto cameras = FindCalibration(root, *folder);
  if (!cameras) {
    throw InputError(root + "/" + *folder, "",
                     "no calibration: expected P0.txt, P1.txt, ... in this "
                     "folder or in Calibration/, or calibration.json, "
                     "cameras.json or Calib.toml");
  }
  const auto detections = FirstOf(
      root, *folder, {"detections", "detections.jsonl", "detections.json"});
  if (!detections) {
    throw InputError(root + "/" + *folder, "",
                     "no detections: expected detections/, detections.jsonl or "
                     "detections.json in any supported format "
                     "(docs/official_data.md)");
  }
  const bool shelf = set == BenchmarkSet::kShelf;
  // Like the authors' runs, begins three frames before the first scored one.
  const FrameRange frames = shelf ? FrameRange{297, 601} : FrameRange{347, 751};
  Dataset dataset = {
      shelf ? "Shelf" : "Campus",
      "your own, in " + *detections + ", from a detector unknown to kinegraph",
      *cameras,
      *detections,
      *truth,
      "",
      "",
      {frames},
      shelf ? ShelfProtocol() : CampusProtocol()};
  std::vector<Method> methods = shelf ? ShelfMethods() : CampusMethods();
  // The official data contain the frames before the first scored one, so no
  // method needs to repeat the first frame: methods that do so are left out or
  // changed.
  const auto is_warmed = [](const Method& method) {
    return method.name == "paper mode, text, warmed up";
  };
  methods.erase(std::remove_if(methods.begin(), methods.end(), is_warmed),
                methods.end());
  for (Method& method : methods) {
    if (method.set == kWarmUp) method.set.clear();
  }
  Benchmark benchmark;
  benchmark.set = set;
  benchmark.ground_truth = *truth;
  benchmark.recordings = {{std::move(dataset), std::move(methods)}};
  return benchmark;
}

const std::vector<std::string>& ActorColumns() {
  static const std::vector<std::string> kColumns = {"Actor1", "Actor2",
                                                    "Actor3", "Average"};
  return kColumns;
}

}  // namespace

Dataset ShelfFilled() {
  return Shelf(
      "filled",
      "OpenPose with missing joints filled in (confidence 0), the input of the "
      "authors' code; the first frame is repeated three times",
      "shelf/reference/filled_coco17", "paper/shelf_authors_code.toml",
      "input.repeat_first_frame=3");
}

Dataset ShelfReal() {
  return Shelf("real", "joints of OpenPose, frames 300..600 only",
               "shelf/detections/openpose", "paper/shelf.toml", "");
}

Dataset CampusModelled(const std::string& level) {
  return {"Campus, modelled " + level,
          "the annotation with modelled noise (" + level +
              "), not a detector's output",
          "campus/calibration.json",
          "campus/detections_modelled/" + level,
          "campus/annotation_3d.json",
          "paper/campus.toml",
          "",
          {},
          CampusProtocol()};
}

LoadedDataset LoadDataset(const Dataset& dataset,
                          const std::string& data_folder) {
  LoadedDataset loaded;
  loaded.dataset = dataset;
  loaded.options =
      ReadRunOptions(ProjectConfig(dataset.config), dataset.set, "");
  const std::string root = data_folder + "/";
  loaded.request.frames = dataset.frames;
  loaded.request.cameras =
      ReadCameras(root + dataset.cameras, loaded.options.cameras);
  loaded.detections = ReadDetections(root + dataset.detections,
                                     DetectionOptionsOf(loaded.options));
  TrackReadOptions truth;
  truth.frame_rate_hz = loaded.options.input.frame_rate_hz;
  loaded.truth = ReadTracks(root + dataset.ground_truth, truth);
  return loaded;
}

TrackSequence TracksOf(const LoadedDataset& loaded, const RunOptions& options) {
  return TrackSequenceOf(options, loaded.request, loaded.detections);
}

LoadedDataset LoadDataset(const BenchmarkData& data,
                          const BenchmarkRecording& recording,
                          const Method& method) {
  Dataset dataset = recording.dataset;
  dataset.config = method.config;
  dataset.set = JoinSets(method.set, data.set);
  return LoadDataset(dataset, data.folder);
}

BenchmarkData FindBenchmarks(const std::string& folder,
                             const std::string& set) {
  BenchmarkData data;
  data.folder = folder;
  data.set = set;
  if (IsFile(folder + "/" + ShelfReal().ground_truth)) {
    data.benchmarks.push_back(DevelopersShelf());
  } else if (auto shelf = OfficialSet(folder, BenchmarkSet::kShelf,
                                      {"shelf", "Shelf"})) {
    data.benchmarks.push_back(*std::move(shelf));
  }
  if (IsFile(folder + "/" + CampusModelled("clean").ground_truth)) {
    data.benchmarks.push_back(DevelopersCampus());
  } else if (auto campus = OfficialSet(
                 folder, BenchmarkSet::kCampus,
                 {"campus", "Campus", "CampusSeq1", "Campus_Seq1"})) {
    data.benchmarks.push_back(*std::move(campus));
  }
  if (data.benchmarks.empty()) {
    throw InputError(
        folder, "",
        "contains neither the developers' data (shelf/tum/actorsGT.mat, "
        "campus/annotation_3d.json) nor official downloads "
        "(shelf/actorsGT.mat, campus/actorsGT.mat; "
        "docs/official_data.md)");
  }
  return data;
}

PublishedTable PublishedCampus() {
  return {
      "table 1 of Chu et al. (2021); each on its own detections. Two printed "
      "averages are not the means of their cells: Belagiannis et al. (84.9) "
      "and Tanke et al. (93.7)",
      ActorColumns(),
      {{"Belagiannis et al.", {"93.5", "75.7", "85.4", "84.5"}},
       {"Ershadi-N. et al.", {"94.2", "92.9", "84.6", "90.6"}},
       {"Bridgeman et al.", {"91.8", "92.7", "93.2", "92.6"}},
       {"Tanke et al.", {"98", "91", "92.2", "95.7"}},
       {"Dong et al.", {"97.6", "93.3", "98.0", "96.3"}},
       {"Chen et al.", {"97.1", "94.1", "98.6", "96.6"}},
       {"Tu et al.", {"97.6", "93.8", "98.8", "96.7"}},
       {"Zhang et al.", {"-", "-", "-", "-"}},
       {"Chu et al.", {"98.37", "93.76", "98.26", "96.79"}}}};
}

PublishedTable PublishedCampusExtended() {
  return {
      "table of the extended Campus set of Chu et al. (2021); the dagger marks "
      "their re-implementation of Chen et al.",
      ActorColumns(),
      {{"Dong et al.", {"97.55", "93.33", "98.19", "96.36"}},
       {"†Chen et al.", {"98.37", "95.31", "98.13", "97.27"}},
       {"Chu et al.", {"98.37", "95.65", "98.41", "97.47"}}}};
}

PublishedTable PublishedShelf() {
  return {"table 1 of Chu et al. (2021); each on its own detections",
          ActorColumns(),
          {{"Belagiannis et al.", {"75.3", "69.7", "87.6", "77.5"}},
           {"Ershadi-N. et al.", {"93.3", "75.9", "94.8", "88.0"}},
           {"Bridgeman et al.", {"99.7", "92.8", "97.7", "96.7"}},
           {"Tanke et al.", {"99.8", "90", "98", "95.9"}},
           {"Dong et al.", {"98.8", "94.1", "97.8", "96.9"}},
           {"Chen et al.", {"99.6", "93.2", "97.5", "96.8"}},
           {"Tu et al.", {"99.3", "94.1", "97.6", "97.0"}},
           {"Zhang et al.", {"99.0", "96.2", "97.6", "97.6"}},
           {"Chu et al.", {"99.14", "95.41", "97.64", "97.39"}}}};
}

PublishedTable PublishedCampusParts() {
  return {
      "table of body parts of Chu et al. (2021), which prints \"Ul\" over the "
      "last column of Campus too; the dagger marks their re-implementation of "
      "Chen et al. on their detections. The paper does not say whether actors "
      "are pooled or averaged",
      {"upper arms", "lower arms", "upper legs", "lower legs"},
      {{"Tanke et al.", {"97.7", "84.3", "99.3", "99.0"}},
       {"Chen et al.", {"98.6", "84.6", "-", "-"}},
       {"†Chen et al.", {"99.8", "84.2", "100.0", "100.0"}},
       {"Chu et al.", {"99.8", "84.3", "100.0", "100.0"}}}};
}

PublishedTable PublishedShelfParts() {
  return {
      "table of body parts of Chu et al. (2021); the dagger marks their "
      "re-implementation of Chen et al. on their detections. The paper does "
      "not say whether actors are pooled or averaged",
      {"upper arms", "lower arms", "upper legs", "lower legs"},
      {{"Tanke et al.", {"98.0", "86.3", "100.0", "100.0"}},
       {"Chen et al.", {"98.7", "87.7", "-", "-"}},
       {"†Chen et al.", {"98.8", "89.9", "100.0", "99.9"}},
       {"Chu et al.", {"98.8", "90.5", "100.0", "100.0"}}}};
}

PublishedTable PublishedRuntime() {
  return {
      "table of runtimes of Chu et al. (2021), Shelf, ms per frame, including "
      "the figures that they quote from others. Their text gives 2 ms for the "
      "association where the table has 1; for Campus it gives 1, 5 and 0.5 ms "
      "(association, reconstruction, initialisation)",
      {"affinity", "association", "reconstruction", "initialisation", "fps"},
      {{"Bridgeman et al.", {"-", "-", "-", "-", "110"}},
       {"Dong et al.", {"25", "20", "60", "-", "9.5"}},
       {"Chen et al.", {"-", "-", "-", "-", "325"}},
       {"Chu et al., without joints filter",
        {"1 (both)", "", "3.5", "1", "181"}},
       {"Chu et al.", {"1 (both)", "", "8", "1", "100"}}}};
}

PublishedTable PublishedAblation() {
  return {
      "sentences of section 4.4 of Chu et al. (2021), because the source of "
      "the paper lacks the values of its figure",
      {"measure", "PCP, %"},
      {{"part-aware instead of body-aware, Campus",
        {"mean of actors", "about +2.1"}},
       {"joints filter added", {"lower arms", "+0.5 to +1.0"}},
       {"joints filter added to †Chen et al.",
        {"mean of actors", "97.28 to 97.43"}},
       {"any of these changes", {"torso", "100 in every method"}}}};
}

}  // namespace kinegraph
