// Tracks as dense NumPy arrays (track_export.h lists them).
#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/binary/npz_file.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

// The arrays of one recording. Each is made, written and forgotten in turn.
class Arrays {
 public:
  explicit Arrays(const TrackSequence& tracks)
      : tracks_(tracks),
        ids_(IdsOf(tracks)),
        frames_(tracks.frames.size()),
        joints_(tracks.header.skeleton.joints().size()) {}

  std::vector<size_t> Shape(std::vector<size_t> more = {}) const {
    std::vector<size_t> shape = {frames_, ids_.size(), joints_};
    shape.insert(shape.end(), more.begin(), more.end());
    return shape;
  }

  const std::vector<int64_t>& ids() const { return ids_; }

  std::vector<double> Positions() const {
    return Dense<double>(3, kNan,
                         [](const PersonPose& person, size_t j, double* to) {
                           const Joint3d& joint = person.joints[j];
                           if (joint.present())
                             std::copy_n(joint.position_m.data(), 3, to);
                         });
  }

  std::vector<int8_t> Status() const {
    constexpr int8_t kAbsent = -1;
    return Dense<int8_t>(1, kAbsent,
                         [](const PersonPose& person, size_t j, int8_t* to) {
                           switch (person.joints[j].status) {
                             case JointStatus::kMissing:
                               *to = 0;
                               break;
                             case JointStatus::kInferred:
                               *to = 1;
                               break;
                             case JointStatus::kObserved:
                               *to = 2;
                               break;
                           }
                         });
  }

  std::vector<int16_t> Views() const {
    constexpr int16_t kUnknown = -1;
    return Dense<int16_t>(
        1, kUnknown, [](const PersonPose& person, size_t j, int16_t* to) {
          if (person.inlier_views.empty()) return;
          *to = static_cast<int16_t>(std::min<int>(
              person.inlier_views[j], std::numeric_limits<int16_t>::max()));
        });
  }

  std::vector<double> Covariances() const {
    return Dense<double>(
        9, kNan, [](const PersonPose& person, size_t j, double* to) {
          if (person.covariances.empty() || !person.covariances[j]) return;
          std::copy_n(person.covariances[j]->data(), 9, to);  // symmetric
        });
  }

 private:
  // `fill` writes the `width` numbers of one joint.
  template <typename Value, typename Fill>
  std::vector<Value> Dense(size_t width, Value empty, const Fill& fill) const {
    std::vector<Value> values(frames_ * ids_.size() * joints_ * width, empty);
    for (size_t f = 0; f < frames_; ++f) {
      for (const PersonPose& person : tracks_.frames[f].people) {
        const auto at =
            std::lower_bound(ids_.begin(), ids_.end(), person.id.value());
        const auto p = static_cast<size_t>(at - ids_.begin());
        Value* to = values.data() + (f * ids_.size() + p) * joints_ * width;
        for (size_t j = 0; j < joints_; ++j) {
          fill(person, j, to + j * width);
        }
      }
    }
    return values;
  }

  const TrackSequence& tracks_;
  const std::vector<int64_t> ids_;
  const size_t frames_;
  const size_t joints_;
};

// Before gigabytes are filled that no file can take.
void CheckSize(const std::string& path, const std::vector<size_t>& shape,
               bool has_covariances) {
  double bytes = has_covariances ? 9 * 8.0 + 3 * 8.0 : 3 * 8.0;
  for (const size_t side : shape) bytes *= static_cast<double>(side);
  if (bytes < static_cast<double>(NpzFile::kMaxBytes)) return;
  throw InputError(path, "",
                   std::to_string(shape[0]) + " frames of " +
                       std::to_string(shape[1]) +
                       " people would have more than 4 GB, which this format "
                       "does not hold; take fewer frames or CSV");
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

void WriteTracksNpz(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  const Arrays arrays(tracks);
  CheckSize(path, arrays.Shape(), contents.has_covariances);
  NpzFile file(path);
  file.Add("positions", arrays.Shape({3}), arrays.Positions());
  file.Add("status", arrays.Shape(), arrays.Status());
  if (contents.has_views) file.Add("views", arrays.Shape(), arrays.Views());
  if (contents.has_covariances) {
    file.Add("covariance", arrays.Shape({3, 3}), arrays.Covariances());
  }
  file.Add("ids", {arrays.ids().size()}, arrays.ids());
  AddNames(options.names, arrays.ids(), &file);
  AddClock(tracks, contents.has_clock, &file);
  AddSkeleton(tracks.header.skeleton, &file);
  file.Commit();
  lost_fields->push_back("the configuration is not kept");
  if (!contents.has_clock) lost_fields->push_back(kNoClock);
  if (contents.has_matches) lost_fields->push_back("matches are not kept");
}

}  // namespace kinegraph
