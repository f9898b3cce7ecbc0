#include <talus/site/tile_store.h>

#include "tile_pack.h"

#include <talus/io/hidden_folder.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <new>
#include <stdexcept>
#include <system_error>
#include <type_traits>
#include <utility>

#if defined(__linux__)
#include <sys/mman.h>
#endif

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

#if defined(__linux__)
/** Memory that begins at a multiple of its size. malloc would take twice as much of it. */
void* map_aligned(std::size_t size)
{
  void* const all =
      mmap(nullptr, 2 * size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (all == MAP_FAILED) return nullptr;
  const std::size_t after = reinterpret_cast<std::uintptr_t>(all) % size;
  const std::size_t before = after == 0 ? 0 : size - after;
  char* const first = static_cast<char*>(all) + before;
  if (before > 0) munmap(all, before);
  munmap(first + size, size - before);
#if defined(MADV_HUGEPAGE)
  madvise(first, size, MADV_HUGEPAGE);
#endif
  return first;
}
void unmap(void* first, std::size_t size) { munmap(first, size); }
#else
void* map_aligned(std::size_t size) { return std::aligned_alloc(size, size); }
void unmap(void* first, std::size_t) { std::free(first); }
#endif

/** Memory of tiles, in large pages where there are such: a drive comes to a new tile every few
 * metres, and small pages would cost more than to fill it. */
template <class T>
class TileMemory
{
 public:
  T* take()
  {
    if (free_.empty()) add_block();
    T* const tile = free_.back();
    free_.pop_back();
    return tile;
  }
  void give_back(T* tile) { free_.push_back(tile); }
  /** All that was ever needed at once. */
  std::size_t bytes() const { return blocks_.size() * kBlock; }
  /** With the next tile. */
  std::size_t bytes_to_take() const { return bytes() + (free_.empty() ? kBlock : 0); }

 private:
  static constexpr std::size_t kTiles = 4, kBlock = kTiles * sizeof(T);
  struct BlockEnd
  {
    void operator()(void* block) const { unmap(block, kBlock); }
  };
  void add_block()
  {
    blocks_.emplace_back(map_aligned(kBlock));
    if (!blocks_.back()) throw std::bad_alloc();
    free_.reserve(kTiles * blocks_.size());
    for (std::size_t i = 0; i < kTiles; ++i)
      free_.push_back(static_cast<T*>(blocks_.back().get()) + i);
  }

  std::vector<std::unique_ptr<void, BlockEnd>> blocks_;
  std::vector<T*> free_;
};
static_assert(std::is_trivially_destructible_v<Tile>);
static_assert(std::is_trivially_destructible_v<ChannelTile>);
}  // namespace

template <class T>
struct StoreOf<T>::Impl
{
  /** Of a tile; those in memory stand in a list, the one that was asked for last in front. */
  struct Entry
  {
    T* tile = nullptr;  //!< null: packed, or on disk
    std::vector<std::uint8_t> packed;  //!< empty: not packed, or on disk
    bool is_on_disk = false;  //!< as it is in memory, if it is there
    bool is_changed = false;  //!< since it was asked
    Entry *newer = nullptr, *older = nullptr;
    const TileKey* key = nullptr;

    bool is_in_memory() const { return tile || !packed.empty(); }
  };

  Impl(std::size_t memory_bytes, std::string parent)
      : most_bytes(std::max(memory_bytes, kMinInMemory * sizeof(T))), folder(std::move(parent))
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
    T* const tile = room_for_tile();
    try
    {
      if (!entry.packed.empty())
        packer().unpack(entry.packed, *tile);
      else if (entry.is_on_disk)
        read_packed(path_of(*entry.key), packer(), *tile);
      else
        new (tile) T;
    }
    catch (...)
    {
      memory.give_back(tile);
      throw;
    }
    if (entry.is_in_memory()) leave_memory(entry);
    entry.tile = tile;
    enter_memory(entry);
    return *tile;
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

  T* room_for_tile()
  {
    while (memory.bytes_to_take() + packed_bytes > most_bytes) put_oldest_on_disk();
    return memory.take();
  }

  /** Of what is in memory. */
  void put_oldest_on_disk()
  {
    Entry& last = *oldest;
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
    link(entry);
    ++in_memory;
  }
  void leave_memory(Entry& entry)
  {
    unlink(entry);
    --in_memory;
    if (read_last == &entry) read_last = nullptr;
    if (entry.tile) memory.give_back(entry.tile);
    packed_bytes -= entry.packed.size();
    entry.tile = nullptr;
    entry.packed = std::vector<std::uint8_t>();  // {} would keep its memory
  }
  void to_front(Entry& entry)
  {
    unlink(entry);
    link(entry);
  }
  void link(Entry& entry)
  {
    entry.newer = nullptr;
    entry.older = newest;
    (newest ? newest->newer : oldest) = &entry;
    newest = &entry;
  }
  void unlink(Entry& entry)
  {
    (entry.newer ? entry.newer->older : newest) = entry.older;
    (entry.older ? entry.older->newer : oldest) = entry.newer;
  }

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

  std::size_t most_bytes, packed_bytes = 0, in_memory = 0;
  std::string folder;
  TileMemory<T> memory;
  std::unique_ptr<io::HiddenFolder> hidden;
  std::map<TileKey, Entry> entries;
  Entry *newest = nullptr, *oldest = nullptr;
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
    found->second.is_changed = true;
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
  if (impl_->entries.size() * sizeof(T) > impl_->most_bytes) return;
  for (auto& [key, entry] : impl_->entries)
    if (!entry.packed.empty()) impl_->open(entry);
}

template <class T>
std::vector<TileKey> StoreOf<T>::take_changed()
{
  std::vector<TileKey> changed;
  for (auto& [key, entry] : impl_->entries)
    if (std::exchange(entry.is_changed, false)) changed.push_back(key);
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
  return impl_->in_memory;
}

template <class T>
typename StoreOf<T>::Memory StoreOf<T>::memory() const
{
  return {impl_->memory.bytes(), impl_->packed_bytes};
}

template class StoreOf<Tile>;
template class StoreOf<ChannelTile>;

}  // namespace talus::site
