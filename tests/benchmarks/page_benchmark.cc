// The page of a big take, 5 minutes of 6 people at 30 Hz, in headless Chromium:
//
//   build/tests/benchmarks/page_benchmark [SECONDS]
//
// What it prints for each page: the size; the time from asking for the file
// until its first picture was handed over; and the script's own time a picture
// while it plays (all that the page's code does for one animation frame,
// three.js included) over SECONDS, default 60, after the first two. That time
// is given twice: the processor time of the page's thread, and the time on the
// clock, in which the thread may also have stood aside for others. Chromium
// has no graphics card here and draws in software (SwiftShader), in a process
// that wants every core it can get, so the second depends on the machine and
// the pictures a second say nothing about a user's.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/table.h"
#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "core/synthetic/scene.h"
#include "tests/support/browser.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using testing::Browser;

Scene BigScene() {
  SceneOptions options;
  options.people = 6;
  options.duration_s = 300.0;
  options.frame_rate_hz = 30.0;
  options.motion.visitors = 0.0;  // all six all the time
  return MakeScene(options);
}

// What cameras see of everybody, without noise.
DetectionSequence SeenBy(const CameraRig& cameras,
                         const TrackSequence& tracks) {
  DetectionSequence seen;
  seen.header.skeleton = tracks.header.skeleton;
  seen.header.frame_rate_hz = tracks.header.frame_rate_hz;
  for (const Camera& camera : cameras) {
    seen.header.view_names.push_back(camera.name());
  }
  for (const TrackFrame& frame : tracks.frames) {
    DetectionFrame in_frame;
    in_frame.frame = frame.frame;
    in_frame.time = frame.time;
    for (const Camera& camera : cameras) {
      ViewDetections view;
      for (const PersonPose& person : frame.people) {
        view.detections.push_back(testing::Project(person.joints, camera));
        view.detections.back().index_in_file =
            static_cast<int>(view.detections.size()) - 1;
      }
      in_frame.views.push_back(std::move(view));
    }
    seen.frames.push_back(std::move(in_frame));
  }
  return seen;
}

struct Pictures {
  double open_s = 0.0;
  std::vector<double> processor_ms;  // ascending
  std::vector<double> clock_ms;      // ascending
};

Pictures Play(const std::string& path, double seconds) {
  Browser browser({1400, 1000, 1.0, false});
  Pictures pictures;
  const auto begin = std::chrono::steady_clock::now();
  browser.Open(path);
  browser.WaitFor("window.kinegraph && kinegraph.state.pictures > 0");
  pictures.open_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
          .count();
  browser.MiddleOf("#panels");  // so that panels are drawn, when there are any
  browser.Evaluate(
      "if (kinegraph.results[0].covariance)"
      "document.getElementById('show-ellipsoids').click()");
  browser.Evaluate("kinegraph.play(); window.since = performance.now()");
  const auto wait = [&](double until_s) {
    browser.WaitFor(
        "performance.now() - since > " + std::to_string(1000.0 * until_s),
        until_s + 60.0);
  };
  wait(2.0);
  browser.StartTrace("devtools.timeline");
  wait(2.0 + seconds);
  for (const Json& event : browser.StopTrace()) {
    if (event["name"] != "FunctionCall" || event["ph"] != "X") continue;
    const Json data = event["args"].value("data", Json::object());
    if (data.value("functionName", "") != "tick") continue;
    pictures.clock_ms.push_back(1e-3 * event["dur"].get<double>());
    pictures.processor_ms.push_back(1e-3 * event.value("tdur", 0.0));
  }
  for (std::vector<double>* times :
       {&pictures.clock_ms, &pictures.processor_ms}) {
    if (times->empty()) times->push_back(0.0);
    std::sort(times->begin(), times->end());
  }
  for (const std::string& problem : browser.problems()) {
    std::fprintf(stderr, "%s\n", problem.c_str());
  }
  return pictures;
}

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share *
                                    static_cast<double>(sorted.size() - 1))];
}

void Run(double seconds) {
  const Scene scene = BigScene();
  PageInput input;
  input.title = "big take";
  input.results.push_back({"truth", ResultRole::kTracks, TruthOf(scene)});
  for (PersonPose& person : input.results[0].tracks.frames[0].people) {
    person.inlier_views.assign(person.joints.size(), 3);
  }
  const testing::TemporaryFolder folder;
  Table table({"page", "MB", "opens, s", "processor, ms: median", "95th", "max",
               "clock, ms: median", "95th", "max", "pictures"});
  std::string notes;
  for (const std::string name :
       {"tracks", "tracks, cameras", "with detections, covariances"}) {
    PageOptions options;
    if (name != "tracks") input.cameras = scene.cameras;
    if (name.find("with") == 0) {
      TrackSequence& tracks = input.results[0].tracks;
      input.detections = SeenBy(scene.cameras, tracks);
      for (TrackFrame& frame : tracks.frames) {
        for (PersonPose& person : frame.people) {
          person.covariances.assign(person.joints.size(),
                                    Eigen::Matrix3d::Identity() * 1e-4);
        }
      }
      options.with_covariance = true;
    }
    const PageData data = MakePageData(input, options);
    const std::string path = (folder.path() / "page.html").string();
    const size_t bytes = WritePage(input.title, data.json, path);
    const Pictures pictures = Play(path, seconds);
    std::vector<std::string> row = {name,
                                    Fixed(static_cast<double>(bytes) / 1e6, 1),
                                    Fixed(pictures.open_s, 1)};
    for (const auto* times : {&pictures.processor_ms, &pictures.clock_ms}) {
      for (const double share : {0.5, 0.95, 1.0}) {
        row.push_back(Fixed(Quantile(*times, share), 1));
      }
    }
    row.push_back(std::to_string(pictures.clock_ms.size()));
    table.AddRow(row);
    if (data.extras_stride > 1) {
      notes += name + ": detections and covariances of one frame in " +
               std::to_string(data.extras_stride) + "\n";
    }
  }
  std::printf("%s, drawing in software\n\n%s\n%s", Browser().Version().c_str(),
              table.ToString(TableStyle::kMarkdown).c_str(), notes.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  if (!kinegraph::testing::Browser::IsInstalled()) {
    std::fprintf(stderr, "needs a browser: apt-get install chromium\n");
    return 1;
  }
  kinegraph::Run(argc > 1 ? std::atof(argv[1]) : 60.0);
  return 0;
}
