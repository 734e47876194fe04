#include "core/io/detections/view_pairing.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

constexpr int kNone = -1;

using Words = std::vector<std::string>;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// "Recording_Cam-01" -> recording, cam, 1. Numbers remain text, so that they
// cannot overflow.
Words WordsOf(const std::string& name) {
  Words words;
  char before = ' ';
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool counts = std::isalnum(byte) != 0 || byte >= 0x80;
    const bool goes_on = counts && !words.empty() && before != ' ' &&
                         IsDigit(c) == IsDigit(before);
    before = counts ? c : ' ';
    if (!counts) continue;
    if (!goes_on) words.emplace_back();
    if (words.back() == "0") words.back().clear();
    words.back() += static_cast<char>(std::tolower(byte));
  }
  return words;
}

std::optional<std::string> LastNumber(const Words& words) {
  const auto at = std::find_if(words.rbegin(), words.rend(), [](const auto& w) {
    return IsDigit(w.front());
  });
  return at == words.rend() ? std::nullopt : std::optional(*at);
}

// The first names of a list, as text for a message.
std::string Listed(const std::vector<std::string>& names) {
  constexpr size_t kShown = 8;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    text += (i == 0 ? "'" : ", '") + Printable(names[i]) + "'";
  }
  if (names.size() > kShown) {
    text += " and " + std::to_string(names.size() - kShown) + " more";
  }
  return text;
}

std::vector<std::string> NamesOf(const CameraRig& cameras) {
  std::vector<std::string> names;
  for (const Camera& camera : cameras) names.push_back(camera.name());
  return names;
}

int IndexOf(const std::vector<std::string>& names, const std::string& name) {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? kNone : static_cast<int>(at - names.begin());
}

std::vector<Words> WordsOfAll(const std::vector<std::string>& names) {
  std::vector<Words> words;
  for (const std::string& name : names) words.push_back(WordsOf(name));
  return words;
}

bool StandsIn(const Words& part, const Words& whole) {
  return std::search(whole.begin(), whole.end(), part.begin(), part.end()) !=
         whole.end();
}

// Removes the words with which all names begin and those with which all end.
std::vector<Words> Distinct(const std::vector<Words>& names) {
  if (names.size() < 2) return names;
  const auto shared = [&names](bool from_end) {
    size_t count = 0;
    const auto word = [&](const Words& name) {
      return count >= name.size()
                 ? ""
                 : name[from_end ? name.size() - 1 - count : count];
    };
    while (!word(names.front()).empty() &&
           std::all_of(names.begin(), names.end(), [&](const Words& name) {
             return word(name) == word(names.front());
           })) {
      ++count;
    }
    return count;
  };
  const size_t front = shared(false);
  const size_t back = shared(true);
  std::vector<Words> rests;
  for (const Words& name : names) {
    rests.emplace_back();
    for (size_t i = front; i + back < name.size(); ++i) {
      rests.back().push_back(name[i]);
    }
  }
  return rests;
}

class Pairing {
 public:
  Pairing(const std::vector<std::string>& views,
          const std::vector<std::string>& cameras, UnpairedViews unpaired)
      : views_(views),
        cameras_(cameras),
        unpaired_(unpaired),
        view_words_(WordsOfAll(views)),
        camera_words_(WordsOfAll(cameras)),
        view_rests_(Distinct(view_words_)),
        camera_rests_(Distinct(camera_words_)),
        owner_(cameras.size(), kNone) {
    result_.camera_of_view.assign(views.size(), kNone);
  }

  void PairByName(const std::map<std::string, std::string>& map) {
    for (size_t v = 0; v < views_.size(); ++v) {
      const auto mapped = map.find(views_[v]);
      const bool is_mapped = mapped != map.end();
      const int camera =
          IndexOf(cameras_, is_mapped ? mapped->second : views_[v]);
      if (camera == kNone) continue;
      Give(v, camera, is_mapped ? PairedBy::kMap : PairedBy::kName);
    }
  }

