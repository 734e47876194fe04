#include "core/io/configuration/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::StartsWith;

enum class Mode { kPaper, kGraph };

// One key of each kind, at the top and in a table.
struct SampleOptions {
  Mode mode = Mode::kPaper;
  double alpha_2d = 60.0;
  int64_t epsilon = 10;
  bool backfill = false;
  std::string title = "none";
  std::vector<std::string> use;
  std::vector<double> gates = {1.0, 2.0};
  std::map<std::string, std::string> map;
  std::array<double, 3> sigma_px = {6.0, 6.0, 6.0};

  void Describe(OptionVisitor& visitor) {
    visitor.Choice("mode", &mode, {"paper", "graph"}, "Pair of estimators.");
    visitor.Text("title", &title, "A title.");
    visitor.Enter("association");
    visitor.Number("alpha_2d", &alpha_2d, Positive(), "px per frame",
                   "Scale of the distance.");
    visitor.Integer("epsilon", &epsilon, Between(1, 17), "joints",
                    "Least joints.");
    visitor.Boolean("backfill", &backfill, "Go back | forth.");
    visitor.NumberList("gates", &gates, NonNegative(), "m", "Gates.");
    visitor.Leave();
    visitor.Enter("cameras");
    visitor.TextList("use", &use, "Cameras.");
    visitor.TextMap("map", &map, "Camera of a view.");
    visitor.Leave();
    visitor.NumberTable("sigma_px", sigma_px.data(), {"head", "wrist", "foot"},
                        Positive(), "px", "Of a joint.");
  }
};

// A further key in a table of SampleOptions.
struct MoreOptions {
  int64_t window = 10;
  void Describe(OptionVisitor& visitor) {
    visitor.Enter("association");
    visitor.Integer("window", &window, Positive(), "frames", "Length.");
    visitor.Leave();
  }
};

SampleOptions Applied(const std::string& text, const std::string& set = "") {
  ConfigFile config = ConfigFile::Parse(text, "sample.toml");
  config.Override(set, "--set");
  SampleOptions options;
  config.Apply(&options);
  config.RejectUnknown();
  return options;
}

std::string ErrorOf(const std::string& text, const std::string& set = "") {
  return InputErrorOf([&] { Applied(text, set); });
}

TEST(Config, UnsetKeysKeepDefaults) {
  const SampleOptions options = Applied("");
  EXPECT_EQ(options.alpha_2d, 60.0);
  EXPECT_EQ(options.title, "none");
  EXPECT_THAT(options.gates, ElementsAre(1.0, 2.0));
}

TEST(Config, ReadsEveryKind) {
  const SampleOptions options = Applied(R"(
mode = "graph"
title = "Shelf"
[association]
alpha_2d = 70       # an integer is accepted as a number
epsilon = 9
backfill = true
gates = [0, 0.5]
[cameras]
use = ["0", "1"]
map = { cam0 = "Camera0", "cam.1" = "Camera1" }
)");
  EXPECT_EQ(options.mode, Mode::kGraph);
  EXPECT_EQ(options.title, "Shelf");
  EXPECT_EQ(options.alpha_2d, 70.0);
  EXPECT_EQ(options.epsilon, 9);
  EXPECT_TRUE(options.backfill);
  EXPECT_THAT(options.gates, ElementsAre(0.0, 0.5));
  EXPECT_THAT(options.use, ElementsAre("0", "1"));
  EXPECT_EQ(options.map.at("cam0"), "Camera0");
  EXPECT_EQ(options.map.at("cam.1"), "Camera1");
}

TEST(Config, NumberTableMayBeOneNumberOrATable) {
  EXPECT_THAT(Applied("sigma_px = 8").sigma_px, ElementsAre(8.0, 8.0, 8.0));
  EXPECT_THAT(Applied("[sigma_px]\nwrist = 9").sigma_px,
              ElementsAre(6.0, 9.0, 6.0));
  EXPECT_THAT(Applied("[sigma_px]\nwrist = 9", "sigma_px=7").sigma_px,
              ElementsAre(7.0, 7.0, 7.0));
  EXPECT_THAT(
      Applied("sigma_px = 8", "sigma_px.wrist=9;sigma_px.foot=5").sigma_px,
      ElementsAre(8.0, 9.0, 5.0));
  EXPECT_THAT(ErrorOf("sigma_px = 0"), HasSubstr("'sigma_px': found 0, "));
  EXPECT_THAT(ErrorOf("sigma_px = \"a\""), HasSubstr("expected a number"));
  EXPECT_THAT(ErrorOf("[sigma_px]\nwrist = -1"),
              HasSubstr("sample.toml:2: key 'sigma_px.wrist': found -1"));
  EXPECT_THAT(ErrorOf("[sigma_px]\nwrits = 1"),
              HasSubstr("did you mean 'sigma_px.wrist'?"));
  EXPECT_THAT(ErrorOf("", "sigma_px.hand=1"), HasSubstr("is not known"));
}

