// actorsGT.mat (TUM), a MATLAB 5 file: the cell `actor3D`, 1 x ACTORS, of cells
// FRAMES x 1, of JOINTS x 3 doubles [m] or nothing. Actor and frame are places
// in these cells.
#include <matio.h>

#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "core/io/track_export.h"
#include "core/io/track_losses.h"

namespace kinegraph {
namespace {

// The official file's shape; also keeps a stray id from filling the memory.
constexpr int64_t kMaxActors = 1000;
constexpr int64_t kMaxFrames = 1'000'000;

struct MatCloser {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct VariableFree {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, VariableFree>;

Variable NewCell(const char* name, size_t rows, size_t columns) {
  size_t dims[2] = {rows, columns};
  return Variable(
      Mat_VarCreate(name, MAT_C_CELL, MAT_T_CELL, 2, dims, nullptr, 0));
}

// Column after column; NaN where a joint is missing.
Variable NewPose(const Pose3d* pose, size_t joint_count) {
  size_t dims[2] = {0, 0};
  std::vector<double> numbers;
  if (pose != nullptr) {
    dims[0] = joint_count;
    dims[1] = 3;
    for (int axis = 0; axis < 3; ++axis) {
      for (const Joint3d& joint : *pose) {
        numbers.push_back(joint.present()
                              ? joint.position_m[axis]
                              : std::numeric_limits<double>::quiet_NaN());
      }
    }
  }
  return Variable(Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims,
                                pose == nullptr ? nullptr : numbers.data(), 0));
}

Variable MakeActors(const TrackSequence& tracks) {
  const std::vector<int64_t> ids = IdsOf(tracks);
  if (ids.empty()) throw InputError("the tracks have nobody in them");
  const int64_t frames = tracks.frames.back().frame + 1;
  if (ids.back() >= kMaxActors || frames > kMaxFrames) {
    throw InputError(
        "an actor's number is its place in actorsGT.mat, a frame's too: the "
        "largest id is " +
        std::to_string(ids.back()) + ", expected below 1000; the last frame " +
        std::to_string(frames - 1) + ", expected below 1000000");
  }
  const auto actor_count = static_cast<size_t>(ids.back()) + 1;
  const auto frame_count = static_cast<size_t>(frames);
  std::vector<std::vector<const Pose3d*>> poses(
      actor_count, std::vector<const Pose3d*>(frame_count, nullptr));
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      poses[static_cast<size_t>(person.id.value())]
           [static_cast<size_t>(frame.frame)] = &person.joints;
    }
  }
  const auto joint_count =
      static_cast<size_t>(tracks.header.skeleton.joint_count());
  Variable actors = NewCell("actor3D", 1, actor_count);
  for (size_t a = 0; a < actor_count; ++a) {
    Variable of_actor = NewCell(nullptr, frame_count, 1);
    for (size_t f = 0; f < frame_count; ++f) {
      Mat_VarSetCell(of_actor.get(), static_cast<int>(f),
                     NewPose(poses[a][f], joint_count).release());
    }
    Mat_VarSetCell(actors.get(), static_cast<int>(a), of_actor.release());
  }
  return actors;
}

}  // namespace

void WriteTracksTum(const std::string& path, const TrackSequence& tracks,
                    Losses* losses) {
  const Variable actors = MakeActors(tracks);
  const std::string aside = path + ".partial";
  {
    // A text of our own: matio's has the date, and the same tracks shall give
    // the same bytes.
    const std::unique_ptr<mat_t, MatCloser> file(Mat_CreateVer(
        aside.c_str(), "MATLAB 5.0 MAT-file, by kinegraph", MAT_FT_MAT5));
    if (file == nullptr ||
        Mat_VarWrite(file.get(), actors.get(), MAT_COMPRESSION_NONE) != 0) {
      std::remove(aside.c_str());
      throw InputError(path, "", "cannot be written");
    }
  }
  if (std::rename(aside.c_str(), path.c_str()) != 0) {
    std::remove(aside.c_str());
    throw InputError(path, "", "cannot be written");
  }
  NotePositionsOnly(tracks, losses);
  NoteClock(tracks, losses);
  if (tracks.frames.front().frame > 0 ||
      tracks.frames.back().frame + 1 !=
          static_cast<int64_t>(tracks.frames.size())) {
    losses->push_back(
        "frames that the input leaves out, from 0 on, are there without "
        "people");
  }
  if (tracks.header.skeleton != Tum14()) NoteSkeleton(tracks, losses);
}

}  // namespace kinegraph
