#include "kept_site.h"

#include "../common/crash_context.h"

#include <mrpt/obs/CObservationGPS.h>
#include <talus/number_text.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
constexpr double kJump_m = 200;  // between two points of a way, of which each metre has one

/** In (-180, 180]: what is one place and heading has one text. */
double same_turn(double angle_deg)
{
  const double turn_deg = std::remainder(angle_deg, 360);
  return turn_deg == -180 ? 180 : turn_deg + 0.0;  // no -0
}

std::size_t megabytes(double mb) { return static_cast<std::size_t>(mb * 1024 * 1024); }

std::vector<double> numbers_of(const std::string& text)
{
  std::vector<double> numbers;
  for (std::size_t from = 0, comma = 0; comma != std::string::npos; from = comma + 1)
  {
    comma = text.find(',', from);
    const std::string part = text.substr(from, comma - from);
    const auto number = number_from(part);
    if (!number || !std::isfinite(*number))
      throw std::invalid_argument("'" + part + "' is no number");
    numbers.push_back(*number);
  }
  return numbers;
}
}  // namespace

site::GeoOrigin origin_from_text(const std::string& text)
{
  struct Limit
  {
    const char* name;
    double min, max;
  };
  static constexpr std::array<Limit, 4> kLimits{
      {{"latitude", -90, 90},
       {"longitude", -180, 180},
       {"altitude", -12000, 100000},
       {"heading", -360, 360}}};
  std::vector<double> n = numbers_of(text);
  if (n.size() < 2 || n.size() > kLimits.size())
    throw std::invalid_argument(
        "'" + text + "' must be LAT,LON[,ALT[,HEADING]], for example 36.8383,-2.4045,52,30");
  for (std::size_t i = 0; i < n.size(); ++i)
    if (n[i] < kLimits[i].min || n[i] > kLimits[i].max)
      throw std::invalid_argument(
          std::string("the ") + kLimits[i].name + " " + number_text(n[i]) + " is not in [" +
          number_text(kLimits[i].min) + ", " + number_text(kLimits[i].max) + "]");
  n.resize(kLimits.size());
  return {n[0], same_turn(n[1]), n[2], same_turn(n[3])};
}

KeptSite::KeptSite(const Options& options, const Parameters& parameters, const std::string& folder)
    : site_(parameters.resolution_m, megabytes(options.memory_mb), folder),
      far_(options.keep_far ? site::Far::Together : site::Far::Apart)
{
  if (!options.resume.empty()) resume(options.resume, parameters.channels);
  if (options.origin) place(*options.origin);
  mapper_.emplace(site_, !options.keep_new);
  if (options.traffic) mapper_->note_traffic();
}

void KeptSite::resume(const std::string& path, const std::vector<Channel>& channels)
{
  const CrashContext context(path, kCompareWithSource);
  site::read_site_files(path, site_);
  try
  {
    add_channels(site_.channels, channels);
  }
  catch (const std::invalid_argument& e)
  {
    throw std::runtime_error(
        path + ": its channels do not go with those of --channels: " + e.what());
  }
}

void KeptSite::place(const site::GeoOrigin& origin)
{
  const auto text = [](const site::GeoOrigin& o)
  {
    return fixed_text(o.latitude_deg, 7) + "," + fixed_text(o.longitude_deg, 7) + "," +
           fixed_text(o.altitude_m, 2) + "," + fixed_text(o.heading_deg, 3);
  };
  if (site_.origin && text(*site_.origin) != text(origin))
    warnings_.push_back(
        "the map that is resumed has another origin on Earth, " + text(*site_.origin) +
        ": that of --origin replaces it");
  site_.origin = origin;
}

FrameReport KeptSite::update(ElevationMapper& map, const Frame& frame)
{
  return mapper_->update(map, frame);
}

bool KeptSite::take_fix(
    const mrpt::obs::CObservation& obs, const std::optional<mrpt::poses::CPose3D>& T_map_base)
{
  const auto* gps = dynamic_cast<const mrpt::obs::CObservationGPS*>(&obs);
  if (!gps) return false;
  if (site_.origin || !T_map_base || !gps->has_GGA_datum()) return true;
  const auto& fix = gps->getMsgByClass<mrpt::obs::gnss::Message_NMEA_GGA>().fields;
  const mrpt::poses::CPose3D antenna = *T_map_base + gps->sensorPose;
  const site::GpsFix f{fix.latitude_degrees, fix.longitude_degrees, fix.altitude_meters,
                       antenna.x(),          antenna.y(),           antenna.z()};
  const bool is_valid = fix.fix_quality > 0 && std::abs(f.latitude_deg) <= 90 &&
                        std::abs(f.longitude_deg) <= 180 && std::isfinite(f.altitude_m);
  if (is_valid) fixes_.push_back(f);
  return true;
}

void KeptSite::finish(const ElevationMapper& map, io::RunSummary& run, bool is_driven)
{
  mapper_->keep_window(map);
  mapper_->look_back(map);
  if (!is_driven) site_.ways.pop_back();
  warn_of_islands();
  std::string warning;
  if (!site_.origin) site_.origin = site::origin_from_fixes(fixes_, warning);
  if (!warning.empty()) warnings_.push_back(warning);
  run.warnings.insert(run.warnings.end(), warnings_.begin(), warnings_.end());
  run.site = summary();
}

void KeptSite::warn_of_islands()
{
  if (far_ == site::Far::Together) return;
  for (std::string& text : site::texts_of_islands("site.tif", site_))
  {
    warnings_.push_back(std::move(text));
    ++islands_;
  }
}

io::SiteSummary KeptSite::summary()
{
  io::SiteSummary s;
  const site::KnownCells known = site::known_cells(site_);
  s.cells = known.by_state;
  s.floors = static_cast<int>(site::floors_of(site_).size());
  s.islands = islands_;
  s.area_m2 = known.area_m2;
  for (const auto& way : site_.ways)
    for (std::size_t i = 1; i < way.size(); ++i)
    {
      const double step_m = std::hypot(
          way[i].x_m - way[i - 1].x_m, way[i].y_m - way[i - 1].y_m, way[i].z_m - way[i - 1].z_m);
      if (step_m < kJump_m) s.length_m += step_m;
    }
  return s;
}

void KeptSite::write(
    const std::string& folder, const std::string& name, const site::Progress& progress)
{
  const fs::path to(folder);
  site_.name = name;
  site::write_site_files(
      (to / "site.tif").string(), (to / "site.png").string(), site_, progress, far_);
  if (const site::Traffic* traffic = mapper_->traffic())
    site::write_traffic_files((to / "traffic.tif").string(), *traffic, site_, far_);
}

}  // namespace talus::app
