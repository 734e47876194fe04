#include "solvers/scene/reading_search.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace kinegraph {
namespace {

// Another reading must agree this much better (of 1) to be thought of. Wrong
// readings of sound scenes stay below the right one; what chance gives to a
// maximum over all of them is a few hundredths.
constexpr double kMinReadingGain = 0.08;
// And reach this much itself: two views of one person agree to 0.6 to 0.9.
constexpr double kMinScore = 0.3;
// Readings this near the best fit equally.
constexpr double kEqual = 0.025;

// Agreement of one view with another when they take two of the cameras.
class PairTable {
 public:
  PairTable(const CameraRig& cameras, const std::vector<ViewPeople>& raw,
            const std::vector<int>& frames)
      : cameras_(cameras), frames_(frames), views_(raw.size()) {
    for (size_t v = 0; v < views_; ++v) {
      for (size_t c = 0; c < views_; ++c) {
        ideal_.push_back(Undistorted(raw[v], cameras[c]));
      }
    }
    known_.assign(views_ * views_ * views_ * views_, 0);
    table_.resize(known_.size());
  }

  PairAgreement Of(const std::vector<int>& camera_of_view) {
    PairAgreement all;
    for (size_t a = 0; a < views_; ++a) {
      for (size_t b = a + 1; b < views_; ++b) {
        all.Add(Pair(a, b, static_cast<size_t>(camera_of_view[a]),
                     static_cast<size_t>(camera_of_view[b])));
      }
    }
    return all;
  }

 private:
  const PairAgreement& Pair(size_t a, size_t b, size_t camera_a,
                            size_t camera_b) {
    const size_t at =
        ((a * views_ + b) * views_ + camera_a) * views_ + camera_b;
    if (!known_[at]) {
      known_[at] = 1;
      table_[at] = AgreementOf(
          cameras_[camera_a], ideal_[a * views_ + camera_a], cameras_[camera_b],
          ideal_[b * views_ + camera_b], frames_);
    }
    return table_[at];
  }

  const CameraRig& cameras_;
  const std::vector<int>& frames_;
  size_t views_;
  std::vector<ViewPeople> ideal_;  // [view * views + camera]
  std::vector<char> known_;
  std::vector<PairAgreement> table_;
};

// All ways to give the cameras to the views, where they are few; else those
// that exchange two.
std::vector<std::vector<int>> Permutations(size_t views) {
  std::vector<int> identity(views);
  std::iota(identity.begin(), identity.end(), 0);
  std::vector<std::vector<int>> permutations;
  constexpr size_t kAllUpTo = 5;
  if (views <= kAllUpTo) {
    std::vector<int> order = identity;
    while (std::next_permutation(order.begin(), order.end())) {
      permutations.push_back(order);
    }
    return permutations;
  }
  for (size_t a = 0; a < views; ++a) {
    for (size_t b = a + 1; b < views; ++b) {
      std::vector<int> order = identity;
      std::swap(order[a], order[b]);
      permutations.push_back(order);
    }
  }
  return permutations;
}

class Search {
 public:
  Search(const CameraRig& cameras, const std::vector<ViewPeople>& raw,
         const std::vector<int>& frames)
      : cameras_(cameras), raw_(raw), frames_(frames) {}

  ReadingScore Score(const Reading& reading) const {
    const PairAgreement agreement =
        AgreementOfAll(CamerasOf(cameras_, reading),
                       PeopleOf(cameras_, raw_, reading), frames_);
    return {reading, agreement.score(), agreement.mean_px()};
  }

  // Everything that differs from `from` in one thing.
  std::vector<ReadingScore> Neighbours(const Reading& from) const {
    std::vector<ReadingScore> scores;
    for (int p = 0; p < kPoseReadingCount; ++p) {
      Reading next = from;
      next.pose = static_cast<PoseReading>(p);
      if (!(next == from)) scores.push_back(Score(next));
    }
    AddScales(from, &scores);
    AddImages(from, &scores);
    AddExchanges(from, &scores);
    return scores;
  }

