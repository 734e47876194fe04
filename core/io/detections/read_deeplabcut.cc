// DeepLabCut's CSV of predictions (Lightning Pose's too), a file a view: header
// rows "scorer", "individuals" (several animals or people only), "bodyparts",
// "coords", then a row a frame. A folder with such a folder a detector (two
// seeds of Lightning Pose, say) is one recording, in which they are fused.
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/deeplabcut_recording.h"
#include "core/io/detections/format.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

struct Header {
  DeepLabCutColumns columns;
  size_t first = 0;  // column that holds a coordinate
  size_t width = 0;
};

class HeaderReader {
 public:
  void Take(std::vector<std::string> row) {
    width_ = row.size();
    if (row.front() == "individuals") {
      individuals_ = std::move(row);
    } else if (row.front() == "bodyparts") {
      parts_ = std::move(row);
    } else if (row.front() == "coords") {
      coords_ = std::move(row);
    }
  }

  size_t width() const { return width_; }  // 0 before the first row

  Header Finish() const {
    if (parts_.empty()) throw InputError("expected a row 'bodyparts'");
    Header header;
    header.width = width_;
    while (header.first < width_ && coords_[header.first] != "x") {
      ++header.first;  // the index: a frame, or folders and a file name
    }
    header.columns =
        FindDeepLabCutColumns(individuals_, parts_, coords_, header.first);
    return header;
  }

 private:
  size_t width_ = 0;
  std::vector<std::string> individuals_;
  std::vector<std::string> parts_;
  std::vector<std::string> coords_;
};

Header ReadHeader(CsvRows* rows) {
  HeaderReader header;
  std::vector<std::string> cells;
  while (rows->Next(&cells, header.width())) {
    const bool last = cells.front() == "coords";
    const bool known = last || cells.front() == "scorer" ||
                       cells.front() == "individuals" ||
                       cells.front() == "bodyparts";
    if (!known) break;
    header.Take(std::move(cells));
    if (last) return header.Finish();
  }
  throw InputError(
      "expected the header rows scorer, bodyparts and coords of DeepLabCut");
}

void ReadRows(CsvRows* rows, size_t view_idx,
              const DetectionReadOptions& options,
              DeepLabCutRecording* recording) {
  const Header header = ReadHeader(rows);
  const DeepLabCutColumns& columns = header.columns;
  recording->SettleSkeleton(columns.labels);
  std::vector<std::string> cells;
  while (rows->Next(&cells, header.width)) {
    const int64_t frame = FrameOfName(cells[header.first - 1]);
    recording->Touch(frame);
    for (size_t p = 0; p < columns.people.size(); ++p) {
      recording->Add(frame, view_idx, p,
                     ReadKeypointRow(cells, columns.people[p], columns.labels,
                                     options.zero_confidence)
                         .joints);
    }
  }
}

void ReadDeepLabCutView(const std::string& path, size_t view_idx,
                        const DetectionReadOptions& options,
                        DeepLabCutRecording* recording) {
  const std::string text = ReadTextFile(path);
  CsvRows rows(text);
  Located(
      path, [&] { return rows.Place(); },
      [&] { ReadRows(&rows, view_idx, options, recording); });
}

std::unique_ptr<DetectionSource> OpenDeepLabCutFile(
    const std::string& path, const DetectionReadOptions& options) {
  return OpenDeepLabCut(path, options, ".csv", ReadDeepLabCutView);
}

bool RecogniseDeepLabCut(const DetectionHead& head) {
  const std::vector<std::string> row = head.FirstRow();
  return row.size() > 1 && row.front() == "scorer";
}

}  // namespace

DetectionFormat DeepLabCutFormat() {
  DetectionFormat format;
  format.name = "deeplabcut";
  format.layout =
      "CSV, a file a view (Lightning Pose too); a folder of such folders: "
      "detectors that are fused";
  format.extension = ".csv";
  format.files = DetectionFormat::Files::kFileAView;
  format.recognise = RecogniseDeepLabCut;
  format.open = OpenDeepLabCutFile;
  return format;
}

}  // namespace kinegraph
