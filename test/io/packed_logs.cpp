#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <talus/io/packed_log.h>
#include <talus/io/rawlog_reader.h>
#include <talus/io/trajectory.h>

#include <cstdint>
#include <filesystem>
#include <functional>

#include "log_files.h"
#include "message_of.h"
#include "packing.h"

using namespace mrpt::obs;
using namespace talus::test;
using mrpt::poses::CPose3D;
using talus::io::RawlogReader;
using talus::io::Trajectory;

namespace
{
CObservationPointCloud::Ptr cloud(double time_s, int points)
{
  auto obs = observation_at<CObservationPointCloud>(time_s, "lidar");
  auto map = mrpt::maps::CSimplePointsMap::Create();
  for (int i = 0; i < points; ++i)
  {
    const int uneven = i % 101 * (i % 101) % 101;
    map->insertPoint(0.37F * static_cast<float>(uneven), 0.5F, -0.01F * static_cast<float>(i));
  }
  obs->pointcloud = map;
  return obs;
}

std::string bytes_of(const Objects& objects)
{
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  for (const auto& object : objects) archive << *object;
  return {static_cast<const char*>(stream.getRawBufferData()), stream.getTotalBytesCount()};
}

/** The log again, by what it is read as. */
std::string read_again(const std::string& path)
{
  RawlogReader reader(path);
  Objects objects;
  while (auto obs = reader.next()) objects.push_back(obs);
  return bytes_of(objects);
}

std::string complaint(const std::string& path)
{
  return message_of([&] { read_again(path); });
}
bool is_refused(const std::string& path) { return complaint(path) != "no error"; }

using Pack = std::function<std::string(const std::string&)>;
struct Way
{
  const char* name;
  Pack pack;
};
const std::vector<Way> kPacked{
    {"gz", gz_of}, {"zstd", [](const std::string& bytes) { return zstd_of(bytes); }}};

const Objects kSmall{cloud(1, 20), cloud(2, 20), cloud(3, 20)};

}  // namespace

TEST(PackedLogs, are_read_plain_and_packed_in_one_piece_or_in_several)
{
  const ScratchDir dir;
  const auto log = bytes_of({cloud(1, 30000), cloud(2, 50000), cloud(3, 4)});
  const auto half = log.size() / 2;
  const auto parts = [&](const Pack& pack)
  { return pack(log.substr(0, half)) + pack("") + pack(log.substr(half)); };
  const auto without_checksum = [](const std::string& bytes) { return zstd_of(bytes, false); };
  const std::string for_other_programs("\x52\x2a\x4d\x18\3\0\0\0abc", 11);
  for (const auto& file :
       {log, gz_of(log), parts(gz_of), zstd_of(log), without_checksum(log), parts(kPacked[1].pack),
        zstd_of(log) + for_other_programs})
  {
    write_bytes(dir / "a.rawlog", file);
    EXPECT_TRUE(read_again(dir / "a.rawlog") == log) << file.size();
  }
}

TEST(PackedLogs, are_written_as_gz_for_other_programs_whatever_packs_well)
{
  const ScratchDir dir;
  auto noise = cloud(1, 40000);
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < 40000; ++i)
  {
    state = 1664525 * state + 1013904223;
    noise->pointcloud->setPoint(i, static_cast<float>(state), static_cast<float>(~state), 0);
  }
  const Objects all{noise, cloud(2, 40000), cloud(3, 4), noise};
  talus::io::PackedLog log(dir / "a.rawlog");
  for (const auto& object : all)
  {
    log.write(*object);
    if (object == all[1]) log.flush();
  }
  log.close();
  const auto bytes = bytes_of(all);
  EXPECT_LT(std::filesystem::file_size(dir / "a.rawlog"), 0.9 * static_cast<double>(bytes.size()));
  mrpt::io::CFileGZInputStream file(dir / "a.rawlog");
  std::string read(bytes.size() + 1, '\0');
  read.resize(file.Read(read.data(), read.size()));
  EXPECT_TRUE(read == bytes);
  EXPECT_TRUE(read_again(dir / "a.rawlog") == bytes);
}

TEST(PackedLogs, tell_how_far_the_reader_is)
{
  const ScratchDir dir;
  const auto log = bytes_of({cloud(1, 3000), cloud(2, 3000), cloud(3, 3000)});
  for (const auto& way : kPacked)
  {
    write_bytes(dir / "a.rawlog", way.pack(log));
    RawlogReader reader(dir / "a.rawlog");
    for (const double done : {1.0 / 3, 2.0 / 3, 1.0})
    {
      ASSERT_TRUE(reader.next());
      EXPECT_NEAR(reader.progress(), done, 0.34) << way.name;  // it reads an object ahead
    }
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.progress(), 1.0) << way.name;
  }
}

TEST(PackedLogs, that_are_cut_short_are_found_wherever_they_are_cut)
{
  const ScratchDir dir;
  const auto log = bytes_of(kSmall);
  for (const auto& way : kPacked)
  {
    const auto file = way.pack(log);
    for (std::size_t size = 4; size < file.size(); size += size + 20 < file.size() ? 5 : 1)
    {
      write_bytes(dir / "cut.rawlog", file.substr(0, size));
      expect_error(
          [&] { read_again(dir / "cut.rawlog"); },
          {"cut.rawlog", way.name, "cut short", "byte " + std::to_string(size), "Copy it again"});
    }
    std::vector<std::string> others{file.substr(0, 1), file.substr(0, 2), file.substr(0, 3)};
    const auto first = way.pack(bytes_of({kSmall[0]})), second = way.pack(bytes_of({kSmall[1]}));
    for (std::size_t size = 4; size < second.size(); size += 5)  // of two pieces
      others.push_back(first + second.substr(0, size));
    for (const auto& other : others)
    {
      write_bytes(dir / "cut.rawlog", other);
      EXPECT_TRUE(is_refused(dir / "cut.rawlog")) << way.name << " " << other.size();
    }
  }
}

