// Cyclone DDS asks a type what to do with its samples: here they are their bytes.
#include "raw_type.h"

#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

namespace talus::live
{
namespace
{
const RawMessage& raw(const ddsi_serdata* d) { return *static_cast<const RawMessage*>(d); }

RawMessage* new_message(const ddsi_sertype* type, ddsi_serdata_kind kind)
{
  auto* message = new RawMessage();
  ddsi_serdata_init(message, type, kind);
  message->hash = type->serdata_basehash;  // there are no keys
  return message;
}

void pad(std::string& bytes) { bytes.resize((bytes.size() + 3) / 4 * 4); }

std::uint32_t size_of(const ddsi_serdata* d)
{
  return static_cast<std::uint32_t>(raw(d).bytes.size());
}
bool same_key(const ddsi_serdata*, const ddsi_serdata*) { return true; }
void free_message(ddsi_serdata* d) { delete static_cast<RawMessage*>(d); }

ddsi_serdata* from_fragments(
    const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment, std::size_t size)
{
  if (size > kMaxMessage_bytes) return nullptr;
  auto* message = new_message(type, kind);
  message->bytes.resize(size);
  for (std::uint32_t end = 0; fragment; fragment = fragment->nextfrag)
  {
    const auto first = std::max(fragment->min, end);
    if (fragment->maxp1 <= end) continue;
    const auto* payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    end = std::min(fragment->maxp1, static_cast<std::uint32_t>(size));
    std::memcpy(&message->bytes[first], payload + (first - fragment->min), end - first);
  }
  pad(message->bytes);
  return message;
}

ddsi_serdata* from_parts(
    const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
    const ddsrt_iovec_t* parts, std::size_t size)
{
  if (size > kMaxMessage_bytes) return nullptr;
  auto* message = new_message(type, kind);
  for (ddsrt_msg_iovlen_t i = 0; i < count; ++i)
    message->bytes.append(static_cast<const char*>(parts[i].iov_base), parts[i].iov_len);
  pad(message->bytes);
  return message;
}

ddsi_serdata* from_key(const ddsi_sertype* type, const ddsi_keyhash*)
{
  return new_message(type, SDK_KEY);
}

/** For dds_write() and dds_take(), whose samples are strings. */
ddsi_serdata* from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample)
{
  auto* message = new_message(type, kind);
  if (kind == SDK_DATA) message->bytes = *static_cast<const std::string*>(sample);
  return message;
}
bool to_sample(const ddsi_serdata* d, void* sample, void**, void*)
{
  *static_cast<std::string*>(sample) = raw(d).bytes;
  return true;
}

void to_bytes(const ddsi_serdata* d, std::size_t from, std::size_t size, void* out)
{
  std::memcpy(out, raw(d).bytes.data() + from, size);
}
ddsi_serdata* lend_bytes(
    const ddsi_serdata* d, std::size_t from, std::size_t size, ddsrt_iovec_t* out)
{
  out->iov_base = const_cast<char*>(raw(d).bytes.data()) + from;
  out->iov_len = static_cast<ddsrt_iov_len_t>(size);
  return ddsi_serdata_ref(d);
}
void return_bytes(ddsi_serdata* d, const ddsrt_iovec_t*) { ddsi_serdata_unref(d); }

ddsi_serdata* without_type(const ddsi_serdata* d)
{
  auto* message = new_message(d->type, SDK_KEY);
  message->type = nullptr;
  return message;
}
bool key_to_sample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return true; }

std::size_t print(const ddsi_sertype* type, const ddsi_serdata*, char* text, std::size_t size)
{
  return static_cast<std::size_t>(std::snprintf(text, size, "%s", type->type_name));
}
void key_hash(const ddsi_serdata*, ddsi_keyhash* hash, bool) { *hash = {}; }

ddsi_serdata_ops message_ops()
{
  ddsi_serdata_ops ops{};
  ops.eqkey = same_key;
  ops.get_size = size_of;
  ops.from_ser = from_fragments;
  ops.from_ser_iov = from_parts;
  ops.from_keyhash = from_key;
  ops.from_sample = from_sample;
  ops.to_ser = to_bytes;
  ops.to_ser_ref = lend_bytes;
  ops.to_ser_unref = return_bytes;
  ops.to_sample = to_sample;
  ops.to_untyped = without_type;
  ops.untyped_to_sample = key_to_sample;
  ops.free = free_message;
  ops.print = print;
  ops.get_keyhash = key_hash;
  return ops;
}

void free_type(ddsi_sertype* type)
{
  ddsi_sertype_fini(type);
  delete type;
}
void zero_samples(const ddsi_sertype*, void*, std::size_t) {}
void realloc_samples(void** samples, const ddsi_sertype*, void*, std::size_t, std::size_t count)
{
  for (std::size_t i = 0; i < count; ++i) samples[i] = nullptr;
}
void free_samples(const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {}
bool same_type(const ddsi_sertype*, const ddsi_sertype*) { return true; }  // the name is compared
std::uint32_t hash_of_type(const ddsi_sertype*) { return 0; }
/** There is one representation only, XCDR1. */
ddsi_sertype* derived(
    const ddsi_sertype* type, dds_data_representation_id_t,
    dds_type_consistency_enforcement_qospolicy_t)
{
  return const_cast<ddsi_sertype*>(type);
}

ddsi_sertype_ops type_ops()
{
  ddsi_sertype_ops ops{};
  ops.version = ddsi_sertype_v0;
  ops.free = free_type;
  ops.zero_samples = zero_samples;
  ops.realloc_samples = realloc_samples;
  ops.free_samples = free_samples;
  ops.equal = same_type;
  ops.hash = hash_of_type;
  ops.derive_sertype = derived;
  return ops;
}
}  // namespace

ddsi_sertype* make_raw_type(const std::string& name)
{
  static const ddsi_serdata_ops of_messages = message_ops();
  static const ddsi_sertype_ops of_types = type_ops();
  auto* type = new ddsi_sertype();
  ddsi_sertype_init_flags(
      type, name.c_str(), &of_types, &of_messages, DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

RawMessage* make_raw_message(const ddsi_sertype* type, std::string bytes)
{
  auto* message = new_message(type, SDK_DATA);
  message->bytes = std::move(bytes);
  pad(message->bytes);
  return message;
}

}  // namespace talus::live
