// Joint angles, speeds and distances of everybody in a recording, as one table.
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
  // Upwards in the world, a unit vector; nullopt: as people stand and `known`
  // says.
  std::optional<Eigen::Vector3d> up;
  UpEvidence known;
  // Joints that fewer than two views support in a frame count as missing.
  bool observed_only = false;
};

// One person in one frame; a value for each column, NaN where there is none.
struct KinematicsRow {
  int64_t frame = 0;
  TimeNs time = 0;
  TrackId id;
  std::vector<double> values;
};

// What the columns are, in this order, as far as the skeleton has the joints:
//   NAME_deg, and NAME_low_deg, NAME_high_deg when anybody has covariances
//   com_x_m, com_y_m, com_z_m        centre of mass in the world
//   NAME_speed_m_s                   pelvis (along the floor), com, joints
//   pelvis_path_m                    way of the pelvis along the floor so far
// Speeds and paths are there only when the recording has times; the lean of the
// trunk, the pelvis' obliquity, speed and path only when up is known.
struct KinematicsTable {
  // That was used; where it is not known, nothing that rests on it is there.
  std::optional<Eigen::Vector3d> up;
  bool has_times = false;           // else all times are 0
  std::vector<std::string> angles;  // names, without unit
  std::vector<std::string> columns;
  std::vector<KinematicsRow> rows;  // by frame, then as people stand in it
  std::vector<std::string> notes;   // what is not there, and why

  // Place of a column; -1 when there is no such column.
  int IndexOf(const std::string& column) const;
};

// A speed is the difference of the positions one frame before and one frame
// after, over the time between them; where one of them is missing, or farther
// away than one and a half frames, there is none.
KinematicsTable MeasureKinematics(const TrackSequence& tracks,
                                  const KinematicsOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_KINEMATICS_KINEMATICS_H_
