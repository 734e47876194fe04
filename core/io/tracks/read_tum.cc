// actorsGT.mat of Campus and Shelf (TUM): a MATLAB 5 file with the cell
// `actor3D`, 1 x ACTORS; each entry a cell FRAMES x 1; each entry of that 14 x
// 3 doubles in metres, or empty where the actor is not annotated. The id of an
// actor is its place, the frame that of the entry, both from zero.
#include <matio.h>

#include <cmath>
#include <memory>
#include <mutex>

#include "core/base/error.h"
#include "core/io/binary/mat_check.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"

namespace kinegraph {
namespace {

constexpr const char* kVariable = "actor3D";

struct MatCloser {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct VariableFree {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

// matio prints its errors and aborts on some unless it is given another way.
void Quiet(int, char*) {}

// Number of entries by the declared dimensions; 0 for an empty cell, which has
// rank 0 and no dimensions.
size_t EntryCount(const matvar_t& variable) {
  if (variable.rank <= 0 || variable.dims == nullptr) return 0;
  size_t count = 1;
  for (int d = 0; d < variable.rank; ++d) count *= variable.dims[d];
  return count;
}

class TumReader {
 public:
  TumReader(const std::string& path, TrackCollector* collector)
      : path_(path), collector_(collector) {}

  void Read(const matvar_t& actors) {
    const size_t actor_count = CellSize(actors, kVariable);
    for (size_t a = 0; a < actor_count; ++a) {
      const std::string name =
          std::string(kVariable) + "{" + std::to_string(a + 1) + "}";
      const matvar_t& frames = Entry(actors, a, name);
      const size_t frame_count = CellSize(frames, name);
      if (a > 0 && frame_count != frame_count_) {
        throw InputError(
            path_, name,
            "found " + std::to_string(frame_count) + " frames, expected " +
                std::to_string(frame_count_) + " as of the first actor");
      }
      frame_count_ = frame_count;
      for (size_t f = 0; f < frame_count; ++f) {
        const std::string entry = name + "{" + std::to_string(f + 1) + "}";
        ReadEntry(Entry(frames, f, entry), entry, static_cast<int64_t>(f),
                  TrackId(static_cast<int64_t>(a)));
      }
    }
  }

 private:
  // The declared number of entries; the entries must all be there.
  size_t CellSize(const matvar_t& cell, const std::string& name) const {
    const size_t count = EntryCount(cell);
    if (cell.class_type != MAT_C_CELL || count == 0 || cell.data == nullptr) {
      throw InputError(path_, name, "is no cell array with entries");
    }
    if (cell.nbytes != count * sizeof(matvar_t*)) {
      throw InputError(path_, name, "has fewer entries than it declares");
    }
    return count;
  }

  const matvar_t& Entry(const matvar_t& cell, size_t index,
                        const std::string& name) const {
    const matvar_t* entry = static_cast<matvar_t* const*>(cell.data)[index];
    if (entry == nullptr) throw InputError(path_, name, "is missing");
    return *entry;
  }

  void ReadEntry(const matvar_t& entry, const std::string& name, int64_t frame,
                 TrackId id) {
    collector_->Touch(frame);
    const size_t count = EntryCount(entry);
    if (count == 0) return;  // not annotated
    const size_t joints = collector_->header().skeleton.joints().size();
    const bool fits = entry.rank == 2 && entry.dims[0] == joints &&
                      entry.dims[1] == 3 && entry.class_type == MAT_C_DOUBLE &&
                      entry.isComplex == 0 && entry.data != nullptr &&
                      entry.nbytes == count * sizeof(double);
    if (!fits) {
      throw InputError(path_, name,
                       "expected " + std::to_string(joints) +
                           " x 3 doubles or an empty entry");
    }
    Pose3d& pose = collector_->Add(frame, id)->joints;
    const auto* m = static_cast<const double*>(entry.data);
    for (size_t j = 0; j < joints; ++j) {
      const double x = m[j];  // columns follow one another
      const double y = m[joints + j];
      const double z = m[2 * joints + j];
      if (std::isinf(x) || std::isinf(y) || std::isinf(z)) {
        throw InputError(path_, name, "holds an infinite number");
      }
      if (std::isnan(x + y + z)) continue;  // MATLAB's way to say "none"
      pose[j] = ObservedJoint(x, y, z);
    }
  }

  const std::string path_;
  TrackCollector* const collector_;
  size_t frame_count_ = 0;
};

}  // namespace

TrackSequence ReadTumTracks(const std::string& path,
                            const TrackReadOptions& options) {
  CheckMatFile(ReadBytes(path), path);
  static std::once_flag quiet;
  std::call_once(quiet, [] { Mat_LogInitFunc("kinegraph", Quiet); });
  const std::unique_ptr<mat_t, MatCloser> file(
      Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (file == nullptr) throw InputError(path, "", "is no MATLAB 5 file");
  const std::unique_ptr<matvar_t, VariableFree> actors(
      Mat_VarRead(file.get(), kVariable));
  if (actors == nullptr) {
    throw InputError(path, kVariable, "is missing or damaged");
  }
  TrackHeader header;
  header.mode = "tum";
  header.skeleton = options.skeleton.value_or(Tum14());
  header.frame_rate_hz = options.frame_rate_hz;
  TrackCollector collector(std::move(header));
  TumReader(path, &collector).Read(*actors);
  return collector.Finish();
}

TrackFormat TumTrackFormat() {
  TrackFormat format;
  format.name = "tum";
  format.layout = "actorsGT.mat";
  format.unit_m = 1.0;
  // "MATLAB 5.0 MAT-file".
  format.recognise = [](const TrackHead& head) { return head.kind == 'M'; };
  format.read = ReadTumTracks;
  format.write = WriteTracksTum;
  format.kept = "frame, identity, positions";
  format.lost =
      "times, status, covariances; frames begin at 0; refused: identities "
      "above 999";
  return format;
}

}  // namespace kinegraph
