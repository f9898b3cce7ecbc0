// Files of one scan: what is read of them, and what is said of those that are wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string_view>

#include "apps/common/memory_limit.h"
#include "log_files.h"
#include "record_file.h"
#include "formats.h"
#include "point_times.h"
#include "scan_formats.h"

using namespace talus::import;
using namespace talus::test;

namespace
{
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/** A spiral, all fields in it. */
Points spiral(std::size_t count)
{
  Points p;
  for (std::size_t i = 0; i < count; ++i)
  {
    const float angle = 0.1F * static_cast<float>(i);
    p.x.push_back(angle * std::cos(angle));
    p.y.push_back(angle * std::sin(angle));
    p.z.push_back(0.01F * angle - 0.5F);
    p.intensity.push_back(static_cast<float>(i % 256));
    p.time.push_back(1e-4F * static_cast<float>(i));
    p.ring.push_back(static_cast<std::uint16_t>(i % 16));
  }
  return p;
}

struct FileKind
{
  const char* ending;
  void (*read)(const std::string&, ScanFile&);
  std::string (*write)(const Points&);
};
const FileKind kFileKinds[] = {
    {"kitti.bin", read_bin, kitti_bin},
    {"ascii.pcd", read_pcd, pcd_ascii},
    {"binary.pcd", read_pcd, [](const Points& p) { return pcd_binary(p); }},
    {"compressed.pcd", read_pcd, pcd_compressed},
    {"ascii.ply", read_ply, ply_ascii},
    {"little.ply", read_ply, ply_little},
    {"big.ply", read_ply, ply_big}};

class ScanFiles : public testing::Test
{
 protected:
  ScanFile read(const FileKind& format, const std::string& bytes) const
  {
    const std::string path = dir_ / format.ending;
    write_bytes(path, bytes);
    ScanFile scan;
    format.read(path, scan);
    return scan;
  }
  ScanFile read_as(const std::string& ending, const std::string& bytes) const
  {
    for (const FileKind& f : kFileKinds)
      if (f.ending == ending) return read(f, bytes);
    throw std::logic_error(ending);
  }
  void refuses(
      const std::string& ending, const std::string& bytes, std::vector<std::string> words) const
  {
    words.push_back(dir_ / ending);
    expect_error([&] { read_as(ending, bytes); }, words);
  }
  ScratchDir dir_;
};

/** Every float of a file is a double that gives it back. */
std::vector<float> floats(const std::vector<double>& numbers)
{
  return {numbers.begin(), numbers.end()};
}

std::string replaced(std::string text, const std::string& from, const std::string& to)
{
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}
}  // namespace

TEST_F(ScanFiles, of_each_format_give_every_number_back)
{
  const Points p = spiral(1000);
  for (const FileKind& f : kFileKinds)
  {
    const ScanFile scan = read(f, f.write(p));
    EXPECT_EQ(floats(scan.x_m), p.x) << f.ending;
    EXPECT_EQ(floats(scan.y_m), p.y) << f.ending;
    EXPECT_EQ(floats(scan.z_m), p.z) << f.ending;
    EXPECT_EQ(scan.intensity, p.intensity) << f.ending;
    EXPECT_EQ(scan.not_finite, 0u) << f.ending;
    if (std::string(f.ending) == "kitti.bin") continue;
    EXPECT_EQ(std::vector<float>(scan.time.begin(), scan.time.end()), p.time) << f.ending;
    EXPECT_EQ(scan.ring, p.ring) << f.ending;
  }
}

TEST_F(ScanFiles, lose_the_points_that_are_not_finite_and_count_them)
{
  Points p = spiral(10);
  p.x[2] = kNaN;
  p.z[7] = std::numeric_limits<float>::infinity();
  for (const FileKind& f : kFileKinds)
  {
    const ScanFile scan = read(f, f.write(p));
    ASSERT_EQ(scan.x_m.size(), 8u) << f.ending;
    EXPECT_EQ(scan.intensity.size(), 8u) << f.ending;
    EXPECT_EQ(scan.not_finite, 2u) << f.ending;
    EXPECT_EQ(static_cast<float>(scan.x_m[2]), p.x[3]) << f.ending;
  }
}

