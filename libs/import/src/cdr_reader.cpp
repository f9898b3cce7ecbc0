#include "cdr_reader.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/config.h>
#include <fastcdr/exceptions/Exception.h>

namespace talus::import
{
namespace
{
using eprosima::fastcdr::Cdr;

constexpr std::size_t kEncapsulation = 4;

std::string_view body_of(std::string_view message)
{
  if (message.size() < kEncapsulation)
    throw CdrError("has only " + std::to_string(message.size()) + " bytes");
  if (message[0] != 0 || (message[1] != 0 && message[1] != 1))
    throw CdrError(
        "is not serialized as plain CDR (it begins with " +
        std::to_string(static_cast<unsigned char>(message[0])) + " " +
        std::to_string(static_cast<unsigned char>(message[1])) + " instead of 0 0 or 0 1)");
  return message.substr(kEncapsulation);
}

Cdr cdr_of(eprosima::fastcdr::FastBuffer& buffer, bool is_little)
{
  const auto order = is_little ? Cdr::LITTLE_ENDIANNESS : Cdr::BIG_ENDIANNESS;
#if FASTCDR_VERSION_MAJOR >= 2
  return Cdr(buffer, order, eprosima::fastcdr::CdrVersion::CORBA_CDR);
#else
  return Cdr(buffer, order, Cdr::CORBA_CDR);
#endif
}

const char* position_of(Cdr& cdr)
{
#if FASTCDR_VERSION_MAJOR >= 2
  return cdr.get_current_position();
#else
  return cdr.getCurrentPosition();
#endif
}
}  // namespace

struct CdrReader::Impl
{
  explicit Impl(std::string_view message)
      : body(body_of(message)),
        buffer(const_cast<char*>(body.data()), body.size()),  // which is only read
        cdr(cdr_of(buffer, message[1] == 1))
  {
  }
  std::size_t left()
  {
    return static_cast<std::size_t>(body.data() + body.size() - position_of(cdr));
  }

  std::string_view body;
  eprosima::fastcdr::FastBuffer buffer;
  Cdr cdr;
};

CdrReader::CdrReader(std::string_view message) : impl_(std::make_unique<Impl>(message)) {}
CdrReader::~CdrReader() = default;

template <class T>
T CdrReader::number()
{
  T value{};
  try
  {
    impl_->cdr.deserialize(value);
  }
  catch (const eprosima::fastcdr::exception::Exception&)
  {
    throw CdrError("is cut short or damaged");
  }
  return value;
}

bool CdrReader::flag() { return u8() != 0; }
std::uint8_t CdrReader::u8() { return number<std::uint8_t>(); }
std::int32_t CdrReader::i32() { return number<std::int32_t>(); }
std::uint32_t CdrReader::u32() { return number<std::uint32_t>(); }
std::uint64_t CdrReader::u64() { return number<std::uint64_t>(); }
double CdrReader::f64() { return number<double>(); }
std::string CdrReader::string() { return number<std::string>(); }

std::uint32_t CdrReader::count(std::size_t min_bytes)
{
  const std::uint32_t n = u32();
  if (n > impl_->left() / min_bytes)
    throw CdrError(
        "holds " + std::to_string(n) + " elements by its count, but only " +
        std::to_string(impl_->left()) + " bytes");
  return n;
}

std::string_view CdrReader::rest() { return {position_of(impl_->cdr), impl_->left()}; }

std::string_view CdrReader::bytes()
{
  const std::uint32_t n = count(1);
  const std::string_view at(position_of(impl_->cdr), n);
  impl_->cdr.jump(n);
  return at;
}

}  // namespace talus::import
