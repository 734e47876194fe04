#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/time.h"
#include "core/io/detections/formats.h"

namespace kinegraph {
namespace {

// Frame rate of a view [Hz], and the offset subtracted from its frame numbers.
using Counting = std::pair<double, int64_t>;

// The counting of each view that the options name.
std::map<size_t, Counting> CountingOfViews(
    const DetectionHeader& header, const DetectionReadOptions& options) {
  std::map<size_t, Counting> counting;
  const auto of = [&](const std::string& key,
                      const std::string& name) -> Counting& {
    std::string known;
    for (size_t v = 0; v < header.view_names.size(); ++v) {
      const std::string& one = header.view_names[v];
      if (one == name) {
        return counting.try_emplace(v, header.frame_rate_hz, 0).first->second;
      }
      known += (known.empty() ? "" : ", ") + Printable(one);
    }
    throw InputError(key + Printable(name) +
                     ": the detections have no view of that name, expected "
                     "one of " +
                     known);
  };
  for (const auto& [name, rate_hz] : options.view_frame_rate_hz) {
    of("input.view_frame_rate.", name).first = rate_hz;
  }
  for (const auto& [name, offset] : options.view_frame_offset) {
    of("input.view_frame_offset.", name).second = offset;
  }
  return counting;
}

bool ShowsAnybody(const DetectionFrame& frame,
                  const std::vector<size_t>& views) {
  return std::any_of(views.begin(), views.end(), [&](size_t v) {
    return !frame.views[v].detections.empty();
  });
}

// Adds the frames of the views `own`, which have the recording's rate, from the
// first frame in which one of them has detections; the views in `others` remain
// empty. Returns the last frame with detections of `own`; -1 if there is none.
int64_t AddOwnViews(const FrameClock& clock, const std::vector<size_t>& own,
                    const std::map<size_t, Counting>& others,
                    DetectionSource* source, DetectionCollector* collector) {
  int64_t last = -1;
  DetectionFrame frame;
  while (source->Next(&frame)) {
    // Tolerance of 1 us: files round their times.
    if (std::abs(frame.time - clock.TimeOf(frame.frame)) > FromSeconds(1e-6)) {
      throw InputError(
          "input.view_frame_rate, input.view_frame_offset: frame " +
          std::to_string(frame.frame) +
          " has its own time; a file with times must specify those of "
          "individual views by view_times");
    }
    const bool has_any = ShowsAnybody(frame, own);
    // Empty frames before the first one may stem from files of the other views,
    // which number their frames differently.
    if (!has_any && last < 0) continue;
    if (has_any) last = frame.frame;
    for (const auto& [v, counting] : others) {
      frame.views[v].detections.clear();
      frame.views[v].capture_time = frame.time;
    }
    *collector->Touch(frame.frame) = std::move(frame);
  }
  return last;
}

// Adds views with the same counting to the frames of the recording that are
// nearest in time. A tie goes to the earlier frame, so that the recording does
// not become longer. Returns the last frame to which detections were added; -1
// if there is none.
int64_t AddViews(const FrameClock& recording, const Counting& counting,
                 const std::vector<size_t>& views, DetectionSource* source,
                 DetectionCollector* collector) {
  const FrameClock clock(counting.first);
  int64_t last = -1;
  TimeNs nearest = 0;
  DetectionFrame frame;
  while (source->Next(&frame)) {
    const int64_t number = frame.frame - counting.second;
    if (number < 0 || !ShowsAnybody(frame, views)) continue;
    const TimeNs time = clock.TimeOf(number);
    // Times are rounded to nanoseconds: a millionth of a frame at 1000 Hz.
    const auto joined_number =
        static_cast<int64_t>(std::ceil(recording.Frames(time) - 0.5 - 1e-6));
    DetectionFrame* joined = collector->Touch(joined_number);
    const TimeNs off = std::abs(time - joined->time);
    if (joined_number == last && off >= nearest) continue;
    last = joined_number;
    nearest = off;
    for (const size_t v : views) {
      joined->views[v].detections = std::move(frame.views[v].detections);
      joined->views[v].capture_time = time;
    }
  }
  return last;
}

}  // namespace

std::unique_ptr<DetectionSource> OpenRated(
    const std::function<std::unique_ptr<DetectionSource>()>& open,
    const DetectionReadOptions& options) {
  const std::unique_ptr<DetectionSource> source = open();
  const DetectionHeader& header = source->header();
  if (!(header.frame_rate_hz > 0.0)) {
    throw OptionError(
        "input.frame_rate",
        "not given, but required in Hz for views with a frame rate or "
        "frame numbers of their own");
  }
  const std::map<size_t, Counting> others = CountingOfViews(header, options);
  std::map<Counting, std::vector<size_t>> alike;
  for (const auto& [v, counting] : others) alike[counting].push_back(v);
  std::vector<size_t> own;
  for (size_t v = 0; v < header.view_names.size(); ++v) {
    if (others.count(v) == 0) own.push_back(v);
  }
  const FrameClock clock(header.frame_rate_hz);
  DetectionCollector collector(header);
  int64_t last = AddOwnViews(clock, own, others, source.get(), &collector);
  for (const auto& [counting, views] : alike) {
    last = std::max(last,
                    AddViews(clock, counting, views, open().get(), &collector));
  }
  // Files at a higher rate have frame numbers beyond the end of the recording,
  // for which AddOwnViews has created frames.
  collector.DropAfter(last);
  return collector.Finish();
}

}  // namespace kinegraph
