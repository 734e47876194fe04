// Chooses the graph's parameters on the real Shelf take by held-out cameras,
// in two folds of frames: what is chosen on one fold is scored on the other.
// Prints Markdown.
//
//   build/tests/benchmarks/fold_accuracy [bones]
//
// The whole offline pipeline, at fixed noise and solved by sweeps
// (configs/benchmark/offline.toml), runs once without each camera for every
// candidate; without "bones" the candidates are scored without bone lengths, in
// a tenth of the time. Where noise is learnt from the take most of these
// parameters mean nothing.
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "core/base/frame_range.h"
#include "core/evaluation/held_out.h"
#include "tests/support/shelf.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

// Shelf's folds; the second between them (25 frames) belongs to neither.
struct Fold {
  int64_t first = 0;
  int64_t last = 0;
};
constexpr Fold kFolds[] = {{300, 437}, {463, 600}};

struct Candidate {
  double process_noise = 1.0;  // times the defaults in code
  double loss_scale = 3.0;     // sigmas
  double confidence_power = 0.5;
  double bone_sigma_m = 0.02;
};

std::string NameOf(const Candidate& c, bool bones) {
  char text[128];
  std::snprintf(text, sizeof(text), "%.2g | %.2g | %.2g%s", c.process_noise,
                c.loss_scale, c.confidence_power, bones ? " | " : "");
  std::string name = text;
  if (bones) {
    std::snprintf(text, sizeof(text), "%.3g", c.bone_sigma_m);
    name += text;
  }
  return name;
}

HeldOutScores InFold(const HeldOutScores& scores, const Fold& fold) {
  HeldOutScores part;
  std::vector<size_t> place(scores.people.size(), scores.people.size());
  for (size_t i = 0; i < scores.people.size(); ++i) {
    const int64_t frame = scores.people[i].frame;
    if (frame < fold.first || frame > fold.last) continue;
    place[i] = part.people.size();
    part.people.push_back(scores.people[i]);
  }
  for (HeldOutJoint joint : scores.joints) {
    if (place[joint.person_idx] == scores.people.size()) continue;
    joint.person_idx = place[joint.person_idx];
    part.joints.push_back(joint);
  }
  return part;
}

void Append(const HeldOutScores& part, HeldOutScores* all) {
  const size_t offset = all->people.size();
  all->people.insert(all->people.end(), part.people.begin(), part.people.end());
  for (HeldOutJoint joint : part.joints) {
    joint.person_idx += offset;
    all->joints.push_back(joint);
  }
}

double MeanOf(const HeldOutScores& scores) {
  return SummariseHeldOut(scores, AllJoints(), {25, 1, 0.95, 1})
      .figure_px(HeldOutFigure::kMeanTruncated);
}

HeldOutScores ScoreCandidate(const testing::ShelfTake& take,
                             const Candidate& candidate, bool bones) {
  RunOptions options =
      ReadRunOptions(ProjectConfig("benchmark/offline.toml"), "", "");
  GraphOptions& graph = options.estimators.graph;
  const GraphOptions defaults;
  for (size_t i = 0; i < graph.process_noise.size(); ++i) {
    graph.process_noise[i] =
        candidate.process_noise * defaults.process_noise[i];
  }
  graph.loss_scale = candidate.loss_scale;
  graph.confidence_power = candidate.confidence_power;
  graph.bones = bones;
  graph.bone_sigma_m = candidate.bone_sigma_m;
  graph.covariance = false;
  return testing::ScoreHeldOutCameras(take, options);
}

std::vector<Candidate> Candidates(bool bones) {
  std::vector<Candidate> candidates;
  for (const double q : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    for (const double c : {2.0, 2.5, 3.0, 4.0}) {
      for (const double power : {0.5, 1.0}) {
        candidates.push_back({q, c, power, 0.02});
      }
    }
  }
  if (!bones) return candidates;
  candidates.clear();
  for (const double q : {0.5, 1.0, 2.0}) {
    for (const double bone : {0.01, 0.02, 0.04}) {
      candidates.push_back({q, 3.0, 0.5, bone});
    }
  }
  return candidates;
}

int Main(bool bones) {
  const auto data = testing::FindData("shelf");
  if (!data.has_value()) {
    std::fprintf(stderr, "needs real data (set KINEGRAPH_DATA)\n");
    return 1;
  }
  const testing::ShelfTake take =
      testing::LoadRawShelf(data->parent_path().string());
  const HeldOutScores paper = testing::ScoreHeldOutCameras(
      take, ReadRunOptions(ProjectConfig("paper/shelf.toml"), "", ""));
  const std::vector<Candidate> candidates = Candidates(bones);
  std::printf(
      "| process noise | loss scale | confidence power |%s first fold "
      "| second fold |\n",
      bones ? " bone sigma, m |" : "");
  std::vector<HeldOutScores> scores[2];
  size_t best[2] = {0, 0};
  for (size_t i = 0; i < candidates.size(); ++i) {
    const HeldOutScores all = ScoreCandidate(take, candidates[i], bones);
    double mean[2];
    for (int fold = 0; fold < 2; ++fold) {
      scores[fold].push_back(InFold(all, kFolds[fold]));
      mean[fold] = MeanOf(scores[fold].back());
      if (mean[fold] < MeanOf(scores[fold][best[fold]])) best[fold] = i;
    }
    std::printf("| %s | %.3f | %.3f |\n", NameOf(candidates[i], bones).c_str(),
                mean[0], mean[1]);
    std::fflush(stdout);
  }
  HeldOutScores crossed;
  HeldOutScores same;
  HeldOutScores baseline;
  for (int fold = 0; fold < 2; ++fold) {
    std::printf("best on fold %d: %s\n", fold + 1,
                NameOf(candidates[best[fold]], bones).c_str());
    Append(scores[fold][best[1 - fold]], &crossed);
    Append(scores[fold][best[fold]], &same);
    Append(InFold(paper, kFolds[fold]), &baseline);
  }
  for (const HeldOutFigure figure :
       {HeldOutFigure::kMeanTruncated, HeldOutFigure::kP90}) {
    const Interval ratio = HeldOutRatioInterval(crossed, baseline, figure);
    const auto value = [figure](const HeldOutScores& of) {
      return SummariseHeldOut(of, AllJoints(), {25, 1, 0.95, 1})
          .figure_px(figure);
    };
    std::printf(
        "%s: paper %.3f, chosen on the other fold %.3f (ratio %.3f [%.3f, "
        "%.3f]), on the same fold %.3f\n",
        figure == HeldOutFigure::kP90 ? "90th percentile, px"
                                      : "mean of min(error, 30), px",
        value(baseline), value(crossed), value(crossed) / value(baseline),
        ratio.low, ratio.high, value(same));
  }
  return 0;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::Main(argc > 1 && std::strcmp(argv[1], "bones") == 0);
}
