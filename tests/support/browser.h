// A headless Chromium, operated like a user: real keys, clicks and touches, any
// screen. Controlled through a pipe by the Chrome DevTools Protocol
// (https://chromedevtools.github.io/devtools-protocol).
#ifndef KINEGRAPH_TESTS_SUPPORT_BROWSER_H_
#define KINEGRAPH_TESTS_SUPPORT_BROWSER_H_

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/text/json.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

// A screen in CSS pixels.
struct Screen {
  int width = 1400;
  int height = 1000;
  double pixel_ratio = 1.0;
  bool is_phone = false;  // with touch input and the viewport of a phone
};

struct PagePoint {
  double x = 0.0;  // CSS pixels from the left of the viewport
  double y = 0.0;
};

// Every call throws std::runtime_error if the browser does not respond within a
// minute or responds with an error.
class Browser {
 public:
  static bool IsInstalled();

  explicit Browser(const Screen& screen = {});
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  // Sets prefers-color-scheme; call before Open().
  void PreferDark(bool dark);
  // Opens a file and waits until it has loaded.
  void Open(const std::string& path);

  // The value of a JavaScript expression; promises are waited for.
  Json Evaluate(const std::string& expression);
  // Waits until the expression is true; false after `timeout_s`.
  bool WaitFor(const std::string& expression, double timeout_s = 30.0);

  // The centre of the first element that matches a CSS selector, scrolled into
  // view.
  PagePoint MiddleOf(const std::string& selector);
  void Click(PagePoint at);
  void Click(const std::string& selector) { Click(MiddleOf(selector)); }
  // Moves the mouse with a button held, "left" or "right".
  void DragMouse(PagePoint from, PagePoint to,
                 const std::string& button = "left");
  // Turns the wheel by `pixels`; positive scrolls down.
  void Wheel(PagePoint at, double pixels);
  // A key by its name in KeyboardEvent.key: "ArrowRight", " ", "+".
  void Press(const std::string& key, bool shift = false);
  // Touches the page and moves the fingers; `from` and `to` have one point per
  // finger.
  void Drag(const std::vector<PagePoint>& from,
            const std::vector<PagePoint>& to);
  // Returns after the click event that the browser derives from the tap.
  void Tap(PagePoint at);
  void Tap(const std::string& selector) { Tap(MiddleOf(selector)); }

  // The viewport as a PNG file.
  void SaveScreenshot(const std::string& path);

  // Since the last Open(): console errors, failed assertions, uncaught
  // exceptions and violated security policies. Chromium's messages on software
  // rendering are warnings and excluded.
  const std::vector<std::string>& problems() const { return problems_; }
  // All URLs requested since the last Open().
  const std::vector<std::string>& requests() const { return requests_; }

 private:
  // Sends a message without waiting for its answer; returns the message's id.
  int Send(const std::string& method, const Json& parameters);
  Json Call(const std::string& method, const Json& parameters = Json::object());
  Json Receive();
  void Note(const Json& event);
  void Mouse(const std::string& type, PagePoint at, const Json& more);
  void TouchAt(const std::string& type, const std::vector<PagePoint>& points);

  TemporaryFolder profile_;
  FILE* to_browser_ = nullptr;
  int from_browser_ = -1;
  std::string received_;  // not yet parsed; may end within a message
  std::string session_;
  int last_id_ = 0;
  bool loaded_ = false;
  std::vector<std::string> problems_;
  std::vector<std::string> requests_;
};

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_BROWSER_H_
