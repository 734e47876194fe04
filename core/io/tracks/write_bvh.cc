// Biovision's BVH: a hierarchy with offsets at rest, then a row a frame with
// the root's place and three angles a joint. A file is one person. Centimetres
// and degrees; the channels stand as Zrotation Xrotation Yrotation, so a joint
// is turned by Rz Rx Ry. Y is up.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/joint_tree.h"
#include "core/io/tracks/lost_fields.h"
#include "core/io/tracks/person_files.h"
#include "core/io/tracks/read_bvh.h"
#include "core/io/tracks/rows.h"
#include "core/io/tracks/tree_motion.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

constexpr double kDegrees = 180.0 / kPi;

struct Angles {
  double z = 0.0;
  double x = 0.0;
  double y = 0.0;
};

// The turn nearest to `near` that leads to the same angle.
double Unwound(double angle, double near) {
  return angle + 2.0 * kPi * std::round((near - angle) / (2.0 * kPi));
}

Angles Unwound(const Angles& angles, const Angles& near) {
  return {Unwound(angles.z, near.z), Unwound(angles.x, near.x),
          Unwound(angles.y, near.y)};
}

double Distance(const Angles& a, const Angles& b) {
  return std::abs(a.z - b.z) + std::abs(a.x - b.x) + std::abs(a.y - b.y);
}

// Of the two triples that give the rotation the one nearer to the last row's,
// so that a curve has no jumps.
Angles AnglesOf(const Eigen::Quaterniond& rotation, const Angles& last) {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  constexpr double kUpright = 1.0 - 1e-12;
  Angles one;
  one.x = std::asin(std::clamp(r(2, 1), -1.0, 1.0));
  if (std::abs(r(2, 1)) < kUpright) {
    one.y = std::atan2(-r(2, 0), r(2, 2));
    one.z = std::atan2(-r(0, 1), r(1, 1));
  } else {  // only the sum of the other two is told
    one.y = 0.0;
    one.z = std::atan2(r(1, 0), r(0, 0));
  }
  const Angles other = {one.z + kPi, kPi - one.x, one.y + kPi};
  const Angles a = Unwound(one, last);
  const Angles b = Unwound(other, last);
  return Distance(a, last) <= Distance(b, last) ? a : b;
}

std::string NameOf(const TreeJoint& joint) {
  std::string name = joint.name;
  for (char& c : name) {
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  }
  return name;
}

std::string Offset(const Vector3d& offset_m, const std::string& indent) {
  const Vector3d cm = 1.0 / kBvhCentimetre_m * offset_m;
  return fmt::format("{}OFFSET {:.6f} {:.6f} {:.6f}\n", indent, cm.x(), cm.y(),
                     cm.z());
}

void WriteBvhJoint(const JointTree& tree, const TreeMotion& motion,
                   size_t joint, int depth, std::string* text) {
  const std::string indent(static_cast<size_t>(depth), '\t');
  const std::string inside = indent + "\t";
  const bool is_root = tree[joint].parent < 0;
  *text += indent + (is_root ? "ROOT " : "JOINT ") + NameOf(tree[joint]) +
           "\n" + indent + "{\n" + Offset(motion.offsets_m[joint], inside);
  *text +=
      inside +
      (is_root ? "CHANNELS 6 Xposition Yposition Zposition " : "CHANNELS 3 ") +
      "Zrotation Xrotation Yrotation\n";
  for (const int child : tree[joint].children) {
    WriteBvhJoint(tree, motion, static_cast<size_t>(child), depth + 1, text);
  }
  if (tree[joint].children.empty()) {
    // Straight on; a joint alone has something to be seen, too.
    constexpr double kShare = 0.3;
    const Vector3d end_m = motion.offsets_m[joint].isZero()
                               ? Vector3d(0.05 * Vector3d::UnitY())
                               : Vector3d(kShare * motion.offsets_m[joint]);
    *text += inside + "End Site\n" + inside + "{\n" +
             Offset(end_m, inside + "\t") + inside + "}\n";
  }
  *text += indent + "}\n";
}

