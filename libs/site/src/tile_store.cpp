#include <talus/site/tile_store.h>

#include "tile_pack.h"

#include <talus/io/atomic_file.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <list>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace fs = std::filesystem;

namespace talus::site
{
namespace
{
constexpr const char* kTilesPrefix = ".talus-tiles.";

struct FileEnd
{
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileEnd>;

[[noreturn]] void fail_to_write(const fs::path& path, int error)
{
  throw std::runtime_error(
      path.string() + ": cannot write this tile of the map: " + std::strerror(error) +
      "; free some space there, or let more of the map stay in memory with a larger --memory");
}
[[noreturn]] void fail_to_read(const fs::path& path, const std::string& reason)
{
  throw std::runtime_error(
      path.string() + ": cannot read this tile of the map back: " + reason +
      "; leave the folder alone while the map is made, and run again (with a larger --memory fewer "
      "tiles go to disk)");
}

/** Whole or not at all. */
void write_packed(const fs::path& path, const std::vector<std::uint8_t>& packed)
{
  const fs::path part = path.string() + ".part";
  errno = 0;
  File file(std::fopen(part.c_str(), "wb"));
  if (!file) fail_to_write(path, errno);
  const bool written = std::fwrite(packed.data(), 1, packed.size(), file.get()) == packed.size();
  const bool is_whole = written && std::fclose(file.release()) == 0;
  if (is_whole && std::rename(part.c_str(), path.c_str()) == 0) return;
  const int error = errno;
  file.reset();
  std::remove(part.c_str());
  fail_to_write(path, error);
}

template <class T>
void read_packed(const fs::path& path, TilePacker& packer, T& tile)
{
  errno = 0;
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail_to_read(path, std::strerror(errno));
  std::vector<std::uint8_t> packed(TilePacker::kMaxPacked);
  packed.resize(std::fread(packed.data(), 1, packed.size(), file.get()));
  if (std::ferror(file.get())) fail_to_read(path, std::strerror(errno));
  try
  {
    packer.unpack(packed, tile);
  }
  catch (const std::runtime_error& e)
  {
    fail_to_read(path, e.what());
  }
}
}  // namespace

template <class T>
struct StoreOf<T>::Impl
{
  /** Of a tile. */
  struct Entry
  {
    std::unique_ptr<T> tile;  //!< null: packed, or on disk
    std::vector<std::uint8_t> packed;  //!< empty: not packed, or on disk
    bool is_on_disk = false;  //!< as it is in memory, if it is there
    std::uint64_t change = 0;  //!< when at() gave it out last, by the count of these calls
    typename std::list<Entry*>::iterator in_recent;  //!< if it is in memory
    const TileKey* key = nullptr;

    bool is_in_memory() const { return tile || !packed.empty(); }
  };

  Impl(std::size_t memory_bytes, std::string parent)
      : max_bytes(std::max(memory_bytes, kMinInMemory * sizeof(T))), folder(std::move(parent))
  {
  }

  /** To be read: what is packed stays packed. */
  const T& read(Entry& entry)
  {
    if (entry.packed.empty()) return open(entry);
    to_front(entry);
    if (read_last == &entry) return *copy;
    read_last = nullptr;
    if (!copy) copy = std::make_unique<T>();
    packer().unpack(entry.packed, *copy);
    read_last = &entry;
    return *copy;
  }

  /** To be changed. */
  T& open(Entry& entry)
  {
    if (entry.is_in_memory()) to_front(entry);
    if (entry.tile) return *entry.tile;
    std::unique_ptr<T> tile = room_for_tile();
    if (!entry.packed.empty())
      packer().unpack(entry.packed, *tile);
    else if (entry.is_on_disk)
      read_packed(path_of(*entry.key), packer(), *tile);
    else
      *tile = T();
    if (entry.is_in_memory()) leave_memory(entry);
    entry.tile = std::move(tile);
    enter_memory(entry);
    return *entry.tile;
  }

  void pack(Entry& entry)
  {
    if (!entry.tile) return;
    std::vector<std::uint8_t> bytes = packer().pack(*entry.tile);
    leave_memory(entry);
    entry.packed = std::move(bytes);
    packed_bytes += entry.packed.size();
    enter_memory(entry);
  }

  /** Tiles are used again: to ask the system for memory takes longer than to fill it. */
  std::unique_ptr<T> room_for_tile()
  {
    while ((made + (spare.empty() ? 1 : 0)) * sizeof(T) + packed_bytes > max_bytes)
      put_oldest_on_disk();
    if (spare.empty())
    {
      spare.push_back(std::make_unique<T>());
      ++made;
    }
    std::unique_ptr<T> tile = std::move(spare.back());
    spare.pop_back();
    return tile;
  }

  /** Of what is in memory. */
  void put_oldest_on_disk()
  {
    Entry& last = *recent.back();
    if (!last.is_on_disk)
      write_packed(path_of(*last.key), last.tile ? packer().pack(*last.tile) : last.packed);
    last.is_on_disk = true;
    leave_memory(last);
  }

