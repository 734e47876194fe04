#include "core/io/tracks/writer.h"

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

// Keeps the comma between the entries of one object or array.
class Separator {
 public:
  const char* Next() {
    const char* text = is_first_ ? "" : ", ";
    is_first_ = false;
    return text;
  }

 private:
  bool is_first_ = true;
};

}  // namespace

class TrackWriter::Impl {
 public:
  Impl(const std::string& path, const TrackHeader& header,
       const TrackWriteOptions& options)
      : options_(options),
        joint_count_(header.skeleton.joints().size()),
        file_(path) {
    for (const std::string& name : header.view_names) {
      views_.push_back(JsonText(name));
    }
    WriteHeader(header);
  }

  void Write(const TrackFrame& frame) {
    if (frame.frame <= last_frame_) {
      throw std::logic_error("tracks of frame " + std::to_string(frame.frame) +
                             " come after those of frame " +
                             std::to_string(last_frame_));
    }
    last_frame_ = frame.frame;
    out_.Text("{\"frame\": ");
    out_.Integer(frame.frame);
    out_.Text(", \"time\": ");
    out_.Seconds(frame.time);
    out_.Text(", \"people\": [");
    Separator separator;
    for (const PersonPose& person : frame.people) {
      out_.Text(separator.Next());
      WritePerson(person);
    }
    out_.Text("]}\n");
    Flush();
  }

  void Commit() { file_.Commit(); }
  void HandOver() { file_.Flush(); }

 private:
  void Flush() {
    file_.Write(out_.text().data(), out_.text().size());
    out_.Clear();
  }

  void WriteHeader(const TrackHeader& header) {
    const std::string config = CompactObject(header.config_json);
    if (config.empty()) {
      throw std::logic_error("the configuration of tracks is no JSON object");
    }
    out_.Text(
        "{\"kinegraph\": 1, \"units\": {\"length\": \"m\", \"time\": \"s\"}, "
        "\"skeleton\": ");
    out_.Text(SkeletonJson(header.skeleton));
    out_.Text(", \"mode\": ");
    out_.Text(JsonText(header.mode));
    out_.Text(", \"frame_rate\": ");
    if (header.frame_rate_hz > 0.0) {
      out_.Number(header.frame_rate_hz);
    } else {
      out_.Text("null");
    }
    if (options_.observations) {
      out_.Text(", \"views\": [");
      Separator separator;
      for (const std::string& view : views_) {
        out_.Text(separator.Next());
        out_.Text(view);
      }
      out_.Text("]");
    }
    WriteNames();
    out_.Text(", \"config\": ");
    out_.Text(config);
    out_.Text("}\n");
    Flush();
  }

  void WriteNames() {
    if (options_.names.empty()) return;
    out_.Text(", \"names\": {");
    Separator separator;
    for (const auto& [id, name] : options_.names) {
      out_.Text(separator.Next());
      out_.Text("\"" + std::to_string(id.value()) + "\": " + JsonText(name));
    }
    out_.Text("}");
  }

  void WritePerson(const PersonPose& person) {
    CheckLength(person.joints.size());
    out_.Text("{\"id\": ");
    out_.Integer(person.id.value());
    out_.Text(", \"joints\": ");
    WriteArray(person.joints, [this](const Joint3d& joint) {
      if (joint.present()) {
        WriteNumbers(joint.position_m.data(), 3);
      } else {
        out_.Text("null");
      }
    });
    out_.Text(", \"status\": ");
    WriteArray(person.joints, [this](const Joint3d& joint) {
      out_.Text("\"");
      out_.Text(ToString(joint.status));
      out_.Text("\"");
    });
    WriteCovariances(person);
    if (!person.inlier_views.empty()) {
      CheckLength(person.inlier_views.size());
      out_.Text(", \"views\": ");
      WriteArray(person.inlier_views,
                 [this](int count) { out_.Integer(count); });
    }
    if (options_.observations) WriteObservations(person);
    out_.Text("}");
  }

  void WriteCovariances(const PersonPose& person) {
    const auto& covariances = person.covariances;
    if (std::none_of(covariances.begin(), covariances.end(),
                     [](const auto& c) { return c.has_value(); })) {
      return;
    }
    CheckLength(covariances.size());
    out_.Text(", \"covariance\": ");
    WriteArray(covariances, [this](const std::optional<Eigen::Matrix3d>& c) {
      if (!c) {
        out_.Text("null");
        return;
      }
      const double upper[6] = {(*c)(0, 0), (*c)(0, 1), (*c)(0, 2),
                               (*c)(1, 1), (*c)(1, 2), (*c)(2, 2)};
      WriteNumbers(upper, 6);
    });
  }

  void WriteObservations(const PersonPose& person) {
    out_.Text(", \"score\": ");
    out_.Number(person.score);
    out_.Text(", \"matches\": {");
    Separator matches;
    for (const ViewMatch& match : person.matches) {
      WriteKey(match, &matches);
      out_.Integer(match.detection_idx);
    }
    out_.Text("}, \"weights\": {");
    Separator weights;
    for (const ViewMatch& match : person.matches) {
      if (match.weights.empty()) continue;
      CheckLength(match.weights.size());
      WriteKey(match, &weights);
      WriteArray(match.weights, [this](const std::optional<double>& weight) {
        if (weight) {
          out_.Number(*weight);
        } else {
          out_.Text("null");
        }
      });
    }
    out_.Text("}");
  }

  void WriteKey(const ViewMatch& match, Separator* separator) {
    const auto view_idx = static_cast<size_t>(match.view_idx);
    if (match.view_idx < 0 || view_idx >= views_.size()) {
      throw std::logic_error(
          "a match names a view that the tracks do not have");
    }
    out_.Text(separator->Next());
    out_.Text(views_[view_idx]);
    out_.Text(": ");
  }

  template <typename Values, typename WriteValue>
  void WriteArray(const Values& values, const WriteValue& write_value) {
    out_.Text("[");
    Separator separator;
    for (const auto& value : values) {
      out_.Text(separator.Next());
      write_value(value);
    }
    out_.Text("]");
  }

  void WriteNumbers(const double* numbers, size_t count) {
    out_.Text("[");
    for (size_t i = 0; i < count; ++i) {
      if (i > 0) out_.Text(", ");
      out_.Number(numbers[i]);
    }
    out_.Text("]");
  }

  void CheckLength(size_t found) const {
    if (found != joint_count_) {
      throw std::logic_error("a person does not have the joints of its tracks");
    }
  }

  const TrackWriteOptions options_;
  const size_t joint_count_;
  AtomicFile file_;
  std::vector<std::string> views_;  // quoted
  int64_t last_frame_ = -1;
  JsonOutput out_;
};

TrackWriter::TrackWriter(const std::string& path, const TrackHeader& header,
                         const TrackWriteOptions& options)
    : impl_(std::make_unique<Impl>(path, header, options)) {}
TrackWriter::~TrackWriter() = default;
void TrackWriter::Write(const TrackFrame& frame) { impl_->Write(frame); }
void TrackWriter::Flush() { impl_->HandOver(); }
void TrackWriter::Commit() { impl_->Commit(); }

void WriteTracks(const std::string& path, const TrackSequence& sequence,
                 const TrackWriteOptions& options) {
  TrackWriter writer(path, sequence.header, options);
  for (const TrackFrame& frame : sequence.frames) writer.Write(frame);
  writer.Commit();
}

}  // namespace kinegraph
