#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "core/io/adapters/adapter.h"
#include "core/io/detections/formats.h"

namespace kinegraph {
namespace {

std::vector<std::string> FlagsOf(const DetectionReadOptions& options) {
  std::vector<std::string> flags;
  if (options.skeleton.has_value()) {
    flags.push_back("--joints=" +
                    std::to_string(options.skeleton->joint_count()));
  }
  if (options.first_frame != 0) {
    flags.push_back("--first_frame=" + std::to_string(options.first_frame));
  }
  if (options.frame_rate_hz > 0.0) {
    flags.push_back(fmt::format("--frame_rate={}", options.frame_rate_hz));
  }
  return flags;
}

class AdapterSource : public DetectionSource {
 public:
  AdapterSource(const Adapter& adapter, const std::string& path,
                const DetectionReadOptions& options)
      : run_(adapter, path, FlagsOf(options)) {
    lines_ = run_.Guard([&] {
      return OpenLines(path, options, run_.TakeOutput(), run_.silence_ms());
    });
  }

  const DetectionHeader& header() const override { return lines_->header(); }
  int64_t frame_count() const override { return lines_->frame_count(); }
  bool Next(DetectionFrame* frame) override {
    const bool is_frame = run_.Guard([&] { return lines_->Next(frame); });
    if (!is_frame) run_.Finish();
    return is_frame;
  }

 private:
  AdapterRun run_;
  std::unique_ptr<DetectionSource> lines_;
};

// Removes people without any found joint; index_in_file of the others becomes
// their position among those that remain.
class SeenPeople : public DetectionSource {
 public:
  explicit SeenPeople(std::unique_ptr<DetectionSource> source)
      : source_(std::move(source)) {}

  const DetectionHeader& header() const override { return source_->header(); }
  int64_t frame_count() const override { return source_->frame_count(); }
  bool Next(DetectionFrame* frame) override {
    if (!source_->Next(frame)) return false;
    for (ViewDetections& view : frame->views) {
      auto& all = view.detections;
      all.erase(std::remove_if(all.begin(), all.end(),
                               [](const Detection& detection) {
                                 return !IsAnyFound(detection.joints);
                               }),
                all.end());
      for (size_t i = 0; i < all.size(); ++i) {
        all[i].index_in_file = static_cast<int>(i);
      }
    }
    return true;
  }

 private:
  const std::unique_ptr<DetectionSource> source_;
};

}  // namespace

std::unique_ptr<DetectionSource> OpenEverybodyByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options) {
  return std::make_unique<AdapterSource>(adapter, path, options);
}

std::unique_ptr<DetectionSource> OpenByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options) {
  return std::make_unique<SeenPeople>(
      OpenEverybodyByAdapter(adapter, path, options));
}

}  // namespace kinegraph
