// The world axes along the X, Y and Z of a file.
#ifndef KINEGRAPH_CORE_IO_TRACKS_AXIS_MAP_H_
#define KINEGRAPH_CORE_IO_TRACKS_AXIS_MAP_H_

#include <Eigen/Core>
#include <array>
#include <string>

namespace kinegraph {

// Axes of a file, each an axis of the world with a sign. The default is TRC's.
struct AxisMap {
  // For each of the file's X, Y and Z: the world axis (0: x) along it, and 1,
  // or -1 if the two point in opposite directions.
  std::array<int, 3> axis = {1, 2, 0};
  std::array<double, 3> sign = {1.0, 1.0, 1.0};

  // Parses a text such as "y,z,x" (the default, from z up to y up) or "x,-z,y".
  // Throws InputError unless it is a permutation of the axes with signs that do
  // not mirror.
  static AxisMap Parse(const std::string& text);
  // The map in which the file's axis `of_file` (0: X) is `sign` (1 or -1) times
  // the world's axis `of_world`. The other two world axes are assigned in
  // ascending order, the last with the sign that avoids mirroring.
  static AxisMap With(size_t of_file, int of_world, double sign);
  // The text from which Parse() reads this map.
  std::string Text() const;

  bool operator==(const AxisMap& other) const {
    return axis == other.axis && sign == other.sign;
  }

  // The file's axis (0: X) along the world axis `of_world` (0: x).
  size_t FileAxisOf(int of_world) const {
    size_t of_file = 0;
    while (axis[of_file] != of_world) ++of_file;
    return of_file;
  }

  // Converts a vector from the world's axes to the file's.
  Eigen::Vector3d Apply(const Eigen::Vector3d& world) const {
    return {sign[0] * world[axis[0]], sign[1] * world[axis[1]],
            sign[2] * world[axis[2]]};
  }
  // The inverse of Apply().
  Eigen::Vector3d Invert(const Eigen::Vector3d& in_file) const {
    Eigen::Vector3d world;
    for (size_t i = 0; i < 3; ++i) {
      world[axis[i]] = sign[i] * in_file[static_cast<Eigen::Index>(i)];
    }
    return world;
  }
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_AXIS_MAP_H_
