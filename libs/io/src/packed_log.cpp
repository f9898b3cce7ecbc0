#include <talus/io/packed_log.h>

#include <isa-l/crc.h>
#include <isa-l/igzip_lib.h>
#include <mrpt/io/CStream.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>
#include <talus/io/atomic_file.h>
#include <talus/io/mrpt_error.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace talus::io
{
/** A gz file. Coordinates hardly pack, and to unpack them takes as long as to map them: a part that
 * stays almost as large stays as it is. */
struct PackedLog::Impl : mrpt::io::CStream
{
  explicit Impl(const std::string& path)
      : file_(path, std::ios::binary), part_(kPart), packed_(2 * kPart), work_(kWork)
  {
    begin();
  }
  bool is_good() const { return file_.good(); }
  /** Ends what was written since the last call; false: it is not written. */
  bool end()
  {
    if (!std::exchange(is_begun_, false)) return file_.good();
    put_part();
    constexpr std::string_view kLast("\x01\0\0\xff\xff", 5);  // a block of no bytes
    file_.write(kLast.data(), kLast.size());
    put(std::exchange(checksum_, 0), 4);
    put(std::exchange(bytes_, 0), 4);
    return file_.flush().good();
  }

  std::size_t Write(const void* from, std::size_t count) override
  {
    if (!is_begun_) begin();
    const auto* at = static_cast<const std::uint8_t*>(from);
    for (std::size_t left = count; left > 0;)
    {
      const std::size_t n = std::min(left, kPart - used_);
      std::memcpy(part_.data() + used_, at, n);
      used_ += n, at += n, left -= n;
      if (used_ == kPart) put_part();
    }
    bytes_ += static_cast<std::uint32_t>(count);
    return file_ ? count : 0;
  }
  std::size_t Read(void*, std::size_t) override { return 0; }
  std::uint64_t Seek(std::int64_t, TSeekOrigin) override { return 0; }
  std::uint64_t getTotalBytesCount() const override { return bytes_; }
  std::uint64_t getPosition() const override { return bytes_; }

 private:
  static constexpr std::size_t kPart = 32768, kWork = ISAL_DEF_LVL1_DEFAULT;

  void begin()
  {
    constexpr std::string_view kBegin("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);
    file_.write(kBegin.data(), kBegin.size());
    is_begun_ = true;
  }
  void put(std::uint32_t number, int bytes)
  {
    for (int i = 0; i < bytes; ++i) file_.put(static_cast<char>(number >> (8 * i)));
  }
  /** As blocks that end with a byte. */
  void put_part()
  {
    constexpr double kWorthIt = 0.8;
    const auto size = static_cast<std::uint32_t>(used_);
    checksum_ = ::crc32_gzip_refl(checksum_, part_.data(), used_);
    ::isal_deflate_stateless_init(&packer_);
    packer_.level = 1;
    packer_.level_buf = work_.data();
    packer_.level_buf_size = static_cast<std::uint32_t>(work_.size());
    packer_.flush = FULL_FLUSH;
    packer_.next_in = part_.data();
    packer_.avail_in = size;
    packer_.next_out = packed_.data();
    packer_.avail_out = static_cast<std::uint32_t>(packed_.size());
    const bool is_packed = ::isal_deflate_stateless(&packer_) == COMP_OK &&
                           packer_.total_out < kWorthIt * static_cast<double>(size);
    if (is_packed)
      file_.write(reinterpret_cast<const char*>(packed_.data()), packer_.total_out);
    else
    {
      put(0, 1);
      put(size, 2);
      put(~size, 2);
      file_.write(reinterpret_cast<const char*>(part_.data()), size);
    }
    used_ = 0;
  }

  std::ofstream file_;
  std::vector<std::uint8_t> part_, packed_, work_;
  std::size_t used_ = 0;
  isal_zstream packer_{};
  bool is_begun_ = false;  //!< what end() ends
  std::uint32_t checksum_ = 0, bytes_ = 0;  //!< of that
};

PackedLog::PackedLog(std::string path, const std::string& name)
    : path_(std::move(path)),
      name_(name.empty() ? path_ : name),
      file_(std::make_unique<Impl>(path_))
{
  if (!file_->is_good()) fail("cannot be written");
}
PackedLog::~PackedLog()
{
  if (file_) file_->end();
}

void PackedLog::fail(const std::string& what) const
{
  throw std::runtime_error(name_ + ": " + what + "; is the disk full? Free some space there");
}

void PackedLog::flush()
{
  if (!file_->end()) fail("cannot be written");
}

void PackedLog::write(const mrpt::serialization::CSerializable& object)
{
  try
  {
    auto archive = mrpt::serialization::archiveFrom(*file_);
    archive << object;
  }
  catch (const std::exception& e)
  {
    fail("could not be written (" + reason_of(e) + ")");
  }
}

void PackedLog::close()
{
  file_->end();
  file_.reset();
  require_complete_packed(path_, name_);
}

}  // namespace talus::io
