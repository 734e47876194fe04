#include "core/io/detections/rated_source.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/time.h"

namespace kinegraph {
namespace {

// The views of one rate, without frames in which none of them shows anybody.
class RatedViews {
 public:
  RatedViews(double rate_hz, int64_t offset, std::vector<size_t> views,
             std::unique_ptr<DetectionSource> source)
      : clock_(rate_hz),
        offset_(offset),
        views_(std::move(views)),
        source_(std::move(source)) {
    Read();
  }

  bool has_frame() const { return has_frame_; }
  // The recording's frame that is nearest to the next one of these views; of
  // two the earlier, so that the recording does not grow by half a frame. The
  // nanoseconds of times are less than a millionth of any frame.
  int64_t NextFrameOf(const FrameClock& recording) const {
    const double frames = recording.Frames(clock_.TimeOf(frame_.frame));
    return static_cast<int64_t>(std::ceil(frames - 0.5 - 1e-6));
  }

  // Gives `frame` what these views saw nearest to it, and goes on behind it.
  void Join(const FrameClock& recording, DetectionFrame* frame) {
    for (const size_t v : views_) frame->views[v].capture_time = frame->time;
    bool found = false;
    TimeNs nearest = 0;
    for (; has_frame_ && NextFrameOf(recording) <= frame->frame; Read()) {
      const TimeNs time = clock_.TimeOf(frame_.frame);
      const TimeNs off = std::abs(time - frame->time);
      if (found && off >= nearest) continue;
      found = true;
      nearest = off;
      for (const size_t v : views_) {
        frame->views[v].detections = std::move(frame_.views[v].detections);
        frame->views[v].capture_time = time;
      }
    }
  }

 private:
  void Read() {
    while ((has_frame_ = source_->Next(&frame_))) {
      frame_.frame -= offset_;
      if (frame_.frame < 0) continue;
      for (const size_t v : views_) {
        if (!frame_.views[v].detections.empty()) return;
      }
    }
  }

  FrameClock clock_;
  int64_t offset_;  // of the numbers of these views' files
  std::vector<size_t> views_;
  std::unique_ptr<DetectionSource> source_;
  DetectionFrame frame_;  // read and not passed
  bool has_frame_ = false;
};

class RatedSource final : public DetectionSource {
 public:
  RatedSource(const std::function<std::unique_ptr<DetectionSource>()>& open,
              const DetectionReadOptions& options)
      : base_(open()), clock_(RateOf(base_->header())) {
    const std::vector<std::string>& names = base_->header().view_names;
    is_rated_.assign(names.size(), false);
    std::vector<double> rates_hz(names.size(), base_->header().frame_rate_hz);
    std::vector<int64_t> offsets(names.size(), 0);
    for (const auto& [name, rate_hz] : options.view_frame_rate_hz) {
      rates_hz[Rated("input.view_frame_rate.", name)] = rate_hz;
    }
    for (const auto& [name, offset] : options.view_frame_offset) {
      offsets[Rated("input.view_frame_offset.", name)] = offset;
    }
    std::map<std::pair<double, int64_t>, std::vector<size_t>> alike;
    for (size_t v = 0; v < names.size(); ++v) {
      if (is_rated_[v]) alike[{rates_hz[v], offsets[v]}].push_back(v);
    }
    for (const auto& [counting, views] : alike) {
      rated_.emplace_back(counting.first, counting.second, views, open());
    }
  }

  const DetectionHeader& header() const override { return base_->header(); }

  bool Next(DetectionFrame* frame) override {
    constexpr int64_t kNone = std::numeric_limits<int64_t>::max();
    if (waiting_.empty() && !ended_) ReadBase();
    int64_t number = kNone;
    for (const RatedViews& views : rated_) {
      if (!views.has_frame()) continue;
      number = std::min(number, views.NextFrameOf(clock_));
    }
    // Files that count faster go on after the end of the recording.
    if (number == kNone && (ended_ || waiting_.empty())) return false;
    if (!waiting_.empty() && waiting_.front().frame <= number) {
      *frame = std::move(waiting_.front());
      waiting_.pop_front();
    } else {
      *frame = FrameAt(number);
    }
    for (RatedViews& views : rated_) views.Join(clock_, frame);
    return true;
  }

 private:
  // The view of that name, which counts in its own way.
  size_t Rated(const std::string& key, const std::string& name) {
    const std::vector<std::string>& names = base_->header().view_names;
    std::string known;
    for (size_t v = 0; v < names.size(); ++v) {
      if (names[v] == name) {
        is_rated_[v] = true;
        return v;
      }
      known += (known.empty() ? "" : ", ") + Printable(names[v]);
    }
    throw InputError(key + Printable(name) +
                     ": the detections have no view of that name, expected "
                     "one of " +
                     known);
  }

  static double RateOf(const DetectionHeader& header) {
    if (!(header.frame_rate_hz > 0.0)) {
      throw OptionError("input.frame_rate",
                        "not given, and views with rates of their own need it "
                        "[Hz]");
    }
    return header.frame_rate_hz;
  }

  DetectionFrame FrameAt(int64_t number) const {
    DetectionFrame frame;
    frame.frame = number;
    frame.time = clock_.TimeOf(number);
    frame.views.resize(is_rated_.size());
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
    return frame;
  }

  // Frames up to the next one in which a view of the recording's own rate shows
  // somebody, from the first such on; at the end, those in which none does any
  // more.
  void ReadBase() {
    DetectionFrame frame;
    while (base_->Next(&frame)) {
      // A microsecond: files round their times.
      if (std::abs(frame.time - clock_.TimeOf(frame.frame)) >
          FromSeconds(1e-6)) {
        throw InputError(
            "input.view_frame_rate: frame " + std::to_string(frame.frame) +
            " tells its own time; such a file states the times of single views "
            "by view_times");
      }
      bool has_any = false;
      for (size_t v = 0; v < is_rated_.size(); ++v) {
        if (is_rated_[v]) frame.views[v].detections.clear();
        has_any = has_any || !frame.views[v].detections.empty();
      }
      // Nobody's before the first: numbers of files that count otherwise.
      if (!has_any && !begun_) continue;
      begun_ = true;
      waiting_.push_back(std::move(frame));
      if (has_any) return;
    }
    ended_ = true;
  }

  std::unique_ptr<DetectionSource> base_;
  FrameClock clock_;
  std::vector<bool> is_rated_;
  std::vector<RatedViews> rated_;
  std::deque<DetectionFrame> waiting_;  // read and not passed
  bool begun_ = false;
  bool ended_ = false;  // those that wait show nobody, nor does any later one
};

}  // namespace

std::unique_ptr<DetectionSource> OpenRated(
    const std::function<std::unique_ptr<DetectionSource>()>& open,
    const DetectionReadOptions& options) {
  return std::make_unique<RatedSource>(open, options);
}

}  // namespace kinegraph
