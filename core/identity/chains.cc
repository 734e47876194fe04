#include "core/identity/chains.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/assignment/hungarian.h"
#include "core/identity/motion.h"

namespace kinegraph {
namespace {

constexpr double kForbidden = 1e6;  // nats
// Prior log odds that a person who appears is already known rather than new: 20
// to 1.
constexpr double kKnownRather = 3.0;  // nats
// Durations of absences have a density proportional to 1 / duration between
// kShortAbsence and kLongAbsence [s], and constant beyond either. After an
// absence of kUsualAbsence a known person is more likely than a new one by the
// odds above.
constexpr double kShortAbsence = 0.2;
constexpr double kUsualAbsence = 3.0;
constexpr double kLongAbsence = 30.0;
// Largest overlap in time of a track with its successor [s], unless the two
// nearly coincide. Also the time from either end of the recording within which
// people may appear and disappear anywhere.
constexpr double kMaxOverlap = 0.5;
// Up to this number of chains the margin of a join comes from the assignment of
// least cost that keeps its two chains apart (BestApart), beyond it from single
// exchanges.
constexpr size_t kExactChains = 100;

// A chain inserted into a gap of another.
struct Insertion {
  size_t guest = 0;  // chains
  size_t host = 0;
  size_t after = 0;  // index in the host's pieces
  // [nats]
  double bones = 0.0;
  double motion = 0.0;
  double gain = 0.0;
  double margin = 0.0;
};

class Linker {
 public:
  Linker(const Skeleton& skeleton, double frame_rate_hz,
         const LinkOptions& options, const std::vector<Tracklet>& tracks)
      : options_(options),
        frame_s_(1.0 / frame_rate_hz),
        bones_(skeleton),
        motion_(tracks),
        pieces_(CutAtContacts(tracks)) {
    std::vector<BoneSamples> samples;
    for (const Tracklet& piece : pieces_.tracklets) {
      samples.push_back(bones_.Measure(piece));
      begin_.push_back(StateAtBegin(piece));
      end_.push_back(StateAtEnd(piece));
      recording_begin_ = std::min(recording_begin_, piece.first().time);
      recording_end_ = std::max(recording_end_, piece.last().time);
    }
    bones_.Learn(samples);
    for (size_t p = 0; p < samples.size(); ++p) {
      chains_.push_back(
          {{static_cast<int>(p)}, std::move(samples[p]), next_number_++});
    }
  }

  void Run() {
    // With a known number of people, the reward of a join is raised, up to
    // kMost, until no more chains than people are left.
    constexpr double kStep = 2.0;   // nats
    constexpr double kMost = 20.0;  // nats
    JoinAll();
    while (options_.people > 0 &&
           static_cast<int64_t>(chains_.size()) > options_.people &&
           reward_ < kMost) {
      reward_ += kStep;
      JoinAll();
    }
    reward_ = 0.0;
    GoOnAsTracked();
    JoinAll();
    if (options_.people > 0) JoinDownTo(static_cast<size_t>(options_.people));
    FindUndecided();
  }

  LinkedPieces Take() {
    return {std::move(pieces_), std::move(chains_), std::move(links_),
            std::move(undecided_)};
  }

 private:
  const Tracklet& First(const Chain& chain) const {
    return pieces_.tracklets[chain.pieces.front()];
  }
  const Tracklet& Last(const Chain& chain) const {
    return pieces_.tracklets[chain.pieces.back()];
  }

  bool MayFollow(const Tracklet& from, const Tracklet& to) const {
    const double gap_s = ToSeconds(to.first().time - from.last().time);
    if (gap_s > 0.0) {
      return options_.max_absence_s == 0.0 || gap_s <= options_.max_absence_s;
    }
    if (from.first().time >= to.first().time ||
        from.last().time >= to.last().time) {
      return false;
    }
    if (gap_s > -kMaxOverlap) return true;
    const Together together = Compare(from, to);
    return together.frames > 0 &&
           together.OfNearlyAll(static_cast<size_t>(together.frames));
  }

