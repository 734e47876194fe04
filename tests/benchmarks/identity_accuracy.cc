// Who is who on synthetic scenes: people who cross, are hidden, leave and come
// back. Prints Markdown: paper mode, graph mode without and with linking
// (core/identity/linking.h), and the tracklets of graph mode joined by truth,
// which is the most that linking alone could reach.
//
//   build/tests/benchmarks/identity_accuracy [SCENE [FIRST_SEED [SEEDS]]]
//
// SCENE is a name of the table below (default: all). Identities depend on the
// front end alone, so the poses are the causal Gaussian's, which is fast; what
// the batch adds to the evidence is not in here.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "apps/common/config_folder.h"
#include "apps/common/synthesis.h"
#include "core/base/random.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/identity.h"
#include "core/identity/edits.h"
#include "core/identity/linking.h"
#include "solvers/session/run.h"

namespace kinegraph {
namespace {

struct Layout {
  const char* name;
  int people;
  int cameras;
  double rate_hz;
  double area_radius_m;
  double hidden_s;  // 0: only as people hide one another
};

constexpr Layout kLayouts[] = {
    {"8_people_8_cameras_50hz", 8, 8, 50.0, 3.0, 0.0},
    {"8_people_5_cameras", 8, 5, 25.0, 3.0, 0.0},
    {"6_people_5_cameras_120hz", 6, 5, 120.0, 3.0, 0.0},
    {"6_people_5_cameras_hidden_0.2s", 6, 5, 25.0, 3.0, 0.2},
    {"6_people_5_cameras_hidden_1s", 6, 5, 25.0, 3.0, 1.0},
    {"6_people_5_cameras_hidden_5s", 6, 5, 25.0, 3.0, 5.0},
    {"4_people_3_cameras", 4, 3, 25.0, 2.5, 0.0},
    {"2_people_2_cameras", 2, 2, 25.0, 2.0, 0.0},
};

constexpr double kDuration = 30.0;  // s
constexpr double kGateM = 0.5;
constexpr double kLasting = 1.0;  // s, an exchange that lasts

std::string Overrides(const Layout& layout, int seed) {
  const auto number = [](double value) { return std::to_string(value); };
  return "scene.people=" + std::to_string(layout.people) +
         ";scene.cameras.count=" + std::to_string(layout.cameras) +
         ";scene.frame_rate=" + number(layout.rate_hz) +
         ";scene.duration=" + number(kDuration) +
         ";scene.motion.area_radius=" + number(layout.area_radius_m) +
         ";scene.seed=" + std::to_string(seed) +
         ";noise.seed=" + std::to_string(1000 + seed);
}

// Hides each person once for `hidden_s` in all views, at a moment of their own.
void Hide(const Layout& layout, int seed, SyntheticTake* take) {
  if (layout.hidden_s == 0.0) return;
  Random random(static_cast<uint64_t>(seed));
  const auto count = static_cast<int64_t>(take->detections.frames.size());
  const auto length =
      static_cast<int64_t>(std::llround(layout.hidden_s * layout.rate_hz));
  for (int person = 0; person < layout.people; ++person) {
    const int64_t margin = count / 6;
    const int64_t begin = margin + random.Index(std::max<int64_t>(
                                       1, count - 2 * margin - length));
    for (int64_t f = begin; f < std::min(count, begin + length); ++f) {
      DetectionFrame& frame = take->detections.frames[static_cast<size_t>(f)];
      for (size_t v = 0; v < frame.views.size(); ++v) {
        auto& truth = take->labels.frames[static_cast<size_t>(f)][v];
        auto& detections = frame.views[v].detections;
        for (size_t d = detections.size(); d-- > 0;) {
          if (truth[d].person != person) continue;
          detections.erase(detections.begin() + static_cast<long>(d));
          truth.erase(truth.begin() + static_cast<long>(d));
        }
      }
    }
  }
}

// The true person that each identity is in each frame.
class TrueNames {
 public:
  TrueNames(const TrackSequence& truth, const TrackSequence& tracks)
      : joints_(CommonJoints(truth.header.skeleton, tracks.header.skeleton)) {
    for (const PersonPair& pair :
         PairPeople(truth, tracks, joints_, kGateM, {})) {
      if (pair.found == nullptr) continue;
      names_[pair.found->id].push_back({pair.frame, pair.truth->id});
    }
  }

  // The one that an identity is most often; -1 for nobody.
  TrackId Of(TrackId identity) const {
    std::map<TrackId, int> votes;
    const auto at = names_.find(identity);
    if (at == names_.end()) return TrackId();
    for (const auto& [frame, name] : at->second) ++votes[name];
    TrackId best;
    int most = 0;
    for (const auto& [name, count] : votes) {
      if (count > most) {
        most = count;
        best = name;
      }
    }
    return best;
  }

  const std::map<TrackId, std::vector<std::pair<int64_t, TrackId>>>& names()
      const {
    return names_;
  }

