// The page in a real browser. A script joined to the page's end works it as a
// user would and leaves its findings in the document, which Chromium prints.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "core/io/json.h"
#include "core/io/text_file.h"
#include "tests/support/rig.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

constexpr const char* kHostile = "</script><img src=x onerror='hacked=1'>";

constexpr const char* kWatch = R"(<script>
var problems = [], hacked = 0;
window.addEventListener('error', (e) => problems.push(String(e.message)));
document.addEventListener('securitypolicyviolation',
                          (e) => problems.push('policy ' + e.blockedURI));
console.error = (...words) => problems.push(words.join(' '));
</script>)";

constexpr const char* kWork = R"(<script>
function key(name) {
  document.body.dispatchEvent(new KeyboardEvent('keydown', {key: name, bubbles: true, cancelable: true}));
  return kinegraph.state.frame;
}
function overlaps() {
  const parts = ['header', '#stage', 'aside section:nth-child(1)', '#moments-card', '#timelines'];
  const boxes = parts.map((part) => document.querySelector(part).getBoundingClientRect());
  const found = [];
  boxes.forEach((a, i) => boxes.forEach((b, k) => {
    const apart = a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
    if (i < k && !apart) found.push(parts[i] + ' ' + parts[k]);
  }));
  document.querySelectorAll('button, select, input, .chart, h1').forEach((node) => {
    if (node.getBoundingClientRect().right > document.body.clientWidth + 1) found.push('outside ' + (node.id || node.textContent));
  });
  return found;
}
const found = {width: innerWidth, webgl: kinegraph.scene !== null};
found.right = key('ArrowRight'); found.end = key('End'); found.left = key('ArrowLeft'); found.home = key('Home');
found.none = key('q');
const scrub = document.getElementById('scrub');
scrub.value = '17'; scrub.dispatchEvent(new Event('input'));
found.scrubbed = kinegraph.state.frame;
const moment = document.querySelector('#moments button');
moment.click();
found.moment = [Number(moment.dataset.at), kinegraph.state.frame];
found.title = document.getElementById('title').textContent;
found.images = document.querySelectorAll('img').length;
found.overlapLight = overlaps();
const ink = () => getComputedStyle(document.body).color;
const first = ink();
document.getElementById('theme').click();
found.overlapDark = overlaps();
found.themesDiffer = first !== ink();
document.body.style.width = '390px';
window.dispatchEvent(new Event('resize'));
found.overlapPhone = innerWidth <= 760 ? overlaps() : [];
key('Home'); key(' ');
setTimeout(() => {
  found.played = kinegraph.state.frame;
  key(' ');
  found.paused = !kinegraph.state.playing;
  found.requests = performance.getEntriesByType('resource').length;
  found.hacked = hacked;
  found.problems = problems;
  const result = document.createElement('textarea');
  result.id = 'found';
  result.textContent = 'BEGIN' + btoa(JSON.stringify(found)) + 'END';
  document.body.append(result);
}, 1500);
</script>)";

std::string FromBase64(const std::string& text) {
  const std::string alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned buffer = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    buffer = (buffer << 6) | static_cast<unsigned>(alphabet.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>((buffer >> bits) & 255u);
  }
  return bytes;
}

std::string HostilePage() {
  PageInput input;
  input.title = kHostile;
  TrackSequence tracks;
  tracks.header.skeleton = Coco17();
  for (int f = 0; f < 100; ++f) {
    TrackFrame frame;
    frame.frame = 300 + f;
    frame.time = FrameClock(25.0).TimeOf(frame.frame);
    for (int p = 0; p < (f < 60 ? 3 : 2); ++p) {
      PersonPose person;
      person.id = TrackId(p);
      person.joints = testing::StandingPerson(0.02 * f, p);
      person.joints[3].status = JointStatus::kInferred;
      if (f == 42) person.joints[9].position_m.x() += 0.3;
      frame.people.push_back(person);
    }
    tracks.frames.push_back(frame);
  }
  input.results.push_back({kHostile, ResultRole::kTracks, tracks});
  input.results.push_back({"truth", ResultRole::kGroundTruth, tracks});
  input.cameras = testing::RingOfCameras(4);
  std::string page = MakePage(input.title, MakePageData(input).json);
  page.insert(page.find("<meta name=\"viewport\""), kWatch);
  return page.insert(page.rfind("</body>"), kWork);
}

bool HasChromium() {
  return std::system("command -v chromium > /dev/null 2>&1") == 0;
}

Json FindingsAt(const std::string& window_size) {
  const testing::TemporaryFolder folder;
  const std::string page = folder.Write("page.html", HostilePage());
  const std::string out = (folder.path() / "dom.html").string();
  const std::string line =
      "timeout 120 chromium --headless --no-sandbox --disable-gpu "
      "--enable-unsafe-swiftshader --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update "
      "--disable-sync --user-data-dir=" +
      (folder.path() / "profile").string() + " --window-size=" + window_size +
      " --virtual-time-budget=6000 --dump-dom file://" + page + " > " + out +
      " 2> /dev/null";
  const int status = std::system(line.c_str());
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  const std::string dom = ReadTextFile(out);
  // The script's own text holds the word too; what it left comes last.
  const size_t begin = dom.rfind("BEGIN");
  const size_t end = dom.rfind("END</textarea>");
  if (begin == std::string::npos || end == std::string::npos || end < begin) {
    ADD_FAILURE() << "the page left no findings";
    return Json::object();
  }
  return ParseJson(FromBase64(dom.substr(begin + 5, end - begin - 5)), "page");
}

class Browser : public ::testing::TestWithParam<const char*> {};

TEST_P(Browser, PageWorks) {
  if (!HasChromium()) {
    GTEST_SKIP() << "needs a browser: apt-get install chromium";
  }
  const Json found = FindingsAt(GetParam());
  ASSERT_TRUE(found.contains("problems"));
  SCOPED_TRACE(found.dump());
  EXPECT_EQ(found["problems"], Json::array());
  EXPECT_EQ(found["requests"], 0) << "everything is in the file";
  EXPECT_EQ(found["webgl"], true);
  // Chromium makes no window narrower than 500; the script squeezes the body.
  EXPECT_EQ(found["width"].get<int>() <= 760,
            std::string(GetParam()) == "390,844");
  EXPECT_EQ(found["right"], 1);
  EXPECT_EQ(found["end"], 99);
  EXPECT_EQ(found["left"], 98);
  EXPECT_EQ(found["home"], 0);
  EXPECT_EQ(found["none"], 0) << "other keys do nothing";
  EXPECT_EQ(found["scrubbed"], 17);
  EXPECT_EQ(found["moment"][0], found["moment"][1]);
  EXPECT_EQ(found["moment"][0], 43) << "the jump back at frame 343";
  EXPECT_GT(found["played"], 0);
  EXPECT_EQ(found["paused"], true);
  EXPECT_EQ(found["title"], kHostile);
  EXPECT_EQ(found["images"], 0);
  EXPECT_EQ(found["hacked"], 0);
  EXPECT_EQ(found["themesDiffer"], true);
  EXPECT_EQ(found["overlapLight"], Json::array());
  EXPECT_EQ(found["overlapDark"], Json::array());
  EXPECT_EQ(found["overlapPhone"], Json::array());
}

INSTANTIATE_TEST_SUITE_P(Sizes, Browser,
                         ::testing::Values("1400,1000", "390,844"));

}  // namespace
}  // namespace kinegraph
