// Tables with one column per coordinate: DeepLabCut's predictions and
// MediaPipe's landmarks.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/box.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

using Texts = std::vector<std::string>;

// The index of a name among `names`, to which it is appended if it is new.
size_t IndexAmong(const std::string& name, Texts* names) {
  const auto at = std::find(names->begin(), names->end(), name);
  const auto index = static_cast<size_t>(at - names->begin());
  if (at == names->end()) names->push_back(name);
  return index;
}

// Columns of a person's joint; -1: there is none.
struct KeypointColumns {
  int x = -1;
  int y = -1;
  int confidence = -1;  // -1: joints that are present have 1
};

// The joints of one person in a row; an empty cell or "nan" is a missing joint.
// Throws InputError that names the joint, but no file.
std::vector<Keypoint> ReadKeypointRow(
    const std::vector<std::string>& cells,
    const std::vector<KeypointColumns>& columns,
    const std::vector<std::string>& labels, ZeroConfidence zero_confidence) {
  std::vector<Keypoint> joints;
  joints.reserve(columns.size());
  for (size_t j = 0; j < columns.size(); ++j) {
    if (columns[j].x < 0) {
      joints.emplace_back();  // this person has no such joint
      continue;
    }
    const auto at = [&](int column) {
      return Located(labels[j], [&] {
        return NumberOfCell(cells[static_cast<size_t>(column)]).value_or(kNan);
      });
    };
    const double confidence =
        columns[j].confidence < 0 ? 1.0 : at(columns[j].confidence);
    joints.push_back(MakeKeypoint(at(columns[j].x), at(columns[j].y),
                                  confidence, zero_confidence));
  }
  return joints;
}

// The frame in a cell: a number, or the name of an image.
int64_t FrameOfCell(const std::string& cell) {
  const auto number = ParseNumber<double>(WithoutPlus(Trimmed(cell)));
  if (!number.has_value()) return FrameOfName(cell);
  if (!(*number >= 0.0) || *number != std::floor(*number)) {
    throw InputError("frame: found '" + Printable(cell) +
                     "', expected a whole number from 0");
  }
  // FrameOfName refuses numbers that look like times.
  return FrameOfName(fmt::format("{:.0f}", *number));
}

// ---- DeepLabCut ----
// DeepLabCut's predictions (and Lightning Pose's), CSV or HDF5, one file per
// view: one column per coordinate, named by individual (only with several
// animals or people), bodypart and coord. A folder that has a folder of such
// files per detector (for example two seeds of Lightning Pose) is one
// recording, in which the detectors are fused.

// ---- Columns ----

// Columns of the joints of each individual.
struct DeepLabCutColumns {
  Texts labels;  // bodyparts
  std::vector<std::vector<KeypointColumns>> people;
};

// Each list has one name per column, except that `individuals` may be empty.
// Columns before `first` are the index of a row: its frame, or folders and an
// image's name. The InputError does not name the file.
DeepLabCutColumns FindDeepLabCutColumns(const Texts& individuals,
                                        const Texts& parts, const Texts& coords,
                                        size_t first) {
  DeepLabCutColumns columns;
  Texts people;
  for (size_t c = first; c < coords.size(); ++c) {
    const size_t person =
        IndexAmong(individuals.empty() ? "" : individuals[c], &people);
    const size_t joint = IndexAmong(parts[c], &columns.labels);
    if (columns.people.size() <= person) columns.people.emplace_back();
    std::vector<KeypointColumns>& joints = columns.people[person];
    if (joints.size() <= joint) joints.resize(joint + 1);
    const int column = static_cast<int>(c);
    if (coords[c] == "x") joints[joint].x = column;
    if (coords[c] == "y") joints[joint].y = column;
    if (coords[c] == "likelihood") joints[joint].confidence = column;
  }
  if (columns.people.empty()) throw InputError("expected columns x and y");
  for (std::vector<KeypointColumns>& joints : columns.people) {
    joints.resize(columns.labels.size());
    for (size_t j = 0; j < joints.size(); ++j) {
      const bool has_x = joints[j].x >= 0;
      // Individuals lack DeepLabCut's "unique bodyparts", which only its
      // individual "single" has.
      const bool may_lack = !individuals.empty() && joints[j].confidence < 0;
      if (has_x == (joints[j].y >= 0) && (has_x || may_lack)) continue;
      throw InputError("bodypart '" + Printable(columns.labels[j]) +
                       "': expected the coords x and y");
    }
  }
  return columns;
}

