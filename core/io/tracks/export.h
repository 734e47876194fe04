// Writing 3D tracks in formats of other programs.
#ifndef KINEGRAPH_CORE_IO_TRACKS_EXPORT_H_
#define KINEGRAPH_CORE_IO_TRACKS_EXPORT_H_

#include <optional>
#include <string>

#include "core/data/person_names.h"
#include "core/data/pose.h"
#include "core/io/text/lost_fields.h"
#include "core/io/tracks/axis_map.h"

namespace kinegraph {

struct TrackExportOptions {
  // Which world axes the file's X, Y, Z are, instead of the format's own.
  std::optional<AxisMap> axes;
  PersonNames names;
};

// All throw InputError when the result cannot be made or the tracks do not fit
// the format; what is left out is added to `losses`. Numbers are written so
// that they read back bit for bit.

// Tidy CSV, one row a joint: frame,time_s,id,joint,x_m,y_m,z_m,status; `views`,
// the six columns cov_xx_m2 .. cov_zz_m2 and `name` follow when anybody has
// them. The
// cells of what is missing are empty, those of times when none is known.
void WriteTracksCsv(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options, LostFields* lost_fields);

// {"unit": "m", "poses": [{"frame", "id", "joints": [[x, y, z] or null]}]}.
void WriteTracksPoses(const std::string& path, const TrackSequence& tracks,
                      const TrackExportOptions& options,
                      LostFields* lost_fields);

// NumPy's .npz, an uncompressed archive of arrays; F frames, P people, J
// joints, dense over all of them:
//   positions   float64 [F, P, J, 3]     m; NaN where there is none
//   status      int8    [F, P, J]        2 observed, 1 inferred, 0 missing;
//                                        -1 where the person is not there
//   views       int16   [F, P, J]        inlier views, -1 unknown; if any
//   covariance  float64 [F, P, J, 3, 3]  m^2; NaN where there is none; if any
//   ids         int64   [P]
//   names       <U      [P]              if anybody has one; empty: none
//   frames      int64   [F]
//   times       float64 [F]              s; NaN when they are not known
//   frame_rate  float64 []               Hz; NaN when it is not known
//   joints      <U      [J]              names
//   bones       int32   [B, 2]           indices into joints
//   skeleton    <U      []               name
void WriteTracksNpz(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options, LostFields* lost_fields);

// TRC as OpenSim and Pose2Sim read it, a file a person: PATH/person_ID.trc, or
// PATH/person_ID_NAME.trc of those who have a name; NAME.trc is the file of the
// one person that the tracks have. All files have a row for every frame of the
// recording, Frame# from 1 and the time of the tracks; the header's
// OrigDataStartFrame is the first frame's number. A marker without position has
// empty cells. Needs a frame rate.
void WriteTracksTrc(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options, LostFields* lost_fields);

// Files of ground truth and results; each keeps frames, identities and
// positions, and the losses say what a reader must be told.

// longcw's annotation_3d.json, in centimetres. Frames are told by their times
// alone, so it needs a frame rate.
void WriteTracksLongcw(const std::string& path, const TrackSequence& tracks,
                       const TrackExportOptions& options,
                       LostFields* lost_fields);
// 4D association's gt.txt or skel.txt, an entry for every frame from the first
// to the last; a missing joint has weight 0.
void WriteTracks4dAssociation(const std::string& path,
                              const TrackSequence& tracks,
                              const TrackExportOptions& options,
                              LostFields* lost_fields);
// CMU Panoptic's hdPose3d, a folder with a file a frame, in centimetres; joints
// are taken over by name.
void WriteTracksPanoptic(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& options,
                         LostFields* lost_fields);
// TUM's actorsGT.mat; the id of a person is the place of the actor.
void WriteTracksTum(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_EXPORT_H_
