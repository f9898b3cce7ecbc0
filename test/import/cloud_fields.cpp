// Fields of a PointCloud2: which bytes of a point they have, and how many numbers.
#include <gtest/gtest.h>

#include "bag_messages.h"
#include "cdr_reader.h"
#include "log_files.h"
#include "scan_formats.h"

using namespace talus::import;
using namespace talus::test;

namespace
{
constexpr std::uint8_t kFloat32 = 7;

struct Field
{
  const char* name;
  std::uint32_t offset, count;
};

/** A message as it is in a bag: CDR, little-endian; texts and numbers of four bytes aligned. */
class Message
{
 public:
  void put_word(std::uint32_t value)
  {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    put(bytes_, value);
  }
  void put_text(const std::string& text)
  {
    put_word(static_cast<std::uint32_t>(text.size() + 1));
    bytes_ += text + '\0';
  }
  void put_byte(std::uint8_t value) { put(bytes_, value); }
  void add(const std::string& bytes) { bytes_ += bytes; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_{"\0\1\0\0", 4};
};

/** Two points of 16 bytes: (1, 2, 3, 4) and (5, 6, 7, 8). */
std::string cloud_with(const std::vector<Field>& fields)
{
  Message message;
  for (const std::uint32_t word : {0U, 0U}) message.put_word(word);  // stamp
  message.put_text("lidar");
  for (const std::uint32_t word : {1U, 2U}) message.put_word(word);  // height, width
  message.put_word(static_cast<std::uint32_t>(fields.size()));
  for (const Field& field : fields)
  {
    message.put_text(field.name);
    message.put_word(field.offset);
    message.put_byte(kFloat32);
    message.put_word(field.count);
  }
  message.put_byte(0);  // little-endian
  for (const std::uint32_t word : {16U, 32U, 32U}) message.put_word(word);  // steps, bytes
  std::string points;
  for (int i = 1; i <= 8; ++i) put(points, static_cast<float>(i));
  message.add(points);
  return message.bytes();
}

ScanFile read(const std::vector<Field>& fields, const std::string& values = "")
{
  const std::string message = cloud_with(fields);
  ScanFile scan;
  scan.values = values;
  collect_points(read_cloud(message), "cloud 7", scan);
  return scan;
}
}  // namespace

TEST(CloudFields, have_one_number_a_point)
{
  EXPECT_EQ(read({{"x", 0, 1}, {"y", 4, 1}, {"z", 8, 1}}).z_m[1], 7);
  EXPECT_EQ(read({{"x", 0, 0}, {"y", 4, 0}, {"z", 8, 0}}).z_m[1], 7) << "as PCL reads it";
  EXPECT_EQ(read({{"x", 0, 1}, {"y", 4, 1}, {"z", 8, 1}, {"rgb", 4, 3}}).z_m[1], 7);
  expect_error(
      [] {
        read({{"x", 0, 1}, {"y", 4, 1}, {"z", 8, 2}});
      },
      {"cloud 7", "'z' has 2 numbers a point"});
}

TEST(CloudFields, have_bytes_of_their_own_inside_of_the_point)
{
  expect_error([] { read({{"x", 0, 1}, {"y", 4, 1}, {"z", 13, 1}}); }, {"'z' outside"});
  expect_error([] { read({{"x", 0, 1}, {"y", 4, 0}, {"z", 4, 0}}); }, {"'y' in the same bytes"});
  expect_error([] { read({{"x", 0, 1}, {"y", 2, 1}, {"z", 8, 1}}); }, {"'x' in the same bytes"});
}

/** Of a colour that is called a float: its bits, here those of 4 and 8. */
TEST(CloudFields, that_are_asked_for_are_the_values)
{
  const std::vector<Field> fields{{"x", 0, 1}, {"y", 4, 1}, {"z", 8, 1}, {"rgb", 12, 1}};
  EXPECT_TRUE(read(fields).rgb.empty()) << "nobody asked";
  EXPECT_EQ(read(fields, "rgb").rgb, (std::vector<std::uint32_t>{0x800000, 0x000000}));
  EXPECT_EQ(
      read({{"x", 0, 1}, {"y", 4, 1}, {"z", 8, 1}, {"Label", 12, 1}}, "label").intensity,
      (std::vector<float>{4, 8}));
  expect_error([&] { read(fields, "label"); }, {"cloud 7", "no 'label'", "x y z rgb", "--values"});
}
