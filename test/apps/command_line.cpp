// What every command line understands, and what it says of mistakes.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/progress_bar.h"
#include "log_files.h"

using namespace talus::app;

TEST(Mounting, is_six_numbers_with_commas)
{
  EXPECT_EQ(mounting_from_text("-0.3,0,0.6,180,-4.5,1e1"), (Mounting{-0.3, 0, 0.6, 180, -4.5, 10}));
  for (const char* wrong :
       {"", "1,2,3,4,5", "1,2,3,4,5,6,7", "1 2 3 4 5 6", "1,2,3,4,5,", "nan,0,0,0,0,0",
        "101,0,0,0,0,0", "0,0,0,0,0,361", "0;0;0;0;0;0", "x,0,0,0,0,0"})
    EXPECT_THROW(mounting_from_text(wrong), std::invalid_argument) << wrong;
}

TEST(Mounting, is_read_as_it_was_written)
{
  const Mounting mounting{-1.25, 0.0625, 0.6789, -179.5, 0.125, 12.345};
  EXPECT_EQ(mounting_from_text(text_of_mounting(mounting)), mounting);
}

TEST(Mounting, says_what_is_wrong_and_in_which_order_numbers_are_needed)
{
  talus::test::expect_error(
      [] { mounting_from_text("0,0,0.6,0,400,0"); },
      {"'400' in '0,0,0.6,0,400,0'", "X,Y,Z,YAW,PITCH,ROLL [m, degrees]"});
}

namespace
{
struct Answer
{
  int code = -1;
  std::string text;
};
/** Of a command that needs --output and knows --trajectory. */
Answer answer_to(std::vector<std::string> words)
{
  CLI::App app{"A command of this test", "talus-test"};
  std::string output, trajectory;
  std::vector<std::string> logs;
  app.add_option("LOG", logs);
  app.add_option("--output", output)->required();
  app.add_option("--trajectory", trajectory);
  words.insert(words.begin(), "talus-test");
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  testing::internal::CaptureStderr();
  const auto code = parse_command_line(app, static_cast<int>(argv.size()), argv.data());
  return {code.value_or(0), testing::internal::GetCapturedStderr()};
}
}  // namespace

TEST(CommandLine, a_misspelt_option_gets_the_nearest)
{
  for (const std::string word : {"--outptu", "--outptu=a", "-output", "--Output"})
  {
    const Answer a = answer_to({"a.rawlog", word, "out"});
    EXPECT_EQ(a.code, 2) << word;
    EXPECT_SAYS(a.text, "did you mean --output?");
  }
  EXPECT_SAYS(
      answer_to({"--output", "out", "--trajektory", "a.tum"}).text, "did you mean --trajectory?");
}

TEST(CommandLine, an_option_that_is_like_none_is_named)
{
  const Answer a = answer_to({"--output", "out", "--bananas"});
  EXPECT_EQ(a.code, 2);
  EXPECT_SAYS(a.text, "there is no option --bananas");
  EXPECT_SAYS_NOT(a.text, "did you mean");
}

TEST(CommandLine, what_is_missing_is_said_where_no_option_is_misspelt)
{
  const Answer a = answer_to({"a.rawlog"});
  EXPECT_EQ(a.code, 2);
  EXPECT_SAYS(a.text, "--output is required");
}

TEST(TimeLeft, follows_from_what_was_done_since_the_job_began)
{
  TimeLeft left;
  EXPECT_EQ(left.text(0.5, 1000), "") << "a map that goes on from another begins in the middle";
  EXPECT_EQ(left.text(0.6, 1001), "") << "too early";
  EXPECT_EQ(left.text(0.75, 1010), "10 s left");
  EXPECT_EQ(left.text(0.1, 1020), "") << "another job";
  EXPECT_EQ(left.text(0.2, 1080), "8 min left");
  EXPECT_EQ(left.text(0.2, 21080), "45 h left");
}

namespace
{
/** What bash offers after these words of a command line. */
std::string completed(
    const std::string& command, const std::string& before, const std::string& word)
{
  const std::string script = "bash <<'END'\nsource '" TALUS_SOURCE_DIR
                             "/apps/common/completion.bash'\n_talus '" TALUS_BIN "/" +
                             command + "' '" + word + "' '" + before +
                             "'\necho \"${COMPREPLY[*]}\"\nEND\n";
  FILE* pipe = ::popen(script.c_str(), "r");
  std::string text;
  std::array<char, 4096> some{};
  while (std::fgets(some.data(), some.size(), pipe)) text += some.data();
  ::pclose(pipe);
  return text;
}
}  // namespace

TEST(Completion, offers_the_options_that_the_command_has)
{
  EXPECT_EQ(completed("talus-merge", "a.tif", "--out"), "--output\n");
  EXPECT_EQ(completed("talus-merge", "a.tif", "--t"), "--threads\n");
  EXPECT_EQ(completed("talus-merge", "--output", "sit"), "\n") << "files are bash's own affair";
}

TEST(Completion, offers_parameters_after_set)
{
  EXPECT_EQ(completed("talus-map", "-s", "resol"), "resolution_m=\n");
  EXPECT_EQ(completed("talus-map", "--set", "window_"), "window_m=\n");
}
