// Accuracy of identities on synthetic scenes: people who cross, are hidden,
// leave and return, and recorded clips placed in one room. Prints a Markdown
// table for paper mode, graph mode without and with linking
// (core/identity/linking.h), and the tracks of graph mode joined by the
// truth, which is the best that linking alone could reach.
//
//   identity_accuracy [--scenes=A,B] [--seeds=FIRST:END] [--set=KEY=VALUE;...]
//     [--scene=KEY=VALUE;...] [--second_pass] [--linking_only] [--details]
//     [--lines=FILE] [--tracks=FOLDER] [--json=FILE]
//   identity_accuracy --table=FILE [--json=FILE]
//
// A scene is a name in kLayouts, or the common beginning of several names such
// as "6p_5c"; default: all. END is not included; the default is 1:2, one seed.
// The counts of each recording are appended to FILE of --lines, and --table
// sums all lines of such a file, so that a long table can be computed in parts.
// --json also writes the figures to a file. --set changes the options of graph
// mode, which runs configs/offline.toml with the block-tridiagonal solver;
// --scene changes the simulation (scene.stature_sigma=0: all people have the
// same height).
// --second_pass also scores the tracks that `track` would write with linking
// and a second pass; --linking_only omits paper mode. --details lists each
// change of identities with the true people before and after it. --tracks
// stores the tracks of graph mode and reuses existing ones, to repeat linking
// quickly.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "apps/common/synthesis.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/identity.h"
#include "core/identity/edits.h"
#include "core/identity/linking.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "solvers/session/run.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

struct Layout {
  const char* name;
  int people;
  int cameras;
  double rate_hz;
  double area_radius_m;
  bool clips;  // recorded motion
};

constexpr Layout kLayouts[] = {
    {"8p_8c_25hz", 8, 8, 25.0, 3.0, false},
    {"8p_8c_50hz", 8, 8, 50.0, 3.0, false},
    {"8p_8c_120hz", 8, 8, 120.0, 3.0, false},
    {"8p_5c_25hz", 8, 5, 25.0, 3.0, false},
    {"8p_5c_50hz", 8, 5, 50.0, 3.0, false},
    {"8p_5c_120hz", 8, 5, 120.0, 3.0, false},
    {"6p_5c_25hz", 6, 5, 25.0, 3.0, false},
    {"6p_5c_50hz", 6, 5, 50.0, 3.0, false},
    {"6p_5c_120hz", 6, 5, 120.0, 3.0, false},
    {"4p_3c_25hz", 4, 3, 25.0, 2.5, false},
    {"4p_3c_50hz", 4, 3, 50.0, 2.5, false},
    {"4p_3c_120hz", 4, 3, 120.0, 2.5, false},
    {"2p_2c_25hz", 2, 2, 25.0, 2.0, false},
    {"2p_2c_50hz", 2, 2, 50.0, 2.0, false},
    {"2p_2c_120hz", 2, 2, 120.0, 2.0, false},
    {"clips_5c_25hz", 4, 5, 25.0, 3.0, true},
    {"clips_5c_50hz", 4, 5, 50.0, 3.0, true},
    {"clips_5c_120hz", 4, 5, 120.0, 3.0, true},
};
const char* const kClips[] = {"dance_30hz", "start_hop_stop_120hz",
                              "start_walk_stop_120hz", "hop_30hz"};

// Recordings at 120 Hz are shorter, to save time.
double DurationS(const Layout& layout) {
  return layout.rate_hz > 100.0 ? 20.0 : 30.0;
}
constexpr double kGateM = 0.5;
constexpr double kLasting =
    1.0;  // s, minimum duration of a persistent exchange
// Joins with a smaller margin are counted separately: at least one in 14 of
// them is expected to be wrong.
constexpr double kClose = 2.5;  // nats
// Each person is hidden once, for one of these durations.
constexpr double kHidden[] = {0.2, 0.5, 1.0, 2.0, 5.0};  // s
// Clips last only 5 to 15 s.
constexpr double kHiddenClips[] = {0.2, 0.5, 1.0, 2.0};  // s
// Two people meet when their centres are closer than kMeet, and part when they
// are farther apart than kPart [m].
constexpr double kMeet = 0.7;
constexpr double kPart = 1.2;

