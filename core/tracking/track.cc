#include "core/tracking/track.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace kinegraph {
namespace {

// Number of pauses remembered. Their third quartile is taken as the typical
// pause: if a detector skips every third frame, half of the pauses are 2 frames
// long, while gaps in a recording are few.
constexpr size_t kRemembered = 15;
// With fewer known pauses an empty frame never counts as a miss.
constexpr size_t kEnough = 8;

}  // namespace

bool HasDetections(const DetectionFrame& frame) {
  return std::any_of(
      frame.views.begin(), frame.views.end(),
      [](const ViewDetections& view) { return !view.detections.empty(); });
}

bool LookRhythm::IsLook(const DetectionFrame& frame) {
  const double frames = begun_ ? clock_.Frames(frame.time - last_) : 1.0;
  if (!HasDetections(frame)) {
    return pauses_.size() >= kEnough &&
           frames > *std::max_element(pauses_.begin(), pauses_.end()) - 0.5;
  }
  if (begun_) Note(std::max(1.0, std::round(frames)));
  begun_ = true;
  last_ = frame.time;
  return true;
}

void LookRhythm::Note(double frames) {
  pauses_.push_back(frames);
  if (pauses_.size() > kRemembered) pauses_.pop_front();
  std::vector<double> sorted(pauses_.begin(), pauses_.end());
  const auto quartile =
      sorted.begin() + static_cast<long>(3 * sorted.size() / 4);
  std::nth_element(sorted.begin(), quartile, sorted.end());
  usual_frames_ = *quartile;
  newest_frames_ = std::min(frames, usual_frames_);
}

void ViewMemory::Store(const Observation& observation, TimeNs frame_time) {
  const auto at =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
        return entry.observation.view_idx == observation.view_idx;
      });
  const auto end = std::find_if(at, entries_.end(), [&](const Entry& entry) {
    return entry.observation.view_idx != observation.view_idx;
  });
  if (end - at < depth_) {
    entries_.insert(at, {frame_time, observation});
    return;
  }
  // The oldest entry is replaced and its memory reused.
  std::rotate(at, end - 1, end);
  at->frame_time = frame_time;
  at->observation = observation;
}

TrackLife::TrackLife(const TrackLifeOptions& options, const FrameClock& clock,
                     TimeNs birth_time)
    : confirm_hits_(options.confirm_hits),
      max_age_frames_(options.max_age_frames),
      independent_frames_(options.independent_frames),
      clock_(clock),
      last_update_(birth_time) {
  ConfirmIfDue();
}

void TrackLife::ConfirmIfDue() {
  if (state_ == TrackState::kTentative &&
      hits_ >= std::min<int64_t>(2, confirm_hits_) &&
      hit_frames_ >= static_cast<double>(confirm_hits_)) {
    state_ = TrackState::kConfirmed;
  }
}

void TrackLife::BeginFrame(TimeNs time, double look_frames) {
  // In consecutive frames Step has already deleted tracks of this age.
  if (independent_frames_ ||
      !clock_.Less(time - last_update_, max_age_frames_ + look_frames)) {
    state_ = TrackState::kDeleted;
  }
}

void TrackLife::Step(TimeNs time, bool matched, bool updated, double frames) {
  if (updated) {
    ++hits_;
    hit_frames_ += frames;
    last_update_ = time;
    ConfirmIfDue();
    return;
  }
  const bool lost = state_ == TrackState::kTentative && !matched;
  const bool stale = !clock_.Less(time - last_update_, max_age_frames_);
  if (lost || stale) state_ = TrackState::kDeleted;
}

void WriteGate::Settle(Verdict waiting, Verdict verdict) {
  std::replace(verdicts_.begin(), verdicts_.end(), waiting, verdict);
}

void WriteGate::Step(TimeNs time, TrackState state, bool updated) {
  if (state == TrackState::kConfirmed) {
    if (!was_confirmed_) {
      Settle(Verdict::kTentative, backfill_ ? Verdict::kWrite : Verdict::kDrop);
      was_confirmed_ = true;
    }
    if (updated) {
      // Half a frame of tolerance: a gap of exactly max_gap frames is bridged.
      const bool bridged =
          max_gap_frames_ > 0.0 &&
          clock_.Less(time - last_update_, max_gap_frames_ + 2.0);
      Settle(Verdict::kGap, bridged ? Verdict::kWrite : Verdict::kDrop);
      last_update_ = time;
      verdicts_.push_back(Verdict::kWrite);
      return;
    }
    verdicts_.push_back(max_gap_frames_ > 0.0 ? Verdict::kGap : Verdict::kDrop);
    return;
  }
  if (updated) last_update_ = time;
  const bool waits = backfill_ && updated && state == TrackState::kTentative;
  verdicts_.push_back(waits ? Verdict::kTentative : Verdict::kDrop);
}

void WriteGate::Close() {
  Settle(Verdict::kTentative, Verdict::kDrop);
  Settle(Verdict::kGap, Verdict::kDrop);
}

bool WriteGate::Pop(bool* write) {
  if (verdicts_.empty()) return false;
  const Verdict oldest = verdicts_.front();
  if (oldest == Verdict::kTentative || oldest == Verdict::kGap) return false;
  *write = oldest == Verdict::kWrite;
  verdicts_.pop_front();
  return true;
}

}  // namespace kinegraph