  // Whether people may appear or disappear in this state.
  bool IsEntry(const MotionState& state) const {
    if (options_.entries.size() < 4) return true;
    if (state.time - recording_begin_ < FromSeconds(kMaxOverlap) ||
        recording_end_ - state.time < FromSeconds(kMaxOverlap)) {
      return true;
    }
    for (size_t i = 0; i + 3 < options_.entries.size(); i += 4) {
      const Eigen::Vector3d centre(options_.entries[i], options_.entries[i + 1],
                                   options_.entries[i + 2]);
      if ((state.position_m - centre).norm() <= options_.entries[i + 3]) {
        return true;
      }
    }
    return false;
  }

  // Log density of an absence from `end` to `begin`, relative to that of
  // kUsualAbsence.
  static double Absence(const MotionState& end, const MotionState& begin) {
    return std::log(kUsualAbsence / std::clamp(ToSeconds(begin.time - end.time),
                                               kShortAbsence, kLongAbsence));
  }

  Evidence Weigh(size_t one, size_t other) const {
    const Chain& from = chains_[one];
    const Chain& to = chains_[other];
    Evidence evidence;
    if (!MayFollow(Last(from), First(to))) return evidence;
    const int last = from.pieces.back();
    const int first = to.pieces.front();
    const MotionState& end = end_[last];
    const MotionState& begin = begin_[first];
    evidence.allowed = true;
    evidence.bones = BonesOf(from, to);
    // If the two overlap in time, their states at the same moment are compared.
    const bool at_once = begin.time <= end.time;
    evidence.motion = motion_.LogRatio(
        at_once ? StateUpTo(Last(from), begin.time) : end, begin, frame_s_);
    evidence.other = kKnownRather + Absence(end, begin);
    if (pieces_.next[last] == first) {
      // If the cut was made because no view saw the person, the tracker's
      // continuation counts half. It is reduced by the evidence of the motion
      // across each unseen part of the contact, where that is against it.
      double continuity =
          (pieces_.blind[last] ? 0.5 : 1.0) * options_.continuity;
      for (const auto& [before, after] : pieces_.hops[last]) {
        continuity += std::min(0.0, motion_.LogRatio(before, after, frame_s_));
      }
      evidence.other += continuity;
    }
    if (!IsEntry(end)) evidence.other += options_.entry_penalty;
    if (!IsEntry(begin)) evidence.other += options_.entry_penalty;
    evidence.other += reward_;
    return evidence;
  }

  double BonesOf(const Chain& one, const Chain& other) const {
    // Ordered, because the ratio is symmetric only up to rounding.
    if (other.number < one.number) return BonesOf(other, one);
    const auto [known, fresh] =
        known_bones_.try_emplace({one.number, other.number}, 0.0);
    if (fresh) known->second = bones_.LogRatio(one.bones, other.bones);
    return known->second;
  }

  // Forgets the bones of chains that were joined since.
  void ForgetBones() {
    std::vector<char> is_left(next_number_, 0);
    for (const Chain& chain : chains_) {
      is_left[chain.number] = 1;
    }
    for (auto at = known_bones_.begin(); at != known_bones_.end();) {
      const auto [one, other] = at->first;
      const bool keeps = is_left[one] != 0 && is_left[other] != 0;
      at = keeps ? std::next(at) : known_bones_.erase(at);
    }
  }

  void WeighAll() {
    ForgetBones();
    const size_t n = chains_.size();
    evidence_.assign(n, std::vector<Evidence>(n));
    for (size_t from = 0; from < n; ++from) {
      for (size_t to = 0; to < n; ++to) {
        if (from != to) evidence_[from][to] = Weigh(from, to);
      }
    }
  }