  // Pairs those of `views` that have no camera yet, by the first rule that fits
  // all of them or, with kLeaveOut, all that have a candidate; false if none
  // does.
  bool PairRest(std::vector<size_t> views) {
    views.erase(std::remove_if(views.begin(), views.end(),
                               [this](size_t v) {
                                 return result_.camera_of_view[v] != kNone;
                               }),
                views.end());
    return views.empty() ||
           PairBy(PairedBy::kWithin, views, &Pairing::Longest) ||
           PairBy(PairedBy::kNumber, views, &Pairing::OfSameNumber) ||
           PairBy(PairedBy::kDistinct, views, &Pairing::OfSameRest) ||
           PairByOrder(views);
  }

  // Throws InputError with the reason why no rule fits; with kLeaveOut, only
  // for a view that matches several cameras or a camera that several views
  // match.
  void Fail(const std::vector<size_t>& views) const {
    const bool may_be_left = unpaired_ == UnpairedViews::kLeaveOut;
    if (cameras_.empty() && !may_be_left) {
      throw InputError("there are no cameras for the views " + Listed(views_));
    }
    std::vector<int> claimed = owner_;
    for (const size_t v : views) {
      if (result_.camera_of_view[v] != kNone) continue;
      const std::vector<int> candidates = OfSameNumber(v);
      const std::string view = "view '" + Printable(views_[v]) + "'";
      if (candidates.empty() && may_be_left) continue;
      if (candidates.empty()) {
        throw InputError(view +
                         " has no camera of the same name or number among " +
                         Listed(cameras_) +
                         "; cameras.map can name one, cameras.use leaves "
                         "it out");
      }
      if (candidates.size() > 1) {
        std::vector<std::string> names;
        for (const int c : candidates) names.push_back(NameOf(c));
        throw InputError(view + " matches the cameras " + Listed(names) +
                         "; cameras.map (or cameras.use) must decide");
      }
      Claim(v, candidates.front(), &claimed);
    }
    if (may_be_left) return;
    throw InputError(
        "the views " + Listed(views_) + " and the cameras " + Listed(cameras_) +
        " have names that do not match; cameras.map must pair them");
  }

  const ViewPairing& result() const { return result_; }

 private:
  using Candidates = std::vector<int> (Pairing::*)(size_t v) const;

  const std::string& NameOf(int camera) const {
    return cameras_[static_cast<size_t>(camera)];
  }

  // Assigns the camera to the view. Throws InputError if another view has it.
  void Claim(size_t view, int camera, std::vector<int>* owners) const {
    int& owner = (*owners)[static_cast<size_t>(camera)];
    if (owner != kNone) {
      throw InputError(
          "views '" + Printable(views_[static_cast<size_t>(owner)]) +
          "' and '" + Printable(views_[view]) + "' both match camera '" +
          Printable(NameOf(camera)) + "'; cameras.map must decide");
    }
    owner = static_cast<int>(view);
  }

  void Give(size_t view, int camera, PairedBy paired_by) {
    Claim(view, camera, &owner_);
    result_.camera_of_view[view] = camera;
    result_.paired_by = std::max(result_.paired_by, paired_by);
  }

  template <typename Fits>
  std::vector<int> Where(const Fits& fits) const {
    std::vector<int> cameras;
    for (size_t c = 0; c < cameras_.size(); ++c) {
      if (fits(c)) cameras.push_back(static_cast<int>(c));
    }
    return cameras;
  }

  std::vector<int> OfSameNumber(size_t v) const {
    const auto number = LastNumber(view_words_[v]);
    return Where([&](size_t c) {
      return number.has_value() && LastNumber(camera_words_[c]) == number;
    });
  }

  std::vector<int> OfSameRest(size_t v) const {
    return Where([&](size_t c) { return view_rests_[v] == camera_rests_[c]; });
  }

  // The cameras whose name contains the view's or is contained in it; of these,
  // the ones with the most words in common.
  std::vector<int> Longest(size_t v) const {
    std::vector<size_t> common;
    size_t most = 1;
    for (const Words& camera : camera_words_) {
      const Words& view = view_words_[v];
      const bool fits = StandsIn(camera, view) || StandsIn(view, camera);
      common.push_back(fits ? std::min(view.size(), camera.size()) : 0);
      most = std::max(most, common.back());
    }
    return Where([&](size_t c) { return common[c] == most; });
  }