TEST(Config, ErrorForARemovedKeyNamesTheReplacement) {
  EXPECT_THAT(
      ErrorOf("[tracking]\nmax_age = 10"),
      HasSubstr("sample.toml:2: key 'tracking.max_age': was removed: use "
                "tracking.max_age_s"));
  // If a table was removed, each of its keys is reported as removed.
  EXPECT_THAT(ErrorOf("", "filters.kalman.jerk_noise.head=50"),
              HasSubstr("was removed: use filters.kalman.process_noise_scale"));
}

TEST(Config, ErrorsNameFileLineKeyValueAndLimits) {
  EXPECT_EQ(ErrorOf("[association]\nalpha_2d = -3.5\n"),
            "sample.toml:2: key 'association.alpha_2d': found -3.5, allowed "
            "> 0 (px per frame)");
  EXPECT_EQ(ErrorOf("[association]\n\nalpha_2d = 'x'\n"),
            "sample.toml:3: key 'association.alpha_2d': found 'x', expected a "
            "number, allowed > 0 (px per frame)");
  EXPECT_EQ(ErrorOf("mode = 'grph'"),
            "sample.toml:1: key 'mode': found 'grph', allowed 'paper', "
            "'graph'");
  EXPECT_EQ(ErrorOf("", "association.epsilon=18"),
            "--set: key 'association.epsilon': found '18', allowed 1 .. 17 "
            "(joints)");
}

TEST(Config, RefusesWrongTypesAndValuesOutOfRange) {
  for (const char* text : {"association.alpha_2d = true",
                           "association.alpha_2d = [1]",
                           "association.alpha_2d = 1979-05-27",
                           "association.epsilon = 9.0",
                           "association.epsilon = '9'",
                           "association.backfill = 1",
                           "association.backfill = 'true'",
                           "title = 3",
                           "mode = 1",
                           "association.gates = 1",
                           "association.gates = ['a']",
                           "association.gates = [[1]]",
                           "cameras.use = 'a'",
                           "cameras.use = [1]",
                           "cameras.map = 'a'",
                           "cameras.map.a = true",
                           "cameras.map.a.b = 'c'",
                           "association = 3",
                           "cameras = []",
                           "[[association]]\nepsilon = 3",
                           "association.alpha_2d = nan",
                           "association.alpha_2d = inf",
                           "association.alpha_2d = 0",
                           "association.alpha_2d = 0.0",
                           "association.epsilon = 0",
                           "association.gates = [1, -1]",
                           "association.gates = [nan]",
                           "association.gates = [inf]",
                           "association.epsilon = 99999999999999999999"}) {
    EXPECT_THAT(ErrorOf(text), StartsWith("sample.toml:1: ")) << text;
  }
  EXPECT_THAT(ErrorOf("association.gates = [1, -1]"),
              HasSubstr("key 'association.gates[1]': found -1"));
}

TEST(Config, SuggestsTheNearestKey) {
  EXPECT_EQ(ErrorOf("[association]\nalpha_2D = 3\n"),
            "sample.toml:2: key 'association.alpha_2D': is not known; did you "
            "mean 'association.alpha_2d'?");
  EXPECT_THAT(ErrorOf("[asociation]\nepsilon = 3\n"),
              HasSubstr("did you mean 'association.epsilon'?"));
  EXPECT_THAT(ErrorOf("epsilon = 3\n"),
              HasSubstr("did you mean 'association.epsilon'?"));
  EXPECT_THAT(ErrorOf("something_entirely_different = 3\n"),
              ::testing::EndsWith("is not known"));
  EXPECT_THAT(ErrorOf("[nothing]\n"), HasSubstr("key 'nothing'"));
  EXPECT_THAT(ErrorOf("[[tables]]\na = 1\n"), HasSubstr("key 'tables'"));
  EXPECT_THAT(ErrorOf("b = 1\na = 1\n"), StartsWith("sample.toml:1: key 'b'"));
  EXPECT_THAT(ErrorOf("", "titel=x"), HasSubstr("did you mean 'title'?"));
}

