// Some KB that unpack to very much: refused by name, with no more memory than 100 MB beside what
// the bytes that are there can hold.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bag_log.h"
#include "sanitizer.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;

namespace
{
struct Reading
{
  std::string error;
  long most_kb = 0;  //!< of memory
};

long most_kb_of(int who)
{
  rusage usage{};
  getrusage(who, &usage);
  return usage.ru_maxrss;
}

/** Reads a bag in a process of its own. */
Reading read_apart(const std::string& path)
{
  int ends[2] = {-1, -1};
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0)
  {
    const auto error = error_of(path).substr(0, 4000);
    const long before_kb = most_kb_of(RUSAGE_SELF);
    const auto text = std::to_string(before_kb) + " " + error;
    _exit(write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  close(ends[1]);
  std::string text(5000, ' ');
  const auto got = read(ends[0], text.data(), text.size());
  close(ends[0]);
  waitpid(child, nullptr, 0);
  text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  const auto blank = text.find(' ');
  if (blank == std::string::npos) return {};
  return {text.substr(blank + 1), std::stol(text)};
}
}  // namespace

class BagMemory : public testing::TestWithParam<std::pair<const char*, const char*>>
{
};

TEST_P(BagMemory, ABombIsRefusedByNameAndTakesLittle)
{
  TALUS_SKIP_UNDER_SANITIZER("it counts memory");
  const std::string name = GetParam().first;
  MAKE_BAGS(name);
  const auto reading = read_apart(dir / name);
  EXPECT_TRUE(holds(reading.error, name) && holds(reading.error, GetParam().second))
      << reading.error;
  const auto file_kb = static_cast<long>(std::filesystem::file_size(dir / name) / 1024);
  EXPECT_GT(reading.most_kb, 0);
  EXPECT_LT(reading.most_kb, most_kb_of(RUSAGE_SELF) + 100 * 1024 + 16 * file_kb);
}

INSTANTIATE_TEST_SUITE_P(
    All, BagMemory,
    testing::Values(
        std::make_pair("tf_bomb.mcap", "transforms and poses in a bag of"),
        std::make_pair("frame_bomb.mcap", "more than 10000"),
        std::make_pair("cloud_bomb.mcap", "unpacks to more than 1048576 points"),
        std::make_pair("cloud_bomb_message.mcap", "unpacks to more than 1048576 points"),
        std::make_pair("chunk_bomb_zstd.mcap", "packed bytes no more than"),
        std::make_pair("chunk_bomb_lz4.mcap", "packed bytes no more than"),
        std::make_pair("topic_bomb.mcap", "no bag has"),
        std::make_pair("overlapping_bomb.mcap", "unpacks to more than 1048576 points"),
        std::make_pair("bomb.mcap", "packed bytes no more than"),
        std::make_pair("generated.db3", "string or blob too big")));
