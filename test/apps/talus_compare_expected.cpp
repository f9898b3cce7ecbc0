// Failures that are expected: written by the command, found beside the worlds, and told from new
// ones.
#include "compared_worlds.h"

#include <regex>

namespace
{
class TalusCompareExpected : public ComparedWorlds
{
 protected:
  void SetUp() override
  {
    ComparedWorlds::SetUp();
    write_world_with_wall("worlds/odd/wall");
  }
  Outcome compare(const std::string& options) const
  {
    return run("worlds/odd/wall.yaml --methods talus --output out " + options);
  }
  std::string file() const { return path("worlds/expected_failures.tsv"); }
  std::string noted() const { return text("worlds/expected_failures.tsv"); }
  void note(const std::string& text) const { std::ofstream(file()) << text; }
  /** The text with the value of the row `reach`, moved by so much, and another reason. */
  std::string with_reach(double by) const
  {
    const std::string all = noted();
    std::smatch row;
    EXPECT_TRUE(std::regex_search(all, row, std::regex("wall\treach\t([0-9.]+)\t.*"))) << all;
    const std::string value = std::to_string(std::stod(row[1]) + by);
    return std::string(row.prefix()) + "wall\treach\t" + value + "\tthe wall hides it" +
           std::string(row.suffix());
  }
};

bool has(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

TEST_F(TalusCompareExpected, WhatWasAcceptedIsExpectedAndAnythingElseFails)
{
  const Outcome before = compare("--check");
  EXPECT_EQ(before.code, 1) << before.text;
  EXPECT_TRUE(has(before.text, "not hold (marked !)")) << before.text;

  ASSERT_EQ(compare("--accept " + file()).code, 0);
  const Outcome same = compare("--check");
  EXPECT_EQ(same.code, 0) << same.text;
  EXPECT_TRUE(has(same.text, "as expected (*), 0 new or clearly worse (!)")) << same.text;
  EXPECT_TRUE(
      std::regex_search(text("out/tables.md"), std::regex(R"(\| reach \|[^|]*\| [0-9.]+\* \|)")))
      << text("out/tables.md");

  note(with_reach(0.02));
  const Outcome worse = compare("--check");
  EXPECT_EQ(worse.code, 1) << worse.text;
  EXPECT_TRUE(has(worse.text, "New or clearly worse:\n\n- wall reach: ")) << worse.text;
  EXPECT_TRUE(
      std::regex_search(text("out/tables.md"), std::regex(R"(\| reach \|[^|]*\| [0-9.]+! \|)")));
  EXPECT_EQ(compare("").code, 0) << "nobody asked for the check";
}

TEST_F(TalusCompareExpected, TellsWhatNoLongerFailsAndKeepsReasonsAndOtherWorlds)
{
  ASSERT_EQ(compare("--accept " + file()).code, 0);
  const std::string elsewhere = "zoo\tleak\t0.5\ta bear\n";
  note(with_reach(0) + "wall\tobstacle_blocked\t0.9\tonce\n" + elsewhere);
  const Outcome o = compare("--check");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(has(o.text, "No longer fails; take these out of the expected failures by --accept"))
      << o.text;
  EXPECT_TRUE(has(o.text, "- wall obstacle_blocked: ")) << o.text;

  ASSERT_EQ(compare("--accept " + file()).code, 0);
  EXPECT_TRUE(has(noted(), "\tthe wall hides it\n")) << noted();
  EXPECT_TRUE(has(noted(), elsewhere)) << noted();
  EXPECT_FALSE(has(noted(), "obstacle_blocked")) << noted();
}

TEST_F(TalusCompareExpected, RefusesToAcceptAnotherMapAndToReadADamagedFile)
{
  for (const char* other : {"--set resolution_m=0.1", "--frames 5", "--seed 3", "--expected x.tsv"})
  {
    const Outcome o = compare("--accept " + file() + " " + other);
    EXPECT_EQ(o.code, 2) << o.text;
    EXPECT_TRUE(has(o.text, "--accept")) << o.text;
  }
  EXPECT_FALSE(fs::exists(file()));
  note("# a comment\nwall\treach\tmuch\tno number\n");
  const Outcome o = compare("--check");
  EXPECT_EQ(o.code, 1) << o.text;
  EXPECT_TRUE(has(o.text, "expected_failures.tsv:2: 'much' is no value")) << o.text;
}

TEST_F(TalusCompareExpected, OfTheWorldsThatComeWithItAllFailuresAreNoted)
{
  std::string worlds;
  for (const char* name : {"flat", "slope", "table", "ditch", "person"})
    worlds += TALUS_SOURCE_DIR "/datasets/worlds/" + std::string(name) + ".yaml ";
  const Outcome o = run(worlds + "--methods talus --check --output out");
  EXPECT_EQ(o.code, 0) << o.text << "what is meant: ./dev compare --accept";
}

}  // namespace
