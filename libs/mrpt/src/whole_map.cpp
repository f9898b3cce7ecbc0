#include "whole_map.h"

#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>
#include <talus/site/tile_bytes.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace talus
{
namespace
{
constexpr std::size_t kMemory_bytes = 512U << 20;
constexpr int kMaxCells = 4096;  // along a side of what is shown and asked at once
constexpr std::size_t kMaxTileBytes = 1U << 20;
constexpr const char* kWhole = "the whole map";

void copy_tiles(site::TileStore& from, site::TileStore& to)
{
  for (const site::TileKey& key : from.keys()) to.at(key) = *from.find(key);
}

void write_state(mrpt::serialization::CArchive& out, const site::SiteMapper::State& s)
{
  out << static_cast<std::int32_t>(s.floor) << static_cast<std::int32_t>(s.floors)
      << static_cast<std::uint8_t>(s.choice) << s.base.x_m << s.base.y_m << s.base.z_m << s.calm.x_m
      << s.calm.y_m << s.calm.z_m << static_cast<std::int32_t>(s.frames_calm) << s.stamp_s
      << s.kept_s;
}

site::SiteMapper::State read_state(detail::StreamReader& in)
{
  using Choice = site::SiteMapper::Choice;
  const auto place = [&]
  {
    site::SiteMapper::Position p;
    for (double* v : {&p.x_m, &p.y_m, &p.z_m}) *v = in.number<double>(kWhole);
    return p;
  };
  site::SiteMapper::State s;
  s.floor = in.number<std::int32_t>(kWhole);
  s.floors = in.number<std::int32_t>(kWhole);
  const auto choice = in.number<std::uint8_t>(kWhole);
  if (choice > static_cast<std::uint8_t>(Choice::LeftFloor)) in.fail(kWhole);
  s.choice = static_cast<Choice>(choice);
  s.base = place();
  s.calm = place();
  s.frames_calm = in.number<std::int32_t>(kWhole);
  s.stamp_s = in.number<double>(kWhole);
  s.kept_s = in.number<double>(kWhole);
  if (s.floor < 0 || s.floors <= s.floor || s.frames_calm < 0 || !std::isfinite(s.base.z_m))
    in.fail(kWhole);
  return s;
}

using Path = std::vector<site::WayPoint>;

void write_path(mrpt::serialization::CArchive& out, const Path& path)
{
  out << static_cast<std::uint64_t>(path.size());
  for (const auto& p : path) out << p.x_m << p.y_m << p.z_m << p.floor;
}

Path read_path(detail::StreamReader& in)
{
  Path path;
  for (auto left = in.number<std::uint64_t>(kWhole); left > 0; left--)
  {
    site::WayPoint p{};
    for (float* v : {&p.x_m, &p.y_m, &p.z_m}) *v = in.number<float>(kWhole);
    p.floor = in.number<std::int32_t>(kWhole);
    if (!std::isfinite(p.x_m) || !std::isfinite(p.y_m) || !std::isfinite(p.z_m)) in.fail(kWhole);
    path.push_back(p);
  }
  return path;
}

/** For tiles that find no room in memory: a folder that is needed by few maps must not stop all. */
std::string folder_of_tiles()
{
  std::error_code none;
  const auto folder = std::filesystem::temp_directory_path(none);
  return none ? "." : folder.string();
}
}  // namespace

WholeMap::WholeMap(double resolution_m)
    : site_(resolution_m, kMemory_bytes, folder_of_tiles()), mapper_(site_)
{
}

WholeMap::WholeMap(const WholeMap& o) : WholeMap(o.site_.resolution_m)
{
  // A tile that is on disk comes into memory to be read: nothing that anybody sees changes.
  copy_tiles(const_cast<WholeMap&>(o).site_.tiles, site_.tiles);
  site_.origin = o.site_.origin;
  site_.ways = o.site_.ways;
  mapper_.go_on(o.mapper_.state());
  loaded_ = o.loaded_;
}

FrameReport WholeMap::update(ElevationMapper& map, const Frame& frame)
{
  forget_floor();
  return mapper_.update(map, frame);
}

site::Site& WholeMap::site(const ElevationMapper& map)
{
  mapper_.keep_window(map);
  return site_;
}

site::Site& WholeMap::site_in_hindsight(const ElevationMapper& map)
{
  mapper_.keep_window(map);
  mapper_.look_back(map);
  return site_;
}

const MapSnapshot& WholeMap::floor(const ElevationMapper& map)
{
  if (shown_) return *shown_;
  const site::SiteMapper::Position base = mapper_.state().base;
  shown_ = &floor_map_.update(
      site(map), mapper_.floor(), map.parameters(), kMaxCells, base.x_m, base.y_m);
  return *shown_;
}

void WholeMap::load(const std::string& path)
{
  site::read_site_files(path, site_);
  // The mapper counts the floors that there are, and begins a way of its own.
  mapper_.go_on(site::SiteMapper(site_).state());
  loaded_ = true;
}

void WholeMap::write(const ElevationMapper& map, mrpt::serialization::CArchive& out)
{
  site::Site& all = site_in_hindsight(map);
  write_state(out, mapper_.state());
  out << static_cast<std::uint64_t>(all.ways.size());
  for (const Path& path : all.ways) write_path(out, path);
  const auto keys = all.tiles.keys();
  out << static_cast<std::uint64_t>(keys.size());
  for (const auto& key : keys)
  {
    const auto bytes = bytes_of(*all.tiles.find(key));
    out << key.floor << key.x << key.y << static_cast<std::uint64_t>(bytes.size());
    out.WriteBuffer(bytes.data(), bytes.size());
  }
}

void WholeMap::read(detail::StreamReader& in)
{
  const site::SiteMapper::State state = read_state(in);
  site_.ways.clear();
  for (auto left = in.number<std::uint64_t>(kWhole); left > 0; left--)
    site_.ways.push_back(read_path(in));
  if (site_.ways.empty()) in.fail(kWhole);
  for (auto left = in.number<std::uint64_t>(kWhole); left > 0; left--)
  {
    site::TileKey key;
    for (std::int32_t* v : {&key.floor, &key.x, &key.y}) *v = in.number<std::int32_t>(kWhole);
    const auto size = in.number<std::uint64_t>(kWhole);
    if (key.floor < 0 || key.floor >= state.floors || size > kMaxTileBytes) in.fail(kWhole);
    read_tile(in.bytes(size, kWhole), site_.tiles.at(key));
  }
  mapper_.go_on(state);
  loaded_ = true;
}
}  // namespace talus
