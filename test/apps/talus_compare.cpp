// The command talus-compare from end to end: its files, messages and exit codes.
#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>

#include "compared_worlds.h"

namespace
{
using TalusCompare = ComparedWorlds;

TEST_F(TalusCompare, ScoresAWorldIntoTablesJsonAndPictures)
{
  const Outcome o = runs("small.yaml --output out");
  EXPECT_SAYS(o.text, "octomap");
  EXPECT_SAYS(o.text, "measured_ground_flat_rmse_m");

  const auto json = comparison();
  const auto& world = json["worlds"][0];
  EXPECT_EQ(world["name"], "small");
  EXPECT_EQ(world["frames"], 11);
  EXPECT_LT(world["methods"]["talus"]["measured_ground_flat_rmse_m"], 0.005);
  EXPECT_EQ(world["methods"].size(), 7);
  EXPECT_EQ(world["fills"].size(), 5);
  EXPECT_FALSE(world["budgets"].empty());

  EXPECT_FALSE(cv::imread(path("out/maps.png")).empty());

  EXPECT_EQ(world["sensor"], "RS-LiDAR-16");
  const auto& heights = world["heights"]["measured"];
  EXPECT_GT(heights["all"]["within_2"], 0.85);
  EXPECT_EQ(heights["near"]["n"].get<int>() + heights["far"]["n"].get<int>(), heights["all"]["n"]);
  EXPECT_SAYS(text("out/tables.md"), "## heights within one and two estimated");
  ASSERT_EQ(world["risk"].size(), 10U);
  EXPECT_LT(world["risk"][0]["impassable"], 0.1 * world["risk"][0]["n"].get<double>());
}

TEST_F(TalusCompare, SaysOfSeveralWorldsHowManyFailAndWhichIsTheWorst)
{
  write_world_with_wall("wall");
  const Outcome o = runs("small.yaml wall.yaml --methods talus --output out");
  int judged = 0, fail = 0, not_seen = 0;
  double worst = 2;
  const auto json = comparison();
  for (const auto& world : json["worlds"])
  {
    std::map<std::string, nlohmann::json> budgets;
    for (const auto& b : world["budgets"]) budgets[b["name"]] = b;
    const bool fails = budgets["reach"]["verdict"] == "fail";
    judged += budgets["reach"]["verdict"] != "not applicable";
    fail += fails;
    not_seen += fails && budgets["reach_seen"]["verdict"] != "fail";
    worst = std::min(worst, budgets["reach"]["value"].get<double>());
  }
  ASSERT_GT(fail, 0);  // the floor behind the box is not seen
  const std::size_t row = o.text.find("\n  reach ");  // the overview comes first
  ASSERT_NE(row, std::string::npos) << o.text;
  std::istringstream words(o.text.substr(row));
  std::string name, sign;
  double limit = 0, median = 0, worst_shown = 0;
  int counts[3] = {};
  words >> name >> sign >> limit >> counts[0] >> counts[1] >> counts[2] >> median >> worst_shown;
  EXPECT_EQ(counts[0], judged);
  EXPECT_EQ(counts[1], fail);
  EXPECT_EQ(counts[2], not_seen);
  EXPECT_NEAR(worst_shown, worst, 0.0006);
}

TEST_F(TalusCompare, ShowsInEachColumnOfTheFillsWhatItsHeadingSays)
{
  std::ofstream(path("rough.yaml"))
      << "ground: [roughness: {amplitude_m: 0.05, wavelength_m: 0.6, seed: 1}]\n"
         "objects: [box: {at_m: [3, 1], size_m: [0.5, 0.5, 0.5]}]\n"
         "robot: {path_m: [[0, 0], [1, 0]]}\n";
  runs("rough.yaml --methods talus --output out");
  const std::string page = text("out/tables.md");
  const auto cells_of = [&](std::size_t from)
  {
    std::istringstream line(page.substr(from, page.find('\n', from) - from));
    std::vector<std::string> cells;
    for (std::string cell; std::getline(line, cell, '|');) cells.push_back(cell);
    return cells;
  };
  const std::size_t table = page.find("| fill |");
  ASSERT_NE(table, std::string::npos) << page;
  const auto headings = cells_of(table), shown = cells_of(page.find("\n| bgk |", table) + 1);
  ASSERT_EQ(headings.size(), shown.size());
  const auto bgk = comparison()["worlds"][0]["fills"]["bgk"];
  std::set<double> different;
  for (const char* name : {"seen", "two_sided", "one_sided"})
  {
    std::string heading = std::string(" ") + name + " RMSE ";
    std::replace(heading.begin(), heading.end(), '_', '-');
    const auto column = std::find(headings.begin(), headings.end(), heading) - headings.begin();
    ASSERT_LT(column, static_cast<std::ptrdiff_t>(headings.size())) << heading;
    const double mm = 1000 * bgk[std::string(name) + "_rmse_m"].get<double>();
    EXPECT_NEAR(std::stod(shown[static_cast<std::size_t>(column)]), mm, 0.051) << heading;
    different.insert(std::round(10 * mm));
  }
  EXPECT_EQ(different.size(), 3U) << "of equal figures nobody can tell which is which";
}

TEST_F(TalusCompare, GivesTheSameFiguresForTheLogOfAWorldAsForTheWorld)
{
  write_small_log();
  const std::string methods = " --methods talus --output ";
  runs("small.yaml" + methods + "a");
  const Outcome b = runs("log/small.rawlog --world small.yaml" + methods + "b");
  const auto figure = [&](const std::string& folder, const std::string& name) {
    return json(folder + "/comparison.json")["worlds"][0]["methods"]["talus"][name].get<double>();
  };
  for (const char* name : {"measured_ground_rmse_m", "coverage_measured", "reach"})
    EXPECT_NEAR(figure("a", name), figure("b", name), 1e-4) << name;  // poses rounded in the log
}

TEST_F(TalusCompare, LeavesOutAScanWhosePoseIsNowhere)
{
  write_small_log();
  const auto with_x = [&](const std::string& x)
  {
    std::istringstream lines(text("log/small.tum"));
    std::string line, text, stamp, old;
    for (int i = 0; std::getline(lines, line); ++i)
    {
      std::istringstream words(line);
      words >> stamp >> old;
      text += i == 2 ? stamp + " " + x + line.substr(stamp.size() + 1 + old.size()) : line;
      text += "\n";
    }
    std::ofstream(path("bad.tum")) << text;
    return run(
        "log/small.rawlog --trajectory bad.tum "
        "--quiet --evaluate 1 --set resolution_m=0.1 --output out");
  };
  const Outcome nowhere = with_x("1e300");
  EXPECT_EQ(nowhere.code, 0) << nowhere.text;
  EXPECT_SAYS(nowhere.text, "small.rawlog: 1 scan was skipped");
  const Outcome far_off = with_x("900000");  // a grid over the whole way would take 1 TB
  EXPECT_EQ(far_off.code, 0) << far_off.text;
  EXPECT_EQ(far_off.text, "");
}

TEST_F(TalusCompare, HoldsPointsOutOfALogWithoutTruthAndSaysOnlyWhatThereIs)
{
  write_small_log();
  const Outcome o = runs("log/small.rawlog --methods talus --output out");
  const auto json = comparison();
  EXPECT_GT(json["held_out"][0]["fills"]["bgk"]["all_n"], 100);
  EXPECT_LT(json["held_out"][0]["fills"]["talus"]["all_median_m"], 0.03);
  EXPECT_GT(json["held_out"][0]["heights"]["measured"]["all"]["n"], 100);
  EXPECT_SAYS(o.err, "talus-compare: small: 1 method");
  for (const char* absent : {"budget", "hang pass", "precision", "mover"})
  {
    EXPECT_SAYS_NOT(o.text, absent);
    EXPECT_SAYS_NOT(text("out/tables.md"), absent);
  }
  for (const char* there : {"known %", "unjudged"}) EXPECT_SAYS(o.text, there);
}

/** Labels of talus-map as those of people would be: its ground is a road, all else is something. */
class TalusCompareLabels : public TalusCompare
{
 protected:
  void SetUp() override
  {
    TalusCompare::SetUp();
    write_small_log();
    const Outcome map =
        shell(std::string(TALUS_MAP_EXE) + " " + log_ + " --no-site --output map --labels labels");
    ASSERT_EQ(map.code, 0) << map.text;
    for (int scan = 0; scan < 11; ++scan)
    {
      std::string bytes = text("labels/" + name_of(scan));
      ASSERT_GT(bytes.size(), 4000U);
      for (std::size_t i = 0; i < bytes.size(); i += 4) bytes[i] = bytes[i] == 1 ? 40 : 50;
      std::ofstream(path("labels/" + name_of(scan)), std::ios::binary) << bytes;
    }
  }
  static std::string name_of(int scan)
  {
    return std::string(scan < 10 ? "00000" : "0000") + std::to_string(scan) + ".label";
  }
  Outcome compare(const std::string& more) const
  {
    return run(log_ + " --evaluate 1 --methods talus --output out " + more);
  }