// ---- Several detectors ----

// Each detector's joints of one person.
using JointsByDetector = std::vector<std::vector<Keypoint>>;

Keypoint FuseJoint(const JointsByDetector& by_detector, size_t j, int detectors,
                   double apart_px) {
  Keypoint best;
  Eigen::Vector2d sum_px = Eigen::Vector2d::Zero();
  double weight_sum = 0.0;
  for (const std::vector<Keypoint>& joints : by_detector) {
    const Keypoint& joint = joints[j];
    if (!joint.found) continue;
    // If all confidences are 0, all have the same weight.
    const double weight = std::max(joint.confidence, 1e-12);
    sum_px += weight * joint.px;
    weight_sum += weight;
    if (!best.found || joint.confidence > best.confidence) best = joint;
  }
  if (!best.found) return best;
  const Eigen::Vector2d mean_px = sum_px / weight_sum;
  double confidence_sum = 0.0;
  for (const std::vector<Keypoint>& joints : by_detector) {
    const Keypoint& joint = joints[j];
    if (!joint.found) continue;
    if ((joint.px - best.px).norm() > apart_px) {
      best.confidence /= detectors;
      return best;
    }
    confidence_sum += joint.confidence;
  }
  best.px = mean_px;
  best.confidence = confidence_sum / detectors;
  return best;
}

// The recording being read. With several detectors, for example two seeds of
// one network, the position of a joint is the mean of their positions weighted
// by confidence; its confidence is the mean over all detectors, where a
// detector that does not see the joint counts with 0. If a position differs
// from the most confident one by more than a twentieth of the diagonal of the
// person's box (some 9 cm on an adult, more than noise), the most confident
// position is used and the other detectors count as not seeing the joint.
class DeepLabCutRecording : public DetectionCollector {
 public:
  DeepLabCutRecording(const DetectionHeader& header, int detectors)
      : DetectionCollector(header), detectors_(detectors) {}

  void AddPerson(int64_t frame, size_t view_idx, size_t person,
                 std::vector<Keypoint> joints) {
    if (detectors_ == 1) {
      AddFound(frame, view_idx, std::move(joints));
    } else if (IsAnyFound(joints)) {
      waiting_[{frame, view_idx, person}].push_back(std::move(joints));
    }
  }

  std::unique_ptr<DetectionSource> FinishAll() {
    constexpr double kApart = 0.05;
    for (const auto& [key, by_detector] : waiting_) {
      const auto& [frame, view_idx, person] = key;
      Eigen::AlignedBox2d box;  // around all joints that the detectors found
      for (const std::vector<Keypoint>& joints : by_detector) {
        box.extend(BoxAround(joints));
      }
      const double apart_px = kApart * DiagonalPx(box);
      std::vector<Keypoint>& joints = Add(frame, view_idx)->joints;
      for (size_t j = 0; j < by_detector.front().size(); ++j) {
        joints.push_back(FuseJoint(by_detector, j, detectors_, apart_px));
      }
    }
    return Finish();
  }

 private:
  const int detectors_;
  // By frame, view and person; unused with one detector.
  std::map<std::tuple<int64_t, size_t, size_t>, JointsByDetector> waiting_;
};

// Opens a folder with one file per view, the file of one view, or a folder with
// one such folder per detector. `read` adds one file to the recording.
std::unique_ptr<DetectionSource> OpenDetectors(
    const std::string& path, const DetectionReadOptions& options,
    const std::string& extension,
    void (*read)(const std::string& file, size_t view_idx,
                 const DetectionReadOptions& options,
                 DeepLabCutRecording* recording)) {
  NamedPaths detectors = ListDataFolders(path, extension);
  if (detectors.empty()) detectors = {{"", path}};
  std::vector<NamedPaths> files;
  for (const auto& [name, folder] : detectors) {
    files.push_back(ListViewFiles(folder, extension));
  }
  const Texts views = NamesOf(files.front());
  DeepLabCutRecording recording(HeaderOf(views, options),
                                static_cast<int>(detectors.size()));
  for (size_t d = 0; d < files.size(); ++d) {
    if (NamesOf(files[d]) != views) {
      throw InputError(detectors[d].second, "",
                       "has other views than " + detectors.front().second +
                           ", expected the same views for every detector");
    }
    for (size_t v = 0; v < files[d].size(); ++v) {
      read(files[d][v].second, v, options, &recording);
    }
  }
  return recording.FinishAll();
}