  bool PairBy(PairedBy paired_by, const std::vector<size_t>& views,
              Candidates candidates) {
    std::map<size_t, int> pairs;
    std::set<int> taken;
    // Names such as "cam01_json" and "cam_01" are reported as having equal
    // numbers.
    bool same_numbers = paired_by == PairedBy::kWithin;
    for (const size_t v : views) {
      const std::vector<int> cameras = (this->*candidates)(v);
      if (cameras.empty() && unpaired_ == UnpairedViews::kLeaveOut) continue;
      if (cameras.size() != 1 ||
          owner_[static_cast<size_t>(cameras.front())] != kNone ||
          !taken.insert(cameras.front()).second) {
        return false;
      }
      pairs[v] = cameras.front();
      same_numbers = same_numbers && OfSameNumber(v) == cameras;
    }
    for (const auto& [v, camera] : pairs) {
      Give(v, camera, same_numbers ? PairedBy::kNumber : paired_by);
    }
    return !pairs.empty();
  }

  bool PairByOrder(std::vector<size_t> views) {
    std::vector<int> cameras =
        Where([&](size_t c) { return owner_[c] == kNone; });
    if (views.size() != cameras.size() || views.size() != views_.size()) {
      return false;
    }
    std::sort(views.begin(), views.end(), [this](size_t a, size_t b) {
      return NaturalLess(views_[a], views_[b]);
    });
    std::sort(cameras.begin(), cameras.end(), [this](int a, int b) {
      return NaturalLess(NameOf(a), NameOf(b));
    });
    if (!MayBeOrdered(views, cameras)) return false;
    for (size_t i = 0; i < views.size(); ++i) {
      Give(views[i], cameras[i], PairedBy::kOrder);
    }
    return true;
  }

  // Whether the numbers in the names permit pairing by order. If views and
  // cameras have numbers in common, those of either views or cameras must begin
  // at 0, and those of the counterparts must be higher by one: views 0, 1, 2
  // and cameras 1, 2, 3.
  bool MayBeOrdered(const std::vector<size_t>& views,
                    const std::vector<int>& cameras) const {
    const auto integer = [](const Words& words) {
      return LastInteger(LastNumber(words).value_or(""));
    };
    std::set<int64_t> of_views;
    std::set<int64_t> of_cameras;
    std::set<int64_t> shifts;
    for (size_t i = 0; i < views.size(); ++i) {
      const auto view = integer(view_rests_[views[i]]);
      const auto camera =
          integer(camera_rests_[static_cast<size_t>(cameras[i])]);
      if (view.has_value()) of_views.insert(*view);
      if (camera.has_value()) of_cameras.insert(*camera);
      shifts.insert(camera.value_or(0) - view.value_or(0));
    }
    const bool share =
        std::any_of(
            of_views.begin(), of_views.end(),
            [&](int64_t number) { return of_cameras.count(number) > 0; }) ||
        std::any_of(views.begin(), views.end(),
                    [this](size_t v) { return !OfSameNumber(v).empty(); });
    if (!share) return true;
    if (of_views.empty() || of_cameras.empty()) return false;
    const int64_t first = std::min(*of_views.begin(), *of_cameras.begin());
    const int64_t shift = *shifts.begin();
    return shifts.size() == 1 && first == 0 && std::abs(shift) == 1;
  }

  const std::vector<std::string>& views_;
  const std::vector<std::string>& cameras_;
  const UnpairedViews unpaired_;
  const std::vector<Words> view_words_;
  const std::vector<Words> camera_words_;
  const std::vector<Words> view_rests_;  // after Distinct
  const std::vector<Words> camera_rests_;
  std::vector<int> owner_;  // the view of each camera
  ViewPairing result_;
};

