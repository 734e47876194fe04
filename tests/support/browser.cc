#include "tests/support/browser.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "tests/support/base64.h"

namespace kinegraph::testing {
namespace {

constexpr int kAnswerTimeoutMs = 60000;

[[noreturn]] void Fail(const std::string& what) {
  throw std::runtime_error("browser: " + what);
}

}  // namespace

bool Browser::IsInstalled() {
  return std::system("command -v chromium > /dev/null 2>&1") == 0;
}

Browser::Browser(const Screen& screen) {
  signal(SIGPIPE, SIG_IGN);  // if the browser dies, write() reports an error
  const std::string folder = profile_.path().string();
  const std::string answers = folder + "/answers";
  if (mkfifo(answers.c_str(), 0600) != 0) Fail("cannot make a pipe");
  // Chromium reads from descriptor 3, writes to 4, and ends when 3 is closed.
  // Containers have little shared memory.
  const std::string command =
      "exec timeout --kill-after=5 300 chromium --headless --no-sandbox "
      "--disable-gpu --disable-dev-shm-usage --enable-unsafe-swiftshader "
      "--no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --disable-quic "
      "--remote-debugging-pipe --user-data-dir='" +
      folder + "/profile' about:blank 3<&0 4>'" + answers +
      "' </dev/null >/dev/null 2>&1";
  to_browser_ = popen(command.c_str(), "we");
  if (to_browser_ == nullptr) Fail("cannot start chromium");
  from_browser_ = open(answers.c_str(), O_RDONLY | O_CLOEXEC);

  const Json target = Call("Target.createTarget", {{"url", "about:blank"}});
  session_ = Call("Target.attachToTarget", {{"targetId", target["targetId"]},
                                            {"flatten", true}})["sessionId"];
  for (const char* domain : {"Page", "Runtime", "Log", "Network"}) {
    Call(std::string(domain) + ".enable");
  }
  Call("Emulation.setDeviceMetricsOverride",
       {{"width", screen.width},
        {"height", screen.height},
        {"deviceScaleFactor", screen.pixel_ratio},
        {"mobile", screen.is_phone}});
  Call("Emulation.setTouchEmulationEnabled",
       {{"enabled", screen.is_phone}, {"maxTouchPoints", 5}});
}

Browser::~Browser() {
  try {
    session_.clear();
    Call("Browser.close");
  } catch (const std::runtime_error&) {
    // The browser ends when its input is closed, or at the time limit.
  }
  close(from_browser_);
  pclose(to_browser_);  // waits for its end
}

Json Browser::Receive() {
  for (;;) {
    const size_t end = received_.find('\0');
    if (end != std::string::npos) {
      const Json message = Json::parse(received_.substr(0, end));
      received_.erase(0, end + 1);
      return message;
    }
    pollfd wait = {from_browser_, POLLIN, 0};
    if (poll(&wait, 1, kAnswerTimeoutMs) <= 0) Fail("no answer");
    char buffer[1 << 16];
    const ssize_t count = read(from_browser_, buffer, sizeof(buffer));
    if (count <= 0) Fail("ended unexpectedly");
    received_.append(buffer, static_cast<size_t>(count));
  }
}

int Browser::Send(const std::string& method, const Json& parameters) {
  const int id = ++last_id_;
  Json message = {{"id", id}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump();
  // The closing zero is part of the message.
  fwrite(text.c_str(), 1, text.size() + 1, to_browser_);
  if (fflush(to_browser_) != 0) Fail("does not accept messages");
  return id;
}

Json Browser::Call(const std::string& method, const Json& parameters) {
  const int id = Send(method, parameters);
  for (;;) {
    const Json answer = Receive();
    if (!answer.contains("id")) {
      Note(answer);
      continue;
    }
    if (answer["id"] != id) continue;
    if (answer.contains("error")) Fail(method + ": " + answer.dump());
    return answer["result"];
  }
}

void Browser::Note(const Json& event) {
  const std::string method = event["method"];
  const Json& parameters = event["params"];
  if (method == "Page.loadEventFired") loaded_ = true;
  if (method == "Network.requestWillBeSent") {
    requests_.push_back(parameters["request"]["url"]);
  }
  if (method == "Runtime.exceptionThrown") {
    problems_.push_back(parameters["exceptionDetails"].dump());
  }
  if (method == "Runtime.consoleAPICalled" &&
      (parameters["type"] == "error" || parameters["type"] == "assert")) {
    problems_.push_back(parameters["args"].dump());
  }
  if (method == "Log.entryAdded" && parameters["entry"]["level"] == "error") {
    problems_.push_back(parameters["entry"].dump());
  }
}

void Browser::PreferDark(bool dark) {
  Call("Emulation.setEmulatedMedia",
       {{"features", Json::array({{{"name", "prefers-color-scheme"},
                                   {"value", dark ? "dark" : "light"}}})}});
}

void Browser::Open(const std::string& path) {
  loaded_ = false;
  problems_.clear();
  requests_.clear();
  const Json answer = Call("Page.navigate", {{"url", "file://" + path}});
  if (answer.contains("errorText")) Fail(answer.dump());
  while (!loaded_) {
    const Json event = Receive();
    if (event.contains("method")) Note(event);
  }
}

Json Browser::Evaluate(const std::string& expression) {
  const Json answer = Call("Runtime.evaluate", {{"expression", expression},
                                                {"returnByValue", true},
                                                {"awaitPromise", true},
                                                {"userGesture", true}});
  if (answer.contains("exceptionDetails")) {
    Fail(expression + ": " + answer["exceptionDetails"].dump());
  }
  return answer["result"].value("value", Json());
}

bool Browser::WaitFor(const std::string& expression, double timeout_s) {
  const auto until = std::chrono::steady_clock::now() +
                     std::chrono::duration<double>(timeout_s);
  do {
    if (Evaluate("Boolean(" + expression + ")") == true) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  } while (std::chrono::steady_clock::now() < until);
  return false;
}

PagePoint Browser::MiddleOf(const std::string& selector) {
  const Json box = Evaluate(
      "(() => { const node = document.querySelector(" + Json(selector).dump() +
      "); node.scrollIntoView({block: 'center', behavior: 'instant'});"
      "const box = node.getBoundingClientRect();"
      "return [box.left + box.width / 2, box.top + box.height / 2]; })()");
  return {box[0].get<double>(), box[1].get<double>()};
}

void Browser::Mouse(const std::string& type, PagePoint at, const Json& more) {
  Json event = {{"type", type}, {"x", at.x}, {"y", at.y}};
  event.update(more);
  Call("Input.dispatchMouseEvent", event);
}

void Browser::Click(PagePoint at) {
  const Json left = {{"button", "left"}, {"clickCount", 1}};
  Mouse("mouseMoved", at, Json::object());
  Mouse("mousePressed", at, left);
  Mouse("mouseReleased", at, left);
}

void Browser::DragMouse(PagePoint from, PagePoint to,
                        const std::string& button) {
  const Json held = {{"button", button},
                     {"buttons", button == "right" ? 2 : 1},
                     {"clickCount", 1}};
  Mouse("mouseMoved", from, Json::object());
  Mouse("mousePressed", from, held);
  Mouse("mouseMoved", {0.5 * (from.x + to.x), 0.5 * (from.y + to.y)}, held);
  Mouse("mouseMoved", to, held);
  Mouse("mouseReleased", to, held);
}

void Browser::Wheel(PagePoint at, double pixels) {
  Mouse("mouseWheel", at, {{"deltaX", 0.0}, {"deltaY", pixels}});
}

void Browser::Press(const std::string& key, bool shift) {
  Json event = {{"key", key}, {"modifiers", shift ? 8 : 0}};
  if (key.size() == 1) event["text"] = key;
  for (const char* type : {"keyDown", "keyUp"}) {
    event["type"] = type;
    Call("Input.dispatchKeyEvent", event);
  }
}

void Browser::TouchAt(const std::string& type,
                      const std::vector<PagePoint>& points) {
  Json touches = Json::array();
  for (size_t finger = 0; finger < points.size(); ++finger) {
    touches.push_back(
        {{"x", points[finger].x}, {"y", points[finger].y}, {"id", finger}});
  }
  Call("Input.dispatchTouchEvent", {{"type", type}, {"touchPoints", touches}});
}

void Browser::Drag(const std::vector<PagePoint>& from,
                   const std::vector<PagePoint>& to) {
  constexpr int kSteps = 8;
  TouchAt("touchStart", from);
  for (int step = 1; step <= kSteps; ++step) {
    const double share = static_cast<double>(step) / kSteps;
    std::vector<PagePoint> at = from;
    for (size_t finger = 0; finger < from.size(); ++finger) {
      at[finger].x += share * (to[finger].x - from[finger].x);
      at[finger].y += share * (to[finger].y - from[finger].y);
    }
    if (at[0].x != from[0].x || at[0].y != from[0].y) TouchAt("touchMove", at);
  }
  TouchAt("touchEnd", {});
}

void Browser::Tap(PagePoint at) {
  Evaluate(
      "window.tapped = false; addEventListener('click',"
      "() => { window.tapped = true; }, {capture: true, once: true})");
  // A touch of half a second is not a tap, and on a busy machine the delivery
  // of its end may take longer. A tap directly after a drag may also be
  // ignored; like a user, this taps again.
  for (int attempt = 0; attempt < 5; ++attempt) {
    Send("Input.dispatchTouchEvent",
         {{"type", "touchStart"},
          {"touchPoints", Json::array({{{"x", at.x}, {"y", at.y}}})}});
    TouchAt("touchEnd", {});
    if (WaitFor("window.tapped", 3.0)) return;
  }
  Fail("five taps caused no click");
}

void Browser::SaveScreenshot(const std::string& path) {
  const std::string data =
      Call("Page.captureScreenshot", {{"format", "png"}})["data"];
  std::ofstream file(path, std::ios::binary);
  file << FromBase64(data);
  if (!file) Fail("cannot write " + path);
}

}  // namespace kinegraph::testing
