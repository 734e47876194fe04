#include "core/identity/linking.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/identity/chains.h"
#include "core/identity/duplicate_tracks.h"
#include "core/identity/edits.h"
#include "core/identity/false_positives.h"
#include "core/identity/tracklet.h"

namespace kinegraph {
namespace {

// The edits that give the tracks that were cut into pieces one number a chain,
// and those that stay undecided.
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
      IdentityEdit edit = EditOf(EditOp::kUndecided, link);
      edit.persons = {label_[link.from], label_[link.to]};
      edits_.push_back(std::move(edit));
    }
    return std::move(edits_);
  }

 private:
  // The piece before `piece` that has its label now; -1 without one.
  int Earlier(int piece) const {
    int earlier = -1;
    for (int p = 0; p < static_cast<int>(label_.size()); ++p) {
      if (p == piece || label_[p] != label_[piece] ||
          tracklets_[p].first().frame >= tracklets_[piece].first().frame) {
        continue;
      }
      if (earlier < 0 ||
          tracklets_[p].first().frame > tracklets_[earlier].first().frame) {
        earlier = p;
      }
    }
    return earlier;
  }
  // The piece after the end of `piece`, not `but`, that has its label.
  int Later(int piece, int but) const {
    int later = -1;
    for (int p = 0; p < static_cast<int>(label_.size()); ++p) {
      if (p == piece || p == but || label_[p] != label_[piece] ||
          tracklets_[p].first().frame <= tracklets_[piece].first().frame) {
        continue;
      }
      if (later < 0 ||
          tracklets_[p].first().frame < tracklets_[later].first().frame) {
        later = p;
      }
    }
    return later;
  }

  IdentityEdit EditOf(EditOp op, const Link& link) const {
    IdentityEdit edit;
    edit.op = op;
    edit.frames = FrameSpan{tracklets_[link.from].last().frame,
                            tracklets_[link.to].first().frame};
    edit.evidence = {{"bones", link.evidence.bones},
                     {"motion", link.evidence.motion},
                     {"other", link.evidence.other},
                     {"gap_s", link.gap_s},
                     {"bone_difference_m", link.bone_difference_m}};
    edit.margin = link.margin;
    return edit;
  }

  // Gives `piece` and all later ones of its label another one.
  void Relabel(int piece, TrackId from, TrackId to) {
    const int64_t first = tracklets_[piece].first().frame;
    for (size_t p = 0; p < label_.size(); ++p) {
      if (label_[p] == from && tracklets_[p].first().frame >= first) {
        label_[p] = to;
      }
    }
  }

  // From `piece` on, its label becomes a new identity.
  void CutBefore(int piece, const Link* link) {
    IdentityEdit edit;
    if (link != nullptr) edit = EditOf(EditOp::kCut, *link);
    edit.op = EditOp::kCut;
    const TrackId old = label_[piece];
    const TrackId fresh(next_id_++);
    edit.persons = {old, fresh};
    edit.frames = FrameSpan{tracklets_[piece].first().frame, last_frame_};
    edits_.push_back(std::move(edit));
    Relabel(piece, old, fresh);
  }

  // Two tracks each of which continued as the other's person.
  bool Exchange(int piece, int wanted) {
    const int earlier = Earlier(piece);  // was followed by `piece`
    const int rival = Later(wanted, piece);
    if (earlier < 0 || rival < 0 || before_[rival] != earlier ||
        after_[wanted] != piece) {
      return false;
    }
    IdentityEdit edit;
    if (evidence_.count(piece)) {
      edit = EditOf(EditOp::kSwap, *evidence_.at(piece));
    }
    edit.op = EditOp::kSwap;
    const TrackId one = label_[wanted];
    const TrackId other = label_[piece];
    edit.persons = {one, other};
    const int64_t from = std::min(tracklets_[piece].first().frame,
                                  tracklets_[rival].first().frame);
    edit.frames = FrameSpan{from, last_frame_};
    edits_.push_back(std::move(edit));
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

  // Makes the label of `piece` that of the piece before it in its chain.
  void Settle(int piece) {
    const int wanted = before_[piece];
    const int earlier = Earlier(piece);
    const Link* link = evidence_.count(piece) ? evidence_.at(piece) : nullptr;
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
    IdentityEdit edit;
    if (link != nullptr) edit = EditOf(EditOp::kJoin, *link);
    edit.op = EditOp::kJoin;
    edit.frames = FrameSpan{tracklets_[wanted].last().frame,
                            tracklets_[piece].first().frame};
    const TrackId one = label_[wanted];
    const TrackId other = label_[piece];
    edit.persons = {one, other};
    edits_.push_back(std::move(edit));
    for (TrackId& label : label_) {
      if (label == other) label = one;
    }
  }

  // Where both are present, the end of the track that dies is removed.
  void Trim(int from, int to) {
    const int64_t first = tracklets_[to].first().frame;
    const int64_t last = tracklets_[from].last().frame;
    if (last < first) return;
    IdentityEdit edit;
    edit.op = EditOp::kDelete;
    edit.persons = {label_[from]};
    edit.frames = FrameSpan{first, last};
    edit.evidence = {{"double_of", static_cast<double>(label_[to].value())}};
    edits_.push_back(std::move(edit));
  }

  const LinkedPieces& linked_;
  const std::vector<Tracklet>& tracklets_;
  int64_t last_frame_;
  std::vector<TrackId> label_;  // of each piece, after the edits so far
  std::vector<int> before_;     // in its chain, or -1
  std::vector<int> after_;
  std::map<int, const Link*> evidence_;  // by the piece joined
  int64_t next_id_ = 0;
  std::vector<IdentityEdit> edits_;
};

}  // namespace

void CheckLinkOptions(const LinkOptions& options) {
  CheckOptions(options);
  if (options.entries.size() % 4 == 0) return;
  throw OptionError("identity.entries",
                    "found " + std::to_string(options.entries.size()) +
                        " numbers, expected four a sphere: x, y, z, radius");
}

std::vector<IdentityEdit> LinkIdentities(
    const Skeleton& skeleton, double frame_rate_hz, const LinkOptions& options,
    std::vector<TrackFrame>* frames, std::vector<std::string>* left_out,
    const std::vector<Succession>& successions) {
  CheckLinkOptions(options);
  std::vector<IdentityEdit> edits;
  const auto apply = [&](std::vector<IdentityEdit> more) {
    for (std::string& line : ApplyEdits(std::move(more), frames, &edits)) {
      if (left_out != nullptr) left_out->push_back(std::move(line));
    }
  };
  if (frames->empty()) return edits;
  apply(FindDuplicates(CollectTracklets(*frames, skeleton)));
  apply(FindFalsePositives(skeleton, options.min_margin,
                           CollectTracklets(*frames, skeleton)));
  const std::vector<Tracklet> tracks = CollectTracklets(*frames, skeleton);
  if (tracks.empty()) return edits;
  const LinkedPieces linked =
      JoinPieces(skeleton, frame_rate_hz, options, tracks, successions);
  apply(EditWriter(linked, frames->back().frame).Write());
  return edits;
}

}  // namespace kinegraph