  const std::string log_ = "log/small.rawlog";
};

TEST_F(TalusCompareLabels, AreScoredByPointAndScan)
{
  const Outcome o = compare("--labels labels");
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_SAYS(o.text, "points labelled as ground");
  const auto labels = comparison()["labels"];
  ASSERT_EQ(labels.size(), 2U);
  EXPECT_EQ(labels[0]["f1"], 1) << "those of the same map";
  EXPECT_EQ(labels[0]["scans"], 11);
  EXPECT_EQ(labels[0]["alone"], false);
  EXPECT_GT(labels[1]["f1"], 0.98);
  EXPECT_LT(labels[1]["f1"], 1);
}

TEST_F(TalusCompareLabels, BelongToTheScansOfTheLogByTheirNumber)
{
  std::string tum = text("log/small.tum");
  const auto first = tum.find("\n1") + 1;  // a line for each pose, with its stamp
  tum.erase(0, tum.find('\n', first) + 1);
  std::ofstream(path("late.tum")) << tum;
  std::ofstream(path("labels/000000.label")) << "of the scan that has no pose now";
  const std::string more = "--trajectory late.tum --labels labels";
  const Outcome late = compare(more);
  ASSERT_EQ(late.code, 0) << late.text;
  const auto labels = comparison()["labels"];
  EXPECT_EQ(labels[0]["scans"], 10);
  EXPECT_GT(labels[0]["f1"], 0.98);
  fs::remove(path("labels/000010.label"));
  const Outcome all = compare(more);
  EXPECT_EQ(all.code, 1);
  EXPECT_SAYS(all.text, "labels/000010.label");
}

TEST_F(TalusCompareLabels, ThatCannotBeThoseOfTheLogAreRefused)
{
  const auto fails = [&](const std::string& because)
  {
    const Outcome o = compare("--labels labels");
    EXPECT_EQ(o.code, 1) << o.text;
    EXPECT_SAYS(o.text, because);
    EXPECT_FALSE(exists("out")) << because;
  };
  std::ofstream(path("labels/000003.label"), std::ios::app) << "more";
  fails("000003.label: has ");
  for (int scan = 0; scan < 11; ++scan)
  {
    std::string bytes = text("labels/" + name_of(scan));
    if (scan == 3) bytes.resize(bytes.size() - 4);
    std::replace(bytes.begin(), bytes.end(), static_cast<char>(40), static_cast<char>(1));
    std::ofstream(path("labels/" + name_of(scan)), std::ios::binary) << bytes;
  }
  fails("no point is labelled as ground");
  fs::remove_all(path("labels"));
  fails("is no folder");
}

TEST_F(TalusCompareLabels, AreForOneLogAndForTalus)
{
  for (const std::string& rest :
       {log_ + " --methods octomap", log_ + " --methods talus --world small.yaml",
        log_ + " " + log_ + " --methods talus", std::string("small.yaml --methods talus")})
  {
    fails(rest + " --labels labels --output out", 2, {"--labels"});
  }
}

TEST_F(TalusCompare, TakesSoManyFramesOfALogAsOfAWorld)
{
  write_small_log();
  const std::string rest = " --methods talus --evaluate 1 --frames 4 --output out";
  for (const char* input : {"small.yaml", "log/small.rawlog"})
  {
    runs(path(input) + rest);
    EXPECT_EQ(comparison()["worlds"][0]["frames"], 4) << input;
  }
}

TEST_F(TalusCompare, RefusesAnOptionThatWouldDoNothing)
{
  write_small_log();
  const std::string world = "small.yaml", log = "log/small.rawlog";
  const auto refused = [&](const std::string& inputs, const std::string& option)
  {
    fails(inputs + " " + option + " --output out", 2, {option.substr(0, option.find(' '))});
    EXPECT_FALSE(exists("out")) << option;
  };
  for (const char* option :
       {"--scanner VLP-16", "--seed 3", "--noise 0.1", "--pose-noise 0.1", "--z-drift 0.1"})
    refused(log, option);
  refused(world + " " + log, "--seed 3");
  for (const char* option :
       {"--world w.yaml", "--truth t.tif", "--trajectory t.tum", "--sensor front"})
    refused(world, option);
  refused(log + " --world " + world, "--truth t.tif");
}

TEST_F(TalusCompare, WritesAllFilesOrNoneAndNoneOverAnInput)
{
  write("tables.md.yaml", text("small.yaml"));
  fs::create_directories(path("out/maps.png"));  // a folder where a file should go
  fs::create_symlink(path("tables.md.yaml"), path("out/tables.md"));
  const Outcome o = run("tables.md.yaml --output out --methods talus");
  talus::test::expect_end(o, 1, {"is an input"});
  EXPECT_SAYS_NOT(o.text, "budgets") << "compared first";
  fails("small.yaml --methods talus --output out", 1, {"maps.png"});
  EXPECT_FALSE(exists("out/comparison.json"));
  EXPECT_EQ(hidden("out"), 0);
}

TEST_F(TalusCompare, NamesTheParameterTheConfigurationOrTheOptionThatIsWrong)
{
  const std::string one = "small.yaml --output out ";
  write("m.ini", "[map_CDualElevationMap_00_insertOpts]\nresolution_m = 0.1\n");
  fails(one + "--config m.ini --set window=5000", 1, {"5000 m at resolution_m = 0.1 m"});
  fails(one + "--set fill_samples=guess", 1, {"a number from 1 to 16"});
  fails(one + "--methods talus,grid", 1, {"heightgrid"});
  for (const char* wrong :
       {"--noise nan", "--pose-noise nan", "--z-drift nan", "--seed -1", "--config ''",
        "--no-such-option"})
    fails(one + wrong, 2, {});
  EXPECT_FALSE(exists("out"));
  fails("", 2, {});
  fails("--help", 0, {"Examples"});
}

TEST_F(TalusCompare, DoesTheOtherInputsWhereOneFailsIntoAFolderThatIsNotUtf8)
{
  fails(
      "nowhere.yaml small.yaml --methods talus --set resolution_m=0.1 --output 'm\xfcll'", 1,
      {"nowhere.yaml"});
  EXPECT_EQ(json("m\xfcll/comparison.json")["worlds"].size(), 1U);
}

}  // namespace
