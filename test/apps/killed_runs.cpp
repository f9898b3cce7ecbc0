// A run that is killed, at whatever moment: the place has the results of one run or no seal, and
// after the next run, which may be killed as well, all of one run.
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "apps/common/child_process.h"
#include "apps/common/output_folder.h"
#include "log_files.h"

namespace fs = std::filesystem;
using talus::app::OutputFolder;
using talus::test::read_bytes;
using talus::test::ScratchDir;
using talus::test::write_bytes;

namespace
{
using Files = std::map<std::string, std::string>;

/** All files below a folder, and the folders among them that are hidden. */
Files files_in(const std::string& folder)
{
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
  {
    const std::string name = entry.path().lexically_relative(folder).string();
    const bool is_hidden = entry.path().filename().string().rfind('.', 0) == 0;
    if (!entry.is_directory())
      files[name] = read_bytes(entry.path().string());
    else if (is_hidden)
      files[name] = "hidden folder";
  }
  return files;
}

/** A run with other results than the next. The second has fewer snapshots, and one file more. */
struct Run
{
  char sign;
  int snapshots;
  bool has_more;

  Files files() const
  {
    Files files;
    for (const char* name : {"map.tif", "map.png", "seal"})
      files[std::string("out/") + name] = text(name);
    if (has_more) files["out/more/more.txt"] = text("more");
    for (int i = 1; i <= snapshots; ++i)
      files["out/frames/frame_00000" + std::to_string(i) + ".tif"] = text("snapshot");
    return files;
  }

  void write(const ScratchDir& dir) const
  {
    OutputFolder output(dir / "out");
    for (const auto& [name, bytes] : files())
    {
      const fs::path file = fs::path(output.staging()) / fs::path(name).lexically_relative("out");
      fs::create_directories(file.parent_path());
      write_bytes(file.string(), bytes);
    }
    output.commit(std::set<std::string>{"map.tif", "seal"});
  }

 private:
  std::string text(const std::string& name) const { return name + " of run " + sign; }
};

const Run kFirst{'A', 3, false}, kSecond{'B', 2, true};

constexpr int kStep = 6;  // begin and end of three system calls

/** Runs `work` in a child that is killed when it begins or ends a system call, the `nth` such
 * moment. False when it was at its end before. */
bool is_killed_at(int nth, const std::function<void()>& work)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    if (!std::freopen("/dev/null", "w", stderr) || ::ptrace(PTRACE_TRACEME, 0, 0, 0) != 0) _exit(1);
    std::raise(SIGSTOP);
    work();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  for (int i = 0; i < nth && WIFSTOPPED(status); ++i)
  {
    ::ptrace(PTRACE_SYSCALL, child, 0, 0);
    ::waitpid(child, &status, 0);
  }
  if (!WIFSTOPPED(status)) return false;
  ::kill(child, SIGKILL);
  ::waitpid(child, &status, 0);
  return true;
}

/** After a first run, a second one that is killed at its nth moment. False when it was at its end
 * before. */
bool kill_second_run(const ScratchDir& dir, int nth)
{
  fs::remove_all(dir / "");
  fs::create_directories(dir / "out/frames");
  write_bytes(dir / "out/frames/notes.txt", "mine");
  for (const auto& [name, bytes] : kFirst.files()) write_bytes(dir / name, bytes);
  return is_killed_at(nth, [&] { kSecond.write(dir); });
}

/** Of which run the results are: where a seal is, everything is of its run. '?': no seal. Files of
 * other names are left alone. */
char sign_of(const ScratchDir& dir, int nth)
{
  Files files = files_in(dir / "");
  EXPECT_EQ(files.count("out/frames/notes.txt"), 1U);
  const auto seal = files.find("out/seal");
  const auto map = files.find("out/map.tif");
  if (map != files.end())
  {
    EXPECT_EQ(map->second.back(), files["out/map.png"].back()) << "one pair, killed at " << nth;
  }
  if (seal == files.end()) return '?';
  const char sign = seal->second.back();
  for (const auto& [name, bytes] : (sign == 'A' ? kFirst : kSecond).files())
    EXPECT_EQ(files[name], bytes) << name << ", killed at " << nth;
  return sign;
}
}  // namespace