std::string Overrides(const Layout& layout, int seed, double rate_hz,
                      double duration_s) {
  const auto number = [](double value) { return std::to_string(value); };
  std::string set =
      "scene.cameras.count=" + std::to_string(layout.cameras) +
      ";scene.frame_rate=" + number(rate_hz) +
      ";scene.motion.area_radius=" + number(layout.area_radius_m) +
      ";scene.seed=" + std::to_string(seed) +
      ";noise.seed=" + std::to_string(1000 + seed);
  if (layout.clips) return set + ";motion.start=[0.0, 1.0, 2.0, 3.0]";
  return set + ";scene.people=" + std::to_string(layout.people) +
         ";scene.duration=" + number(duration_s);
}

// Removes one person's detections from a frame, and marks the true joints as
// inferred.
void HideIn(size_t f, int person, SyntheticRecording* recording) {
  DetectionFrame& frame = recording->detections.frames[f];
  for (size_t v = 0; v < frame.views.size(); ++v) {
    auto& truth = recording->labels.frames[f][v];
    auto& detections = frame.views[v].detections;
    for (size_t d = detections.size(); d-- > 0;) {
      if (truth[d].person != person) continue;
      detections.erase(detections.begin() + static_cast<long>(d));
      truth.erase(truth.begin() + static_cast<long>(d));
    }
  }
  for (PersonPose& pose : recording->truth.frames[f].people) {
    if (pose.id.value() != person) continue;
    for (Joint3d& joint : pose.joints) joint.status = JointStatus::kInferred;
  }
}

// Hides each person once in all views, at different times.
void Hide(const Layout& layout, int seed, SyntheticRecording* recording) {
  Random random(static_cast<uint64_t>(seed));
  for (int person = 0; person < layout.people; ++person) {
    std::vector<size_t> there;  // frames
    for (size_t f = 0; f < recording->truth.frames.size(); ++f) {
      for (const PersonPose& pose : recording->truth.frames[f].people) {
        if (pose.id.value() == person) there.push_back(f);
      }
    }
    const auto which = static_cast<size_t>(person + seed);
    const double hidden_s = layout.clips
                                ? kHiddenClips[which % std::size(kHiddenClips)]
                                : kHidden[which % std::size(kHidden)];
    const auto length =
        static_cast<int64_t>(std::llround(hidden_s * layout.rate_hz));
    const auto count = static_cast<int64_t>(there.size());
    // The person is visible for a second before and after.
    const auto margin = static_cast<int64_t>(layout.rate_hz);
    const int64_t room = count - 2 * margin - length;
    if (room < 1) continue;
    const int64_t begin = margin + random.Index(room);
    for (int64_t k = begin; k < begin + length; ++k) {
      HideIn(there[static_cast<size_t>(k)], person, recording);
    }
  }
}

// Number of encounters of two people.
int Encounters(const TrackSequence& truth) {
  std::set<std::pair<TrackId, TrackId>> together;
  int count = 0;
  for (const TrackFrame& frame : truth.frames) {
    for (const PersonPose& a : frame.people) {
      for (const PersonPose& b : frame.people) {
        if (!(a.id < b.id)) continue;
        const auto at_a = MeanPosition(a.joints);
        const auto at_b = MeanPosition(b.joints);
        if (!at_a.has_value() || !at_b.has_value()) continue;
        const double distance_m =
            (*at_a - *at_b).head<2>().norm();  // on the floor
        if (distance_m > kPart) together.erase({a.id, b.id});
        if (distance_m < kMeet && together.insert({a.id, b.id}).second) {
          ++count;
        }
      }
    }
  }
  return count;
}

// Stores the true person of each pose in its score (-1: unmatched), which edits
// of identities do not change.
void MarkTruth(const TrackSequence& truth, TrackSequence* tracks) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks->header.skeleton);
  std::map<const PersonPose*, double> names;
  for (const PersonPair& pair :
       PairPeople(truth, *tracks, joints, kGateM, {})) {
    if (pair.found == nullptr) continue;
    names[pair.found] = static_cast<double>(pair.truth->id.value());
  }
  for (TrackFrame& frame : tracks->frames) {
    for (PersonPose& person : frame.people) {
      const auto name = names.find(&person);
      person.score = name == names.end() ? -1.0 : name->second;
    }
  }
}