// ---- CSV ----
// Header rows "scorer", "individuals", "bodyparts" and "coords", then one row
// per frame.

struct DeepLabCutHeader {
  DeepLabCutColumns columns;
  size_t first = 0;  // first column with a coordinate
  size_t width = 0;
};

DeepLabCutHeader ReadDeepLabCutHeader(CsvRows* rows) {
  std::map<std::string, Texts> named = {
      {"scorer", {}}, {"individuals", {}}, {"bodyparts", {}}, {"coords", {}}};
  DeepLabCutHeader header;
  for (Texts cells; rows->Next(&cells, header.width);) {
    header.width = cells.size();
    const std::string name = cells.front();
    if (named.count(name) == 0) break;
    named[name] = cells;
    if (name != "coords") continue;
    if (named["bodyparts"].empty()) {
      throw InputError("expected a row 'bodyparts'");
    }
    while (header.first < header.width && cells[header.first] != "x") {
      ++header.first;  // index: a frame, or folders and a file name
    }
    header.columns = FindDeepLabCutColumns(
        named["individuals"], named["bodyparts"], cells, header.first);
    return header;
  }
  throw InputError(
      "expected the header rows scorer, bodyparts and coords of DeepLabCut");
}

void ReadDeepLabCutView(const std::string& path, size_t view_idx,
                        const DetectionReadOptions& options,
                        DeepLabCutRecording* recording) {
  ReadText<CsvRows>(path, [&](CsvRows* rows) {
    const DeepLabCutHeader header = ReadDeepLabCutHeader(rows);
    const DeepLabCutColumns& columns = header.columns;
    recording->SettleSkeleton(columns.labels);
    for (Texts cells; rows->Next(&cells, header.width);) {
      const int64_t frame = FrameOfCell(cells[header.first - 1]);
      recording->Touch(frame);
      for (size_t p = 0; p < columns.people.size(); ++p) {
        recording->AddPerson(
            frame, view_idx, p,
            ReadKeypointRow(cells, columns.people[p], columns.labels,
                            options.zero_confidence));
      }
    }
  });
}

// ---- HDF5 ----
// Read by an adapter, which prints every individual in every frame.

void ReadDeepLabCutH5View(const std::string& path, size_t view_idx,
                          const DetectionReadOptions& options,
                          DeepLabCutRecording* recording) {
  const auto view = OpenEverybodyByAdapter(
      OwnAdapter("deeplabcut_h5", AdapterKind::kDetections), path, options);
  const Skeleton& skeleton = view->header().skeleton;
  Located(path, [&] {
    recording->SettleSkeleton(skeleton.joints(), skeleton.bones(),
                              skeleton.name());
  });
  for (DetectionFrame frame; view->Next(&frame);) {
    recording->Touch(frame.frame);
    auto& people = frame.views.front().detections;
    for (size_t p = 0; p < people.size(); ++p) {
      recording->AddPerson(frame.frame, view_idx, p,
                           std::move(people[p].joints));
    }
  }
}

}  // namespace

bool RecogniseDeepLabCut(const DetectionHead& head) {
  const Texts row = head.FirstRow();
  return row.size() > 1 && row.front() == "scorer";
}

std::unique_ptr<DetectionSource> OpenDeepLabCut(
    const std::string& path, const DetectionReadOptions& options) {
  return OpenDetectors(path, options, ".csv", ReadDeepLabCutView);
}

std::unique_ptr<DetectionSource> OpenDeepLabCutH5(
    const std::string& path, const DetectionReadOptions& options) {
  return OpenDetectors(path, options, ".h5", ReadDeepLabCutH5View);
}

// ---- MediaPipe ----
// MediaPipe's landmarks as a table in pixels, one file per view:
// "frame,NAME_x,NAME_y,NAME_visibility,...", one row per frame, or per frame
// and person. Joints may have the names of any skeleton, in any spelling. The
// confidence may also be NAME_confidence or NAME_score, or missing (then 1).

