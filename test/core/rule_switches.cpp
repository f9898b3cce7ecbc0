#include <gtest/gtest.h>
#include "exact_scene.h"
#include "kernels/rule_switches.h"

#include <cstdlib>
#include <stdexcept>

// Core as a laboratory builds it: TALUS_WITHOUT_RULES names the rules that do not count.

using namespace talus;
using namespace talus::test;

namespace
{
/** For as long as it lives. */
struct Without
{
  explicit Without(const char* rules) { setenv("TALUS_WITHOUT_RULES", rules, 1); }
  ~Without() { unsetenv("TALUS_WITHOUT_RULES"); }
};

/** After some scans of a floor with a wall, a table and a trailer. */
std::vector<float> traversability()
{
  Parameters p;
  p.window_m = 6;
  ElevationMapper map(p, Backend::Cpu, 1);
  ExactScene scene;
  scene.boxes = {
      {{1, -2, 0}, {2.5, -1.9, 1}}, {{1.5, 0, 0.75}, {2, 1, 0.8}}, {{-2, -1, 0.2}, {-1, 1, 0.7}}};
  Random random(3);
  for (int i = 0; i < 4; i++)
    map.update(scene.scan(ExactScene::pose(0.05 * i, 0, 0.7), 300, 20, -0.7, 0.1, random, 0.01)
                   .frame(0.1 * i));
  return map.layer(Layer::Traversability);
}

int differing(const std::vector<float>& a, const std::vector<float>& b)
{
  int n = 0;
  for (std::size_t i = 0; i < a.size(); i++) n += !(a[i] == b[i] || (a[i] != a[i] && b[i] != b[i]));
  return n;
}
}  // namespace

TEST(RuleSwitches, ARuleThatIsOffChangesTheMapAndNoOtherRunOfIt)
{
  const auto all = traversability();
  {
    const Without proof("40");
    EXPECT_GT(differing(all, traversability()), 50);
  }
  EXPECT_EQ(differing(all, traversability()), 0);
}

TEST(RuleSwitches, EachRuleCanBeOffAloneAndAllTogether)
{
  std::string all;
  for (const kernels::Rule rule : kernels::kRules)
  {
    const std::string number = std::to_string(rule);
    all += (all.empty() ? "" : ",") + number;
    const Without one(number.c_str());
    EXPECT_NO_THROW(ElevationMapper(Parameters(), Backend::Cpu, 1)) << number;
  }
  const Without none_left(all.c_str());
  EXPECT_NO_THROW(traversability());
}

TEST(RuleSwitches, ANumberWithoutASwitchIsRefused)
{
  for (const char* wrong : {"7", "48", "0", "x", "30,,31"})
  {
    const Without rule(wrong);
    EXPECT_THROW(ElevationMapper(Parameters(), Backend::Cpu, 1), std::invalid_argument) << wrong;
  }
}
