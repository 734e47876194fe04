// Takes a screenshot of a page written by `report`, for the documentation:
//
//   build/research/page_picture PAGE.html OUT.png WIDTHxHEIGHT[@RATIO][phone]
//     [JAVASCRIPT]
//
// JAVASCRIPT sets the page's state, for example kinegraph.setFrame(30). If it
// contains "dark", the page is shown in its dark colours. "phone" makes the
// viewport that of a phone.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

#include "tests/support/browser.h"

int main(int argc, char** argv) {
  using kinegraph::testing::Browser;
  kinegraph::testing::Screen screen;
  if (argc < 4 || std::sscanf(argv[3], "%dx%d@%lf", &screen.width,
                              &screen.height, &screen.pixel_ratio) < 2) {
    std::fprintf(stderr,
                 "expected PAGE.html OUT.png WIDTHxHEIGHT[@RATIO][phone] "
                 "[JAVASCRIPT]\n");
    return 2;
  }
  screen.is_phone = std::string(argv[3]).find("phone") != std::string::npos;
  try {
    Browser browser(screen);
    browser.PreferDark(argc > 4 &&
                       std::string(argv[4]).find("dark") != std::string::npos);
    browser.Open(std::filesystem::absolute(argv[1]).string());
    browser.WaitFor("window.kinegraph && kinegraph.state.pictures > 0");
    if (argc > 4) browser.Evaluate(argv[4]);
    // Waits for further renderings, which show the change.
    browser.Evaluate(
        "(() => { window.enough = kinegraph.state.pictures + 3; })()");
    browser.WaitFor("kinegraph.state.pictures > enough");
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    browser.SaveScreenshot(argv[2]);
    for (const std::string& problem : browser.problems()) {
      std::fprintf(stderr, "%s\n", problem.c_str());
    }
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
