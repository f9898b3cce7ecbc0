// talus-compare where rules of the map are left out: what it says, and that the map is another one.
#include <sstream>

#include "compared_worlds.h"

namespace
{
class TalusCompareRules : public ComparedWorlds
{
 protected:
  /** `command` is one of the two executables, with variables of the environment before it. */
  Outcome run(
      const std::string& command, const std::string& arguments,
      const std::string& methods = "talus") const
  {
    return shell(
        command + " small.yaml --evaluate 1 --frames 5 --methods " + methods + " --output " +
        "out " + arguments);
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
};

TEST_F(TalusCompareRules, WithoutItsRulesTheMapIsAnotherOneAndTheTablesNameThem)
{
  ASSERT_EQ(run(TALUS_COMPARE_SWITCHED_EXE, "").code, 0);
  const auto all = comparison();
  EXPECT_EQ(all["without_rules"], nlohmann::json::array());
  EXPECT_SAYS_NOT(text("out/tables.md"), "Without rule");

  const std::string rules = rules_with_switch();
  const Outcome o = run(TALUS_COMPARE_SWITCHED_EXE, "--without " + rules);
  ASSERT_EQ(o.code, 0) << o.text;
  const auto none = comparison();
  EXPECT_NE(none["worlds"][0]["methods"], all["worlds"][0]["methods"]);
  EXPECT_EQ(none["without_rules"], nlohmann::json::parse("[" + rules + "]"));
  const std::string words = "Without rules " + rules.substr(0, rules.find(',')) + ", ";
  EXPECT_SAYS(o.text, words);
  EXPECT_SAYS(text("out/tables.md"), words);
}

TEST_F(TalusCompareRules, RefusesWhatIsNoRuleOrOfNoUse)
{
  for (const char* wrong : {"--without x", "--without 99", "--without -1"})
  {
    EXPECT_EQ(run(TALUS_COMPARE_SWITCHED_EXE, wrong).code, 2) << wrong;
    EXPECT_FALSE(exists("out")) << wrong;
  }
  const Outcome o = run(TALUS_COMPARE_SWITCHED_EXE, "--without 1", "paper");
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_SAYS(o.text, "--without is for talus");
}

TEST_F(TalusCompareRules, ABuildWithoutSwitchesSaysWhichBuildHasThem)
{
#if defined(TALUS_RULE_SWITCHES)
  GTEST_SKIP() << "this build has switches";
#endif
  const Outcome o = run(TALUS_COMPARE_EXE, "--without 1");
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_SAYS(o.text, "-DTALUS_RULE_SWITCHES=ON");
  EXPECT_FALSE(exists("out"));
}

}  // namespace
