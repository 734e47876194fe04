#include "core/io/tracks/axis_map.h"

#include <Eigen/LU>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"

namespace kinegraph {
namespace {

double Determinant(const AxisMap& map) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<size_t>(i);
    matrix(i, map.axis[at]) = map.sign[at];
  }
  return matrix.determinant();
}

}  // namespace

AxisMap AxisMap::Parse(const std::string& text) {
  const auto fail = [&text](const std::string& expected) {
    return InputError("--axes: found '" + Printable(text) + "', expected " +
                      expected);
  };
  AxisMap map;
  const std::vector<std::string> parts = Split(text, ',');
  bool is_axes = parts.size() == 3;
  for (size_t i = 0; is_axes && i < 3; ++i) {
    const bool is_back = parts[i].rfind('-', 0) == 0;
    const std::string letter = parts[i].substr(is_back ? 1 : 0);
    is_axes = letter == "x" || letter == "y" || letter == "z";
    map.axis[i] = letter.empty() ? 0 : letter[0] - 'x';
    map.sign[i] = is_back ? -1.0 : 1.0;
  }
  if (!is_axes) throw fail("three axes such as y,z,x");
  if (Determinant(map) != 1.0) {
    throw fail("each axis once, and no mirroring as in x,z,y");
  }
  return map;
}

AxisMap AxisMap::With(size_t of_file, int of_world, double sign) {
  AxisMap map;
  int next = 0;
  for (size_t i = 0; i < 3; ++i) {
    if (next == of_world) ++next;
    map.axis[i] = i == of_file ? of_world : next++;
    map.sign[i] = i == of_file ? sign : 1.0;
  }
  map.sign[of_file == 2 ? 1 : 2] = Determinant(map);
  return map;
}

std::string AxisMap::Text() const {
  std::string text;
  for (size_t i = 0; i < 3; ++i) {
    text += std::string(i == 0 ? "" : ",") + (sign[i] < 0.0 ? "-" : "") +
            static_cast<char>('x' + axis[i]);
  }
  return text;
}

}  // namespace kinegraph