 private:
  JointPairs joints_;
  std::map<TrackId, std::vector<std::pair<int64_t, TrackId>>> names_;
};

// Identities that are one true person for kLasting and then another for as
// long.
int LastingExchanges(const TrueNames& names, double rate_hz) {
  const auto lasting = static_cast<int64_t>(kLasting * rate_hz);
  int exchanges = 0;
  for (const auto& [identity, frames] : names.names()) {
    TrackId settled;
    TrackId current;
    int64_t run = 0;
    for (const auto& [frame, name] : frames) {
      run = name == current ? run + 1 : 1;
      current = name;
      if (run != lasting) continue;
      if (settled.value() >= 0 && settled != name) ++exchanges;
      settled = name;
    }
  }
  return exchanges;
}

TrackSequence JoinedByTruth(const TrackSequence& truth,
                            const TrackSequence& tracks) {
  const TrueNames names(truth, tracks);
  TrackSequence joined = tracks;
  for (TrackFrame& frame : joined.frames) {
    std::map<TrackId, int> count;
    for (PersonPose& person : frame.people) {
      const TrackId name = names.Of(person.id);
      person.id =
          name.value() >= 0 ? name : TrackId(1'000'000 + person.id.value());
      // Two tracks of one person at once: the later is somebody of their own.
      if (count[person.id]++ > 0) {
        person.id = TrackId(2'000'000 + person.id.value());
      }
    }
  }
  return joined;
}

struct Row {
  IdentityResult counts;  // summed
  double hota = 0.0;      // summed over seeds
  int seeds = 0;
  int exchanges = 0;

  void Add(const TrackSequence& truth, const TrackSequence& tracks) {
    const IdentityResult result = EvaluateIdentity(truth, tracks);
    counts.true_person_frames += result.true_person_frames;
    counts.found_person_frames += result.found_person_frames;
    counts.misses += result.misses;
    counts.false_positives += result.false_positives;
    counts.switches += result.switches;
    counts.identity_true_positives += result.identity_true_positives;
    hota += result.Hota().hota;
    ++seeds;
    exchanges +=
        LastingExchanges(TrueNames(truth, tracks), truth.header.frame_rate_hz);
  }
  void Print(const char* scene, const char* name, const std::string& joins) {
    std::printf("| %s | %s | %d | %.2f | %.2f | %.2f | %lld | %d | %s |\n",
                scene, name, seeds, 100.0 * counts.Idf1(), 100.0 * hota / seeds,
                100.0 * counts.Mota(), static_cast<long long>(counts.switches),
                exchanges, joins.c_str());
    std::fflush(stdout);
  }
};

// Joins of two tracks that are two people.
struct Joins {
  int made = 0;
  int wrong = 0;

  void Count(const TrackSequence& truth, TrackSequence tracks,
             const std::vector<IdentityEdit>& edits) {
    for (IdentityEdit edit : edits) {
      if (edit.op == EditOp::kJoin) {
        const TrueNames names(truth, tracks);
        const auto& all = names.names();
        const auto one = all.find(edit.persons[0]);
        const auto other = all.find(edit.persons[1]);
        ++made;
        if (one != all.end() && other != all.end()) {
          // Who each was at the join.
          TrackId before;
          for (const auto& [frame, name] : one->second) {
            if (frame <= edit.frames->first) before = name;
          }
          TrackId after;
          for (const auto& [frame, name] : other->second) {
            if (frame < edit.frames->last) continue;
            after = name;
            break;
          }
          const bool known = before.value() >= 0 && after.value() >= 0;
          if (known && before != after) ++wrong;
        }
      }
      ApplyEdit(&edit, &tracks.frames);
    }
  }
};

int Main(const std::string& only, int first_seed, int seeds) {
  std::printf(
      "| scene | mode | n | IDF1, %% | HOTA, %% | MOTA, %% | switches | "
      "lasting "
      "exchanges | joins, wrong |\n|---|---|---|---|---|---|---|---|---|\n");
  const RunOptions paper =
      ReadRunOptions(ProjectConfig("synthetic/track_paper.toml"), "", "");
  const RunOptions graph = ReadRunOptions(
      ProjectConfig("synthetic/track_batch.toml"),
      "output.estimator=gaussian;tracking.second_pass=false", "");
  for (const Layout& layout : kLayouts) {
    if (!only.empty() && only != layout.name) continue;
    Row of_paper;
    Row of_graph;
    Row linked;
    Row by_truth;
    Joins joins;
    for (int seed = first_seed; seed < first_seed + seeds; ++seed) {
      SyntheticTake take = MakeTake(ProjectConfig("synthetic/demo.toml"),
                                    Overrides(layout, seed));
      Hide(layout, seed, &take);
      RunRequest request;
      request.cameras = take.scene.cameras;
      of_paper.Add(take.truth,
                   TrackSequenceOf(paper, request, take.detections));
      const TrackSequence tracks =
          TrackSequenceOf(graph, request, take.detections);
      of_graph.Add(take.truth, tracks);
      by_truth.Add(take.truth, JoinedByTruth(take.truth, tracks));
      TrackSequence result = tracks;
      const std::vector<IdentityEdit> edits =
          LinkIdentities(tracks.header.skeleton, tracks.header.frame_rate_hz,
                         LinkOptions(), &result.frames);
      linked.Add(take.truth, result);
      joins.Count(take.truth, tracks, edits);
    }
    of_paper.Print(layout.name, "paper", "");
    of_graph.Print(layout.name, "graph", "");
    linked.Print(
        layout.name, "graph, linked",
        std::to_string(joins.made) + ", " + std::to_string(joins.wrong));
    by_truth.Print(layout.name, "graph, joined by truth", "");
  }
  return 0;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::Main(argc > 1 ? argv[1] : "",
                         argc > 2 ? std::atoi(argv[2]) : 1,
                         argc > 3 ? std::atoi(argv[3]) : 2);
}
