#include "tests/support/browser.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "tests/support/base64.h"

extern char** environ;

namespace kinegraph::testing {
namespace {

constexpr int kAnswerTimeoutMs = 60000;
// Where Chromium expects the ends of its pipes.
constexpr int kChildReads = 3;
constexpr int kChildWrites = 4;

[[noreturn]] void Fail(const std::string& what) {
  throw std::runtime_error("browser: " + what);
}

// Both ends far above the numbers that the child uses, closed on exec.
struct Pipe {
  Pipe() {
    int ends[2];
    if (pipe(ends) != 0) Fail("cannot make a pipe");
    reads = fcntl(ends[0], F_DUPFD_CLOEXEC, 10);
    writes = fcntl(ends[1], F_DUPFD_CLOEXEC, 10);
    close(ends[0]);
    close(ends[1]);
  }
  int reads = -1;
  int writes = -1;
};

}  // namespace

bool Browser::IsInstalled() {
  return std::system("command -v chromium > /dev/null 2>&1") == 0;
}

Browser::Browser(const Screen& screen) {
  signal(SIGPIPE, SIG_IGN);  // a browser that died is an error of write()
  const Pipe down;
  const Pipe up;
  std::vector<std::string> arguments = {
      "chromium",
      "--headless",
      "--no-sandbox",
      "--disable-gpu",
      "--disable-dev-shm-usage",  // containers have little of it
      "--enable-unsafe-swiftshader",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      "--disable-quic",
      "--remote-debugging-pipe",
      "--user-data-dir=" + profile_.path().string(),
      "about:blank"};
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, down.reads, kChildReads);
  posix_spawn_file_actions_adddup2(&actions, up.writes, kChildWrites);
  for (const int quiet : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, quiet, "/dev/null", O_WRONLY, 0);
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  const int error = posix_spawnp(&process_, "chromium", &actions, &attributes,
                                 argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  close(down.reads);
  close(up.writes);
  to_browser_ = down.writes;
  from_browser_ = up.reads;
  if (error != 0) Fail("cannot start chromium");

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
    // It is ended below.
  }
  close(to_browser_);
  close(from_browser_);
  if (process_ <= 0) return;
  for (int tenths = 0; tenths < 50; ++tenths) {
    if (waitpid(process_, nullptr, WNOHANG) == process_) {
      process_ = -1;
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  kill(-process_, SIGKILL);
  waitpid(process_, nullptr, 0);
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
    if (count <= 0) Fail("it ended");
    received_.append(buffer, static_cast<size_t>(count));
  }
}

int Browser::Send(const std::string& method, const Json& parameters) {
  const int id = ++last_id_;
  Json message = {{"id", id}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump();
  // The closing zero is part of the message.
  for (size_t done = 0; done <= text.size();) {
    const ssize_t count =
        write(to_browser_, text.c_str() + done, text.size() + 1 - done);
    if (count <= 0) Fail("it does not listen");
    done += static_cast<size_t>(count);
  }
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
  Fail("no click came of five taps");
}

void Browser::SaveScreenshot(const std::string& path) {
  const std::string data =
      Call("Page.captureScreenshot", {{"format", "png"}})["data"];
  std::ofstream file(path, std::ios::binary);
  file << FromBase64(data);
  if (!file) Fail("cannot write " + path);
}

}  // namespace kinegraph::testing
