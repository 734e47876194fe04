#include "core/identity/linking.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/identity/chains.h"
#include "core/identity/edits.h"
#include "core/identity/tracklet.h"

namespace kinegraph {
namespace {

// Removals of tracks that nearly always coincide with a longer one, or with an
// equally long one of lower identity.
std::vector<IdentityEdit> FindDuplicates(const std::vector<Tracklet>& tracks) {
  std::vector<IdentityEdit> edits;
  for (size_t i = 0; i < tracks.size(); ++i) {
    for (size_t k = 0; k < tracks.size(); ++k) {
      const Tracklet& one = tracks[i];
      const Tracklet& other = tracks[k];
      const auto length = [](const Tracklet& t) { return t.frames.size(); };
      if (i == k || length(one) > length(other) ||
          (length(one) == length(other) && i < k)) {
        continue;
      }
      if (one.last().frame < other.first().frame ||
          other.last().frame < one.first().frame) {
        continue;
      }
      const Together together = Compare(one, other);
      if (!together.OfNearlyAll(length(one))) continue;
      IdentityEdit edit;
      edit.op = EditOp::kDelete;
      edit.persons = {one.id};
      edit.frames = FrameSpan{one.first().frame, one.last().frame};
      edit.evidence = {{"double_of", static_cast<double>(other.id.value())},
                       {"share", together.ShareOf(length(one))},
                       {"distance_m", together.distance_m}};
      edits.push_back(std::move(edit));
      break;
    }
  }
  return edits;
}

// The edits that give the pieces of each chain one identity, and those that
// remain undecided.
class EditWriter {
 public:
  EditWriter(const LinkedPieces& linked, int64_t last_frame)
      : linked_(linked),
        tracklets_(linked.pieces.tracklets),
        last_frame_(last_frame) {
    for (const Tracklet& piece : tracklets_) {
      label_.push_back(piece.id);
      next_id_ = std::max(next_id_, piece.id.value() + 1);
    }
    before_.assign(tracklets_.size(), -1);
    after_.assign(tracklets_.size(), -1);
    for (const Chain& chain : linked.chains) {
      for (size_t i = 1; i < chain.pieces.size(); ++i) {
        before_[chain.pieces[i]] = chain.pieces[i - 1];
        after_[chain.pieces[i - 1]] = chain.pieces[i];
      }
    }
    for (const Link& link : linked.links) evidence_[link.to] = &link;
  }

  std::vector<IdentityEdit> Write() {
    std::vector<int> order(tracklets_.size());
    for (size_t p = 0; p < order.size(); ++p) order[p] = static_cast<int>(p);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return tracklets_[a].first().frame < tracklets_[b].first().frame;
    });
    for (const int piece : order) Settle(piece);
    for (const Link& link : linked_.undecided) {
      if (label_[link.from] == label_[link.to]) continue;
      edits_.push_back(EditOf(EditOp::kUndecided,
                              {label_[link.from], label_[link.to]},
                              Between(link.from, link.to), &link));
    }
    return std::move(edits_);
  }

 private:
  // The nearest piece before or after the beginning of `piece`, except `but`,
  // that currently has its label; -1 if there is none.
  int Neighbour(int piece, bool after, int but = -1) const {
    const auto first = [&](int p) { return tracklets_[p].first().frame; };
    const auto precedes = [&](int a, int b) {
      return after ? first(a) < first(b) : first(a) > first(b);
    };
    int nearest = -1;
    for (int p = 0; p < static_cast<int>(label_.size()); ++p) {
      if (p == but || label_[p] != label_[piece] || !precedes(piece, p)) {
        continue;
      }
      if (nearest < 0 || precedes(p, nearest)) nearest = p;
    }
    return nearest;
  }
  int Earlier(int piece) const { return Neighbour(piece, /*after=*/false); }
  int Later(int piece, int but) const {
    return Neighbour(piece, /*after=*/true, but);
  }

  // An edit with the evidence of `link`, if any.
  static IdentityEdit EditOf(EditOp op, std::vector<TrackId> persons,
                             const FrameSpan& frames, const Link* link) {
    IdentityEdit edit;
    edit.op = op;
    edit.persons = std::move(persons);
    edit.frames = frames;
    if (link == nullptr) return edit;
    edit.evidence = {{"bones", link->evidence.bones},
                     {"motion", link->evidence.motion},
                     {"other", link->evidence.other},
                     {"gap_s", link->gap_s},
                     {"bone_difference_m", link->bone_difference_m}};
    edit.margin = link->margin;
    return edit;
  }
  // The frames from the end of one piece to the beginning of another.
  FrameSpan Between(int from, int to) const {
    return {tracklets_[from].last().frame, tracklets_[to].first().frame};
  }
  const Link* LinkTo(int piece) const {
    const auto link = evidence_.find(piece);
    return link == evidence_.end() ? nullptr : link->second;
  }

  // Gives `piece` and all later ones of its label a new label.
  void Relabel(int piece, TrackId from, TrackId to) {
    const int64_t first = tracklets_[piece].first().frame;
    for (size_t p = 0; p < label_.size(); ++p) {
      if (label_[p] == from && tracklets_[p].first().frame >= first) {
        label_[p] = to;
      }
    }
  }