TEST(Config, DottedKeysInQuotesAreRefused) {
  EXPECT_EQ(ErrorOf("title = \"a\"\n\"association.alpha_2d\" = 70\n"),
            "sample.toml:2: key 'association.alpha_2d': is in quotes, expected "
            "it without");
  EXPECT_THAT(ErrorOf("[\"cameras.map\"]\na = \"b\"\n"),
              HasSubstr("key 'cameras.map': is in quotes"));
  EXPECT_EQ(Applied("[cameras.map]\n\"cam.1\" = \"x\"\n").map.at("cam.1"), "x");
}

TEST(Config, AcceptsEmptyKnownTables) {
  EXPECT_EQ(Applied("[association]\n[cameras]\n[cameras.map]\n").epsilon, 10);
}

TEST(Config, RefusesInvalidToml) {
  for (const std::string& text :
       {std::string("mode = \"paper\"\nmode = \"graph\"\n"),
        std::string("[a]\n[a]\n"), std::string("mode = \n"),
        std::string("mode \"paper\""), std::string("\xff\xfe"),
        std::string("a = 1\0b", 7), "a = " + std::string(1000000, '['),
        std::string("a = 1__0"), std::string("a = \"x\ny\"")}) {
    EXPECT_THAT(ErrorOf(text), StartsWith("sample.toml:"));
  }
  EXPECT_THAT(ErrorOf("title = 'a'\ntitle = 'b'\n"),
              StartsWith("sample.toml:2: is not TOML: "));
}

TEST(Config, ErrorsNameUnreadableFiles) {
  const testing::TemporaryFolder folder;
  const std::string missing = (folder.path() / "none.toml").string();
  EXPECT_THAT(InputErrorOf([&] { ConfigFile::Read(missing); }),
              StartsWith(missing + ": cannot be read"));
  EXPECT_THAT(InputErrorOf([&] { ConfigFile::Read(folder.path().string()); }),
              HasSubstr("is a folder"));
  ConfigFile config = ConfigFile::Read(folder.Write("a.toml", "title = 'x'"));
  SampleOptions options;
  config.Apply(&options);
  EXPECT_EQ(options.title, "x");
}

TEST(Config, OverridesHavePrecedenceOverTheFile) {
  const SampleOptions options = Applied(
      "mode = 'paper'\n[association]\nalpha_2d = 70\n",
      "mode=graph; association.alpha_2d = 1e2 ;association.epsilon=9;"
      "association.backfill=true;title=\"a = b\";cameras.map.cam0=Camera0;");
  EXPECT_EQ(options.mode, Mode::kGraph);
  EXPECT_EQ(options.alpha_2d, 100.0);
  EXPECT_EQ(options.epsilon, 9);
  EXPECT_TRUE(options.backfill);
  EXPECT_EQ(options.title, "a = b");
  EXPECT_EQ(options.map.at("cam0"), "Camera0");
  // A text may look like a number.
  EXPECT_EQ(Applied("", "title=12").title, "12");
}

TEST(Config, LaterOverridesHavePrecedence) {
  ConfigFile config = ConfigFile::Empty();
  config.Override("title=first", "--set");
  config.Override("title=second", "--mode");
  SampleOptions options;
  config.Apply(&options);
  EXPECT_EQ(options.title, "second");
}

TEST(Config, RefusesBadOverrides) {
  for (const char* set : {"title",
                          "=3",
                          "title=a;title=b",
                          "association.alpha_2d=fast",
                          "association.alpha_2d=",
                          "association.alpha_2d=nan",
                          "association.alpha_2d=1e400",
                          "association.alpha_2d=3 px",
                          "association.epsilon=3.0",
                          "association.backfill=yes",
                          "mode=",
                          "association.gates=1",
                          "association.gates=[1",
                          "association.gates=[1, x]",
                          "association.gates=[1,]",
                          "association.gates=[-1]",
                          "cameras.use=a",
                          "cameras.map=a",
                          "association=3",
                          "association.alpha_2d.x=3",
                          "none=3"}) {
    EXPECT_THAT(ErrorOf("", set), StartsWith("--set: ")) << set;
  }
}