 private:
  void AddScales(const Reading& from, std::vector<ReadingScore>* scores) const {
    std::vector<double> factors = {0.25,      1.0 / 3.0, 0.5, 2.0 / 3.0, 0.75,
                                   4.0 / 3.0, 1.5,       2.0, 3.0,       4.0};
    for (const Camera& camera : cameras_) {
      const double width = ImageWidth(camera);
      // K of coordinates divided by the image's width.
      if (camera.focal_px() < 20.0) {
        double reach = 1.0;
        for (const auto& frame : raw_[0].frames) {
          for (const auto& person : frame) {
            for (const auto& px : person.px) reach = std::max(reach, px.x());
          }
        }
        factors.push_back(camera.width_px() > 0 ? camera.width_px() : reach);
      } else if (width > 0.0 && camera.focal_px() > 50.0 * width) {
        factors.push_back(1.0 / width);
      }
      break;  // one K tells
    }
    for (const double factor : factors) {
      Reading next = from;
      next.image_scale *= factor;
      scores->push_back(Score(next));
    }
  }

  void AddImages(const Reading& from, std::vector<ReadingScore>* scores) const {
    for (int i = 1; i < kImageReadingCount; ++i) {
      const auto image = static_cast<ImageReading>(i);
      Reading all = from;
      all.images.assign(all.images.size(), image);
      if (!(all == from)) scores->push_back(Score(all));
      for (size_t v = 0; v < from.images.size(); ++v) {
        Reading one = from;
        one.images[v] = image;
        if (!(one == from)) scores->push_back(Score(one));
      }
    }
  }

  void AddExchanges(const Reading& from,
                    std::vector<ReadingScore>* scores) const {
    // Images stay with their views, the rest goes with the cameras.
    Reading plain = Reading::AsRead(cameras_.size());
    plain.pose = from.pose;
    plain.image_scale = from.image_scale;
    plain.without_lens = from.without_lens;
    const CameraRig rig = CamerasOf(cameras_, plain);
    std::vector<ViewPeople> restored;
    for (size_t v = 0; v < raw_.size(); ++v) {
      restored.push_back(Restored(raw_[v], from.images[v],
                                  ImageWidth(cameras_[v]),
                                  ImageHeight(cameras_[v])));
    }
    PairTable table(rig, restored, frames_);
    for (const std::vector<int>& order : Permutations(cameras_.size())) {
      Reading next = from;
      next.camera_of_view = order;
      if (next == from) continue;
      const PairAgreement agreement = table.Of(order);
      scores->push_back({next, agreement.score(), agreement.mean_px()});
    }
  }

  const CameraRig& cameras_;
  const std::vector<ViewPeople>& raw_;
  const std::vector<int>& frames_;
};

// How many things a reading changes: the fewer, the likelier.
int ChangeCount(const Reading& reading) {
  int count = reading.pose != PoseReading::kAsRead;
  count += reading.image_scale != 1.0;
  count += reading.without_lens;
  int images = 0;
  for (const ImageReading image : reading.images) {
    images += image != ImageReading::kAsRead;
  }
  const bool all_alike =
      std::all_of(reading.images.begin(), reading.images.end(),
                  [&](ImageReading i) { return i == reading.images.front(); });
  count += all_alike ? (images > 0 ? 1 : 0) : images;
  for (size_t v = 0; v < reading.camera_of_view.size(); ++v) {
    count += reading.camera_of_view[v] != static_cast<int>(v);
  }
  return count;
}

void SortBest(std::vector<ReadingScore>* scores) {
  std::stable_sort(scores->begin(), scores->end(),
                   [](const ReadingScore& a, const ReadingScore& b) {
                     return a.score > b.score;
                   });
}

}  // namespace

ReadingSearch SearchReadings(const CameraRig& cameras,
                             const std::vector<ViewPeople>& raw,
                             const std::vector<int>& frames) {
  const Search search(cameras, raw, frames);
  ReadingSearch result;
  result.as_read = search.Score(Reading::AsRead(cameras.size()));
  ReadingScore best = result.as_read;
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<ReadingScore> scores = search.Neighbours(best.reading);
    SortBest(&scores);
    if (scores.empty() || scores.front().score < kMinScore ||
        scores.front().score < best.score + kMinReadingGain) {
      break;
    }
    result.better.clear();
    for (const ReadingScore& score : scores) {
      if (score.score >= scores.front().score - kEqual) {
        result.better.push_back(score);
      }
    }
    // Of what fits equally, the simplest comes first.
    std::stable_sort(result.better.begin(), result.better.end(),
                     [](const ReadingScore& a, const ReadingScore& b) {
                       return ChangeCount(a.reading) < ChangeCount(b.reading);
                     });
    best = result.better.front();
  }
  return result;
}

}  // namespace kinegraph