  // The best assignment of a predecessor to each chain, without the `forbidden`
  // pairs (from, to). In the cost matrix rows are the chains that begin;
  // columns those that end, and "no predecessor" for each row. Returns the cost
  // and the predecessors, -1 for none.
  double Assign(const std::vector<std::pair<int, int>>& forbidden,
                std::vector<int>* predecessor) {
    const size_t n = chains_.size();
    std::vector<double> cost(n * 2 * n, kForbidden);
    for (size_t to = 0; to < n; ++to) {
      for (size_t from = 0; from < n; ++from) {
        const Evidence& evidence = evidence_[from][to];
        if (!evidence.allowed) continue;
        cost[to * 2 * n + from] = -evidence.total();
      }
      cost[to * 2 * n + n + to] = 0.0;
    }
    for (const auto& [from, to] : forbidden) {
      cost[to * 2 * n + from] = kForbidden;
    }
    solver_.Minimise(cost, static_cast<int>(n), static_cast<int>(2 * n),
                     predecessor);
    double total = 0.0;
    for (size_t to = 0; to < n; ++to) {
      int& from = (*predecessor)[to];
      total += cost[to * 2 * n + from];
      if (from >= static_cast<int>(n)) from = -1;
    }
    return total;
  }

  // Cost of the best assignment in which the two are different people, joined
  // neither directly nor through others.
  double BestApart(int from, int to,
                   const std::vector<std::pair<int, int>>& forbidden) {
    constexpr size_t kDeepest = 4;
    std::vector<int> predecessor;
    const double total = Assign(forbidden, &predecessor);
    std::vector<std::pair<int, int>> path;
    int at = to;
    while (at != from && at >= 0) {
      const int before = predecessor[at];
      path.push_back({before, at});
      at = before;
    }
    if (at != from) return total;
    if (forbidden.size() >= kDeepest) {
      // A person who is hidden often may be joined in many ways. Giving the
      // later chain no predecessor certainly separates the two, though perhaps
      // not at the least cost.
      std::vector<std::pair<int, int>> more = forbidden;
      for (int before = 0; before < static_cast<int>(chains_.size());
           ++before) {
        more.emplace_back(before, to);
      }
      return Assign(more, &predecessor);
    }
    double best = std::numeric_limits<double>::max();
    for (const std::pair<int, int>& join : path) {
      std::vector<std::pair<int, int>> more = forbidden;
      more.push_back(join);
      best = std::min(best, BestApart(from, to, more));
    }
    return best;
  }

  // How much worse the best assignment is in which the two are different people
  // [nats].
  double Margin(int from, int to, double best,
                const std::vector<int>& predecessor) {
    if (chains_.size() <= kExactChains) {
      return BestApart(from, to, {{from, to}}) - best;
    }
    // The alternatives considered: the two are not joined, or exchange partners
    // with one other join.
    const auto gain = [&](int f, int t) {
      if (f < 0) return 0.0;
      const Evidence& evidence = evidence_[f][t];
      return evidence.allowed ? evidence.total() : -kForbidden;
    };
    double margin = gain(from, to);
    std::vector<char> used(chains_.size(), 0);
    for (const int f : predecessor) {
      if (f >= 0) used[f] = 1;
    }
    for (int t = 0; t < static_cast<int>(chains_.size()); ++t) {
      if (t == to) continue;
      const int f = predecessor[t];
      margin = std::min(margin, gain(from, to) + gain(f, t) -
                                    std::max(0.0, gain(f, to)) -
                                    std::max(0.0, gain(from, t)));
      // A chain t without a successor may precede `to` instead of `from`,
      // unless it may itself follow `from`, which would still connect the two.
      if (!used[t] && !evidence_[from][t].allowed) {
        margin = std::min(margin, gain(from, to) - gain(t, to));
      }
    }
    return margin;
  }

  Link MakeLink(int from, int to) const {
    const Chain& one = chains_[from];
    const Chain& other = chains_[to];
    Link link;
    link.from = one.pieces.back();
    link.to = other.pieces.front();
    link.evidence = evidence_[from][to];
    link.gap_s = ToSeconds(First(other).first().time - Last(one).last().time);
    link.bone_difference_m = bones_.MeanDifference(one.bones, other.bones);
    return link;
  }

