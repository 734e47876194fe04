// DeepLabCut's HDF5 of predictions, a file a view: pandas' table
// "df_with_missing", whose index is the frame and whose columns are named by
// scorer, individual (several animals or people only), bodypart and coord. The
// names are a Python list of tuples, pickled by PyTables in protocol 0.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/binary/hdf5_file.h"
#include "core/io/detections/deeplabcut_recording.h"
#include "core/io/detections/format.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/pickle.h"

namespace kinegraph {
namespace {

constexpr const char* kTable = "df_with_missing/table";
constexpr const char* kValues = "values_block_0";
constexpr size_t kMostNames = 4;  // scorer, individual, bodypart, coord

// The names of each column: a list of tuples of texts.
std::vector<std::vector<std::string>> NamesOf(const std::string& pickled) {
  try {
    return ParseTextPickle(pickled, kTable)
        .get<std::vector<std::vector<std::string>>>();
  } catch (const InputError&) {
  } catch (const Json::exception&) {
  }
  throw InputError(
      "expected the names of columns as DeepLabCut's pandas writes them");
}

// `width`: numbers a frame, a name each.
DeepLabCutColumns ColumnsOf(const Hdf5File& file, size_t width) {
  const std::string pickled =
      file.Attribute(kTable, std::string(kValues) + "_kind");
  std::vector<std::string> individuals;
  std::vector<std::string> parts;
  std::vector<std::string> coords;
  for (const auto& names : NamesOf(pickled)) {
    // scorer, (individual,) bodypart, coord
    if (names.size() != 3 && names.size() != kMostNames) {
      throw InputError("found a column of " + std::to_string(names.size()) +
                       " names, expected scorer, bodypart and coord");
    }
    if (names.size() == kMostNames) individuals.push_back(names[1]);
    parts.push_back(names[names.size() - 2]);
    coords.push_back(names.back());
  }
  if (!individuals.empty() && individuals.size() != parts.size()) {
    throw InputError("some columns name an individual and some do not");
  }
  if (coords.size() != width) {
    throw InputError("has " + std::to_string(width) + " numbers a frame, and " +
                     std::to_string(coords.size()) + " names of columns");
  }
  return FindDeepLabCutColumns(individuals, parts, coords, 0);
}

void ReadDeepLabCutH5File(const Hdf5File& file, const std::string& path,
                          size_t view_idx, const DetectionReadOptions& options,
                          DeepLabCutRecording* recording) {
  if (!file.Has("df_with_missing") || !file.Has(kTable)) {
    throw InputError(path, "",
                     "has no df_with_missing/table, expected DeepLabCut's "
                     "predictions as it writes them (pandas' format='table')");
  }
  if (file.Attribute(kTable, "index_kind") != "integer") {
    throw InputError(path, kTable,
                     "has no frame numbers, expected DeepLabCut's predictions "
                     "of a video (labels of pictures are CSV)");
  }
  size_t width = 0;
  size_t one = 0;
  const std::vector<double> frames = file.Field(kTable, "index", &one);
  const std::vector<double> values = file.Field(kTable, kValues, &width);
  Located(
      path, [] { return std::string(kTable); },
      [&] {
        const DeepLabCutColumns columns = ColumnsOf(file, width);
        if (one != 1) throw InputError("index: expected one number a frame");
        recording->SettleSkeleton(columns.labels);
        for (size_t r = 0; r < frames.size(); ++r) {
          const double* row = &values[r * width];
          if (!(frames[r] >= 0.0 &&
                frames[r] <= static_cast<double>(kMaxFrame))) {
            throw InputError("found a frame below 0 or too large");
          }
          const auto frame = static_cast<int64_t>(frames[r]);
          recording->Touch(frame);
          for (size_t p = 0; p < columns.people.size(); ++p) {
            std::vector<Keypoint> joints;
            for (const KeypointColumns& at : columns.people[p]) {
              joints.push_back(
                  MakeKeypoint(row[at.x], row[at.y],
                               at.confidence < 0 ? 1.0 : row[at.confidence],
                               options.zero_confidence));
            }
            recording->Add(frame, view_idx, p, std::move(joints));
          }
        }
      });
}

void ReadDeepLabCutH5View(const std::string& path, size_t view_idx,
                          const DetectionReadOptions& options,
                          DeepLabCutRecording* recording) {
  ReadHdf5(path, [&](const Hdf5File& file) {
    ReadDeepLabCutH5File(file, path, view_idx, options, recording);
  });
}

std::unique_ptr<DetectionSource> OpenDeepLabCutH5File(
    const std::string& path, const DetectionReadOptions& options) {
  return OpenDeepLabCut(path, options, ".h5", ReadDeepLabCutH5View);
}

bool RecogniseDeepLabCutH5(const DetectionHead& head) {
  return head.HasKey("df_with_missing");
}

}  // namespace

DetectionFormat DeepLabCutH5Format() {
  DetectionFormat format;
  format.name = "deeplabcut_h5";
  format.layout = "DeepLabCut's HDF5, a file a view";
  format.extension = ".h5";
  format.files = DetectionFormat::Files::kFileAView;
  format.recognise = RecogniseDeepLabCutH5;
  format.open = OpenDeepLabCutH5File;
  return format;
}

}  // namespace kinegraph
