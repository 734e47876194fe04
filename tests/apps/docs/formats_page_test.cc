// docs/formats.md: the files written for scripts, and the keys that the page of
// `report` reads. Other examples are read in tests/core/io.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "apps/common/recording_output.h"
#include "apps/report/page_data.h"
#include "core/io/files/text_file.h"
#include "tests/support/page_example.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Json = nlohmann::json;
using testing::PageExample;

constexpr const char* kPage = "docs/formats.md";

void CollectKeys(const Json& json, std::set<std::string>* keys) {
  for (const auto& [key, value] : json.items()) {
    if (json.is_object()) keys->insert(key);
    if (value.is_structured()) CollectKeys(value, keys);
  }
}

std::set<std::string> KeysOf(const std::string& text) {
  std::set<std::string> keys;
  CollectKeys(Json::parse(text), &keys);
  return keys;
}

// A summary with all optional parts.
std::set<std::string> KeysThatAreWritten() {
  RecordingReport report;
  report.cameras.emplace_back();
  report.people.emplace_back();
  report.warnings.emplace_back();
  RunSummary run;
  run.solves.solves = 1;
  LearntNoise learnt;
  learnt.classes[0].joints_seen = 1;
  std::set<std::string> keys = KeysOf(ReportJson(report, run, learnt));
  keys.erase(ToString(static_cast<JointClass>(0)));
  return keys;
}

TEST(FormatsPage, PageListsTheKeysOfTheSummary) {
  const std::string page = ReadTextFile(testing::ProjectFile(kPage).string());
  const size_t begin = page.find("\n## Summary");
  ASSERT_NE(begin, std::string::npos);
  const std::string section =
      page.substr(begin, page.find("```json", begin) - begin);
  const std::set<std::string> written = KeysThatAreWritten();
  for (const std::string& key : written) {
    EXPECT_NE(section.find("`" + key + "`"), std::string::npos) << key;
  }
  for (const std::string& key :
       KeysOf(PageExample(kPage, "take.summary.json"))) {
    EXPECT_EQ(written.count(key), 1u) << key << " is not written";
  }
}

TEST(FormatsPage, ReportReadsTheExamplesOfThePage) {
  PageInput input;
  input.results.emplace_back();
  input.results[0].label = "take";
  input.results[0].tracks.header.skeleton = Skeleton("one", {"nose"}, {});
  input.results[0].tracks.frames.emplace_back();
  input.results[0].summary_json = PageExample(kPage, "take.summary.json");
  input.doctor_json = PageExample(kPage, "doctor.json");
  const Json page = Json::parse(MakePageData(input).json);
  EXPECT_EQ(page["results"][0]["summary"],
            Json::parse(input.results[0].summary_json));
  EXPECT_EQ(page["doctor"], Json::parse(input.doctor_json));
}

}  // namespace
}  // namespace kinegraph
