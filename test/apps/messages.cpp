// What commands print: nothing that a terminal obeys, and the file that is to blame.
#include <gtest/gtest.h>

#include <csignal>
#include <iostream>
#include <new>
#include <sstream>

#include "apps/common/child_process.h"
#include "apps/common/crash_context.h"
#include "apps/common/printable.h"
#include "log_files.h"
#include "sanitizer.h"

using namespace talus::app;

TEST(Printable, TextStaysAsItIs)
{
  for (const std::string text : {"", "a b\tc", "Gr\u00fc\u00dfe \u20ac \U0001F916", "\\x1b"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, WhatATerminalObeysBecomesACode)
{
  EXPECT_EQ(printable("\x1b[31mred\r\x7f\a"), "\\x1b[31mred\\x0d\\x7f\\x07");
  EXPECT_EQ(printable(std::string("\0", 1)), "\\x00");
  EXPECT_EQ(printable("a\nb"), "a\\x0ab") << "a line of its own";
  EXPECT_EQ(printable("a\nb\t", "\n"), "a\nb\\x09");
  EXPECT_EQ(printable("\u009b31m"), "\\xc2\\x9b31m") << "the same as ESC [, in one character";
}

TEST(Printable, WhatIsLongLosesItsMiddle)
{
  const std::string path(300, 'p');
  EXPECT_EQ(shortened("a " + path + "\n"), "a " + path + "\n");
  EXPECT_EQ(
      shortened("window_m = '" + std::string(5000, 'a') + "' is no number"),
      "window_m = '" + std::string(199, 'a') + "...(4702 more)..." + std::string(99, 'a') +
          "' is no number");
}

TEST(PrintableOutput, HoldsForAllThatIsPrintedWhileItLives)
{
  std::ostringstream shown;
  auto* before = std::cerr.rdbuf(shown.rdbuf());
  {
    const PrintableOutput printable_output;
    std::cerr << "sensor '\x1b]0;title\a'" << 7 << '\x1b' << std::endl;
  }
  std::cerr << "\x1b";
  std::cerr.rdbuf(before);
  EXPECT_EQ(shown.str(), "sensor '\\x1b]0;title\\x07'7\\x1b\n\x1b");
}

namespace
{
/** What is told of a child that crashed while it did this. */
template <class F>
std::string told(const F& work)
{
  return crash_text("a.rawlog", run_in_child(work).signal);
}

int crash()
{
  std::signal(SIGSEGV, SIG_DFL);  // a sanitizer catches it
  return std::raise(SIGSEGV);
}
}  // namespace

TEST(CrashContext, IsBlamedForACrashOfTheChild)
{
  const auto with_context = []
  {
    const CrashContext outer("b.yaml", "Mend it");
    const CrashContext inner("c.simplemap", "Copy it again");
    return crash();
  };
  const std::string start = ": crashed the program (signal 11, Segmentation fault); it gives no ";
  EXPECT_EQ(told(with_context), "c.simplemap" + start + "results. Copy it again");
  EXPECT_EQ(crash_text("a.rawlog", SIGSEGV).rfind("a.rawlog" + start, 0), 0U) << "told once";
  const auto with_outer = []
  {
    const CrashContext outer("b.yaml", "Mend it");
    {
      const CrashContext inner("c.simplemap", "Copy it again");
    }
    return crash();
  };
  EXPECT_EQ(told(with_outer), "b.yaml" + start + "results. Mend it");
  EXPECT_EQ(told(crash).rfind("a.rawlog" + start, 0), 0U) << "not that of the child before";
}

TEST(CrashContext, IsBlamedForWantOfMemory)
{
  TALUS_SKIP_UNDER_SANITIZER("it ends the program where memory ends");
  const auto take_all = [] { return std::string(std::size_t{1} << 45, 'x').size(); };
  talus::test::expect_error(
      [&] { guarded("b.yaml", "Mend it", take_all); }, {"b.yaml: needs more memory"});
  EXPECT_EQ(
      failure_text(std::bad_alloc(), "b.yaml", "Mend it"),
      "b.yaml: needs more memory than there is. Mend it");
  EXPECT_EQ(failure_text(std::runtime_error("text"), "b.yaml", "Mend it"), "text");
}
