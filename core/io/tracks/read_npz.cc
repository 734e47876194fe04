// Tracks from the arrays that WriteTracksNpz writes (track_export.h). Without
// `status` every position is an observed joint.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/io/binary/npz_reader.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/ids.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/person_files.h"

namespace kinegraph {
namespace {

class NpzTrackReader {
 public:
  NpzTrackReader(const std::string& path, const TrackReadOptions& options)
      : path_(path), options_(options), file_(path) {}

  TrackSequence Read() {
    const std::vector<size_t>& shape = file_.At("positions", 4).shape;
    frames_ = shape[0];
    people_ = shape[1];
    joints_ = shape[2];
    if (shape[3] != 3) file_.Fail("positions", "expected [.., .., .., 3]");
    positions_ = file_.Numbers("positions", 4);
    ids_ = Checked("ids", people_, kMaxId);
    numbers_ = Checked("frames", frames_, kMaxFrame);
    if (file_.Has("status")) status_ = Dense("status");
    if (file_.Has("views")) views_ = Dense("views");
    if (file_.Has("covariance")) {
      covariances_ = file_.Numbers("covariance", 5);
      if (covariances_.size() != frames_ * people_ * joints_ * 9) {
        file_.Fail("covariance", "does not fit the positions");
      }
    }
    TrackCollector collector(ReadHeader());
    for (size_t f = 0; f < frames_; ++f) {
      Located(
          path_, [&] { return "frames[" + std::to_string(f) + "]"; },
          [&] { ReadFrame(f, &collector); });
    }
    ReadTimes(&collector);
    return collector.Finish();
  }

 private:
  std::vector<int64_t> Checked(const std::string& name, size_t count,
                               int64_t high) const {
    std::vector<int64_t> values = file_.Integers(name, 1);
    if (values.size() != count) file_.Fail(name, "does not fit the positions");
    for (const int64_t value : values) {
      if (value < 0 || value > high) {
        file_.Fail(name, "found " + std::to_string(value) + ", expected 0 .. " +
                             std::to_string(high));
      }
    }
    return values;
  }

  std::vector<int64_t> Dense(const std::string& name) const {
    std::vector<int64_t> values = file_.Integers(name, 3);
    if (values.size() != frames_ * people_ * joints_) {
      file_.Fail(name, "does not fit the positions");
    }
    return values;
  }

  std::vector<Bone> ReadBones() const {
    if (file_.At("bones", 2).shape[1] != 2) {
      file_.Fail("bones", "expected [.., 2]");
    }
    const std::vector<int64_t> ends = file_.Integers("bones", 2);
    const auto count = static_cast<int64_t>(joints_);
    for (const int64_t end : ends) {
      if (end >= 0 && end < count) continue;
      file_.Fail("bones",
                 fmt::format("found {}, expected 0 .. {}", end, count - 1));
    }
    std::vector<Bone> bones;
    for (size_t b = 0; b < ends.size(); b += 2) {
      bones.push_back(
          {static_cast<int>(ends[b]), static_cast<int>(ends[b + 1])});
    }
    return bones;
  }

  TrackHeader ReadHeader() const {
    TrackHeader header;
    header.mode = "npz";
    const std::vector<std::string> names = file_.Texts("joints", 1);
    if (names.size() != joints_) {
      file_.Fail("joints", "does not fit the positions");
    }
    if (!options_.skeleton.has_value() && file_.Has("bones") &&
        file_.Has("skeleton")) {
      try {
        header.skeleton =
            Skeleton(file_.Texts("skeleton", 0).front(), names, ReadBones());
      } catch (const OptionError& error) {
        file_.Fail("skeleton", error.message());
      }
    } else {
      header.skeleton =
          Located(path_, [&] { return SkeletonOfNames(names, options_); });
    }
    if (options_.frame_rate_hz > 0.0) {
      header.frame_rate_hz = options_.frame_rate_hz;
    } else if (file_.Has("frame_rate")) {
      const double rate = file_.Numbers("frame_rate", 0).front();
      if (rate > 1e6 || rate < 0.0) file_.Fail("frame_rate", "expected Hz");
      if (rate > 0.0) header.frame_rate_hz = rate;
    }
    return header;
  }

