#include <talus/site/tile_store.h>

#include <utility>

namespace talus::site
{
TileStore::TileStore(std::size_t memory_bytes, std::string folder)
    : memory_bytes_(memory_bytes), folder_(std::move(folder))
{
}
TileStore::~TileStore() = default;

const Tile* TileStore::find(const TileKey& key)
{
  const auto found = tiles_.find(key);
  return found == tiles_.end() ? nullptr : found->second.get();
}

Tile& TileStore::at(const TileKey& key)
{
  auto& tile = tiles_[key];
  if (!tile) tile = std::make_unique<Tile>();
  return *tile;
}

std::vector<TileKey> TileStore::keys() const
{
  std::vector<TileKey> keys;
  keys.reserve(tiles_.size());
  for (const auto& entry : tiles_) keys.push_back(entry.first);
  return keys;
}

}  // namespace talus::site