  void erase(typename std::map<TileKey, Entry>::iterator it)
  {
    Entry& entry = it->second;
    if (entry.is_in_memory()) leave_memory(entry);
    std::error_code gone;
    if (entry.is_on_disk) fs::remove(path_of(it->first), gone);
    entries.erase(it);
  }

  void enter_memory(Entry& entry)
  {
    recent.push_front(&entry);
    entry.in_recent = recent.begin();
  }
  void leave_memory(Entry& entry)
  {
    recent.erase(entry.in_recent);
    if (read_last == &entry) read_last = nullptr;
    if (entry.tile) spare.push_back(std::move(entry.tile));
    packed_bytes -= entry.packed.size();
    entry.packed = std::vector<std::uint8_t>();  // {} would keep its memory
  }
  void to_front(Entry& entry) { recent.splice(recent.begin(), recent, entry.in_recent); }

  TilePacker& packer()
  {
    if (!packer_) packer_ = std::make_unique<TilePacker>();
    return *packer_;
  }

  fs::path path_of(const TileKey& key)
  {
    if (!hidden) make_folder();
    return hidden->path() / ("floor_" + std::to_string(key.floor) + "_x_" + std::to_string(key.x) +
                             "_y_" + std::to_string(key.y) + ".tile.zst");
  }
  void make_folder()
  {
    try
    {
      if (!folder.empty()) fs::create_directories(folder);
      io::HiddenFolder::remove_abandoned(folder, kTilesPrefix);
      hidden = std::make_unique<io::HiddenFolder>(folder, kTilesPrefix);
    }
    catch (const std::system_error& e)
    {
      fail_to_write(fs::path(folder) / "tiles", e.code().value());
    }
  }

  std::size_t max_bytes, packed_bytes = 0, made = 0;  //!< tiles, in use or not
  std::uint64_t changes = 0;
  std::string folder;
  std::vector<std::unique_ptr<T>> spare;
  std::unique_ptr<io::HiddenFolder> hidden;
  std::map<TileKey, Entry> entries;
  std::list<Entry*> recent;  //!< in memory, the one that was asked for last in front
  Entry* read_last = nullptr;  //!< of what is packed
  std::unique_ptr<T> copy;  //!< of that

 private:
  std::unique_ptr<TilePacker> packer_;
};

template <class T>
StoreOf<T>::StoreOf(std::size_t memory_bytes, std::string folder)
    : impl_(std::make_unique<Impl>(memory_bytes, std::move(folder)))
{
}
template <class T>
StoreOf<T>::~StoreOf() = default;

template <class T>
bool StoreOf<T>::has(const TileKey& key) const
{
  return impl_->entries.count(key) > 0;
}

template <class T>
const T* StoreOf<T>::find(const TileKey& key)
{
  const auto found = impl_->entries.find(key);
  return found == impl_->entries.end() ? nullptr : &impl_->read(found->second);
}

template <class T>
T& StoreOf<T>::at(const TileKey& key)
{
  const auto [found, is_new] = impl_->entries.try_emplace(key);
  found->second.key = &found->first;
  try
  {
    T& tile = impl_->open(found->second);
    found->second.is_on_disk = false;
    found->second.change = ++impl_->changes;
    return tile;
  }
  catch (...)
  {
    if (is_new) impl_->entries.erase(found);
    throw;
  }
}

template <class T>
void StoreOf<T>::pack(const TileKey& key)
{
  const auto found = impl_->entries.find(key);
  if (found != impl_->entries.end()) impl_->pack(found->second);
}

template <class T>
void StoreOf<T>::unpack_all()
{
  if (impl_->entries.size() * sizeof(T) > impl_->max_bytes) return;
  for (auto& [key, entry] : impl_->entries)
    if (!entry.packed.empty()) impl_->open(entry);
}

template <class T>
std::vector<TileKey> StoreOf<T>::take_changed(std::uint64_t& mark) const
{
  std::vector<TileKey> changed;
  for (const auto& [key, entry] : impl_->entries)
    if (entry.change > mark) changed.push_back(key);
  mark = impl_->changes;
  return changed;
}

template <class T>
void StoreOf<T>::erase(const TileKey& key)
{
  const auto found = impl_->entries.find(key);
  if (found != impl_->entries.end()) impl_->erase(found);
}

template <class T>
std::vector<TileKey> StoreOf<T>::keys() const
{
  std::vector<TileKey> keys;
  keys.reserve(impl_->entries.size());
  for (const auto& entry : impl_->entries) keys.push_back(entry.first);
  return keys;
}

template <class T>
std::size_t StoreOf<T>::tiles_in_memory() const
{
  return impl_->recent.size();
}

template <class T>
typename StoreOf<T>::Memory StoreOf<T>::memory() const
{
  return {impl_->made * sizeof(T), impl_->packed_bytes};
}

template class StoreOf<Tile>;
template class StoreOf<ChannelTile>;

}  // namespace talus::site