TEST(Config, OverrideMaySpecifyAList) {
  EXPECT_TRUE(Applied("", "association.gates=[]").gates.empty());
  EXPECT_THAT(Applied("", "association.gates=[1.5, 3, 0]").gates,
              ElementsAre(1.5, 3.0, 0.0));
  EXPECT_THAT(Applied("", "cameras.use=[left, \"right\"]").use,
              ElementsAre("left", "right"));
}

TEST(Config, SeveralStructsShareAFile) {
  ConfigFile config =
      ConfigFile::Parse("[association]\nwindow = 3\nepsilon = 4\n", "a.toml");
  MoreOptions more;
  config.Apply(&more);
  EXPECT_THAT(InputErrorOf([&] { config.RejectUnknown(); }),
              HasSubstr("association.epsilon"));
  SampleOptions sample;
  config.Apply(&sample);
  config.RejectUnknown();
  EXPECT_EQ(more.window, 3);
  EXPECT_EQ(sample.epsilon, 4);
}

TEST(Config, ReportsWhichKeysAreSetAndWhere) {
  ConfigFile config = ConfigFile::Parse("[a]\nb = 1\n", "a.toml");
  config.Override("c=2", "--set");
  EXPECT_TRUE(config.Has("a"));
  EXPECT_TRUE(config.Has("a.b"));
  EXPECT_TRUE(config.Has("c"));
  EXPECT_FALSE(config.Has("a.c"));
  EXPECT_FALSE(config.Has("a.b.c"));
  EXPECT_STREQ(config.Locate(OptionError("a.b", "is bad")).what(),
               "a.toml:2: key 'a.b': is bad");
  EXPECT_STREQ(config.Locate(OptionError("c", "is bad")).what(),
               "--set: key 'c': is bad");
  EXPECT_STREQ(config.Locate(OptionError("d", "is bad")).what(),
               "a.toml: key 'd': is bad");
}

// ---- Skeletons ----

constexpr const char* kSkeletons = R"([skeletons.stick]
joints = ["l_hip", "r_hip", "hat"]
bones = [["l_hip", "r_hip"], ["hat", "l_hip"]]
[skeletons.dots]
joints = ["a"]
)";

TEST(Skeletons, AreReadFromTables) {
  ConfigFile config = ConfigFile::Parse(kSkeletons, "a.toml");
  const std::vector<Skeleton> skeletons = config.ReadSkeletons();
  config.RejectUnknown();
  ASSERT_EQ(skeletons.size(), 2u);
  const Skeleton stick = ResolveSkeleton("stick", skeletons);
  EXPECT_THAT(stick.joints(), ElementsAre("l_hip", "r_hip", "hat"));
  ASSERT_EQ(stick.bones().size(), 2u);
  EXPECT_EQ(stick.bones()[1].a, 2);
  EXPECT_EQ(stick.bones()[1].b, 0);
  EXPECT_EQ(stick.mirror(0), 1);
  EXPECT_EQ(ResolveSkeleton("coco17", skeletons).joint_count(), 17);
  EXPECT_TRUE(ConfigFile::Empty().ReadSkeletons().empty());
}

TEST(Skeletons, ErrorForAnUnknownNameListsKnownNames) {
  ConfigFile config = ConfigFile::Parse(kSkeletons, "a.toml");
  const std::vector<Skeleton> skeletons = config.ReadSkeletons();
  const std::string message =
      InputErrorOf([&] { ResolveSkeleton("coco", skeletons); });
  EXPECT_THAT(message, HasSubstr("'coco'"));
  EXPECT_THAT(message, HasSubstr("coco17"));
  EXPECT_THAT(message, HasSubstr("stick"));
}

