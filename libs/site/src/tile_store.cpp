#include <talus/site/tile_store.h>

#include <talus/io/hidden_folder.h>
#include <zstd.h>

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
constexpr int kFastest = 1;

static_assert(std::is_trivially_copyable_v<SiteCell> && sizeof(SiteCell) == 32);

struct CompressorEnd
{
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};
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

/** Tiles in bytes of a file: compressed, with a checksum. Its memory is kept. */
class TileCodec
{
 public:
  TileCodec() : compressor_(ZSTD_createCCtx()), bytes_(ZSTD_compressBound(sizeof(Tile)))
  {
    if (!compressor_) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(compressor_.get(), ZSTD_c_compressionLevel, kFastest);
    ZSTD_CCtx_setParameter(compressor_.get(), ZSTD_c_checksumFlag, 1);
  }

  /** Whole or not at all. */
  void write(const fs::path& path, const Tile& tile)
  {
    const std::size_t size =
        ZSTD_compress2(compressor_.get(), bytes_.data(), bytes_.size(), &tile, sizeof(Tile));
    if (ZSTD_isError(size)) throw std::runtime_error(ZSTD_getErrorName(size));
    const fs::path part = path.string() + ".part";
    errno = 0;
    File file(std::fopen(part.c_str(), "wb"));
    if (!file) fail_to_write(path, errno);
    const bool written = std::fwrite(bytes_.data(), 1, size, file.get()) == size;
    const bool is_whole = written && std::fclose(file.release()) == 0;
    if (is_whole && std::rename(part.c_str(), path.c_str()) == 0) return;
    const int error = errno;
    file.reset();
    std::remove(part.c_str());
    fail_to_write(path, error);
  }

  void read(const fs::path& path, Tile& tile)
  {
    errno = 0;
    File file(std::fopen(path.c_str(), "rb"));
    if (!file) fail_to_read(path, std::strerror(errno));
    const std::size_t size = std::fread(bytes_.data(), 1, bytes_.size(), file.get());
    if (std::ferror(file.get())) fail_to_read(path, std::strerror(errno));
    if (ZSTD_decompress(&tile, sizeof(Tile), bytes_.data(), size) != sizeof(Tile))
      fail_to_read(path, "it is damaged");
  }

 private:
  std::unique_ptr<ZSTD_CCtx, CompressorEnd> compressor_;
  std::vector<char> bytes_;
};

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
class TileMemory
{
 public:
  Tile* take()
  {
    if (free_.empty()) add_block();
    Tile* const tile = free_.back();
    free_.pop_back();
    return tile;
  }
  void give_back(Tile* tile) { free_.push_back(tile); }

 private:
  static constexpr std::size_t kTiles = 4, kBlock = kTiles * sizeof(Tile);
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
      free_.push_back(static_cast<Tile*>(blocks_.back().get()) + i);
  }

  std::vector<std::unique_ptr<void, BlockEnd>> blocks_;
  std::vector<Tile*> free_;
};
static_assert(std::is_trivially_destructible_v<Tile>);
}  // namespace

struct TileStore::Impl
{
  /** Of a tile; those in memory stand in a list, the one that was asked for last in front. */
  struct Entry
  {
    Tile* tile = nullptr;  //!< null: on disk
    bool is_on_disk = false;  //!< as it is in memory, if it is there
    bool is_changed = false;  //!< since it was asked
    Entry *newer = nullptr, *older = nullptr;
    const TileKey* key = nullptr;
  };

  Impl(std::size_t memory_bytes, std::string parent)
      : most_in_memory(std::max(memory_bytes / sizeof(Tile), kFewestInMemory)),
        folder(std::move(parent))
  {
  }

  /** In memory, and in front. */
  Tile& load(const TileKey& key, Entry& entry)
  {
    if (entry.tile)
      unlink(entry);
    else
    {
      Tile* const tile = in_memory < most_in_memory ? memory.take() : put_oldest_on_disk();
      try
      {
        if (entry.is_on_disk)
          codec().read(path_of(key), *tile);
        else
          new (tile) Tile;
      }
      catch (...)
      {
        memory.give_back(tile);
        throw;
      }
      entry.tile = tile;
      ++in_memory;
    }
    link(entry);
    return *entry.tile;
  }

  /** Of what is in memory; that of its tile is free then. */
  Tile* put_oldest_on_disk()
  {
    Entry& last = *oldest;
    if (!last.is_on_disk) codec().write(path_of(*last.key), *last.tile);
    last.is_on_disk = true;
    unlink(last);
    --in_memory;
    return std::exchange(last.tile, nullptr);
  }

  void erase(std::map<TileKey, Entry>::iterator it)
  {
    Entry& entry = it->second;
    if (entry.tile)
    {
      unlink(entry);
      memory.give_back(entry.tile);
      --in_memory;
    }
    std::error_code gone;
    if (entry.is_on_disk) fs::remove(path_of(it->first), gone);
    entries.erase(it);
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

  TileCodec& codec()
  {
    if (!codec_) codec_ = std::make_unique<TileCodec>();
    return *codec_;
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
      for (const auto& left : io::HiddenFolder::all_in(folder, kTilesPrefix))
        io::HiddenFolder::remove_if_abandoned(left);
      hidden = std::make_unique<io::HiddenFolder>(folder, kTilesPrefix);
    }
    catch (const std::system_error& e)
    {
      fail_to_write(fs::path(folder) / "tiles", e.code().value());
    }
  }

  std::size_t most_in_memory, in_memory = 0;
  std::string folder;
  TileMemory memory;
  std::unique_ptr<io::HiddenFolder> hidden;
  std::map<TileKey, Entry> entries;
  Entry *newest = nullptr, *oldest = nullptr;

 private:
  std::unique_ptr<TileCodec> codec_;
};

TileStore::TileStore(std::size_t memory_bytes, std::string folder)
    : impl_(std::make_unique<Impl>(memory_bytes, std::move(folder)))
{
}
TileStore::~TileStore() = default;

bool TileStore::has(const TileKey& key) const { return impl_->entries.count(key) > 0; }

const Tile* TileStore::find(const TileKey& key)
{
  const auto found = impl_->entries.find(key);
  return found == impl_->entries.end() ? nullptr : &impl_->load(found->first, found->second);
}

Tile& TileStore::at(const TileKey& key)
{
  const auto [found, is_new] = impl_->entries.try_emplace(key);
  found->second.key = &found->first;
  try
  {
    Tile& tile = impl_->load(found->first, found->second);
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

std::vector<TileKey> TileStore::take_changed()
{
  std::vector<TileKey> changed;
  for (auto& [key, entry] : impl_->entries)
    if (std::exchange(entry.is_changed, false)) changed.push_back(key);
  return changed;
}

void TileStore::erase(const TileKey& key)
{
  const auto found = impl_->entries.find(key);
  if (found != impl_->entries.end()) impl_->erase(found);
}

std::vector<TileKey> TileStore::keys() const
{
  std::vector<TileKey> keys;
  keys.reserve(impl_->entries.size());
  for (const auto& entry : impl_->entries) keys.push_back(entry.first);
  return keys;
}

std::size_t TileStore::tiles_in_memory() const { return impl_->in_memory; }

}  // namespace talus::site