// Throws InputError unless every name in the map exists.
void CheckMap(const std::vector<std::string>& views,
              const std::vector<std::string>& cameras,
              const std::map<std::string, std::string>& map) {
  for (const auto& [view, camera] : map) {
    if (IndexOf(views, view) == kNone) {
      throw InputError("cameras.map names view '" + Printable(view) +
                       "', but the views are " + Listed(views));
    }
    if (IndexOf(cameras, camera) == kNone) {
      throw InputError("cameras.map gives view '" + Printable(view) +
                       "' camera '" + Printable(camera) +
                       "', but the cameras are " + Listed(cameras));
    }
  }
}

}  // namespace

const char* ToString(PairedBy paired_by) {
  switch (paired_by) {
    case PairedBy::kMap:
      return "as cameras.map specifies";
    case PairedBy::kName:
      return "by their names";
    case PairedBy::kWithin:
      return "because the name of one contains the other's";
    case PairedBy::kDistinct:
      return "by the distinct parts of their names";
    case PairedBy::kNumber:
      return "by the last number in their names";
    case PairedBy::kOrder:
      break;
  }
  return "in the order of their names, which do not match";
}

ViewPairing PairViewsWithCameras(const std::vector<std::string>& view_names,
                                 const CameraRig& cameras,
                                 const std::map<std::string, std::string>& map,
                                 UnpairedViews unpaired,
                                 const std::vector<std::string>& without) {
  const std::vector<std::string> camera_names = NamesOf(cameras);
  CheckMap(view_names, camera_names, map);
  std::vector<size_t> all;
  std::vector<size_t> wanted;
  for (size_t v = 0; v < view_names.size(); ++v) {
    all.push_back(v);
    if (IndexOf(without, view_names[v]) == kNone) wanted.push_back(v);
  }
  Pairing pairing(view_names, camera_names, unpaired);
  pairing.PairByName(map);
  if (!pairing.PairRest(all) && !pairing.PairRest(wanted)) pairing.Fail(wanted);
  return pairing.result();
}

UsedViews ChooseViews(const std::vector<std::string>& view_names,
                      const CameraRig& cameras,
                      const CameraReadOptions& options,
                      const std::vector<std::string>& without) {
  const ViewPairing pairing = PairViewsWithCameras(
      view_names, cameras, options.map,
      options.use.empty() ? UnpairedViews::kRefuse : UnpairedViews::kLeaveOut,
      without);
  const auto is_left_out = [&without](const std::string& name) {
    return IndexOf(without, name) != kNone;
  };
  UsedViews used;
  used.paired_by = pairing.paired_by;
  for (size_t v = 0; v < view_names.size(); ++v) {
    const int c = pairing.camera_of_view[v];
    if (c < 0 || is_left_out(view_names[v])) continue;
    const Camera& camera = cameras[static_cast<size_t>(c)];
    if (is_left_out(camera.name())) continue;
    used.views.push_back(static_cast<int>(v));
    used.cameras.push_back(camera);
  }
  for (const std::string& name : without) {
    if (IndexOf(view_names, name) == kNone &&
        IndexOf(NamesOf(cameras), name) == kNone) {
      std::string views;
      for (const std::string& view : view_names) {
        views += (views.empty() ? "" : ", ") + Printable(view);
      }
      throw InputError("--without_cameras: no view or camera is named '" +
                       Printable(name) + "', the views are " + views);
    }
  }
  if (used.views.empty()) {
    throw InputError("no view with a camera is left");
  }
  return used;
}

void KeepViews(const std::vector<int>& views, DetectionSequence* detections) {
  DetectionHeader& header = detections->header;
  std::vector<std::string> names;
  for (const int v : views) {
    names.push_back(header.view_names[static_cast<size_t>(v)]);
  }
  header.view_names = std::move(names);
  for (DetectionFrame& frame : detections->frames) {
    std::vector<ViewDetections> kept;
    for (const int v : views) {
      kept.push_back(std::move(frame.views[static_cast<size_t>(v)]));
    }
    frame.views = std::move(kept);
  }
}

}  // namespace kinegraph
