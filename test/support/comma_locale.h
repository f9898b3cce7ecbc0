// A locale with a decimal comma and groups of digits, which a program with windows takes over from
// the desktop.
#pragma once
#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <locale>

namespace talus::test
{
class CommaLocale : public testing::Test
{
 protected:
  void SetUp() override
  {
    setenv("LOCPATH", TALUS_TEST_LOCALES, 1);
    constexpr const char* name = "de_DE.UTF-8";
    if (!std::setlocale(LC_ALL, name))
      GTEST_SKIP() << "there is no locale with a decimal comma: install the Debian package locales "
                      "and configure again";
    std::locale::global(std::locale(name));
    ASSERT_EQ(std::strtod("0.5", nullptr), 0) << "a point ends a number here";
  }
  void TearDown() override
  {
    std::locale::global(std::locale::classic());
    std::setlocale(LC_ALL, "C");
  }
};
}  // namespace talus::test