TEST(KilledRuns, leave_the_results_of_one_run_or_no_seal_and_the_next_run_finishes_them)
{
  if (!is_killed_at(1, [] { ::getppid(); }))
    GTEST_SKIP() << "this machine lets no process trace another";
  const ScratchDir dir;
  testing::internal::CaptureStderr();
  std::map<char, int> count;
  for (int n = 1; kill_second_run(dir, n); n += kStep)
  {
    const char sign = sign_of(dir, n);
    ++count[sign];
    const auto next = [&] { const OutputFolder fails(dir / "out"); };
    for (int m = 1; sign == '?' && is_killed_at(m, next); m += kStep) sign_of(dir, n);
    next();
    Files left = (sign_of(dir, n) == 'A' ? kFirst : kSecond).files();
    left["out/frames/notes.txt"] = "mine";
    EXPECT_EQ(files_in(dir / ""), left) << "killed at " << n;
  }
  EXPECT_GT(count['A'], 20);
  EXPECT_GT(count['?'], 2);
  EXPECT_GT(count['B'], 0);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_SAYS(said, "out: removed what a run that was killed had left");
  EXPECT_SAYS(said, "out: put in place what a run that was killed had left");
}

TEST(KilledRuns, are_not_tidied_up_after_while_another_run_holds_its_folder)
{
  const ScratchDir dir;
  {
    OutputFolder first(dir / "out"), second(dir / "out");
    write_bytes(first.staging() + "/seal", "first");
    write_bytes(second.staging() + "/seal", "second");
    first.commit("seal");
    EXPECT_EQ(read_bytes(dir / "out/seal"), "first");
    second.commit("seal");
    EXPECT_EQ(read_bytes(dir / "out/seal"), "second");
  }
  EXPECT_EQ(files_in(dir / ""), (Files{{"out/seal", "second"}}));
}

TEST(KilledRuns, change_nothing_out_of_their_folder)
{
  const ScratchDir dir;
  fs::create_directories(dir / "elsewhere");
  write_bytes(dir / "mine.txt", "mine");
  for (const bool removes : {false, true})
  {
    const std::string left = dir / "out/.talus-run.abcdef";
    fs::create_directories(left + "/link");
    fs::remove(dir / "out/link");
    fs::create_directory_symlink(dir / "elsewhere", dir / "out/link");
    if (!removes) write_bytes(left + "/link/new.txt", "of somebody");
    write_bytes(left + "/.talus-moves", removes ? "-../mine.txt" : "");
    const OutputFolder next(dir / "out");
    EXPECT_FALSE(fs::exists(left));
  }
  EXPECT_EQ(read_bytes(dir / "mine.txt"), "mine");
  EXPECT_TRUE(fs::is_empty(dir / "elsewhere"));
}

TEST(KilledRuns, take_their_children_along)
{
  const ScratchDir dir;
  const pid_t parent = ::fork();
  if (parent == 0)
  {
    const OutputFolder output(dir / "out");
    const auto work = [&]
    {
      write_bytes(output.staging() + "/child.txt", std::to_string(::getpid()));
      ::kill(::getppid(), SIGKILL);
      for (;;) ::pause();
      return 0;
    };
    ::_exit(talus::app::run_in_child(work).exit_code);
  }
  ::waitpid(parent, nullptr, 0);
  const auto hidden = fs::directory_iterator(dir / "out")->path();
  const pid_t child = std::stoi(read_bytes((hidden / "child.txt").string()));
  const auto is_alive = [&]
  {
    // Nobody may have waited for it yet. A process closes its files, and with them its lock, before
    // it becomes a zombie, but only after its memory is gone.
    const std::string stat = read_bytes("/proc/" + std::to_string(child) + "/stat");
    const auto name_end = stat.rfind(") ");
    return name_end != std::string::npos && stat[name_end + 2] != 'Z' && stat[name_end + 2] != 'X';
  };
  for (int i = 0; i < 1000 && is_alive(); ++i) ::usleep(10000);
  EXPECT_FALSE(is_alive());
  {
    const OutputFolder next(dir / "out");
  }
  EXPECT_TRUE(files_in(dir / "").empty());
}