  // Appends the cut that gives `piece` and all later pieces of its label a new
  // identity.
  void CutBefore(int piece, const Link* link) {
    const TrackId old = label_[piece];
    const TrackId fresh(next_id_++);
    edits_.push_back(EditOf(EditOp::kCut, {old, fresh},
                            {tracklets_[piece].first().frame, last_frame_},
                            link));
    Relabel(piece, old, fresh);
  }

  // Exchanges two tracks if each continued as the other's person; else returns
  // false.
  bool Exchange(int piece, int wanted) {
    const int earlier = Earlier(piece);  // the tracker continued it as `piece`
    const int rival = Later(wanted, piece);
    if (earlier < 0 || rival < 0 || before_[rival] != earlier ||
        after_[wanted] != piece) {
      return false;
    }
    const TrackId one = label_[wanted];
    const TrackId other = label_[piece];
    const int64_t from = std::min(tracklets_[piece].first().frame,
                                  tracklets_[rival].first().frame);
    edits_.push_back(EditOf(EditOp::kSwap, {one, other}, {from, last_frame_},
                            LinkTo(piece)));
    for (size_t p = 0; p < label_.size(); ++p) {
      if (tracklets_[p].first().frame < from) continue;
      if (label_[p] == one) {
        label_[p] = other;
      } else if (label_[p] == other) {
        label_[p] = one;
      }
    }
    return true;
  }

  // Gives `piece` the label of its predecessor in its chain.
  void Settle(int piece) {
    const int wanted = before_[piece];
    const int earlier = Earlier(piece);
    const Link* link = LinkTo(piece);
    if (wanted < 0) {
      if (earlier >= 0) CutBefore(piece, nullptr);
      return;
    }
    if (label_[wanted] == label_[piece]) return;
    if (earlier >= 0 && Exchange(piece, wanted)) return;
    if (earlier >= 0) CutBefore(piece, link);
    const int rival = Later(wanted, piece);
    if (rival >= 0) CutBefore(rival, nullptr);
    Trim(wanted, piece);
    const TrackId one = label_[wanted];
    const TrackId other = label_[piece];
    edits_.push_back(
        EditOf(EditOp::kJoin, {one, other}, Between(wanted, piece), link));
    for (TrackId& label : label_) {
      if (label == other) label = one;
    }
  }

  // Removes the end of the earlier track in the frames in which both are
  // present.
  void Trim(int from, int to) {
    const FrameSpan both = {tracklets_[to].first().frame,
                            tracklets_[from].last().frame};
    if (both.last < both.first) return;
    IdentityEdit edit = EditOf(EditOp::kDelete, {label_[from]}, both, nullptr);
    edit.evidence = {{"double_of", static_cast<double>(label_[to].value())}};
    edits_.push_back(std::move(edit));
  }

  const LinkedPieces& linked_;
  const std::vector<Tracklet>& tracklets_;
  int64_t last_frame_;
  std::vector<TrackId> label_;  // of each piece, after the edits so far
  std::vector<int> before_;     // predecessor in its chain, or -1
  std::vector<int> after_;
  std::map<int, const Link*> evidence_;  // by the later piece of the join
  int64_t next_id_ = 0;
  std::vector<IdentityEdit> edits_;
};

}  // namespace

void LinkOptions::Describe(OptionVisitor& visitor) {
  visitor.Boolean("link", &link,
                  "graph mode: join tracks over the whole recording");
  visitor.Number(
      "min_margin", &min_margin, NonNegative(), "nats",
      "advantage over the second best explanation that a change needs");
  visitor.Number("max_absence", &max_absence_s, NonNegative(), "s",
                 "longest absence that is joined; 0: any");
  visitor.Integer("people", &people, Between(0, 10000), "people",
                  "hint: people in the recording; 0: not known");
  visitor.NumberList("entries", &entries, Between(-1e6, 1e6), "m",
                     "hint: spheres where people come and go: x, y, z, radius "
                     "of each");
}

void CheckLinkOptions(const LinkOptions& options) {
  CheckOptions(options);
  if (options.entries.size() % 4 == 0) return;
  throw OptionError("identity.entries",
                    "found " + std::to_string(options.entries.size()) +
                        " numbers, expected four per sphere: x, y, z, radius");
}

std::vector<IdentityEdit> LinkIdentities(const Skeleton& skeleton,
                                         double frame_rate_hz,
                                         const LinkOptions& options,
                                         std::vector<TrackFrame>* frames,
                                         std::vector<std::string>* left_out) {
  CheckLinkOptions(options);
  std::vector<IdentityEdit> edits;
  const auto apply = [&](std::vector<IdentityEdit> more) {
    for (std::string& line : ApplyEdits(std::move(more), frames, &edits)) {
      if (left_out != nullptr) left_out->push_back(std::move(line));
    }
  };
  if (frames->empty()) return edits;
  apply(FindDuplicates(CollectTracklets(*frames, skeleton)));
  const std::vector<Tracklet> tracks = CollectTracklets(*frames, skeleton);
  if (tracks.empty()) return edits;
  const LinkedPieces linked =
      JoinPieces(skeleton, frame_rate_hz, options, tracks);
  apply(EditWriter(linked, frames->back().frame).Write());
  return edits;
}

}  // namespace kinegraph
