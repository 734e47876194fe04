// Dense arrays over frames, people and joints: NumPy's .npz, and the format of
// the Python package `movement`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/data/limits.h"
#include "core/io/binary/npz_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

// ---- NumPy ----
//
// Reads tracks from the NumPy arrays that are listed at WriteNpzTracks. Without
// `status` every finite position is an observed joint.

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
    const size_t all = frames_ * people_ * joints_;
    status_ = file_.Has("status") ? Fitting(all, "status", 3)
                                  : StatusesByPositions(all);
    if (file_.Has("views")) views_ = Fitting(all, "views", 3);
    if (file_.Has("covariance")) {
      covariances_ = file_.Numbers("covariance", 5);
      RequireSize("covariance", covariances_.size(), 9 * all);
    }
    const Skeleton skeleton = ReadSkeleton();
    TrackCollector collector("npz", skeleton, options_, ReadFrameRate());
    for (size_t f = 0; f < frames_; ++f) {
      Located(
          path_, [&] { return "frames[" + std::to_string(f) + "]"; },
          [&] { ReadFrame(f, &collector); });
    }
    ReadTimes(&collector);
    return collector.Finish();
  }

 private:
  void RequireSize(const std::string& name, size_t found,
                   size_t expected) const {
    if (found != expected) file_.Fail(name, "does not fit the positions");
  }

  std::vector<int64_t> Fitting(size_t count, const std::string& name,
                               size_t rank) const {
    std::vector<int64_t> values = file_.Integers(name, rank);
    RequireSize(name, values.size(), count);
    return values;
  }

  std::vector<int64_t> Checked(const std::string& name, size_t count,
                               int64_t high) const {
    std::vector<int64_t> values = Fitting(count, name, 1);
    for (const int64_t value : values) {
      if (value < 0 || value > high) {
        file_.Fail(name, "found " + std::to_string(value) + ", expected 0 .. " +
                             std::to_string(high));
      }
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

  Skeleton ReadSkeleton() const {
    const std::vector<std::string> names = file_.Texts("joints", 1);
    RequireSize("joints", names.size(), joints_);
    if (options_.skeleton.has_value() || !file_.Has("bones") ||
        !file_.Has("skeleton")) {
      return Located(path_, [&] { return SkeletonOfNames(names, options_); });
    }
    try {
      return Skeleton(file_.Texts("skeleton", 0).front(), names, ReadBones());
    } catch (const OptionError& error) {
      file_.Fail("skeleton", error.message());
    }
  }

  // The file's frame rate; 0 if it is unknown.
  double ReadFrameRate() const {
    if (!file_.Has("frame_rate")) return 0.0;
    const double rate = file_.Numbers("frame_rate", 0).front();
    if (rate > kMaxFrameRate_hz || rate < 0.0)
      file_.Fail("frame_rate", "expected a frame rate in Hz");
    return rate > 0.0 ? rate : 0.0;
  }

  // A NaN is an unknown time, for which frame / frame rate remains.
  void ReadTimes(TrackCollector* collector) const {
    if (!file_.Has("times")) return;
    const std::vector<double> times_s = file_.Numbers("times", 1);
    RequireSize("times", times_s.size(), frames_);
    for (size_t f = 0; f < frames_; ++f) {
      if (std::isnan(times_s[f])) continue;
      if (std::abs(times_s[f]) > kMaxTime_s) {
        file_.Fail("times", "exceeds 4.6e9 s");
      }
      collector->Touch(numbers_[f])->time = FromSeconds(times_s[f]);
    }
  }

  void ReadFrame(size_t f, TrackCollector* collector) const {
    collector->Touch(numbers_[f]);
    for (size_t p = 0; p < people_; ++p) {
      const size_t first = (f * people_ + p) * joints_;
      const auto begin = status_.begin() + static_cast<long>(first);
      if (std::all_of(begin, begin + static_cast<long>(joints_),
                      [](int64_t status) { return status < 0; })) {
        continue;
      }
      PersonPose* person = collector->Add(numbers_[f], TrackId(ids_[p]));
      if (!covariances_.empty()) person->covariances.resize(joints_);
      for (size_t j = 0; j < joints_; ++j) {
        person->joints[j] = JointAt(first + j);
        if (!views_.empty()) {
          constexpr int64_t kMaxViews = 100000;
          person->inlier_views.push_back(static_cast<int>(
              std::clamp<int64_t>(views_[first + j], 0, kMaxViews)));
        }
        if (covariances_.empty()) continue;
        const Eigen::Matrix3d covariance(&covariances_[(first + j) * 9]);
        if (!std::isnan(covariance(0, 0))) {
          person->covariances[j] = covariance;
        }
      }
    }
  }

  bool HasPosition(size_t at) const {
    const double* m = &positions_[at * 3];
    return std::isfinite(m[0]) && std::isfinite(m[1]) && std::isfinite(m[2]);
  }

  // For files without `status`: a person is absent from a frame in which all of
  // the person's x coordinates are NaN.
  std::vector<int64_t> StatusesByPositions(size_t count) const {
    std::vector<int64_t> statuses(count);
    for (size_t i = 0; i < count; ++i) {
      const bool has_number = !std::isnan(positions_[i * 3]);
      statuses[i] = HasPosition(i) ? 2 : has_number ? 0 : -1;
    }
    return statuses;
  }

  Joint3d JointAt(size_t at) const {
    if (status_[at] > 2) {
      Refuse("status: found {}, expected -1 .. 2", status_[at]);
    }
    if (status_[at] <= 0) return {};
    if (!HasPosition(at)) {
      throw InputError("status: a joint has a status, but no position");
    }
    return {Eigen::Vector3d(&positions_[at * 3]),
            static_cast<JointStatus>(status_[at])};
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

// An array over frames, people and joints with `width` values each. `fill` sets
// them where a person is present; elsewhere they are `empty`. `ids` ascend.
template <typename Value, typename Fill>
std::vector<Value> Dense(const TrackSequence& tracks,
                         const std::vector<int64_t>& ids, size_t width,
                         Value empty, const Fill& fill) {
  const size_t joints = tracks.header.skeleton.joints().size();
  std::vector<Value> values(tracks.frames.size() * ids.size() * joints * width,
                            empty);
  for (size_t f = 0; f < tracks.frames.size(); ++f) {
    for (const PersonPose& person : tracks.frames[f].people) {
      const auto id =
          std::lower_bound(ids.begin(), ids.end(), person.id.value());
      const size_t place =
          f * ids.size() + static_cast<size_t>(id - ids.begin());
      Value* to = values.data() + place * joints * width;
      for (size_t j = 0; j < joints; ++j) fill(person, j, to + j * width);
    }
  }
  return values;
}

// Throws InputError if the arrays would be too large for a file, before memory
// is allocated.
void CheckSize(const std::string& path, const std::vector<size_t>& shape,
               bool has_covariances) {
  // Of a joint's position and covariance; its other values take only 3 bytes
  // and are neglected.
  double bytes = has_covariances ? 9 * 8.0 + 3 * 8.0 : 3 * 8.0;
  for (const size_t side : shape) bytes *= static_cast<double>(side);
  if (bytes < static_cast<double>(NpzFile::kMaxBytes)) return;
  throw InputError(
      path, "",
      fmt::format("{} frames of {} people would exceed 4 GB, the limit of this "
                  "format; write fewer frames, or CSV",
                  shape[0], shape[1]));
}

void AddClock(const TrackSequence& tracks, bool has_clock, NpzFile* file) {
  std::vector<int64_t> frames;
  std::vector<double> times;
  for (const TrackFrame& frame : tracks.frames) {
    frames.push_back(frame.frame);
    times.push_back(has_clock ? ToSeconds(frame.time) : kNan);
  }
  const double rate = tracks.header.frame_rate_hz;
  file->Add("frames", {frames.size()}, frames);
  file->Add("times", {times.size()}, times);
  file->Add("frame_rate", {}, std::vector<double>{rate > 0.0 ? rate : kNan});
}

void AddNames(const PersonNames& names, const std::vector<int64_t>& ids,
              NpzFile* file) {
  if (names.empty()) return;
  std::vector<std::string> of_ids;
  for (const int64_t id : ids) {
    const auto name = names.find(TrackId(id));
    of_ids.push_back(name == names.end() ? "" : name->second);
  }
  file->AddTexts("names", {ids.size()}, of_ids);
}

void AddSkeleton(const Skeleton& skeleton, NpzFile* file) {
  std::vector<int32_t> bones;
  for (const Bone& bone : skeleton.bones()) {
    bones.push_back(bone.a);
    bones.push_back(bone.b);
  }
  file->AddTexts("joints", {skeleton.joints().size()}, skeleton.joints());
  file->Add("bones", {skeleton.bones().size(), 2}, bones);
  file->AddTexts("skeleton", {}, {skeleton.name()});
}

}  // namespace

bool RecogniseNpzTracks(const TrackHead& head) {
  return head.BeginsWith("PK\x03\x04");
}

TrackSequence ReadNpzTracks(const std::string& path,
                            const TrackReadOptions& options) {
  return NpzTrackReader(path, options).Read();
}

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

// Writes NumPy's .npz, an uncompressed archive of arrays over F frames, P
// people and J joints:
//   positions   float64 [F, P, J, 3]     m; NaN where there is none
//   status      int8    [F, P, J]        2 observed, 1 inferred, 0 missing;
//                                        -1 if the person is absent
//   views       int16   [F, P, J]        inlier views, -1 unknown; if any
//   covariance  float64 [F, P, J, 3, 3]  m^2; NaN where there is none; if any
//   ids         int64   [P]
//   names       <U      [P]              if any person has one; empty: none
//   frames      int64   [F]
//   times       float64 [F]              s; NaN if unknown
//   frame_rate  float64 []               Hz; NaN if unknown
//   joints      <U      [J]              names
//   bones       int32   [B, 2]           indices into joints
//   skeleton    <U      []               name
void WriteNpzTracks(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  const std::vector<int64_t> ids = IdsOf(tracks);
  const size_t frames = tracks.frames.size();
  const size_t joints = tracks.header.skeleton.joints().size();
  CheckSize(path, {frames, ids.size(), joints}, contents.has_covariances);
  NpzFile file(path);
  // One array at a time, to bound memory.
  file.Add("positions", {frames, ids.size(), joints, 3},
           Dense(tracks, ids, 3, kNan,
                 [](const PersonPose& person, size_t j, double* to) {
                   const Joint3d& at = person.joints[j];
                   if (at.present()) std::copy_n(at.position_m.data(), 3, to);
                 }));
  file.Add("status", {frames, ids.size(), joints},
           Dense(tracks, ids, 1, int8_t{-1},
                 [](const PersonPose& person, size_t j, int8_t* to) {
                   *to = static_cast<int8_t>(person.joints[j].status);
                 }));
  if (contents.has_views) {
    file.Add("views", {frames, ids.size(), joints},
             Dense(tracks, ids, 1, int16_t{-1},
                   [](const PersonPose& person, size_t j, int16_t* to) {
                     if (person.inlier_views.empty()) return;
                     constexpr int kMost = std::numeric_limits<int16_t>::max();
                     *to = static_cast<int16_t>(
                         std::min(person.inlier_views[j], kMost));
                   }));
  }
  if (contents.has_covariances) {
    file.Add("covariance", {frames, ids.size(), joints, 3, 3},
             Dense(tracks, ids, 9, kNan,
                   [](const PersonPose& person, size_t j, double* to) {
                     if (person.covariances.empty()) return;
                     const auto& covariance = person.covariances[j];
                     if (covariance) std::copy_n(covariance->data(), 9, to);
                   }));
  }
  file.Add("ids", {ids.size()}, ids);
  AddNames(options.names, ids, &file);
  AddClock(tracks, contents.has_clock, &file);
  AddSkeleton(tracks.header.skeleton, &file);
  file.Commit();
  lost_fields->push_back("the configuration is not kept");
  NoteLosses(contents, {Loss::kUnknownClock, Loss::kMatches}, lost_fields);
}

// Writes a data set of poses for the Python package `movement` and xarray:
// netCDF, written by an adapter.
void WriteMovementTracks(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& options,
                         LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  TrackWriteOptions write;
  write.titles = PersonTitles(RequirePeople(tracks), options.names);
  // `confidence` is the probability that the true joint is within 5 cm of the
  // estimate.
  write.within_m = 0.05;
  WriteTracksByAdapter("movement", path, tracks, write);
  lost_fields->push_back("bones, views and configuration are not kept");
  lost_fields->push_back(
      contents.has_covariances
          ? "of covariances only the standard deviation of each axis is kept"
          : "confidence is NaN: the tracks have no covariances");
  if (!contents.has_clock) {
    lost_fields->push_back(
        "frame numbers are written as times (--frame_rate=HZ)");
  }
}

}  // namespace kinegraph