// Joints as the hierarchy names them, each before those that hang on it: the
// order of a row's angles.
void AddInOrder(const JointTree& tree, size_t joint,
                std::vector<size_t>* order) {
  order->push_back(joint);
  for (const int child : tree[joint].children) {
    AddInOrder(tree, static_cast<size_t>(child), order);
  }
}

// How far the rigid skeleton lies from the tracks.
struct Misfit {
  double sum_m2 = 0.0;
  double largest_m = 0.0;
  int64_t count = 0;
  size_t filled = 0;
};

// The rows of a person, from the first to the last that has him.
struct Span {
  size_t first = 0;
  size_t count = 0;
};

class Writer {
 public:
  Writer(const TrackSequence& tracks, const std::vector<TrackRow>& rows,
         const TrackExportOptions& options)
      : tracks_(tracks),
        rows_(rows),
        axes_(options.axes.value_or(BvhAxes())),
        tree_(MakeJointTree(tracks.header.skeleton, JointsSeen(tracks),
                            /*pivots=*/true)) {
    RequireBones();
    AddInOrder(tree_, 0, &order_);
    for (size_t r = 0; r < rows.size(); ++r) {
      if (rows[r].frame == nullptr) continue;
      for (const PersonPose& person : rows[r].frame->people) {
        const auto [at, is_new] = spans_.try_emplace(person.id.value());
        if (is_new) at->second.first = r;
        at->second.count = r + 1 - at->second.first;
      }
    }
    size_t there = 0;
    for (const auto& [id, span] : spans_) there += span.count;
    // Many who come and go would be files of people who stand still.
    constexpr size_t kMostRows = 200'000;
    constexpr size_t kMostTimes = 5;
    const size_t all = rows.size() * spans_.size();
    on_one_clock_ = all <= std::max(kMostRows, kMostTimes * there);
  }

  void WritePerson(const std::string& path, TrackId id) {
    const Span span = spans_.at(id.value());
    std::vector<const PersonPose*> poses;
    for (size_t r = span.first; r < span.first + span.count; ++r) {
      poses.push_back(FindPerson(rows_[r].frame, id));
    }
    const TreeMotion motion = SolveTreeMotion(tree_, poses, axes_);
    misfit_.filled += motion.filled;
    never_seen_.See(tree_, motion, "person_" + std::to_string(id.value()));
    // Before and after the person the first and the last pose stand.
    const size_t before = on_one_clock_ ? span.first : 0;
    const size_t after =
        on_one_clock_ ? rows_.size() - span.first - span.count : 0;
    AtomicFile file(path);
    std::string text = "HIERARCHY\n";
    WriteBvhJoint(tree_, motion, 0, 0, &text);
    file.Write(text + fmt::format("MOTION\nFrames: {}\nFrame Time: {}\n",
                                  before + span.count + after,
                                  1.0 / tracks_.header.frame_rate_hz));
    std::vector<Angles> last(tree_.size());
    for (size_t r = 0; r < span.count; ++r) {
      const std::string line = Line(motion, r, &last);
      const size_t times =
          1 + (r == 0 ? before : 0) + (r + 1 == span.count ? after : 0);
      for (size_t i = 0; i < times; ++i) file.Write(line);
    }
    file.Commit();
  }

  void NoteLostFields(LostFields* lost_fields) const;

 private:
  // Rotations turn bones; of points alone nothing would be left.
  void RequireBones() const {
    const bool has_bones =
        std::any_of(tree_.begin() + 1, tree_.end(), [](const TreeJoint& joint) {
          return joint.is_held && !joint.is_pivot;
        });
    if (has_bones || tree_.size() == 1) return;
    throw InputError("BVH is made of bones, and the skeleton '" +
                     Printable(tracks_.header.skeleton.name()) +
                     "' has none; C3D, TRC and glTF hold points");
  }

