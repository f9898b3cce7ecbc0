#include "whole.h"

#include <talus/site/site_mapper.h>

#include <filesystem>

namespace fs = std::filesystem;

namespace talus::bench
{
namespace
{
constexpr double kMB = 1024 * 1024;

class KeptWhole : public Whole
{
 public:
  KeptWhole(double resolution_m, double memory_MB, const std::string& folder)
      : folder_(folder),
        site_(resolution_m, static_cast<std::size_t>(memory_MB * kMB), folder),
        mapper_(site_)
  {
  }
  void update(ElevationMapper& map, const Frame& frame) override { mapper_.update(map, frame); }
  std::size_t tiles() const override { return site_.tiles.keys().size(); }
  double tiles_MB() const override
  {
    const site::TileStore::Memory memory = site_.tiles.memory();
    return static_cast<double>(memory.open + memory.packed) / kMB;
  }
  double disk_MB() const override
  {
    std::uintmax_t bytes = 0;
    if (!fs::exists(folder_)) return 0;
    for (const fs::directory_entry& hidden : fs::directory_iterator(folder_))
      if (hidden.is_directory() && hidden.path().filename().string().rfind(".talus-tiles.", 0) == 0)
        for (const fs::directory_entry& tile : fs::directory_iterator(hidden.path()))
          bytes += tile.file_size();
    return static_cast<double>(bytes) / kMB;
  }

 private:
  std::string folder_;
  site::Site site_;
  site::SiteMapper mapper_;
};
}  // namespace

std::unique_ptr<Whole> make_whole(double resolution_m, double memory_MB, const std::string& folder)
{
  return std::make_unique<KeptWhole>(resolution_m, memory_MB, folder);
}

}  // namespace talus::bench
