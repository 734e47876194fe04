#include "apps/tables/benchmark.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

// As the authors start: three frames before the first that is scored.
constexpr const char* kWarmUp = "input.repeat_first_frame=3";
// Zeros are positions, the recording is warmed up as the authors do.
constexpr const char* kFilledSet =
    "detections.zero_confidence=position;input.repeat_first_frame=3";
// configs/offline.toml in what Campus is tracked with.
constexpr const char* kBatchSet =
    "output.estimator=batch;graph.bones=true;tracking.backfill=true;"
    "tracking.second_pass=true";

// The joints filter of Chu et al. in the front end of Chen et al.
constexpr const char* kFilterSet = "reconstruction.joints_filter=true";
// A usual variant: the target is projected where it was not remembered.
constexpr const char* kProjectedSet = "association.target_2d=projected";

constexpr const char* kFromReal =
    "the same OpenPose candidates (data/shelf/README.md)";

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

BenchmarkRecording RecordingOf(Dataset dataset, std::vector<Method> methods) {
  CHECK(!methods.empty());
  dataset.config = methods.front().config;
  dataset.set = methods.front().set;
  return {std::move(dataset), std::move(methods)};
}

// Other programs' results on Shelf that were published or run.
std::vector<ResultFile> ShelfResults() {
  const std::string filled = ShelfFilled().name;
  return {
      {"Chu et al., their own program",
       "shelf/reference/paper_code_shelf_warm3.json", "Shelf, filled", "",
       filled},
      {"Chu et al., their own program, no filter in the update",
       "shelf/reference/paper_code_shelf_warm3_nojf_conf.json", "Shelf, filled",
       "", filled},
      {"4D association, January 2021",
       "shelf/raw/skel.txt",
       kFromReal,
       "joints and pair scores instead of grouped persons; eyes not estimated",
       {}},
      {"4D association, June 2020",
       "shelf/raw/skel_202006.txt",
       kFromReal,
       "joints and pair scores instead of grouped persons; eyes not estimated",
       {}},
      {"4D association, run here on Linux",
       "shelf/peers/4da_linux_O3_SKEL19.json",
       kFromReal,
       "joints and pair scores instead of grouped persons; eyes are its nose",
       {}},
      {"Pose2Sim, multi-person",
       "shelf/peers/p2s_multi.json",
       "Shelf, real",
       "13 joints: ears are its nose, so the conversions that use ears "
       "(voxelpose, 4d) misjudge it",
       {}},
  };
}

// Programs for one person, given the detections of actor 0.
std::vector<ResultFile> ShelfSinglePersonResults() {
  const std::string actor =
      "detections of actor 0, chosen with the authors' track";
  const std::string peers = "shelf/peers/";
  return {
      {"aniposelib, triangulate",
       peers + "anipose_triangulate.json",
       actor,
       "",
       {}},
      {"aniposelib, optim_points, 12 bones",
       peers + "anipose_optim_default_bones.json",
       actor,
       "",
       {}},
      {"aniposelib, the anipose program's weights",
       peers + "anipose_optim_c03_program_config_scores.json",
       actor,
       "",
       {}},
      {"Pose2Sim, triangulation", peers + "p2s_tri_raw.json", actor, "", {}},
      {"Pose2Sim, Hampel and Butterworth",
       peers + "p2s_hampel_butterworth.json",
       actor,
       "",
       {}},
      {"Pose2Sim, Hampel and Kalman",
       peers + "p2s_hampel_kalman.json",
       actor,
       "",
       {}},
      {"Pose2Sim, Hampel and GCV spline",
       peers + "p2s_hampel_gcv_spline.json",
       actor,
       "",
       {}},
      {"Pose2Sim, Hampel and One-Euro",
       peers + "p2s_hampel_one_euro.json",
       actor,
       "",
       {}},
  };
}

Benchmark DevelopersShelf() {
  Benchmark shelf;
  shelf.set = BenchmarkSet::kShelf;
  shelf.ground_truth = ShelfReal().ground_truth;
  shelf.recordings = {RecordingOf(ShelfReal(), ShelfMethods()),
                      RecordingOf(ShelfFilled(), FilledShelfMethods())};
  shelf.results = ShelfResults();
  for (const size_t row : {2, 3}) {
    shelf.own_rules.push_back(
        {shelf.results[row], "shelf/raw/gt.txt", FourDAssociationProtocol(),
         "one-to-one by 14 joints and the middle of the hips, its own head, "
         "strictly less than half the length, unmatched actors skipped, stored "
         "zeros as they are"});
  }
  shelf.single_person = ShelfSinglePersonResults();
  return shelf;
}