TEST_F(ScanFiles, of_points_alone_have_neither_times_nor_intensities)
{
  Points p = spiral(5);
  p.intensity.clear();
  p.time.clear();
  p.ring.clear();
  for (const FileKind& f : kFileKinds)
  {
    const ScanFile scan = read(f, f.write(p));
    EXPECT_EQ(scan.x_m.size(), 5u) << f.ending;
    EXPECT_TRUE(scan.time.empty() && scan.ring.empty()) << f.ending;
    EXPECT_EQ(scan.intensity.empty(), std::string(f.ending) != "kitti.bin") << f.ending;
  }
}

TEST_F(ScanFiles, may_have_other_fields_in_any_order_and_of_any_type)
{
  std::string data;
  for (int i = 0; i < 3; ++i)
  {
    put(data, static_cast<std::uint64_t>(1700000000000000000 + i * 1000000));
    for (int k = 0; k < 5; ++k) put(data, static_cast<std::int16_t>(-1));  // normals, say
    put(data, 1.5 * i);
    put(data, 0.25);
    put(data, static_cast<std::int8_t>(-i));
  }
  const ScanFile pcd = read_as(
      "binary.pcd",
      "VERSION .7\nFIELDS timestamp other z x y\nSIZE 8 2 8 8 1\nTYPE U I F F I\n"
      "COUNT 1 5 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA binary\n" +
          data);
  EXPECT_EQ(floats(pcd.z_m), (std::vector<float>{0, 1.5F, 3}));
  EXPECT_EQ(floats(pcd.x_m), (std::vector<float>{0.25F, 0.25F, 0.25F}));
  EXPECT_EQ(floats(pcd.y_m), (std::vector<float>{0, -1, -2}));
  ASSERT_EQ(pcd.time.size(), 3u);
  PointClock clock;
  clock.add(pcd, 1.7e9);
  const auto since = clock.times_since(1.7e9, pcd);
  ASSERT_EQ(since.size(), 3u);
  EXPECT_NEAR(since[2], 0.002, 1e-6);

  const ScanFile ply = read_as(
      "ascii.ply",
      "ply\r\nformat ascii 1.0\r\nobj_info by hand\r\nelement camera 1\r\nproperty int a\r\n"
      "property list uchar float b\r\nelement vertex 2\r\nproperty double Z\r\nproperty uchar y\r\n"
      "property float x\r\nproperty float scalar_Intensity\r\nproperty double scalar_GpsTime\r\n"
      "end_header\r\n7 2 1.5 2.5\r\n1.25 2 -3 40 100.5\r\n-1 255 1e2 50 100.6\r\n");
  EXPECT_EQ(floats(ply.x_m), (std::vector<float>{-3, 100}));
  EXPECT_EQ(floats(ply.y_m), (std::vector<float>{2, 255}));
  EXPECT_EQ(floats(ply.z_m), (std::vector<float>{1.25F, -1}));
  EXPECT_EQ(ply.intensity, (std::vector<float>{40, 50}));
  EXPECT_EQ(ply.time, (std::vector<double>{100.5, 100.6}));
}

TEST_F(ScanFiles, have_colours_in_each_form_in_which_they_are_written)
{
  const std::vector<std::uint32_t> colours{0xff8001, 0x0102ff};
  const auto rgb_of = [&](const std::string& ending, const std::string& bytes)
  {
    ScanFile scan;
    scan.values = "rgb";
    write_bytes(dir_ / ending, bytes);
    ending == "c.ply" ? read_ply(dir_ / ending, scan) : read_pcd(dir_ / ending, scan);
    EXPECT_TRUE(scan.intensity.empty());
    return scan.rgb;
  };
  const auto header = [](const std::string& type, const std::string& data)
  {
    return "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F " + type +
           "\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA " + data + "\n";
  };
  // With the opacity of PCL, so that the bits of the float are those of a NaN.
  std::string points;
  for (const std::uint32_t colour : colours)
  {
    for (const float at : {1.0F, 2.0F, 3.0F}) put(points, at);
    put(points, colour | 0xff000000);
  }
  EXPECT_EQ(rgb_of("b.pcd", header("F", "binary") + points), colours);
  EXPECT_EQ(rgb_of("u.pcd", header("U", "binary") + points), colours);
  EXPECT_EQ(rgb_of("t.pcd", header("U", "ascii") + "1 2 3 16744449\n1 2 3 66303\n"), colours);
  EXPECT_EQ(
      rgb_of("f.pcd", header("F", "ascii") + "1 2 3 2.34639707e-38\n1 2 3 9.29102921e-41\n"),
      colours);
  EXPECT_EQ(
      rgb_of(
          "c.ply",
          "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
          "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar "
          "blue\nend_header\n1 2 3 255 128 1\n1 2 3 1 2 255\n"),
      colours);
}

