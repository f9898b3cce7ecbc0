#pragma once
// Shared by the specifications of commands: what a command line says and how it ends.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "log_files.h"

namespace talus::test
{
struct CommandEnd
{
  int code = 0;
  std::string text;  //!< of both streams
};

/** Runs a command line of the shell in a folder. */
inline CommandEnd run_in(const std::string& folder, const std::string& command)
{
  const std::string log = folder + "/log.txt";
  const int status = std::system(("cd '" + folder + "' && " + command + " >log.txt 2>&1").c_str());
  return {WEXITSTATUS(status), read_bytes(log)};
}

/** It must have ended with this code, and said these words. */
inline void expect_end(const CommandEnd& end, int code, const std::vector<std::string>& words)
{
  EXPECT_EQ(end.code, code) << end.text;
  for (const auto& word : words)
    EXPECT_NE(end.text.find(word), std::string::npos) << word << " not in " << end.text;
}

}  // namespace talus::test