TEST(PackedLogs, plain_ones_that_are_cut_short_are_found_but_between_two_objects)
{
  const ScratchDir dir;
  const auto log = bytes_of(kSmall);
  const auto one = log.size() / 3;
  for (std::size_t size = 1; size < log.size(); ++size)
  {
    if (const auto far = size % one; far % 17 != 0 && far > 2 && far < one - 2) continue;
    write_bytes(dir / "cut.rawlog", log.substr(0, size));
    EXPECT_EQ(is_refused(dir / "cut.rawlog"), size % one != 0) << size;
  }
}

TEST(PackedLogs, with_one_wrong_bit_are_refused_or_the_bit_means_nothing)
{
  const ScratchDir dir;
  const auto log = bytes_of(kSmall);
  for (const auto& way : kPacked)
  {
    const auto file = way.pack(log);
    int tried = 0, refused = 0;
    for (std::size_t bit = 0; bit < 8 * file.size(); bit += 19, ++tried)
    {
      auto bad = file;
      bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << bit % 8));
      write_bytes(dir / "bad.rawlog", bad);
      if (is_refused(dir / "bad.rawlog"))
        ++refused;
      else
        EXPECT_TRUE(read_again(dir / "bad.rawlog") == log) << way.name << " bit " << bit;
    }
    EXPECT_GT(10 * refused, 9 * tried) << way.name;
  }
}

/** Here the library for gz counts bits behind the last as read. */
TEST(PackedLogs, name_a_byte_of_the_file_where_they_are_damaged_and_cut_short)
{
  const ScratchDir dir;
  const auto file = gz_of(bytes_of(kSmall));
  int complaints = 0;
  for (std::size_t bit = 8 * 30 + 4; bit < 8 * 48; bit += 8)
    for (std::size_t size = bit / 8 + 14; size < bit / 8 + 19; ++size)
    {
      auto bad = file.substr(0, size);
      bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << bit % 8));
      write_bytes(dir / "bad.rawlog", bad);
      const std::string said = complaint(dir / "bad.rawlog"), before = "damaged before its byte ";
      if (const auto begin = said.find(before); begin != std::string::npos)
      {
        EXPECT_LE(std::stoull(said.substr(begin + before.size())), size) << bit;
        ++complaints;
      }
    }
  EXPECT_GT(complaints, 0);
}

TEST(PackedLogs, say_what_is_wrong_where_a_checksum_is_and_where_something_else_follows_the_data)
{
  const ScratchDir dir;
  for (const auto& way : kPacked)
  {
    auto file = way.pack(bytes_of(kSmall));
    for (const auto& rest : {std::string(1, '\0'), std::string("more")})
    {
      write_bytes(dir / "long.rawlog", file + rest);
      expect_error(
          [&] { read_again(dir / "long.rawlog"); },
          {"long.rawlog", way.name, "goes on after its data",
           "byte " + std::to_string(file.size())});
    }
    const std::size_t in_checksum = file.size() - (way.name == std::string("gz") ? 8 : 4);
    file[in_checksum] = static_cast<char>(file[in_checksum] ^ 1);
    write_bytes(dir / "bad.rawlog", file);
    expect_error(
        [&] { read_again(dir / "bad.rawlog"); },
        {"bad.rawlog", way.name, "damaged", "check", "Copy it again"});
  }
}

TEST(PackedLogs, that_unpack_to_more_than_any_log_are_refused)
{
  const ScratchDir dir;
  const std::string zeros(1 << 24, '\0');
  for (const auto& way : kPacked)
  {
    const auto piece = way.pack(zeros);
    std::string file;
    for (int i = 0; i < 66; ++i) file += piece;  // 1.03 GiB
    write_bytes(dir / "bomb.rawlog", file);
    expect_error(
        [&] { read_again(dir / "bomb.rawlog"); },
        {"bomb.rawlog", way.name, "unpacks to more than", "made to fill memory"});
  }
}

TEST(PackedSimpleMap, is_read_and_found_cut_short_in_each_packing)
{
  const ScratchDir dir;
  mrpt::maps::CSimpleMap map;
  auto frame = CSensoryFrame::Create();
  frame->insert(observation_at<CObservationOdometry>(50));
  map.insert(std::make_shared<mrpt::poses::CPose3DPDFGaussian>(CPose3D(3, 0, 0, 0, 0, 0)), frame);
  const auto plain = bytes_of({std::make_shared<mrpt::maps::CSimpleMap>(map)});
  for (const auto& way : kPacked)
  {
    const auto file = way.pack(plain);
    write_bytes(dir / "a.simplemap", file);
    ASSERT_EQ(Trajectory::load(dir / "a.simplemap").entries().size(), 1u) << way.name;
    for (std::size_t size = 4; size < file.size(); size += 7)
    {
      write_bytes(dir / "cut.simplemap", file.substr(0, size));
      expect_error(
          [&] { Trajectory::load(dir / "cut.simplemap"); }, {"cut.simplemap", "cut short"});
    }
  }
}
