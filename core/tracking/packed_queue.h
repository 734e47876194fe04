// Queues of data that wait for the end of a recording, packed into about half
// of the memory: the frames given to estimators and the poses of a first pass.
#ifndef KINEGRAPH_CORE_TRACKING_PACKED_QUEUE_H_
#define KINEGRAPH_CORE_TRACKING_PACKED_QUEUE_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <deque>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/data/pose.h"
#include "core/tracking/estimator.h"

namespace kinegraph {

// Appends values to bytes or reads them back. bytes(a, b, c) does either, so
// each struct lists its fields once, in Exchange.
template <bool kReads>
class ByteExchange {
 public:
  using Bytes = std::conditional_t<kReads, const std::string, std::string>;
  explicit ByteExchange(Bytes* bytes, size_t at = 0) : bytes_(bytes), at_(at) {}

  template <typename... Values>
  void operator()(Values&... values) {
    (One(values), ...);
  }
  // Where the next value is read.
  size_t at() const { return at_; }

 private:
  template <typename T>
  void One(T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      Raw(&value, sizeof(value));
    } else {
      Exchange(*this, value);
    }
  }
  template <int kRows>
  void One(Eigen::Matrix<double, kRows, 1>& vector) {
    Raw(vector.data(), sizeof(double) * kRows);
  }
  // A covariance; its lower triangle if it is exactly symmetric.
  void One(Eigen::Matrix3d& matrix) {
    bool symmetric = !kReads && matrix == matrix.transpose();
    One(symmetric);
    for (int c = 0; c < 3; ++c) {
      for (int r = symmetric ? c : 0; r < 3; ++r) {
        One(matrix(r, c));
        if (kReads && symmetric) matrix(c, r) = matrix(r, c);
      }
    }
  }
  template <typename T>
  void One(std::optional<T>& value) {
    bool has_value = value.has_value();
    One(has_value);
    if (!has_value) return;
    if (kReads) value.emplace();
    One(*value);
  }
  template <typename T>
  void One(std::vector<T>& values) {
    auto count = static_cast<uint32_t>(values.size());
    One(count);
    if (kReads) values.resize(count);
    for (T& value : values) One(value);
  }
  void Raw(void* value, size_t size) {
    if constexpr (kReads) {
      std::memcpy(value, bytes_->data() + at_, size);
      at_ += size;
    } else {
      bytes_->append(static_cast<const char*>(value), size);
    }
  }

  Bytes* bytes_;
  size_t at_;
};

template <typename Bytes>
void Exchange(Bytes& bytes, Keypoint& joint) {
  bytes(joint.found);
  if (joint.found) bytes(joint.px, joint.confidence);
}
template <typename Bytes>
void Exchange(Bytes& bytes, Joint3d& joint) {
  bytes(joint.status);
  if (joint.present()) bytes(joint.position_m);
}
template <typename Bytes>
void Exchange(Bytes& bytes, FreshView& view) {
  bytes(view.view_idx, view.capture_time, view.detection_idx, view.joints);
}
template <typename Bytes>
void Exchange(Bytes& bytes, EstimatorFrame& frame) {
  bytes(frame.frame, frame.time, frame.views, frame.triangulated);
  bytes(frame.has_initial);
  if (frame.has_initial) bytes(frame.initial);
}
template <typename Bytes>
void Exchange(Bytes& bytes, ViewMatch& match) {
  bytes(match.view_idx, match.detection_idx, match.weights);
}
template <typename Bytes>
void Exchange(Bytes& bytes, PersonPose& pose) {
  bytes(pose.joints, pose.inlier_views, pose.covariances, pose.matches,
        pose.score);
}

// Items are stored consecutively in blocks, of which only the first is copied
// as the queue grows; each is freed once its last item is taken. Separate
// allocations would fragment the memory.
template <typename T>
class PackedQueue {
 public:
  void Push(const T& thing) {
    // Writing does not modify the item; Exchange takes non-const references for
    // reading.
    ByteExchange<false> write(&packed_);
    packed_.clear();
    write(const_cast<T&>(thing));
    if (blocks_.empty()) {
      blocks_.emplace_back();  // may stay the only one, so starts small
    } else if (blocks_.back().size() + packed_.size() > kBlockBytes) {
      blocks_.emplace_back().reserve(std::max(kBlockBytes, packed_.size()));
    }
    blocks_.back() += packed_;
    ++size_;
  }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  // Removes and returns the oldest item; the queue must not be empty.
  T Pop() {
    T thing;
    ByteExchange<true> read(&blocks_.front(), taken_);
    read(thing);
    taken_ = read.at();
    --size_;
    if (taken_ == blocks_.front().size()) {
      blocks_.pop_front();
      taken_ = 0;
    }
    return thing;
  }

 private:
  static constexpr size_t kBlockBytes = size_t{256} << 10;

  std::deque<std::string> blocks_;  // each holds whole items
  size_t taken_ = 0;                // bytes of the first block already read
  size_t size_ = 0;
  std::string packed_;  // the newest item; kept to reuse its memory
};

// Measurements and the initial pose are restored bit for bit; the results of
// the joints filter (verdicts, inlier views) are not kept.
using PackedFrames = PackedQueue<EstimatorFrame>;
// Everything but identity and derivatives.
using PackedPoses = PackedQueue<PersonPose>;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_PACKED_QUEUE_H_