TEST_F(ScanFiles, of_ply_may_have_lists_before_their_vertices)
{
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement strip 2\nproperty list ushort int of\n"
      "property uchar tag\nelement nothing 1000000000000\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  for (const std::uint16_t count : {3, 0})
  {
    put(bytes, count, true);
    for (int i = 0; i < count; ++i) put(bytes, i, true);
    bytes += '\x07';
  }
  for (const float number : {1.0F, 2.0F, 3.0F}) put(bytes, number, true);
  EXPECT_EQ(read_as("big.ply", bytes).z_m, std::vector<double>{3});
}

/** Of scans at 10 Hz. `first`: of a scan, in the unit of the file; `stamped_s` of the first one. */
TEST_F(ScanFiles, say_how_their_points_are_timed)
{
  struct Row
  {
    double first, span, per_scan, stamped_s, seconds;
    const char* what;
  };
  const double now = 1.7e9;
  for (const Row& row :
       {Row{0, 0.0999, 0, now, 0, "seconds"},
        {-0.1, 0.1, 0, now, -0.1, "up to the stamp"},
        {0, 99.9, 0, now, 0, "ms"},
        {0, 99900, 0, now, 0, "us"},
        {0, 99.9e6, 0, now, 0, "ns"},
        {now, 0.1, 0.1, now, 0, "seconds since 1970"},
        {1e3 * now, 100, 100, now, 0, "ms since 1970"},
        {1e6 * now, 1e5, 1e5, now, 0, "us since 1970"},
        {1e9 * now, 1e8, 1e8, now, 0, "ns since 1970"},
        {1e9 * now, 2e6, 1e8, now, 0, "ns of a sensor that looks ahead"},
        {0, 0.1, 0.1, 0, 0, "seconds of a simulation"},
        {80000, 0.1, 0.1, now, 0, "seconds of the day"},
        {8e8, 1e5, 1e5, now, 0, "us of the hour"},
        {252818, 0.1, 0.1, now, 0, "seconds of the GPS week, 18 s ahead"},
        {now + 37 - 7200, 0.1, 0.1, now, 0, "PTP's time, in another zone"},
        {now + 2, 0.1, 0.1, now, NAN, "another clock"},
        {0, 0.1, 0.1, now, NAN, "seconds since the start of the driver"},
        {5e11, 1e8, 1e8, now, NAN, "ns since the start of the sensor"},
        {now, 0, 0, now, NAN, "seconds as floats"}})
  {
    SCOPED_TRACE(row.what);
    PointClock clock;
    ScanFile scan;
    for (int i = 0; i < 9; ++i)
    {
      const double first = row.first + i * row.per_scan;
      scan.time = std::vector<double>(100, first + row.span / 2);
      scan.time.front() = first;
      scan.time.back() = first + row.span;
      for (int k = 1; k < 99; ++k) scan.time[k] = first + row.span * k / 99;
      if (i == 3) scan.time[50] = first + 40 * row.span;  // broken
      clock.add(scan, row.stamped_s + 0.1 * i);
    }
    EXPECT_EQ(clock.is_understood(), !std::isnan(row.seconds)) << clock.remark();
    clock.leave_out_broken(scan);
    const auto since = clock.times_since(row.stamped_s + 0.8, scan);
    ASSERT_EQ(since.empty(), std::isnan(row.seconds));
    if (since.empty()) continue;
    EXPECT_NEAR(since[0], row.seconds, 1e-5);
  }
}