TEST(Skeletons, InvalidTablesAreRefused) {
  for (const char* text :
       {"skeletons = 3", "[skeletons]\na = 3", "[skeletons.a]",
        "[skeletons.a]\njoints = []", "[skeletons.a]\njoints = 'x'",
        "[skeletons.a]\njoints = [1]", "[skeletons.a]\njoints = ['x', 'x']",
        "[skeletons.a]\njoints = ['']",
        "[skeletons.a]\njoints = ['x']\nbones = [['x', 'y']]",
        "[skeletons.a]\njoints = ['x', 'y']\nbones = [['x']]",
        "[skeletons.a]\njoints = ['x', 'y']\nbones = ['x', 'y']",
        "[skeletons.a]\njoints = ['x', 'y']\nbones = [[0, 1]]",
        "[skeletons.a]\njoints = ['x']\ncolour = 'red'",
        "[skeletons.coco17]\njoints = ['x']"}) {
    const std::string message = InputErrorOf([&] {
      ConfigFile config = ConfigFile::Parse(text, "a.toml");
      config.ReadSkeletons();
    });
    EXPECT_THAT(message, StartsWith("a.toml:")) << text;
    EXPECT_THAT(message, HasSubstr("skeletons")) << text;
  }
}

// ---- Writers ----

TEST(ConfigJson, NestsTablesInOrder) {
  SampleOptions options;
  options.map["v"] = "c";
  EXPECT_EQ(EffectiveConfigJson(options),
            "{\"mode\":\"paper\",\"title\":\"none\",\"association\":{"
            "\"alpha_2d\":60.0,\"epsilon\":10,\"backfill\":false,"
            "\"gates\":[1.0,2.0]},\"cameras\":{\"use\":[],\"map\":{\"v\":\"c\"}"
            "},\"sigma_px\":6.0}");
  options.sigma_px[1] = 9.0;
  EXPECT_THAT(EffectiveConfigJson(options),
              HasSubstr("\"sigma_px\":{\"head\":6.0,\"wrist\":9.0,"
                        "\"foot\":6.0}"));
}

TEST(ConfigJson, NumbersAreReadBackExactly) {
  Random random(11);
  for (int i = 0; i < 1000; ++i) {
    SampleOptions options;
    options.alpha_2d = std::exp(random.Uniform(-700.0, 700.0));
    options.epsilon = random.Index(std::numeric_limits<int64_t>::max());
    const auto json = nlohmann::json::parse(EffectiveConfigJson(options));
    EXPECT_EQ(json["association"]["alpha_2d"].get<double>(), options.alpha_2d);
    EXPECT_EQ(json["association"]["epsilon"].get<int64_t>(), options.epsilon);
  }
}

TEST(ConfigJson, MergesStructsOfOneTable) {
  const auto json = nlohmann::json::parse(
      EffectiveConfigJson(SampleOptions(), MoreOptions()));
  EXPECT_EQ(json["association"]["epsilon"], 10);
  EXPECT_EQ(json["association"]["window"], 10);
}

TEST(KeyTable, ListsEveryKey) {
  const std::string table = KeyTable(KeysOf<SampleOptions>());
  EXPECT_THAT(table, StartsWith("| key | default | unit | allowed | meaning |\n"
                                "|---|---|---|---|---|\n"));
  EXPECT_THAT(table, HasSubstr("| `mode` | `\"paper\"` |  | \"paper\", "
                               "\"graph\" | Pair of estimators. |\n"));
  EXPECT_THAT(table, HasSubstr("| `association.alpha_2d` | `60` | px per frame "
                               "| > 0 | Scale of the distance. |\n"));
  EXPECT_THAT(table, HasSubstr("| `association.epsilon` | `10` | joints | 1 .. "
                               "17, whole | Least joints. |\n"));
  EXPECT_THAT(table, HasSubstr("Go back \\| forth."));
  EXPECT_THAT(table, HasSubstr("| `association.gates` | `[1, 2]` | m |"));
  EXPECT_THAT(table, HasSubstr("| `cameras.map` | `{}` |"));
  EXPECT_THAT(table, HasSubstr("| `sigma_px` | `6` | px | > 0, for all or by "
                               "head, wrist, foot | Of a joint. |\n"));
  SampleOptions options;
  options.sigma_px[1] = 9.0;
  EXPECT_THAT(KeyTable(KeysOf(options)),
              HasSubstr("`{ head = 6, wrist = 9, foot = 6 }`"));
}

}  // namespace
}  // namespace kinegraph