  // NaN: not known; then frame / frame rate stays.
  void ReadTimes(TrackCollector* collector) const {
    if (!file_.Has("times")) return;
    const std::vector<double> times_s = file_.Numbers("times", 1);
    if (times_s.size() != frames_) {
      file_.Fail("times", "does not fit the positions");
    }
    for (size_t f = 0; f < frames_; ++f) {
      if (std::isnan(times_s[f])) continue;
      if (std::abs(times_s[f]) > 1e9) file_.Fail("times", "is beyond 1e9 s");
      collector->Touch(numbers_[f])->time = FromSeconds(times_s[f]);
    }
  }

  void ReadFrame(size_t f, TrackCollector* collector) const {
    collector->Touch(numbers_[f]);
    for (size_t p = 0; p < people_; ++p) {
      const size_t first = (f * people_ + p) * joints_;
      if (!IsThere(first)) continue;
      PersonPose* person = collector->Add(numbers_[f], TrackId(ids_[p]));
      if (!covariances_.empty()) person->covariances.resize(joints_);
      for (size_t j = 0; j < joints_; ++j) {
        person->joints[j] = JointAt(first + j);
        if (!views_.empty()) {
          constexpr int64_t kMaxViews = 100000;
          person->inlier_views.push_back(static_cast<int>(
              std::clamp<int64_t>(views_[first + j], 0, kMaxViews)));
        }
        if (!covariances_.empty() &&
            !std::isnan(covariances_[(first + j) * 9])) {
          person->covariances[j] =
              Eigen::Map<const Eigen::Matrix3d>(&covariances_[(first + j) * 9]);
        }
      }
    }
  }

  bool IsThere(size_t first) const {
    if (status_.empty()) {
      for (size_t j = 0; j < joints_; ++j) {
        if (!std::isnan(positions_[(first + j) * 3])) return true;
      }
      return false;
    }
    return std::any_of(status_.begin() + static_cast<long>(first),
                       status_.begin() + static_cast<long>(first + joints_),
                       [](int64_t status) { return status >= 0; });
  }

  Joint3d JointAt(size_t at) const {
    const double* m = &positions_[at * 3];
    const bool has_position =
        std::isfinite(m[0]) && std::isfinite(m[1]) && std::isfinite(m[2]);
    const int64_t status =
        status_.empty() ? (has_position ? 2 : 0) : status_[at];
    if (status > 2) {
      throw InputError("status: found " + std::to_string(status) +
                       ", expected -1 .. 2");
    }
    if (status <= 0) return {};
    if (!has_position)
      throw InputError("status: a joint has one, but no position");
    return {{m[0], m[1], m[2]}, static_cast<JointStatus>(status)};
  }

  const std::string path_;
  const TrackReadOptions& options_;
  const NpzReader file_;
  size_t frames_ = 0;
  size_t people_ = 0;
  size_t joints_ = 0;
  std::vector<double> positions_;
  std::vector<double> covariances_;
  std::vector<int64_t> status_;
  std::vector<int64_t> views_;
  std::vector<int64_t> ids_;
  std::vector<int64_t> numbers_;
};

PersonNames ReadNpzNames(const std::string& path) {
  PersonNames names;
  const NpzReader file(path);
  if (!file.Has("names") || !file.Has("ids")) return names;
  const std::vector<std::string> of_ids = file.Texts("names", 1);
  const std::vector<int64_t> ids = file.Integers("ids", 1);
  if (of_ids.size() != ids.size()) file.Fail("names", "does not fit the ids");
  for (size_t p = 0; p < ids.size(); ++p) {
    if (!of_ids[p].empty()) names[TrackId(ids[p])] = of_ids[p];
  }
  return names;
}

}  // namespace

TrackSequence ReadTracksNpz(const std::string& path,
                            const TrackReadOptions& options) {
  return NpzTrackReader(path, options).Read();
}

TrackFormat NpzTrackFormat() {
  TrackFormat format;
  format.name = "npz";
  format.layout = "NumPy's arrays";
  format.unit_m = 1.0;
  format.extensions = {".npz"};
  format.has_marker_names = true;
  format.recognise = [](const TrackHead& head) {
    return head.BeginsWith("PK\x03\x04");
  };
  format.read = ReadTracksNpz;
  format.read_names = ReadNpzNames;
  format.keeps_names = true;
  format.write = WriteTracksNpz;
  format.read_note = "uncompressed";
  format.kept = "the same, all frames, frame rate, bones";
  format.lost = "matches, configuration";
  return format;
}

}  // namespace kinegraph
