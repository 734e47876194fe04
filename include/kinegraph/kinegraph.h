// kinegraph: the 3D motion of people from 2D poses in calibrated cameras. The
// only header that a program needs:
//
//   #include <kinegraph/kinegraph.h>
//
// Its contents, in the order of use:
//   core/geometry/camera.h          cameras: projection, lenses
//   core/skeleton/skeleton.h        joints, bones, mirror pairs
//   core/data/detection.h           2D poses from a detector
//   core/data/pose.h                3D poses as they are written
//   core/io/calibration/calibration.h           ReadCameras, WriteCameras
//   core/io/detections/source.h     ReadDetections, OpenDetections
//   core/io/detections/writer.h     WriteDetections
//   core/io/tracks/tracks.h, writer.h   ReadTracks, WriteTracks
//   core/io/tracks/c3d.h        ReadSegments: poses of segments (C3D)
//   solvers/session/options.h       RunOptions: everything in a configuration
//   solvers/session/session.h       Session: a run, frame by frame
//   solvers/session/run.h           a whole recording at once; FreezeTracking
//   core/tracking/replay.h          other smoothers on the frozen matches
//   core/tracking/estimator.h       interface of a user's own smoother
//   solvers/factory.h               the built-in smoothers
//   solvers/ceres/user_factor.h     a user's own factors
//   core/evaluation/mpjpe.h         errors against a ground truth
//   core/evaluation/identity.h, motion.h   identities, smoothness
//   core/kinematics/kinematics.h, angles.h   joint angles, speeds, distances
//   core/synthetic/scene.h, noise.h   scenes with known truth
//
// Lengths are in metres, image coordinates in pixels, times in nanoseconds
// (TimeNs) or, with the suffix _s, seconds. Bad input throws InputError or
// OptionError, whose what() is one line that names file, line or key.
#ifndef KINEGRAPH_KINEGRAPH_H_
#define KINEGRAPH_KINEGRAPH_H_

#include "core/base/error.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/evaluation/identity.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/geometry/camera.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/c3d.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "core/kinematics/angles.h"
#include "core/kinematics/kinematics.h"
#include "core/skeleton/skeleton.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "core/tracking/estimator.h"
#include "core/tracking/replay.h"
#include "solvers/ceres/user_factor.h"
#include "solvers/factory.h"
#include "solvers/session/options.h"
#include "solvers/session/run.h"
#include "solvers/session/session.h"

#endif  // KINEGRAPH_KINEGRAPH_H_