namespace {

struct MediapipeColumns {
  int frame = -1;
  std::vector<std::string> labels;  // of the joints
  std::vector<KeypointColumns> joints;
};

MediapipeColumns FindMediapipeColumns(const std::vector<std::string>& header) {
  MediapipeColumns columns;
  for (size_t c = 0; c < header.size(); ++c) {
    const std::string name = PlainCell(header[c]);
    const int index = static_cast<int>(c);
    if (name == "frame") columns.frame = index;
    for (const auto& [end, column] :
         {std::pair<std::string, int KeypointColumns::*>{"_x",
                                                         &KeypointColumns::x},
          {"_y", &KeypointColumns::y},
          {"_visibility", &KeypointColumns::confidence},
          {"_confidence", &KeypointColumns::confidence},
          {"_score", &KeypointColumns::confidence}}) {
      if (!EndsIn(name, end)) continue;
      const size_t joint =
          IndexAmong(name.substr(0, name.size() - end.size()), &columns.labels);
      columns.joints.resize(columns.labels.size());
      columns.joints[joint].*column = index;
    }
  }
  // Other columns may end in _score, such as person_score.
  for (size_t j = columns.joints.size(); j-- > 0;) {
    if (columns.joints[j].x >= 0 || columns.joints[j].y >= 0) continue;
    columns.joints.erase(columns.joints.begin() +
                         static_cast<std::ptrdiff_t>(j));
    columns.labels.erase(columns.labels.begin() +
                         static_cast<std::ptrdiff_t>(j));
  }
  if (columns.frame < 0 || columns.joints.empty()) {
    throw InputError(
        "expected columns frame, NAME_x, NAME_y and optionally NAME_visibility "
        "(or NAME_confidence, NAME_score)");
  }
  for (size_t j = 0; j < columns.joints.size(); ++j) {
    if (columns.joints[j].x < 0 || columns.joints[j].y < 0) {
      throw InputError("joint '" + Printable(columns.labels[j]) +
                       "': expected the columns _x and _y");
    }
  }
  return columns;
}

void ReadMediapipeFile(const std::string& path, size_t view_idx,
                       const DetectionReadOptions& options,
                       DetectionCollector* collector) {
  ReadText<CsvRows>(path, [&](CsvRows* rows) {
    Texts cells;
    if (!rows->Next(&cells)) throw InputError("is empty");
    const size_t width = cells.size();
    const MediapipeColumns columns = FindMediapipeColumns(cells);
    collector->SettleSkeleton(columns.labels);
    while (rows->Next(&cells, width)) {
      const int64_t frame =
          FrameOfCell(cells[static_cast<size_t>(columns.frame)]);
      std::vector<Keypoint> joints = ReadKeypointRow(
          cells, columns.joints, columns.labels, options.zero_confidence);
      collector->Touch(frame);
      collector->AddFound(frame, view_idx, std::move(joints));
    }
  });
}

void WriteMediapipeView(int64_t frame, const std::vector<Detection>& detections,
                        ViewFile* file) {
  int person = 0;
  for (const Detection& detection : detections) {
    file->out.Add(frame, ",", person++);
    for (const Keypoint& joint : detection.joints) {
      if (joint.found) {
        file->out.Add(",", joint.px.x(), ",", joint.px.y(), ",",
                      joint.confidence);
      } else {
        file->out.Text(",,,");
      }
    }
    file->out.Text("\n");
  }
}

}  // namespace

bool RecogniseMediapipe(const DetectionHead& head) {
  const std::vector<std::string> row = head.FirstRow();
  return !row.empty() && row.front() == "frame" &&
         std::any_of(row.begin(), row.end(), [](const std::string& name) {
           return EndsIn(name, "_x");
         });
}

std::unique_ptr<DetectionSource> OpenMediapipe(
    const std::string& path, const DetectionReadOptions& options) {
  return ReadViews(ListViewFiles(path, ".csv"), options, ReadMediapipeFile);
}

void WriteMediapipe(const std::string& path, const DetectionWriteOptions&,
                    DetectionSource* source, LostFields* lost_fields) {
  const Skeleton& skeleton = source->header().skeleton;
  std::string heading = "frame,person";
  std::set<std::string> labels;
  for (const std::string& joint : skeleton.joints()) {
    const std::string label = LongJointName(joint);
    if (!labels.insert(label).second) {
      throw InputError("joint '" + Printable(joint) +
                       "': two joints have the name '" + Printable(label) +
                       "' in this format");
    }
    for (const char* column : {"_x", "_y", "_visibility"}) {
      heading += "," + CsvCell(label + column);
    }
  }
  const int64_t empty_frames =
      WriteViewFiles(path, ".csv", heading + "\n", source,
                     FindSkeletonOf(skeleton.joints()) != nullptr, lost_fields,
                     WriteMediapipeView);
  NoteEmptyFrames(empty_frames, lost_fields);
}

}  // namespace kinegraph
