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
    out_.Add("{\"frame\": ", frame.frame, ", \"time\": ", ToSeconds(frame.time),
             ", \"people\": [");
    out_.Join(frame.people,
              [this](const PersonPose& person) { WritePerson(person); });
    out_.Text("]}\n");
    out_.FlushTo(&file_);
  }

  void Commit() { file_.Commit(); }
  void HandOver() { file_.Flush(); }

 private:
  void WriteHeader(const TrackHeader& header) {
    const std::string config = CompactObject(header.config_json);
    if (config.empty()) {
      throw std::logic_error("the configuration of tracks is no JSON object");
    }
    out_.Add(
        "{\"kinegraph\": 1, \"units\": {\"length\": \"m\", \"time\": \"s\"}, "
        "\"skeleton\": ",
        SkeletonJson(header.skeleton), ", \"mode\": ", JsonText(header.mode),
        ", \"frame_rate\": ");
    if (header.frame_rate_hz > 0.0) {
      out_.Number(header.frame_rate_hz);
    } else {
      out_.Text("null");
    }
    if (options_.observations) {
      out_.Text(", \"views\": ");
      WriteArray(views_, [this](const std::string& view) { out_.Text(view); });
    }
    WriteNames();
    out_.Add(", \"config\": ", config, "}\n");
    out_.FlushTo(&file_);
  }

  void WriteNames() {
    if (options_.names.empty()) return;
    out_.Text(", \"names\": {");
    out_.Join(options_.names, [this](const auto& named) {
      out_.Add("\"", named.first.value(), "\": ", JsonText(named.second));
    });
    out_.Text("}");
  }

  void WritePerson(const PersonPose& person) {
    CheckLength(person.joints.size());
    out_.Add("{\"id\": ", person.id.value(), ", \"joints\": ");
    WriteArray(person.joints, [this](const Joint3d& joint) {
      if (!joint.present()) return out_.Text("null");
      const Eigen::Vector3d& at_m = joint.position_m;
      WriteNumbers({at_m.x(), at_m.y(), at_m.z()});
    });
    out_.Text(", \"status\": ");
    WriteArray(person.joints, [this](const Joint3d& joint) {
      out_.Add("\"", ToString(joint.status), "\"");
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
      if (!c) return out_.Text("null");
      WriteNumbers({(*c)(0, 0), (*c)(0, 1), (*c)(0, 2), (*c)(1, 1), (*c)(1, 2),
                    (*c)(2, 2)});
    });
  }

  void WriteObservations(const PersonPose& person) {
    out_.Add(", \"score\": ", person.score, ", \"matches\": {");
    out_.Join(person.matches, [this](const ViewMatch& match) {
      out_.Add(ViewOf(match), ": ", match.detection_idx);
    });
    out_.Text("}, \"weights\": {");
    const char* separator = "";
    for (const ViewMatch& match : person.matches) {
      if (match.weights.empty()) continue;
      CheckLength(match.weights.size());
      out_.Add(separator, ViewOf(match), ": ");
      separator = ", ";
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

  const std::string& ViewOf(const ViewMatch& match) const {
    const auto view_idx = static_cast<size_t>(match.view_idx);
    if (match.view_idx < 0 || view_idx >= views_.size()) {
      throw std::logic_error(
          "a match names a view that the tracks do not have");
    }
    return views_[view_idx];
  }

  template <typename Values, typename WriteValue>
  void WriteArray(const Values& values, const WriteValue& write_value) {
    out_.Text("[");
    out_.Join(values, write_value);
    out_.Text("]");
  }

  void WriteNumbers(std::initializer_list<double> numbers) {
    out_.Text("[");
    out_.Numbers(numbers);
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