TEST_F(ScanFiles, have_the_first_times_that_are_not_all_the_same)
{
  const auto read = [&](const std::string& points)
  {
    return read_as(
        "ascii.pcd",
        "FIELDS x y z time_offset timestamp\nSIZE 4 4 4 4 8\nTYPE F F F F F\nWIDTH 3\n"
        "DATA ascii\n" +
            points);
  };
  EXPECT_EQ(read("1 1 1 0 9\n2 2 2 5 9\n3 3 3 7 9\n").time, (std::vector<double>{0, 5, 7}));
  EXPECT_EQ(read("1 1 1 0 9\n2 2 2 5 8\n3 3 3 7 7\n").time, (std::vector<double>{9, 8, 7}));
  const ScanFile broken = read("1 1 1 0 9\n2 2 2 nan 9\n3 3 3 7 9\n");
  EXPECT_EQ(broken.time, (std::vector<double>{0, 7}));
  EXPECT_EQ(broken.x_m, (std::vector<double>{1, 3}));
  EXPECT_EQ(broken.not_finite, 1u);
  const ScanFile none = read("1 1 1 nan nan\n2 2 2 nan nan\n3 3 3 nan nan\n");
  EXPECT_EQ(none.x_m.size(), 3u);
  PointClock clock;
  clock.add(none, 0);
  EXPECT_NE(clock.remark().find("the same for all points"), std::string::npos);
}

TEST_F(ScanFiles, lose_points_with_broken_times)
{
  ScanFile scan = read_as("binary.pcd", pcd_binary(spiral(100)));
  scan.time.clear();
  for (int i = 0; i < 100; ++i) scan.time.push_back(1e-3 * i);
  PointClock clock;
  for (int i = 0; i < 3; ++i) clock.add(scan, 0.1 * i);
  ScanFile broken = scan;
  broken.time[7] = 3.6;
  EXPECT_EQ(clock.leave_out_broken(broken), 1u);
  EXPECT_EQ(broken.x_m.size(), 99u);
  EXPECT_EQ(broken.time.size(), 99u);
  EXPECT_EQ(broken.x_m[7], scan.x_m[8]);
  broken = scan;
  for (int i = 0; i < 50; ++i) broken.time[i] = 3.6 + i;
  EXPECT_EQ(clock.leave_out_broken(broken), 0u);
  EXPECT_TRUE(broken.time.empty()) << "nobody knows which";
  EXPECT_EQ(broken.x_m.size(), 100u);
}

TEST_F(ScanFiles, of_pcd_say_where_the_scanner_was)
{
  const Points p = spiral(3);
  EXPECT_FALSE(read_as("binary.pcd", pcd_binary(p)).viewpoint);
  const auto scan = read_as("binary.pcd", pcd_binary(p, "1 2 3 0.70710678 0 0 0.70710678"));
  ASSERT_TRUE(scan.viewpoint);
  EXPECT_NEAR(scan.viewpoint->y(), 2, 1e-9);
  EXPECT_NEAR(scan.viewpoint->yaw(), M_PI / 2, 1e-6);
  refuses("binary.pcd", pcd_binary(p, "1 2 3 0 0 0 0"), {"VIEWPOINT", "norm 0"});
  refuses("binary.pcd", pcd_binary(p, "1 2 3 0 0 0"), {"VIEWPOINT", ":9:"});
}

TEST_F(ScanFiles, that_are_cut_name_the_place)
{
  const Points p = spiral(100);
  const auto cut = [](const std::string& bytes) { return bytes.substr(0, bytes.size() - 21); };
  refuses("kitti.bin", cut(kitti_bin(p)), {"1579 bytes", "cut at byte 1568"});
  refuses("ascii.pcd", cut(pcd_ascii(p)), {":111:", "numbers of 6"});
  refuses("binary.pcd", cut(pcd_binary(p)), {"100 points of 22 bytes", "cut after byte"});
  refuses("compressed.pcd", cut(pcd_compressed(p)), {"is cut", "compressed bytes"});
  refuses("ascii.ply", cut(ply_ascii(p)), {"numbers of 6"});
  refuses("little.ply", cut(ply_little(p)), {"100 points of 22 bytes", "cut after byte"});
  refuses("big.ply", cut(ply_big(p)), {"100 points of 22 bytes", "cut after byte"});
  for (const FileKind& f : kFileKinds) refuses(f.ending, "", {"is empty"});
  const auto before = [](const std::string& text, const std::string& word)
  { return text.substr(0, text.find(word)); };
  refuses("ascii.pcd", before(pcd_ascii(p), "DATA"), {"no line DATA", "cut in its header"});
  refuses("ascii.pcd", before(pcd_ascii(p), " 4 4 2"), {":4:", "SIZE has fewer words"});
  refuses("ascii.ply", before(ply_ascii(p), "end_h"), {"no line 'end_header'"});
}