// The true person of each identity, by frame.
class TrueNames {
 public:
  // From tracks marked by MarkTruth.
  explicit TrueNames(const TrackSequence& marked) {
    for (const TrackFrame& frame : marked.frames) {
      for (const PersonPose& person : frame.people) {
        if (person.score < 0.0) continue;
        names_[person.id].push_back(
            {frame.frame, TrackId(static_cast<int64_t>(person.score))});
      }
    }
  }
  TrueNames(const TrackSequence& truth, const TrackSequence& tracks)
      : joints_(CommonJoints(truth.header.skeleton, tracks.header.skeleton)) {
    for (const PersonPair& pair :
         PairPeople(truth, tracks, joints_, kGateM, {})) {
      if (pair.found == nullptr) continue;
      names_[pair.found->id].push_back({pair.frame, pair.truth->id});
    }
  }

  // The most frequent true person of an identity; -1 if unmatched.
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

// Number of times that an identity belongs to one true person for kLasting and
// then to another one for as long, in matched frames.
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
      // Of two simultaneous tracks of one person, the second gets an identity
      // of its own.
      if (count[person.id]++ > 0) {
        person.id = TrackId(2'000'000 + person.id.value());
      }
    }
  }
  return joined;
}

// Counts of one recording, or sums over several.
struct Counts {
  double recordings = 0.0;
  double true_frames = 0.0;
  double found_frames = 0.0;
  double right = 0.0;  // identity true positives
  double misses = 0.0;
  double false_positives = 0.0;
  double switches = 0.0;
  double hota = 0.0;  // summed over recordings
  double exchanges = 0.0;
  double encounters = 0.0;
  double joins = 0.0;
  double wrong_joins = 0.0;
  double close_joins = 0.0;
  double wrong_close_joins = 0.0;

  std::vector<double*> All() {
    return {&recordings,  &true_frames,      &found_frames,    &right,
            &misses,      &switches,         &false_positives, &hota,
            &exchanges,   &encounters,       &joins,           &wrong_joins,
            &close_joins, &wrong_close_joins};
  }
  double Idf1() const { return 2.0 * right / (true_frames + found_frames); }
  double Mota() const {
    return 1.0 - (misses + false_positives + switches) / true_frames;
  }
};

Counts CountsOf(const TrackSequence& truth, const TrackSequence& tracks) {
  const IdentityResult result = EvaluateIdentity(truth, tracks);
  const auto number = [](int64_t value) { return static_cast<double>(value); };
  Counts counts;
  counts.recordings = 1.0;
  counts.true_frames = number(result.true_person_frames);
  counts.found_frames = number(result.found_person_frames);
  counts.right = number(result.identity_true_positives);
  counts.misses = number(result.misses);
  counts.false_positives = number(result.false_positives);
  counts.switches = number(result.switches);
  counts.hota = result.Hota().hota;
  counts.exchanges =
      LastingExchanges(TrueNames(truth, tracks), truth.header.frame_rate_hz);
  counts.encounters = Encounters(truth);
  return counts;
}

// The most frequent true person of an identity in the last second of its
// matched frames up to `frame` or, with `after`, in the first second from
// `frame` on. A single frame would not do: frames next to a gap are often
// unmatched.
TrackId NameAt(const TrueNames& names, TrackId id, int64_t frame, bool after,
               double rate_hz) {
  const auto all = names.names().find(id);
  if (all == names.names().end()) return TrackId();
  std::vector<TrackId> near;
  for (const auto& [at, name] : all->second) {
    if (after ? at >= frame : at <= frame) near.push_back(name);
  }
  if (!after) std::reverse(near.begin(), near.end());
  near.resize(std::min(near.size(), static_cast<size_t>(rate_hz)));
  std::map<TrackId, int> votes;
  TrackId most;
  for (const TrackId name : near) {
    if (++votes[name] > votes[most]) most = name;
  }
  return most;
}

