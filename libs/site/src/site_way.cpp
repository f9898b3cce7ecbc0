#include <talus/site/site_files.h>

#include "site_metadata.h"

#include <gdal_support.h>
#include <talus/io/atomic_file.h>

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <ogrsf_frmts.h>

#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>

namespace fs = std::filesystem;

namespace talus::site
{
namespace
{
constexpr const char* kNotWritten =
    "cannot write this GeoPackage; is the disk full? Free some space there";
constexpr double kYear1980_s = 315532800, kYear2200_s = 7258118400;

/** An option of GDAL for this thread, while it lives. */
class Option
{
 public:
  Option(const char* name, const char* value) : name_(name)
  {
    CPLSetThreadLocalConfigOption(name, value);
  }
  ~Option() { CPLSetThreadLocalConfigOption(name_, nullptr); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

 private:
  const char* name_;
};

void set_time(OGRFeature& feature, const char* field, double stamp_s)
{
  if (!(stamp_s > kYear1980_s && stamp_s < kYear2200_s)) return;
  const auto whole = static_cast<std::time_t>(std::floor(stamp_s));
  std::tm utc{};
  ::gmtime_r(&whole, &utc);
  constexpr int kUtc = 100;
  feature.SetField(
      feature.GetFieldIndex(field), utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
      utc.tm_min, static_cast<float>(utc.tm_sec + stamp_s - static_cast<double>(whole)), kUtc);
}

void set_stamp(OGRFeature& feature, const char* field, double stamp_s)
{
  if (!std::isnan(stamp_s)) feature.SetField(field, stamp_s);
}

class WayWriter
{
 public:
  WayWriter(GDALDataset& dataset, const Site& site) : site_(site), crs_(crs_of(site.origin))
  {
    lines_ = make(
        dataset, "way", wkbLineString25D,
        {{"way", OFTInteger},
         {"length_m", OFTReal},
         {"from_time", OFTDateTime},
         {"to_time", OFTDateTime}});
    points_ = make(
        dataset, "point", wkbPoint25D,
        {{"way", OFTInteger}, {"time", OFTDateTime}, {"time_s", OFTReal}});
  }

  bool add(int number, const std::vector<WayPoint>& way)
  {
    OGRLineString line;
    double length_m = 0;
    for (std::size_t i = 0; i < way.size(); ++i)
    {
      const WayPoint& p = way[i];
      if (i > 0)
        length_m +=
            std::hypot(p.x_m - way[i - 1].x_m, p.y_m - way[i - 1].y_m, p.z_m - way[i - 1].z_m);
      const OGRPoint at = placed(p);
      line.addPoint(&at);
      if (!add_point(number, p, at)) return false;
    }
    return way.size() < 2 || add_line(number, way, line, length_m);
  }
  bool is_made() const { return lines_ && points_; }

 private:
  struct Field
  {
    const char* name;
    OGRFieldType type;
  };

  OGRLayer* make(
      GDALDataset& dataset, const char* name, OGRwkbGeometryType type,
      const std::vector<Field>& fields)
  {
    OGRLayer* layer = dataset.CreateLayer(name, &crs_, type, nullptr);
    for (const Field& f : fields)
    {
      OGRFieldDefn field(f.name, f.type);
      if (layer && layer->CreateField(&field) != OGRERR_NONE) return nullptr;
    }
    return layer;
  }

  OGRPoint placed(const WayPoint& p) const
  {
    double x_m = p.x_m, y_m = p.y_m;
    io::to_crs(x_m, y_m, site_.origin);
    return {x_m, y_m, p.z_m};
  }

  bool add_point(int number, const WayPoint& p, const OGRPoint& at)
  {
    OGRFeature feature(points_->GetLayerDefn());
    feature.SetField("way", number);
    set_time(feature, "time", p.stamp_s);
    set_stamp(feature, "time_s", p.stamp_s);
    feature.SetGeometry(&at);
    return points_->CreateFeature(&feature) == OGRERR_NONE;
  }

  bool add_line(
      int number, const std::vector<WayPoint>& way, const OGRLineString& line, double length_m)
  {
    OGRFeature feature(lines_->GetLayerDefn());
    feature.SetField("way", number);
    feature.SetField("length_m", length_m);
    set_time(feature, "from_time", way.front().stamp_s);
    set_time(feature, "to_time", way.back().stamp_s);
    feature.SetGeometry(&line);
    return lines_->CreateFeature(&feature) == OGRERR_NONE;
  }

  const Site& site_;
  OGRSpatialReference crs_;
  OGRLayer *lines_ = nullptr, *points_ = nullptr;
};

bool write(GDALDataset& dataset, const Site& site, int floor)
{
  if (dataset.StartTransaction() != OGRERR_NONE) return false;
  WayWriter writer(dataset, site);
  if (!writer.is_made()) return false;
  int number = 0;
  for (const auto& way : on_floor(site.ways, floor))
    if (!writer.add(++number, way)) return false;
  return dataset.CommitTransaction() == OGRERR_NONE;
}
}  // namespace

std::string way_file_of(const std::string& site_file)
{
  const fs::path file(site_file);
  return (file.parent_path() / (file.stem().string() + "_way.gpkg")).string();
}

void write_way(const std::string& path, const Site& site, int floor)
{
  io::AtomicFile file(path);
  const io::GdalErrors errors;
  // The same bytes for the same ways; AtomicFile brings them to the disk.
  const Option date("OGR_CURRENT_DATE", "1970-01-01T00:00:00.000Z");
  const Option fast("OGR_SQLITE_SYNCHRONOUS", "OFF");
  io::DatasetPtr dataset(
      io::geopackage_driver().Create(file.temporary_path().c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!dataset || !write(*dataset, site, floor)) io::fail(path, kNotWritten, errors);
  dataset.reset();
  if (errors.any()) io::fail(path, kNotWritten, errors);
  file.commit();
}

}  // namespace talus::site
