#include "solvers/session/used_frames.h"

#include <utility>

namespace kinegraph {

UsedFrames::UsedFrames(const RunScene& scene, SourceOpener reopen)
    : scene_(&scene), reopen_(std::move(reopen)) {}

void UsedFrames::Feed(const DetectionFrame& used) {
  if (!reopen_) waiting_.push_back(used);
}

const DetectionFrame* UsedFrames::At(int64_t frame) {
  if (reopen_ && source_ == nullptr) source_ = reopen_();
  while (source_ != nullptr ? source_->Next(&read_) : !waiting_.empty()) {
    if (source_ == nullptr) {
      current_ = std::move(waiting_.front());
      waiting_.pop_front();
    } else {
      if (read_.frame < frame) continue;
      KeepUsedViews(*scene_, &read_, &current_);
    }
    if (current_.frame == frame) return &current_;
    if (current_.frame > frame) return nullptr;
  }
  return nullptr;
}

}  // namespace kinegraph