// Counts joins, those of tracks of different people, and those with a margin
// below kClose; with `details`, prints each edit.
void CountJoins(const TrackSequence& truth, TrackSequence tracks,
                const std::vector<IdentityEdit>& edits, bool details,
                Counts* counts) {
  const double rate_hz = truth.header.frame_rate_hz;
  MarkTruth(truth, &tracks);
  for (IdentityEdit edit : edits) {
    const bool links =
        edit.op == EditOp::kJoin || edit.op == EditOp::kUndecided;
    if (links || details) {
      const TrueNames names(tracks);
      const TrackId before =
          NameAt(names, edit.persons[0], edit.frames->first, false, rate_hz);
      const TrackId after =
          NameAt(names, edit.persons.back(), edit.frames->last, true, rate_hz);
      const bool known = before.value() >= 0 && after.value() >= 0;
      if (edit.op == EditOp::kJoin) {
        const double wrong = known && before != after ? 1.0 : 0.0;
        const double close = edit.margin.value_or(0.0) < kClose ? 1.0 : 0.0;
        counts->joins += 1.0;
        counts->wrong_joins += wrong;
        counts->close_joins += close;
        counts->wrong_close_joins += close * wrong;
      }
      if (details) {
        std::printf(
            "#   %s %lld %lld [%lld, %lld] truth %lld %lld margin %.2f",
            ToString(edit.op), static_cast<long long>(edit.persons[0].value()),
            static_cast<long long>(edit.persons.back().value()),
            static_cast<long long>(edit.frames->first),
            static_cast<long long>(edit.frames->last),
            static_cast<long long>(before.value()),
            static_cast<long long>(after.value()), edit.margin.value_or(0.0));
        for (const auto& [key, value] : edit.evidence) {
          std::printf(" %s %.3f", key.c_str(), value);
        }
        std::printf("\n");
      }
    }
    ApplyEdit(&edit, &tracks.frames);
  }
}

// Prints the tracks of each true person as IDENTITY:FIRST-LAST frame; a track
// with a gap of more than 0.2 s is printed in pieces.
void PrintPieces(const char* mode, const TrackSequence& truth,
                 const TrackSequence& tracks) {
  const TrueNames names(truth, tracks);
  std::map<TrackId, std::vector<std::string>> of;
  for (const auto& [id, frames] : names.names()) {
    size_t begin = 0;
    for (size_t k = 0; k <= frames.size(); ++k) {
      const bool ends = k == frames.size() ||
                        frames[k].second != frames[begin].second ||
                        frames[k].first > frames[k > 0 ? k - 1 : 0].first +
                                              0.2 * truth.header.frame_rate_hz;
      if (!ends || k == begin) continue;
      std::ostringstream text;
      text << id.value() << ":" << frames[begin].first << "-"
           << frames[k - 1].first;
      of[frames[begin].second].push_back(text.str());
      begin = k;
    }
  }
  for (const auto& [name, pieces] : of) {
    std::printf("#   %s true %lld:", mode,
                static_cast<long long>(name.value()));
    for (const std::string& piece : pieces) std::printf(" %s", piece.c_str());
    std::printf("\n");
  }
}

using Key = std::pair<std::string, std::string>;  // scene, mode

const char* const kModes[] = {"paper", "graph", "graph, linked",
                              "graph, joined by truth",
                              "graph, linked, second pass"};

void PrintTable(std::map<Key, Counts> table) {
  std::printf(
      "| scene | mode | recordings | IDF1, %% | HOTA, %% | MOTA, %% | switches "
      "| encounters | persistent exchanges | joins, wrong |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Layout& layout : kLayouts) {
    for (const char* mode : kModes) {
      const auto at = table.find({layout.name, mode});
      if (at == table.end()) continue;
      const Counts& c = at->second;
      std::printf(
          "| %s | %s | %.0f | %.2f | %.2f | %.2f | %.0f | %.0f | %.0f |",
          layout.name, mode, c.recordings, 100.0 * c.Idf1(),
          100.0 * c.hota / c.recordings, 100.0 * c.Mota(), c.switches,
          c.encounters, c.exchanges);
      if (std::strcmp(mode, "graph, linked") == 0) {
        std::printf(" %.0f, %.0f |\n", c.joins, c.wrong_joins);
      } else {
        std::printf(" |\n");
      }
    }
  }
}

