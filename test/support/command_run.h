#pragma once
// Shared by the specifications of commands: what a command line says and how it ends.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "log_files.h"

namespace talus::test
{
struct CommandEnd
{
  int code = 0;
  std::string out, err;
  std::string text = out + err;

  bool says(const std::string& words) const { return text.find(words) != std::string::npos; }
};

/** Runs a command line of the shell in a folder, in which it leaves nothing of its own. */
inline CommandEnd run_in(const std::string& folder, const std::string& command)
{
  const std::string out = folder + "/.out.txt", err = folder + "/.err.txt";
  const int status = std::system(
      ("cd '" + folder + "' && (" + command + ") >'" + out + "' 2>'" + err + "'").c_str());
  CommandEnd end{WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(out), read_bytes(err)};
  for (const std::string& file : {out, err}) std::filesystem::remove(file);
  return end;
}

/** It must have ended with this code, and said these words. */
inline void expect_end(const CommandEnd& end, int code, const std::vector<std::string>& words)
{
  EXPECT_EQ(end.code, code) << end.text;
  for (const auto& word : words) EXPECT_SAYS(end.text, word);
}

/** A scratch folder in which a program and commands of the shell run, and what they leave there. */
class CommandTest : public testing::Test
{
 protected:
  explicit CommandTest(std::string program = "") : program_(std::move(program)) {}

  /** The program; `before` is put in front, e.g. "ulimit -f 1;". */
  CommandEnd run(const std::string& arguments, const std::string& before = "") const
  {
    return shell(before + " " + command(arguments));
  }
  /** The same, which must succeed. */
  CommandEnd runs(const std::string& arguments, const std::string& before = "") const
  {
    CommandEnd end = run(arguments, before);
    EXPECT_EQ(end.code, 0) << arguments << "\n" << end.text;
    return end;
  }
  void fails(
      const std::string& arguments, int code, const std::vector<std::string>& words,
      const std::string& before = "") const
  {
    expect_end(run(arguments, before), code, words);
  }
  std::string path(const std::string& name = "") const { return dir_ / name; }
  CommandEnd shell(const std::string& command) const { return run_in(path(), command); }
  /** It must succeed. */
  void done(const std::string& command) const
  {
    const CommandEnd end = shell(command);
    ASSERT_EQ(end.code, 0) << command << "\n" << end.text;
  }
  void write(const std::string& name, const std::string& bytes) const
  {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    write_bytes(path(name), bytes);
  }
  std::string text(const std::string& name) const { return read_bytes(path(name)); }
  nlohmann::json json(const std::string& name) const
  {
    return nlohmann::json::parse(text(name), nullptr, false);
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
  /** How many names in a folder begin with a dot: left by a run. */
  int hidden(const std::string& folder = "") const
  {
    int count = 0;
    for (const auto& e : std::filesystem::directory_iterator(path(folder)))
      count += e.path().filename().string()[0] == '.';
    return count;
  }

  ScratchDir dir_;

 private:
  virtual std::string command(const std::string& arguments) const
  {
    return program_ + " " + arguments;
  }
  std::string program_;
};

}  // namespace talus::test