TEST_F(ScanFiles, with_more_points_than_bytes_are_refused_at_once)
{
  const Points p = spiral(10);
  const auto pcd = [&](const std::string& bytes, const std::string& count) {
    return replaced(replaced(bytes, "WIDTH 10", "WIDTH " + count), "POINTS 10", "POINTS " + count);
  };
  refuses("binary.pcd", pcd(pcd_binary(p), "4000000000"), {"4000000000 points", "is cut"});
  refuses("binary.pcd", pcd(pcd_binary(p), "1000000000000"), {":7:", "whole number up to"});
  refuses("ascii.pcd", pcd(pcd_ascii(p), "4000000000"), {"10 of 4000000000 points"});
  refuses("compressed.pcd", pcd(pcd_compressed(p), "4000000000"), {"4000000000 points"});
  refuses("binary.pcd", pcd(pcd_binary(p), "-3"), {"'-3' is not a whole number"});
  for (const char* format : {"little.ply", "big.ply", "ascii.ply"})
    for (const FileKind& f : kFileKinds)
      if (f.ending == std::string(format))
        refuses(
            format, replaced(f.write(p), "vertex 10", "vertex 1000000000000"),
            {"1000000000000 points", "is cut"});

  std::string bomb = pcd_header(p, "binary_compressed");
  put(bomb, std::uint32_t{4});
  put(bomb, std::uint32_t{0xfffffff0});
  refuses("compressed.pcd", bomb + "abcd", {"4294967280", "cannot be"});
}

TEST_F(ScanFiles, of_pcd_have_one_number_a_point_for_each_field_that_is_read)
{
  const Points p = spiral(100);
  struct Coding
  {
    const char* ending;
    std::string bytes;
  };
  for (const auto& [ending, bytes] :
       {Coding{"ascii.pcd", pcd_ascii(p)}, Coding{"binary.pcd", pcd_binary(p)},
        Coding{"compressed.pcd", pcd_compressed(p)}})
  {
    const auto counts = [&bytes = bytes](const std::string& with)
    { return replaced(bytes, "COUNT 1 1 1 1 1 1", "COUNT " + with); };
    refuses(ending, counts("1 1 0 1 1 1"), {":6:", "'z'", "COUNT 0"});
    refuses(ending, counts("1 1 1 1 1 0"), {":6:", "'ring'", "COUNT 0"});
    // The points of a compressed file are then no longer as many as its bytes.
    const std::vector<std::string> words =
        ending == std::string("ascii.pcd") ? std::vector<std::string>{"'y' has 2 numbers a point"}
                                           : std::vector<std::string>{"of 26 bytes need"};
    refuses(ending, counts("1 2 1 1 1 1"), words);
  }
  Points fewer = p;
  fewer.x.resize(1);
  fewer.ring.clear();
  refuses(
      "binary.pcd",
      replaced(pcd_header(fewer, "binary"), "COUNT 1 1 1", "COUNT 1 1 2") + std::string(64, 'a'),
      {"'z' has 2 numbers a point"});
}

