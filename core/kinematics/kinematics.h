// Joint angles, speeds and distances of everyone in a recording, as one table.
#ifndef KINEGRAPH_CORE_KINEMATICS_KINEMATICS_H_
#define KINEGRAPH_CORE_KINEMATICS_KINEMATICS_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/data/pose.h"
#include "core/data/stance.h"

namespace kinegraph {

struct KinematicsOptions {
  // The upward direction in the world, a unit vector; nullopt: determined from
  // how people stand and from `known`.
  std::optional<Eigen::Vector3d> up;
  UpEvidence known;
  // Treat joints supported by fewer than two views in a frame as missing.
  bool observed_only = false;
};

// One person in one frame; a value for each column, NaN where undefined.
struct KinematicsRow {
  int64_t frame = 0;
  TimeNs time = 0;
  TrackId id;
  std::vector<double> values;
};

// The columns in this order, as far as the skeleton has the joints:
//   NAME_deg, and NAME_low_deg, NAME_high_deg if any covariances exist
//   com_x_m, com_y_m, com_z_m        centre of mass in the world
//   NAME_speed_m_s                   pelvis (horizontal), com, joints
//   pelvis_path_m                    horizontal path of the pelvis so far
// Speeds and paths exist only if the recording has times; the lean of the
// trunk, the pelvis' obliquity, speed and path only if up is known.
struct KinematicsTable {
  // The direction used; if unknown, all columns that depend on it are absent.
  std::optional<Eigen::Vector3d> up;
  // The median step between frames is positive; else no speeds or paths.
  bool has_times = false;
  std::vector<std::string> angles;  // names, without unit
  std::vector<std::string> columns;
  std::vector<KinematicsRow> rows;  // by frame, then in the order of its people
  std::vector<std::string> notes;   // what is absent, and why

  // Index of a column; -1 if there is no such column.
  int IndexOf(const std::string& column) const;
};

// A speed is the difference of the positions one frame before and one frame
// after, divided by the time between them; undefined where one of the three
// positions is missing or a neighbour is more than one and a half frames away.
KinematicsTable MeasureKinematics(const TrackSequence& tracks,
                                  const KinematicsOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_KINEMATICS_KINEMATICS_H_
