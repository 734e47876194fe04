// DLT and epipolar conflicts of all joints of a person at once: one joint per
// lane (core/base/pack.h). Performs the operations of TriangulateDlt and
// EpipolarGeometry::Distance in the same order: bit-identical where all views
// measured a joint, equal to within rounding elsewhere.
#ifndef KINEGRAPH_CORE_GEOMETRY_DLT_LANES_H_
#define KINEGRAPH_CORE_GEOMETRY_DLT_LANES_H_

namespace kinegraph {

// One view's measurements of all joints. Arrays have PaddedLanes(joints)
// elements.
struct LaneView {
  const double* P = nullptr;       // 3x4 by columns, world [m] to ideal pixels
  const double* centre = nullptr;  // of the camera in the world [m]
  const double* x_px = nullptr;    // ideal pixels; finite, 0 where not measured
  const double* y_px = nullptr;
  const double* present = nullptr;  // 1: measured, 0: not
  double weight = 1.0;              // scales the equations
};

struct TriangulationOptions {
  // Some ray must differ from the first one by more than this angle.
  double min_angle_rad = 1e-4;
  bool require_in_front = true;  // of every camera that measured the point
};

// One element per lane.
struct LanePoints {
  double* x_m = nullptr;
  double* y_m = nullptr;
  double* z_m = nullptr;
  // 1: a point; 0: none; -1: not converged, use TriangulateDlt.
  double* found = nullptr;
};

// Triangulates lanes 0 .. lanes - 1; `lanes` is a multiple of kLaneMultiple.
void TriangulateLanes(const LaneView* views, int view_count, int lanes,
                      const TriangulationOptions& options,
                      const LanePoints& points);

// Sets conflict[lane] to 1 where both views measured the joint and 1 - distance
// / alpha_px < 0; leaves the others unchanged, also at an epipole, where the
// distance is undefined. `fundamental`: 3x3 by columns, x_b' F x_a = 0.
void MarkConflicts(const LaneView& a, const LaneView& b,
                   const double* fundamental, double alpha_px, int lanes,
                   double* conflict);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_DLT_LANES_H_
