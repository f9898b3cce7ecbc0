// Files that are read: what is none is refused by its name, without waiting for it or reading it.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <talus/input_file.h>
#include <talus/io/geotiff.h>
#include <talus/io/trajectory.h>
#include <talus/sim/ground.h>
#include <talus/sim/world.h>

#include <filesystem>

#include "log_files.h"
#include "message_of.h"

using talus::test::ScratchDir;
using talus::test::write_bytes;

namespace
{
void make_socket(const std::string& path)
{
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(path.size(), sizeof address.sun_path);
  path.copy(address.sun_path, path.size());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  EXPECT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ::close(fd);
}

/** Larger than any memory, and no blocks on the disk. */
void make_huge(const std::string& path)
{
  write_bytes(path, "");
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40);
}
}  // namespace

TEST(InputFile, IsReadWholeUpToItsLimit)
{
  const ScratchDir dir;
  const std::string bytes("a\0b\n", 4);
  write_bytes(dir / "a", bytes);
  EXPECT_EQ(talus::read_input_file(dir / "a", "text", 4), bytes);
  EXPECT_EQ(
      message_of([&] { talus::read_input_file(dir / "a", "text", 3); }),
      dir / "a" + ": has 4 bytes, a text at most 3. Is it another file?");
  make_huge(dir / "huge");
  EXPECT_SAYS(
      message_of([&] { talus::read_input_file(dir / "huge", "text", 1000); }), "1099511627776");
}

TEST(InputFile, IsNoPipeDeviceSocketOrDirectoryForAnyReader)
{
  const ScratchDir dir;
  ASSERT_EQ(::mkfifo((dir / "pipe").c_str(), 0600), 0);
  make_socket(dir / "socket");
  const std::string no_file = "is a pipe or a device", folder = "is a directory";
  const std::vector<std::pair<std::string, std::string>> bad{
      {dir / "pipe", no_file},
      {dir / "socket", no_file},
      {"/dev/zero", no_file},
      {dir / "", folder},
      {dir / "none", "no such file"}};
  for (const auto& file : bad)
  {
    const std::string& path = file.first;
    for (const auto& error :
         {message_of([&] { talus::read_input_file(path, "text", 1000); }),
          message_of([&] { talus::io::Trajectory::load(path); }),
          message_of([&] { talus::io::read_geotiff(path); }),
          message_of([&] { talus::sim::load_world(path); }),
          message_of([&] { talus::sim::read_pgm(path); })})
      EXPECT_SAYS(error, path + ": " + file.second);
  }
}

TEST(InputFile, IsNotReadWhereItIsLargerThanAnyOfItsKind)
{
  const ScratchDir dir;
  make_huge(dir / "huge");
  EXPECT_SAYS(message_of([&] { talus::sim::load_world(dir / "huge"); }), "has 1");
  EXPECT_SAYS(
      message_of([&] { talus::io::Trajectory::load(dir / "huge"); }), "huge:1: no end of the line");
  EXPECT_SAYS(message_of([&] { talus::sim::read_pgm(dir / "huge"); }), "not a grey PGM");
}