TEST_F(ScanFiles, of_a_wrong_kind_say_what_is_missing)
{
  const Points p = spiral(4);
  refuses("ascii.pcd", replaced(pcd_ascii(p), "x y z", "u v w"), {"no x", "u v w intensity"});
  refuses("ascii.ply", replaced(ply_ascii(p), "float y", "float why"), {"no y"});
  refuses("ascii.ply", replaced(ply_ascii(p), "element vertex", "element point"), {"'vertex'"});
  refuses("ascii.ply", replaced(ply_ascii(p), "float x", "quaternion x"), {":5:", "'quaternion'"});
  refuses("ascii.ply", replaced(ply_ascii(p), "float x", "list uchar float x"), {"a list, 'x'"});
  refuses("ascii.ply", replaced(ply_ascii(p), "ascii", "morse"), {":2:", "'morse'"});
  refuses("ascii.pcd", replaced(pcd_ascii(p), "DATA ascii", "DATA morse"), {":11:", "'morse'"});
  refuses("ascii.pcd", replaced(pcd_ascii(p), "SIZE 4", "SIZE 3"), {"SIZE 3"});
  refuses("ascii.pcd", replaced(pcd_ascii(p), "WIDTH 4", "WIDTH 5"), {"WIDTH x HEIGHT 5"});
  refuses("ascii.pcd", replaced(pcd_ascii(p), "-0.5 0 0 0", "-0.5 \x1b[2J 0 0"), {"'?[2J'"});
  std::string far = kitti_bin(p);
  const float far_m = 1e20F;
  std::memcpy(&far[32], &far_m, sizeof far_m);
  refuses("kitti.bin", far, {"point 2", "100 km"});
}

TEST_F(ScanFiles, unpack_pieces_that_are_said_twice)
{
  using namespace std::string_view_literals;  // which keep what follows a byte of 0
  const auto unpacked = [](std::string_view packed, std::size_t size)
  {
    std::string out;
    return unpack_lzf(packed, size, out) ? out : "refused";
  };
  EXPECT_EQ(unpacked("\2abc\40\2\40\0"sv, 9), "abcabcccc");
  EXPECT_EQ(unpacked("\0a\340\24\0"sv, 30), std::string(30, 'a'));
  EXPECT_EQ(unpacked("\0a\340\24\0"sv, 29), "refused");
  EXPECT_EQ(unpacked("\0a\40\1"sv, 4), "refused") << "before the beginning";
  for (const std::string_view cut : {"\5ab"sv, "\0a\340"sv, "\0a\40"sv, "\0a\340\24"sv})
    EXPECT_EQ(unpacked(cut, 30), "refused");
}

TEST_F(ScanFiles, that_are_damaged_in_a_thousand_ways_are_read_or_refused)
{
  std::mt19937 random(7);
  const Points p = spiral(20);
  std::size_t read_count = 0, refused = 0;
#ifndef TALUS_SANITIZER
  const talus::app::MemoryLimit limit(std::size_t{64} << 20);
#endif
  for (const FileKind& f : kFileKinds)
    for (int round = 0; round < 150; ++round)
    {
      std::string bytes = f.write(p);
      const auto at = [&] { return random() % bytes.size(); };
      for (std::uint32_t hits = random() % 4; hits < 4; ++hits) switch (random() % 5)
        {
          case 0:
            bytes[at()] = static_cast<char>(random());
            break;
          case 1:
            bytes[at()] = "0129 -e\n"[random() % 8];
            break;
          case 2:
            bytes.resize(at() + 1);
            break;
          case 3:
            bytes.insert(at(), bytes.substr(at(), random() % 40));
            break;
          default:
            bytes.insert(at(), "9999999999");
            break;
        }
      try
      {
        const ScanFile scan = read(f, bytes);
        ASSERT_EQ(scan.y_m.size(), scan.x_m.size());
        ASSERT_EQ(scan.z_m.size(), scan.x_m.size());
        ASSERT_LE(scan.x_m.size(), bytes.size());
        for (const double x : scan.x_m) ASSERT_TRUE(std::isfinite(x));
        PointClock clock;
        clock.add(scan, 1);
        clock.times_since(1, scan);
        ++read_count;
      }
      catch (const std::bad_alloc&)
      {
        ADD_FAILURE() << f.ending << ", round " << round << ": asks for memory that no byte holds";
      }
      catch (const std::runtime_error& e)
      {
        ASSERT_NE(std::string(e.what()).find(f.ending), std::string::npos) << e.what();
        ++refused;
      }
    }
  EXPECT_GT(read_count, 100u);
  EXPECT_GT(refused, 300u);
}