Benchmark DevelopersCampus() {
  Benchmark campus;
  campus.set = BenchmarkSet::kCampus;
  campus.ground_truth = CampusModelled("clean").ground_truth;
  for (const char* level : {"clean", "typical", "hard"}) {
    campus.recordings.push_back(
        RecordingOf(CampusModelled(level), CampusMethods()));
  }
  campus.results = {{"Chen et al., their published tracks",
                     "campus/result_3d.json",
                     "Chen et al.'s own detections, which are not public",
                     "its head conversion was tuned on this set",
                     {}}};
  return campus;
}

// The first of `names` that is in `folder` (relative to `root`), with its path
// relative to `root`.
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

// The place of a calibration: a file by itself, or the folder of P0.txt.
std::optional<std::string> FindCalibration(const std::string& root,
                                           const std::string& folder) {
  for (const char* name : {"", "Calibration", "calibration"}) {
    const auto sub = FirstOf(root, folder, {name});
    if (sub && FirstOf(root, *sub, {"P0.txt"})) return sub;
  }
  return FirstOf(root, folder,
                 {"cameras.json", "calibration.json", "Calib.toml"});
}

// An official download (docs/official_data.md); nullopt when none of the
// folders' names is there.
std::optional<Benchmark> OfficialSet(const std::string& root, BenchmarkSet set,
                                     const std::vector<std::string>& names) {
  const auto folder = FirstOf(root, "", names);
  if (!folder) return std::nullopt;
  const auto truth = FirstOf(root, *folder, {"actorsGT.mat"});
  if (!truth) return std::nullopt;
  const auto cameras = FindCalibration(root, *folder);
  if (!cameras) {
    throw InputError(root + "/" + *folder, "",
                     "no calibration: expected P0.txt, P1.txt, ... there or in "
                     "Calibration/, or calibration.json, cameras.json or "
                     "Calib.toml");
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
  Dataset dataset;
  dataset.name = shelf ? "Shelf" : "Campus";
  dataset.detections_note =
      "yours, in " + *detections + "; what made them is yours to say";
  dataset.cameras = *cameras;
  dataset.detections = *detections;
  dataset.ground_truth = *truth;
  // Three frames before the first that is scored, as the authors run it.
  dataset.frames = shelf ? std::vector<FrameRange>{{297, 601}}
                         : std::vector<FrameRange>{{347, 751}};
  dataset.protocol = shelf ? ShelfProtocol() : CampusProtocol();
  std::vector<Method> methods = shelf ? ShelfMethods() : CampusMethods();
  // The frames before the first are there; nothing is to be repeated.
  methods.erase(std::remove_if(methods.begin(), methods.end(),
                               [](const Method& method) {
                                 return method.name ==
                                        "paper mode, text, warmed up";
                               }),
                methods.end());
  for (Method& method : methods) {
    if (method.set == kWarmUp) method.set.clear();
  }
  Benchmark benchmark;
  benchmark.set = set;
  benchmark.ground_truth = *truth;
  benchmark.recordings = {RecordingOf(std::move(dataset), std::move(methods))};
  return benchmark;
}

}  // namespace

BenchmarkData FindBenchmarks(const std::string& data_folder) {
  BenchmarkData data;
  data.folder = data_folder;
  if (IsFile(data_folder + "/" + ShelfReal().ground_truth)) {
    data.benchmarks.push_back(DevelopersShelf());
  } else if (auto shelf = OfficialSet(data_folder, BenchmarkSet::kShelf,
                                      {"shelf", "Shelf"})) {
    data.benchmarks.push_back(*std::move(shelf));
  }
  if (IsFile(data_folder + "/" + CampusModelled("clean").ground_truth)) {
    data.benchmarks.push_back(DevelopersCampus());
  } else if (auto campus = OfficialSet(
                 data_folder, BenchmarkSet::kCampus,
                 {"campus", "Campus", "CampusSeq1", "Campus_Seq1"})) {
    data.benchmarks.push_back(*std::move(campus));
  }
  if (data.benchmarks.empty()) {
    throw InputError(data_folder, "",
                     "neither the developers' data (shelf/tum/actorsGT.mat, "
                     "campus/annotation_3d.json) nor official downloads "
                     "(shelf/actorsGT.mat, campus/actorsGT.mat; "
                     "docs/official_data.md)");
  }
  return data;
}

}  // namespace kinegraph