  // Makes the clear joins, repeatedly until there are no new ones.
  void JoinAll() {
    do {
      while (JoinClear()) {
      }
    } while (InsertClear());
  }

  bool JoinClear() {
    WeighAll();
    std::vector<int> predecessor;
    const double best = Assign({}, &predecessor);
    std::vector<std::pair<int, int>> joins;  // chains
    for (size_t to = 0; to < predecessor.size(); ++to) {
      const int from = predecessor[to];
      if (from < 0) continue;
      Link link = MakeLink(from, static_cast<int>(to));
      link.margin = Margin(from, static_cast<int>(to), best, predecessor);
      if (link.margin < options_.min_margin) continue;
      link.decided = true;
      links_.push_back(link);
      joins.push_back({from, static_cast<int>(to)});
    }
    if (joins.empty()) joins = JoinAcross(predecessor, best);
    Merge(joins);
    return !joins.empty();
  }

  // Two chains that the assignment joins through others may clearly be one
  // person while those in between are not. Returns the clearest such join, if
  // any.
  std::vector<std::pair<int, int>> JoinAcross(
      const std::vector<int>& predecessor, double best) {
    if (chains_.size() > kExactChains) return {};
    Link clearest;
    std::vector<std::pair<int, int>> joins;
    for (size_t to = 0; to < predecessor.size(); ++to) {
      int from = predecessor[to];
      if (from < 0) continue;
      for (from = predecessor[from]; from >= 0; from = predecessor[from]) {
        if (!evidence_[from][to].allowed) continue;
        Link link = MakeLink(from, static_cast<int>(to));
        link.margin = Margin(from, static_cast<int>(to), best, predecessor);
        if (link.margin < options_.min_margin) continue;
        if (!joins.empty() && link.margin <= clearest.margin) continue;
        link.decided = true;
        clearest = link;
        joins = {{from, static_cast<int>(to)}};
      }
    }
    if (!joins.empty()) links_.push_back(clearest);
    return joins;
  }

  // Makes the clearest insertion of a chain into an absence of another person.
  bool InsertClear() {
    WeighAll();
    const std::vector<Insertion> all = FindInsertions();
    const Insertion* clearest = nullptr;
    for (const Insertion& one : all) {
      if (one.margin < options_.min_margin) continue;
      if (clearest == nullptr || one.margin > clearest->margin) clearest = &one;
    }
    if (clearest == nullptr) return false;
    Insert(*clearest);
    return true;
  }

  // Insertion of chain `guest` into the first gap of chain `host` that it fits;
  // nullopt if it fits none.
  std::optional<Insertion> Fit(size_t guest, size_t host) const {
    const Chain& one = chains_[guest];
    const Chain& other = chains_[host];
    for (size_t k = 0; k + 1 < other.pieces.size(); ++k) {
      const int before = other.pieces[k];
      const int after = other.pieces[k + 1];
      if (!MayFollow(pieces_.tracklets[before], First(one)) ||
          !MayFollow(Last(one), pieces_.tracklets[after])) {
        continue;
      }
      const int first = one.pieces.front();
      const int last = one.pieces.back();
      Insertion insertion;
      insertion.guest = guest;
      insertion.host = host;
      insertion.after = k;
      insertion.bones = BonesOf(other, one);
      insertion.motion =
          motion_.LogRatio(end_[before], begin_[first], frame_s_) +
          motion_.LogRatio(end_[last], begin_[after], frame_s_) -
          motion_.LogRatio(end_[before], begin_[after], frame_s_);
      insertion.gain =
          insertion.bones + insertion.motion + kKnownRather + reward_;
      return insertion;
    }
    return std::nullopt;
  }

  // Whether the two never appear at once, judging by their pieces.
  bool MayBeOne(size_t one, size_t other) const {
    for (const int a : chains_[one].pieces) {
      for (const int b : chains_[other].pieces) {
        const Tracklet& x = pieces_.tracklets[a];
        const Tracklet& y = pieces_.tracklets[b];
        if (x.first().time <= y.last().time &&
            y.first().time <= x.last().time) {
          return false;
        }
      }
    }
    return true;
  }