  std::string Line(const TreeMotion& motion, size_t row,
                   std::vector<Angles>* last) {
    const std::vector<Vector3d> rigid_m = motion.Rigid(tree_, row);
    for (size_t j = 0; j < tree_.size(); ++j) {
      if (!motion.rows[row].is_seen[j] || tree_[j].is_pivot) continue;
      const double m = (rigid_m[j] - motion.rows[row].positions_m[j]).norm();
      misfit_.sum_m2 += m * m;
      misfit_.largest_m = std::max(misfit_.largest_m, m);
      ++misfit_.count;
    }
    const Vector3d cm = 1.0 / kBvhCentimetre_m * rigid_m[0];
    std::string text =
        fmt::format("{:.6f} {:.6f} {:.6f}", cm.x(), cm.y(), cm.z());
    for (const size_t j : order_) {
      Angles& angles = (*last)[j];
      angles = AnglesOf(motion.Local(tree_, row, j), angles);
      text += fmt::format(" {:.6f} {:.6f} {:.6f}", kDegrees * angles.z,
                          kDegrees * angles.x, kDegrees * angles.y);
    }
    return text + "\n";
  }

  const TrackSequence& tracks_;
  const std::vector<TrackRow>& rows_;
  const AxisMap axes_;
  const JointTree tree_;
  std::vector<size_t> order_;
  std::map<int64_t, Span> spans_;  // by identity
  bool on_one_clock_ = true;
  Misfit misfit_;
  NeverSeen never_seen_;
};

void Writer::NoteLostFields(LostFields* lost_fields) const {
  lost_fields->push_back(
      "frame numbers, times of their own and configuration are not kept");
  if (!on_one_clock_) {
    lost_fields->push_back(fmt::format(
        "{} people in each of {} frames would be files of people who stand "
        "still: each file begins and ends with its person (--person=N writes "
        "one in all frames)",
        spans_.size(), rows_.size()));
  }
  const double rms_m =
      misfit_.count > 0
          ? std::sqrt(misfit_.sum_m2 / static_cast<double>(misfit_.count))
          : 0.0;
  lost_fields->push_back(fmt::format(
      "bones have the median of their lengths: joints lie {:.1f} mm (RMS) and "
      "at most {:.1f} mm from the tracks",
      1000.0 * rms_m, 1000.0 * misfit_.largest_m));
  NoteFilledJoints(misfit_.filled, lost_fields);
  never_seen_.Note(lost_fields);
  NoteUnheld(tree_, lost_fields);
  NotePlainPositions(ContentsOf(tracks_), lost_fields);
}

void WriteTracksBvh(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  RequireFrameRate(tracks, "BVH");
  const std::vector<int64_t> ids = PeopleToWrite(path, kBvhExtension, tracks);
  const std::vector<TrackRow> rows = MakeTrackRows(tracks, "BVH");
  Writer writer(tracks, rows, options);
  WritePersonFiles(path, kBvhExtension, ids, options.names,
                   [&writer](const std::string& file, TrackId id) {
                     writer.WritePerson(file, id);
                   });
  writer.NoteLostFields(lost_fields);
}

}  // namespace

TrackFormat BvhTrackFormat() {
  TrackFormat format;
  format.name = "bvh";
  format.layout = "a skeleton and its angles, cm, a file a person";
  format.extensions = {kBvhExtension};
  format.files = TrackFormat::Files::kFileAPerson;
  format.person_extension = kBvhExtension;
  format.axes = BvhAxes();
  format.unit_m = kBvhCentimetre_m;
  format.has_marker_names = true;
  format.keeps_names = true;
  format.recognise = [](const TrackHead& head) {
    return head.BeginsWith("HIERARCHY") || head.HasFile(kBvhExtension);
  };
  format.read = ReadTracksBvh;
  format.read_names = [](const std::string& path) {
    return NamesOfPersonFiles(path, kBvhExtension);
  };
  format.write = WriteTracksBvh;
  format.read_note =
      "cm, or as `--unit` says; CMU's and Mixamo's names of joints";
  format.kept = "frame rate, identity, directions of bones";
  format.lost =
      "changes of bone lengths, missing joints (filled), absence (the pose "
      "stands), frame numbers, status, covariances";
  return format;
}

}  // namespace kinegraph
