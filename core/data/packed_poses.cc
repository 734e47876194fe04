#include "core/data/packed_poses.h"

#include <optional>
#include <utility>
#include <vector>

#include "core/base/bytes.h"

namespace kinegraph {
namespace {

enum class Form : uint8_t { kNone, kSymmetric, kWhole };

Form FormOf(const std::optional<Eigen::Matrix3d>& covariance) {
  if (!covariance.has_value()) return Form::kNone;
  return *covariance == covariance->transpose() ? Form::kSymmetric
                                                : Form::kWhole;
}

void Put(const std::optional<Eigen::Matrix3d>& covariance, ByteWriter* writer) {
  const Form form = FormOf(covariance);
  writer->Put(form);
  if (form == Form::kWhole) writer->PutMatrix(*covariance);
  if (form != Form::kSymmetric) return;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      writer->Put((*covariance)(row, column));
    }
  }
}

std::optional<Eigen::Matrix3d> GetCovariance(ByteReader* reader) {
  const auto form = reader->Get<Form>();
  if (form == Form::kNone) return std::nullopt;
  Eigen::Matrix3d covariance;
  if (form == Form::kWhole) {
    reader->GetMatrix(&covariance);
    return covariance;
  }
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      covariance(row, column) = covariance(column, row) = reader->Get<double>();
    }
  }
  return covariance;
}

void Put(const ViewMatch& match, ByteWriter* writer) {
  writer->Put(match.view_idx);
  writer->Put(match.detection_idx);
  writer->PutCount(match.weights.size());
  for (const std::optional<double>& weight : match.weights) {
    writer->Put(weight.has_value());
    if (weight.has_value()) writer->Put(*weight);
  }
}

ViewMatch GetMatch(ByteReader* reader) {
  ViewMatch match;
  match.view_idx = reader->Get<int>();
  match.detection_idx = reader->Get<int>();
  match.weights.resize(reader->GetCount());
  for (std::optional<double>& weight : match.weights) {
    if (reader->Get<bool>()) weight = reader->Get<double>();
  }
  return match;
}

}  // namespace

void PackedPoses::Push(PersonPose* pose) {
  ByteWriter writer;
  writer.Put(pose->score);
  writer.PutCount(pose->joints.size());
  for (const Joint3d& joint : pose->joints) {
    writer.PutMatrix(joint.position_m);
    writer.Put(joint.status);
  }
  writer.PutCount(pose->inlier_views.size());
  for (const int views : pose->inlier_views) {
    writer.PutCount(static_cast<size_t>(views));
  }
  writer.PutCount(pose->covariances.size());
  for (const auto& covariance : pose->covariances) Put(covariance, &writer);
  writer.PutCount(pose->matches.size());
  for (const ViewMatch& match : pose->matches) Put(match, &writer);
  poses_.Push(writer.bytes());
  PersonPose nobody;
  nobody.id = pose->id;
  *pose = std::move(nobody);
}

void PackedPoses::RestoreFront(PersonPose* pose) const {
  ByteReader reader(poses_.front());
  pose->score = reader.Get<double>();
  pose->joints.resize(reader.GetCount());
  for (Joint3d& joint : pose->joints) {
    reader.GetMatrix(&joint.position_m);
    joint.status = reader.Get<JointStatus>();
  }
  pose->inlier_views.resize(reader.GetCount());
  for (int& views : pose->inlier_views) {
    views = static_cast<int>(reader.GetCount());
  }
  pose->covariances.resize(reader.GetCount());
  for (auto& covariance : pose->covariances) {
    covariance = GetCovariance(&reader);
  }
  pose->matches.resize(reader.GetCount());
  for (ViewMatch& match : pose->matches) match = GetMatch(&reader);
}

}  // namespace kinegraph