// Writes the figures of the table except the switches; also the close joins.
void WriteJson(const std::string& path, std::map<Key, Counts> table) {
  std::ofstream file(path);
  file.precision(8);
  file << "{";
  const char* comma = "";
  for (auto& [key, c] : table) {
    file << comma << "\n \"" << key.first << ": " << key.second
         << "\": {\"takes\": " << c.recordings
         << ", \"idf1\": " << 100.0 * c.Idf1()
         << ", \"hota\": " << 100.0 * c.hota / c.recordings
         << ", \"mota\": " << 100.0 * c.Mota()
         << ", \"encounters\": " << c.encounters
         << ", \"exchanges\": " << c.exchanges << ", \"joins\": " << c.joins
         << ", \"wrong_joins\": " << c.wrong_joins
         << ", \"close_joins\": " << c.close_joins
         << ", \"wrong_close_joins\": " << c.wrong_close_joins << "}";
    comma = ",";
  }
  file << "\n}\n";
}

std::map<Key, Counts> ReadLines(const std::string& path) {
  std::map<Key, Counts> table;
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string scene, seed, mode;
    std::getline(fields, scene, '\t');
    std::getline(fields, seed, '\t');
    std::getline(fields, mode, '\t');
    Counts one;
    for (double* value : one.All()) fields >> *value;
    Counts& sum = table[{scene, mode}];
    const std::vector<double*> to = sum.All();
    for (size_t i = 0; i < to.size(); ++i) *to[i] += *one.All()[i];
  }
  return table;
}

struct Arguments {
  std::vector<std::string> scenes;
  int first_seed = 1;
  int end_seed = 2;
  std::string set;
  std::string scene;
  bool second_pass = false;
  bool linking_only = false;
  bool details = false;
  std::string lines;
  std::string tracks;
  std::string table;
  std::string json;
};

class Benchmark {
 public:
  explicit Benchmark(const Arguments& arguments)
      : arguments_(arguments),
        paper_(ReadRunOptions(ProjectConfig("synthetic/track_paper.toml"), "",
                              "")),
        graph_(ReadRunOptions(ProjectConfig("offline.toml"),
                              "graph.solver=sweeps;identity.link=false;"
                              "tracking.second_pass=false;" +
                                  arguments.set,
                              "")),
        whole_(ReadRunOptions(ProjectConfig("offline.toml"),
                              "graph.solver=sweeps;" + arguments.set, "")) {}

  void Run(const Layout& layout, int seed) {
    const SyntheticRecording recording = BenchmarkRecording(layout, seed);
    RunRequest request;
    request.cameras = recording.scene.cameras;
    const auto add = [&](const char* mode, const Counts& counts) {
      Add(layout, seed, mode, counts);
    };
    if (!arguments_.linking_only) {
      add("paper",
          CountsOf(recording.truth,
                   TrackSequenceOf(paper_, request, recording.detections)));
    }
    const TrackSequence tracks = FirstPass(layout, seed, recording, graph_);
    add("graph", CountsOf(recording.truth, tracks));
    TrackSequence linked = tracks;
    const std::vector<IdentityEdit> edits =
        LinkIdentities(tracks.header.skeleton, tracks.header.frame_rate_hz,
                       whole_.identity, &linked.frames);
    Counts counts = CountsOf(recording.truth, linked);
    CountJoins(recording.truth, tracks, edits, arguments_.details, &counts);
    add("graph, linked", counts);
    add("graph, joined by truth",
        CountsOf(recording.truth, JoinedByTruth(recording.truth, tracks)));
    if (arguments_.second_pass) {
      add("graph, linked, second pass",
          CountsOf(recording.truth,
                   TrackSequenceOf(whole_, request, recording.detections)));
    }
    if (!arguments_.details) return;
    PrintPieces("graph", recording.truth, tracks);
    PrintPieces("linked", recording.truth, linked);
  }

  const std::map<Key, Counts>& table() const { return table_; }

 private:
  SyntheticRecording BenchmarkRecording(const Layout& layout, int seed) const {
    std::vector<std::string> clips;
    if (layout.clips) {
      for (const char* clip : kClips) {
        const auto found =
            testing::FindData(std::string("motion/") + clip + ".jsonl");
        if (!found.has_value())
          throw InputError("needs data 'motion' (set KINEGRAPH_DATA)");
        clips.push_back(found->string());
      }
    }
    SyntheticRecording recording = MakeRecording(
        ProjectConfig(layout.clips ? "synthetic/motion_crowd.toml"
                                   : "synthetic/demo.toml"),
        Overrides(layout, seed, layout.rate_hz, DurationS(layout)) + ";" +
            arguments_.scene,
        clips);
    Hide(layout, seed, &recording);
    return recording;
  }