  // All insertions with positive log odds, each with its margin over no
  // insertion, over the insertions that it excludes and over the joins of its
  // guest with people other than its host.
  std::vector<Insertion> FindInsertions() const {
    std::vector<Insertion> all;
    for (size_t guest = 0; guest < chains_.size(); ++guest) {
      for (size_t host = 0; host < chains_.size(); ++host) {
        if (guest == host) continue;
        const std::optional<Insertion> fit = Fit(guest, host);
        if (fit.has_value() && fit->gain > 0.0) all.push_back(*fit);
      }
    }
    for (Insertion& one : all) {
      double rival = 0.0;  // no insertion
      for (const Insertion& other : all) {
        const bool same_guest = other.guest == one.guest &&
                                other.host != one.host &&
                                !MayBeOne(other.host, one.host);
        const bool same_place = other.host == one.host &&
                                other.guest != one.guest &&
                                !MayBeOne(other.guest, one.guest);
        if (same_guest || same_place) rival = std::max(rival, other.gain);
      }
      for (size_t c = 0; c < chains_.size(); ++c) {
        if (c == one.guest || c == one.host || MayBeOne(c, one.host)) continue;
        for (const Evidence& other :
             {evidence_[one.guest][c], evidence_[c][one.guest]}) {
          if (other.allowed) rival = std::max(rival, other.total());
        }
      }
      one.margin = one.gain - rival;
    }
    return all;
  }

  void Insert(const Insertion& insertion) {
    Chain& host = chains_[insertion.host];
    const Chain& guest = chains_[insertion.guest];
    const int before = host.pieces[insertion.after];
    const Tracklet& last = pieces_.tracklets[before];
    Link link;
    link.from = before;
    link.to = guest.pieces.front();
    link.evidence = {true, insertion.bones, insertion.motion, kKnownRather};
    link.gap_s = ToSeconds(First(guest).first().time - last.last().time);
    link.bone_difference_m = bones_.MeanDifference(host.bones, guest.bones);
    link.margin = insertion.margin;
    link.decided = true;
    links_.push_back(link);
    host.pieces.insert(
        host.pieces.begin() + static_cast<long>(insertion.after) + 1,
        guest.pieces.begin(), guest.pieces.end());
    host.bones.Append(guest.bones);
    host.number = next_number_++;
    chains_.erase(chains_.begin() + static_cast<long>(insertion.guest));
  }

  // `joins` are one-to-one and without cycles: a chain follows one that began
  // earlier.
  void Merge(const std::vector<std::pair<int, int>>& joins) {
    std::vector<int> next(chains_.size(), -1);
    std::vector<char> follows(chains_.size(), 0);
    for (const auto& [from, to] : joins) {
      next[from] = to;
      follows[to] = 1;
    }
    std::vector<Chain> merged;
    for (size_t c = 0; c < chains_.size(); ++c) {
      if (follows[c]) continue;
      Chain chain = std::move(chains_[c]);
      if (next[c] >= 0) chain.number = next_number_++;
      for (int k = next[c]; k >= 0; k = next[k]) {
        const Chain& more = chains_[k];
        chain.pieces.insert(chain.pieces.end(), more.pieces.begin(),
                            more.pieces.end());
        chain.bones.Append(more.bones);
      }
      merged.push_back(std::move(chain));
    }
    chains_ = std::move(merged);
  }

  // Joins each chain to the piece with which the tracker continued, unless that
  // is clearly another person.
  void GoOnAsTracked() {
    WeighAll();
    std::vector<std::pair<int, int>> joins;
    for (size_t from = 0; from < chains_.size(); ++from) {
      const int next = pieces_.next[chains_[from].pieces.back()];
      for (size_t to = 0; to < chains_.size(); ++to) {
        if (chains_[to].pieces.front() != next || from == to) continue;
        const Evidence& evidence = evidence_[from][to];
        if (!evidence.allowed || evidence.total() < -options_.min_margin) {
          continue;
        }
        joins.push_back({static_cast<int>(from), static_cast<int>(to)});
      }
    }
    Merge(joins);
  }

