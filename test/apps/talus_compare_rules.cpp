// talus-compare where rules of the map are left out: what it says, and that the map is another one.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace fs = std::filesystem;

namespace
{
struct Outcome
{
  int code = 0;
  std::string text;
};

class TalusCompareRules : public testing::Test
{
 protected:
  void SetUp() override
  {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(path("small.yaml")) << "name: small\n"
                                         "seed: 4\n"
                                         "ground: [plane: {z_m: 0}]\n"
                                         "objects: [box: {at_m: [3, 1], size_m: [0.5, 0.5, 0.5]}]\n"
                                         "robot: {path_m: [[0, 0], [0.6, 0]]}\n";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string read(const std::string& name) const
  {
    std::ostringstream out;
    out << std::ifstream(path(name), std::ios::binary).rdbuf();
    return out.str();
  }
  nlohmann::json comparison() const { return nlohmann::json::parse(read("out/comparison.json")); }

  /** `command` is one of the two executables, with variables of the environment before it. */
  Outcome run(
      const std::string& command, const std::string& arguments,
      const std::string& methods = "talus") const
  {
    const std::string line = command + " " + path("small.yaml") + " --evaluate 1 --methods " +
                             methods + " --output " + path("out") + " " + arguments + " >" +
                             path("log.txt") + " 2>&1";
    const int status = std::system(line.c_str());
    return {WEXITSTATUS(status), read("log.txt")};
  }

  /** The numbers of all rules that have a switch, "1,2,..." */
  std::string rules_with_switch() const
  {
    const Outcome o = run(TALUS_COMPARE_SWITCHED_EXE, "--without 0");
    EXPECT_EQ(o.code, 2) << o.text;
    const std::string before = "no rule 0 has a switch. These have one:";
    const std::size_t at = o.text.find(before);
    if (at == std::string::npos) ADD_FAILURE() << o.text;
    std::istringstream numbers(at == std::string::npos ? "" : o.text.substr(at + before.size()));
    std::string list;
    for (int n = 0; numbers >> n;) list += (list.empty() ? "" : ",") + std::to_string(n);
    return list;
  }

 private:
  fs::path folder_ =
      fs::temp_directory_path() / ("talus_compare_rules_test_" + std::to_string(getpid()));
};

TEST_F(TalusCompareRules, WithoutItsRulesTheMapIsAnotherOneAndTheTablesNameThem)
{
  ASSERT_EQ(run(TALUS_COMPARE_SWITCHED_EXE, "").code, 0);
  const auto all = comparison();
  EXPECT_EQ(all["without_rules"], nlohmann::json::array());
  EXPECT_EQ(read("out/tables.md").find("Without rule"), std::string::npos);

  const std::string rules = rules_with_switch();
  const Outcome o = run(TALUS_COMPARE_SWITCHED_EXE, "--without " + rules);
  ASSERT_EQ(o.code, 0) << o.text;
  const auto none = comparison();
  EXPECT_NE(none["worlds"][0]["methods"], all["worlds"][0]["methods"]);
  EXPECT_EQ(none["without_rules"], nlohmann::json::parse("[" + rules + "]"));
  const std::string words = "Without rules " + rules.substr(0, rules.find(',')) + ", ";
  EXPECT_NE(o.text.find(words), std::string::npos) << o.text;
  EXPECT_NE(read("out/tables.md").find(words), std::string::npos) << read("out/tables.md");
}

TEST_F(TalusCompareRules, AlsoSaysSoWhereTheEnvironmentNamesThem)
{
  const std::string rules = rules_with_switch(), last = rules.substr(rules.rfind(',') + 1);
  const Outcome o = run("TALUS_WITHOUT_RULES=" + last + " " TALUS_COMPARE_SWITCHED_EXE, "");
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(comparison()["without_rules"], nlohmann::json::parse("[" + last + "]"));
  EXPECT_NE(o.text.find("Without rule " + last + "."), std::string::npos) << o.text;
}

TEST_F(TalusCompareRules, RefusesWhatIsNoRuleOrOfNoUse)
{
  for (const char* wrong : {"--without x", "--without 99", "--without -1"})
  {
    EXPECT_EQ(run(TALUS_COMPARE_SWITCHED_EXE, wrong).code, 2) << wrong;
    EXPECT_FALSE(fs::exists(path("out"))) << wrong;
  }
  const Outcome o = run(TALUS_COMPARE_SWITCHED_EXE, "--without 1", "paper");
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_NE(o.text.find("--without is for talus"), std::string::npos) << o.text;
}

TEST_F(TalusCompareRules, ABuildWithoutSwitchesSaysWhichBuildHasThem)
{
#if defined(TALUS_RULE_SWITCHES)
  GTEST_SKIP() << "this build has switches";
#endif
  const Outcome o = run(TALUS_COMPARE_EXE, "--without 1");
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_NE(o.text.find("-DTALUS_RULE_SWITCHES=ON"), std::string::npos) << o.text;
  EXPECT_FALSE(fs::exists(path("out")));
}

}  // namespace