  // The tracks of graph mode, read from their file if it exists.
  TrackSequence FirstPass(const Layout& layout, int seed,
                          const SyntheticRecording& recording,
                          const RunOptions& options) const {
    const std::string path = arguments_.tracks + "/" + layout.name + "_" +
                             std::to_string(seed) + ".jsonl";
    if (!arguments_.tracks.empty() && std::filesystem::exists(path)) {
      return ReadTracks(path);
    }
    TrackSequence tracks;
    RunRequest request;
    request.cameras = recording.scene.cameras;
    MemorySource source(recording.detections);
    Session session(options, request, recording.detections.header);
    tracks.header = session.scene().header;
    TrackAll(&source, &session, [&](TrackFrame&& frame) {
      tracks.frames.push_back(std::move(frame));
    });
    if (!arguments_.tracks.empty()) WriteTracks(path, tracks);
    return tracks;
  }

  void Add(const Layout& layout, int seed, const char* mode, Counts counts) {
    const std::vector<double*> from = counts.All();
    const std::vector<double*> to = table_[{layout.name, mode}].All();
    for (size_t i = 0; i < to.size(); ++i) *to[i] += *from[i];
    if (arguments_.details) {
      std::printf("# %s %d %s: IDF1 %.2f HOTA %.2f MOTA %.2f exchanges %.0f\n",
                  layout.name, seed, mode, 100.0 * counts.Idf1(),
                  100.0 * counts.hota, 100.0 * counts.Mota(), counts.exchanges);
      std::fflush(stdout);
    }
    if (arguments_.lines.empty()) return;
    std::ofstream file(arguments_.lines, std::ios::app);
    file.precision(12);
    file << layout.name << '\t' << seed << '\t' << mode;
    for (const double* value : from) file << '\t' << *value;
    file << '\n';
  }

  Arguments arguments_;
  RunOptions paper_, graph_, whole_;
  std::map<Key, Counts> table_;
};

bool IsAsked(const Arguments& arguments, const std::string& scene) {
  return arguments.scenes.empty() ||
         std::any_of(arguments.scenes.begin(), arguments.scenes.end(),
                     [&](const std::string& one) {
                       return scene.compare(0, one.size(), one) == 0;
                     });
}

bool Parse(const std::string& argument, Arguments* arguments) {
  const size_t equals = argument.find('=');
  const std::string key = argument.substr(0, equals);
  const std::string value =
      equals == std::string::npos ? "" : argument.substr(equals + 1);
  if (key == "--scenes") {
    std::istringstream names(value);
    std::string name;
    while (std::getline(names, name, ',')) arguments->scenes.push_back(name);
  } else if (key == "--seeds") {
    return std::sscanf(value.c_str(), "%d:%d", &arguments->first_seed,
                       &arguments->end_seed) == 2;
  } else if (key == "--set") {
    arguments->set = value;
  } else if (key == "--scene") {
    arguments->scene = value;
  } else if (key == "--second_pass") {
    arguments->second_pass = true;
  } else if (key == "--linking_only") {
    arguments->linking_only = true;
  } else if (key == "--details") {
    arguments->details = true;
  } else if (key == "--lines") {
    arguments->lines = value;
  } else if (key == "--tracks") {
    arguments->tracks = value;
  } else if (key == "--table") {
    arguments->table = value;
  } else if (key == "--json") {
    arguments->json = value;
  } else {
    return false;
  }
  return true;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    if (Parse(argv[i], &arguments)) continue;
    std::fprintf(stderr, "unknown or invalid argument: %s\n", argv[i]);
    return 2;
  }
  if (!arguments.table.empty()) {
    PrintTable(ReadLines(arguments.table));
    if (!arguments.json.empty()) {
      WriteJson(arguments.json, ReadLines(arguments.table));
    }
    return 0;
  }
  Benchmark benchmark(arguments);
  for (const Layout& layout : kLayouts) {
    if (!IsAsked(arguments, layout.name)) continue;
    for (int seed = arguments.first_seed; seed < arguments.end_seed; ++seed) {
      benchmark.Run(layout, seed);
    }
  }
  PrintTable(benchmark.table());
  if (!arguments.json.empty()) WriteJson(arguments.json, benchmark.table());
  return 0;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) { return kinegraph::Main(argc, argv); }