  // A known number of people decides what the evidence leaves open: makes the
  // most probable join of the best explanation with the most joins, until no
  // more chains than people are left.
  void JoinDownTo(size_t people) {
    constexpr double kReward = 1e3;  // nats, beyond all evidence
    reward_ = kReward;
    while (chains_.size() > people) {
      WeighAll();
      std::vector<int> predecessor;
      Assign({}, &predecessor);
      std::vector<Link> joins;
      for (size_t to = 0; to < predecessor.size(); ++to) {
        if (predecessor[to] < 0) continue;
        joins.push_back(MakeLink(predecessor[to], static_cast<int>(to)));
        joins.back().evidence.other -= reward_;
        joins.back().decided = true;
      }
      if (joins.empty()) break;
      const auto chosen = std::max_element(
          joins.begin(), joins.end(), [](const Link& a, const Link& b) {
            return a.evidence.total() < b.evidence.total();
          });
      std::vector<std::pair<int, int>> pair;
      for (size_t to = 0; to < predecessor.size(); ++to) {
        if (chains_[to].pieces.front() == chosen->to) {
          pair.emplace_back(predecessor[to], static_cast<int>(to));
        }
      }
      links_.push_back(*chosen);
      Merge(pair);
    }
    reward_ = 0.0;
  }

  // Finds the joins of the best explanation that were not made and, for a chain
  // to which it joins no predecessor, the best candidate with log odds above
  // -min_margin.
  void FindUndecided() {
    WeighAll();
    std::vector<int> predecessor;
    const double best = Assign({}, &predecessor);
    for (size_t to = 0; to < chains_.size(); ++to) {
      int nearest = -1;
      double most = -options_.min_margin;
      double second = 0.0;  // no join
      for (size_t from = 0; from < chains_.size(); ++from) {
        const Evidence& evidence = evidence_[from][to];
        if (!evidence.allowed || evidence.total() <= -options_.min_margin) {
          continue;
        }
        if (evidence.total() > most) {
          if (nearest >= 0) second = std::max(second, most);
          most = evidence.total();
          nearest = static_cast<int>(from);
        } else {
          second = std::max(second, evidence.total());
        }
      }
      const int chosen = predecessor[to];
      if (nearest < 0 && chosen < 0) continue;
      Link link =
          MakeLink(chosen >= 0 ? chosen : nearest, static_cast<int>(to));
      // The margin of a join that the best explanation does not contain is not
      // positive.
      link.margin =
          chosen >= 0 ? Margin(chosen, static_cast<int>(to), best, predecessor)
                      : std::min(0.0, most - second);
      undecided_.push_back(link);
    }
  }

  LinkOptions options_;
  double frame_s_;
  BoneModel bones_;
  IdentityMotion motion_;
  Pieces pieces_;
  std::vector<MotionState> begin_, end_;  // by piece
  TimeNs recording_begin_ = std::numeric_limits<TimeNs>::max();
  TimeNs recording_end_ = std::numeric_limits<TimeNs>::min();
  std::vector<Chain> chains_;
  int next_number_ = 0;  // Chain::number of the next chain
  // Keyed by Chain::number of both chains.
  mutable std::map<std::pair<int, int>, double> known_bones_;
  std::vector<std::vector<Evidence>> evidence_;  // [from][to]
  double reward_ = 0.0;
  HungarianSolver solver_;
  std::vector<Link> links_;
  std::vector<Link> undecided_;
};

}  // namespace

LinkedPieces JoinPieces(const Skeleton& skeleton, double frame_rate_hz,
                        const LinkOptions& options,
                        const std::vector<Tracklet>& tracks) {
  Linker linker(skeleton, frame_rate_hz, options, tracks);
  linker.Run();
  return linker.Take();
}

}  // namespace kinegraph
