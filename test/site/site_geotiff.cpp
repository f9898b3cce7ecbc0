// A site in a file: what GDAL and people see of it, and what comes back.
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>
#include <talus/io/geotiff.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "log_files.h"
#include "sites.h"

namespace fs = std::filesystem;
using namespace talus;
using namespace talus::site;
using namespace talus::test;

namespace
{
constexpr double kResolution_m = 0.05;
constexpr std::uint32_t kNow_s = 1'760'000'000;

std::unique_ptr<Site> empty_site(const std::string& folder, double resolution_m = kResolution_m)
{
  return std::make_unique<Site>(resolution_m, std::size_t{64} << 20, folder);
}

/** A way from below to above zero, with all kinds of cells at both ends. */
void add_cells(Site& s)
{
  for (int i = -700; i <= 700; ++i)
    for (int side = -3; side <= 3; ++side)
    {
      SiteCell& c = cell_at(s, i, i / 2 + side);
      c = measured(0.01F * static_cast<float>(i), kNow_s - static_cast<std::uint32_t>(i + 700));
      if (side == 3) c = with_obstacle(c, 0.5F);
    }
  SiteCell& odd = cell_at(s, -700, -352);
  odd.cell.state = 3;
  odd.cell.traversability = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < CellRecord::kLastingBytes; i++)
    odd.cell.evidence[i] = static_cast<std::uint8_t>(0xFF - 0x1D * i);
  odd.seen_s = 0;  // of a clock that began at 0
  SiteCell& old = cell_at(s, 700, 352);
  old.cell.state = 2;
  old.cell.evidence[1] = 127;
  old.cell.ground_m = -0.0F;
  old.cell.ground_variance_m2 = std::numeric_limits<float>::denorm_min();
  old.seen_s = kNow_s - 1'234'567'891;
  s.ways = {{{-35, -17.5F, 0, 0}, {0, 0.25F, 0.125F, 0}, {35, 17.5F, 3, 1}}};
}

class SiteGeoTiff : public testing::Test
{
 protected:
  ScratchDir dir;
  const std::unique_ptr<Site> site = empty_site(dir / "tiles"), in = empty_site(dir / "tiles_in");
};

struct Open
{
  explicit Open(const std::string& path, bool changes = false)
  {
    GDALAllRegister();
    const char* const options[] = {"IGNORE_COG_LAYOUT_BREAK=YES", nullptr};  // since GDAL 3.10
    data = static_cast<GDALDataset*>(GDALOpenEx(
        path.c_str(), GDAL_OF_RASTER | (changes ? GDAL_OF_UPDATE : 0), nullptr,
        changes ? options : nullptr, nullptr));
  }
  ~Open() { GDALClose(data); }
  const char* item(const char* name, const char* domain = "") const
  {
    const char* text = data->GetMetadataItem(name, domain);
    return text ? text : "(none)";
  }
  GDALDataset* data;
};

std::vector<float> values_of(GDALRasterBand* band)
{
  const int nx = band->GetXSize(), ny = band->GetYSize();
  std::vector<float> v(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
  EXPECT_EQ(
      band->RasterIO(GF_Read, 0, 0, nx, ny, v.data(), nx, ny, GDT_Float32, 0, 0, nullptr), CE_None);
  return v;
}

/** As another program writes it that is told these words of gdal_translate. */
void translate(
    const std::string& from, const std::string& to, const std::vector<std::string>& words)
{
  CPLStringList list;
  for (const std::string& w : words) list.AddString(w.c_str());
  auto* options = GDALTranslateOptionsNew(list.List(), nullptr);
  const Open tif(from);
  GDALClose(GDALTranslate(to.c_str(), tif.data, options, nullptr));
  GDALTranslateOptionsFree(options);
}
}  // namespace

TEST_F(SiteGeoTiff, comes_back_with_the_same_bits)
{
  add_cells(*site);
  write_site(dir / "site.tif", *site, 0);
  read_site(dir / "site.tif", *in, 0);
  EXPECT_EQ(different_cells(*site, *in), 0);
  EXPECT_EQ(in->tiles.keys(), site->tiles.keys()) << "only known cells make tiles";
  ASSERT_EQ(in->ways.size(), 1u);
  ASSERT_EQ(in->ways[0].size(), 2u) << "the third point is on another floor";
  EXPECT_EQ(in->ways[0][1].y_m, 0.25F);
  EXPECT_EQ(info_of_site(dir / "site.tif").resolution_m, kResolution_m);
  write_site(dir / "again.tif", *in, 0);
  EXPECT_EQ(read_bytes(dir / "again.tif"), read_bytes(dir / "site.tif"));
}

TEST_F(SiteGeoTiff, channels_are_its_last_bands_and_come_back_with_the_same_bits)
{
  add_cells(*site);
  write_site(dir / "plain.tif", *site, 0);
  site->channels = channels_from("intensity:mean,label:vote");
  value_at(*site, 100, 50, 0) = 0.1F;
  value_at(*site, 100, 53, 1) = 37.5F;
  value_at(*site, -100, -50, 2) = 15;
  value_at(*site, 5000, 5000, 2) = 3;  // of a cell that is not known
  write_site(dir / "site.tif", *site, 0);
  const Open tif(dir / "site.tif"), plain(dir / "plain.tif");
  ASSERT_EQ(tif.data->GetRasterCount(), 14);
  EXPECT_EQ(plain.data->GetRasterCount(), 10);
  EXPECT_STREQ(tif.data->GetRasterBand(11)->GetDescription(), "intensity");
  EXPECT_STREQ(tif.data->GetRasterBand(14)->GetDescription(), "label_standing");
  EXPECT_STREQ(tif.item("TALUS_CHANNELS"), "intensity:mean,label:vote");
  EXPECT_STREQ(plain.item("TALUS_CHANNELS"), "(none)");
  read_site(dir / "site.tif", *in, 0);
  EXPECT_EQ(different_cells(*site, *in), 0);
  EXPECT_EQ(channels_text(in->channels), "intensity:mean,label:vote");
  EXPECT_EQ(value_at(*in, 100, 50, 0), 0.1F);
  EXPECT_EQ(value_at(*in, 100, 53, 1), 37.5F);
  EXPECT_EQ(value_at(*in, -100, -50, 2), 15);
  EXPECT_TRUE(std::isnan(value_at(*in, 101, 50, 0)));
  write_site(dir / "again.tif", *in, 0);
  EXPECT_EQ(read_bytes(dir / "again.tif"), read_bytes(dir / "site.tif"));
}

TEST_F(SiteGeoTiff, overviews_show_channels_where_they_show_the_cells)
{
  site->channels = channels_from("label:vote");
  for (int x = 0; x < 1200; ++x)
    for (int y = 0; y < 40; ++y)
    {
      cell_at(*site, x, y) = measured(static_cast<float>(x / 100), kNow_s);
      value_at(*site, x, y, 0) = static_cast<float>(x / 100);
    }
  write_site(dir / "site.tif", *site, 0);
  const Open tif(dir / "site.tif");
  GDALRasterBand* const label = tif.data->GetRasterBand(11)->GetOverview(0);
  GDALRasterBand* const ground = tif.data->GetRasterBand(2)->GetOverview(0);
  ASSERT_TRUE(label && ground);
  const std::vector<float> labels = values_of(label), heights = values_of(ground);
  int known = 0;
  for (std::size_t i = 0; i < labels.size(); ++i)
  {
    ASSERT_EQ(std::isnan(labels[i]), std::isnan(heights[i]));
    if (std::isnan(labels[i])) continue;
    ASSERT_EQ(labels[i], heights[i]);
    ++known;
  }
  EXPECT_GE(known, 600 * 20);
}

TEST_F(SiteGeoTiff, with_values_that_are_none_of_its_channels_is_refused)
{
  add_cells(*site);
  site->channels = channels_from("label:mean");
  value_at(*site, 100, 50, 0) = 3.5F;
  write_site(dir / "site.tif", *site, 0);
  Open(dir / "site.tif", true).data->SetMetadataItem("TALUS_CHANNELS", "label:vote");
  expect_error([&] { read_site(dir / "site.tif", *in, 0); }, {"channel 'label' has values"});
}

TEST_F(SiteGeoTiff, has_the_same_bytes_whatever_order_its_tiles_and_ways_came_in)
{
  const auto one = empty_site(dir / "tiles"), other = empty_site(dir / "tiles_2");
  add_cells(*one);
  other->tiles.at({0, 100, 100});  // nothing in it is known
  const auto keys = one->tiles.keys();
  for (auto key = keys.rbegin(); key != keys.rend(); ++key)
    other->tiles.at(*key) = *one->tiles.find(*key);
  one->ways.push_back({{-1, -1, 0, 0}, {1, 1, 0, 0}});
  other->ways = {one->ways[1], one->ways[0]};
  cell_at(*other, -640, -200).cell.ground_m = 7;  // of an unknown cell
  write_site(dir / "one.tif", *one, 0);
  write_site(dir / "other.tif", *other, 0);
  EXPECT_EQ(read_bytes(dir / "one.tif"), read_bytes(dir / "other.tif"));
}

TEST_F(SiteGeoTiff, overviews_keep_the_worst_of_their_cells)
{
  for (int x = 0; x < 1024; ++x) cell_at(*site, x, 0) = measured(1);
  for (const int post : {100, 501, 1002}) cell_at(*site, post, 0).cell.traversability = 0;
  cell_at(*site, 301, 0) = talus::test::with_obstacle(measured(1), 0.8F);
  cell_at(*site, 701, 0).cell.state = 3;
  write_site(dir / "site.tif", *site, 0);
  Open tif(dir / "site.tif");
  const auto at = [&](int band, std::size_t x)
  { return values_of(tif.data->GetRasterBand(band)->GetOverview(0))[63 * 512 + x]; };
  for (const std::size_t post : {50, 250, 501, 150}) EXPECT_EQ(at(1, post), 0) << post;
  EXPECT_EQ(at(1, 51), 1);
  EXPECT_FLOAT_EQ(at(3, 150), 1.8F);
  EXPECT_EQ(at(5, 350), 3);
}

TEST_F(SiteGeoTiff, is_cloud_optimized_with_overviews_and_sparse_blocks)
{
  add_cells(*site);
  cell_at(*site, 9000, 9000) = measured(1, kNow_s);
  write_site(dir / "site.tif", *site, 0);
  EXPECT_LT(fs::file_size(dir / "site.tif"), 400'000u)
      << "blocks without a known cell cost nothing";
  const Open tif(dir / "site.tif");
  ASSERT_TRUE(tif.data);
  EXPECT_STREQ(tif.item("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  EXPECT_STREQ(tif.item("COMPRESSION", "IMAGE_STRUCTURE"), "ZSTD");
  ASSERT_EQ(tif.data->GetRasterCount(), 10);
  auto* band = tif.data->GetRasterBand(5);
  EXPECT_STREQ(band->GetDescription(), "state");
  EXPECT_STREQ(tif.data->GetRasterBand(1)->GetDescription(), "traversability");
  int has_nodata = 0;
  EXPECT_TRUE(std::isnan(band->GetNoDataValue(&has_nodata)) && has_nodata);
  // As validate_cloud_optimized_geotiff: each overview smaller, its bytes before those of the
  // larger, and the list of all images at the beginning.
  const auto offset = [](GDALRasterBand* b, const char* what)
  {
    for (int y = 0; y * 256 < b->GetYSize(); ++y)
      for (int x = 0; x * 256 < b->GetXSize(); ++x)
        if (const char* text = b->GetMetadataItem(
                (what + std::to_string(x) + "_" + std::to_string(y)).c_str(), "TIFF"))
          return std::stoull(text);
    return 0ULL;
  };
  ASSERT_EQ(band->GetOverviewCount(), 5);
  EXPECT_LE(band->GetOverview(4)->GetXSize(), 512);
  EXPECT_LT(std::stoull(band->GetMetadataItem("IFD_OFFSET", "TIFF")), 1000U);
  for (int i = 0; i < 5; ++i)
  {
    auto* larger = i == 0 ? band : band->GetOverview(i - 1);
    auto* overview = band->GetOverview(i);
    EXPECT_EQ(overview->GetXSize(), (larger->GetXSize() + 1) / 2);
    EXPECT_GT(offset(overview, "BLOCK_OFFSET_"), 0U);
    EXPECT_LT(offset(overview, "BLOCK_OFFSET_"), offset(larger, "BLOCK_OFFSET_"));
    EXPECT_GT(
        std::stoull(overview->GetMetadataItem("IFD_OFFSET", "TIFF")),
        std::stoull(larger->GetMetadataItem("IFD_OFFSET", "TIFF")));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(dir / ""), fs::directory_iterator()), 1)
      << "no companions";
}

TEST_F(SiteGeoTiff, lies_in_the_map_frame_where_it_has_no_origin)
{
  cell_at(*site, -1, 130) = measured(4, kNow_s);
  write_site(dir / "site.tif", *site, 0);
  const Open tif(dir / "site.tif");
  double t[6];
  ASSERT_EQ(tif.data->GetGeoTransform(t), CE_None);
  EXPECT_DOUBLE_EQ(t[0], -6.4);
  EXPECT_DOUBLE_EQ(t[3], 12.8);
  EXPECT_TRUE(tif.data->GetSpatialRef()->IsLocal());
  EXPECT_EQ(values_of(tif.data->GetRasterBand(2))[125 * 128 + 127], 4);
  EXPECT_STREQ(tif.item("TALUS_MIN_CELL_X"), "-128");
  EXPECT_STREQ(tif.item("TALUS_MIN_CELL_Y"), "128");
  EXPECT_STREQ(tif.item("TALUS_SEEN_S"), "1760000000");
}

TEST_F(SiteGeoTiff, lies_on_earth_where_its_origin_is_known)
{
  const auto coarse = empty_site(dir / "tiles", 1.0), back = empty_site(dir / "tiles_in", 1.0);
  // The map's x axis points north: its y axis points west.
  coarse->origin = GeoOrigin{48.0, 11.0, 500, 90};
  cell_at(*coarse, 1000, 0) = measured(4);
  cell_at(*coarse, 0, 0) = measured(4);
  write_site(dir / "site.tif", *coarse, 0);
  const Open tif(dir / "site.tif");
  double t[6];
  ASSERT_EQ(tif.data->GetGeoTransform(t), CE_None);
  OGRSpatialReference wgs84;
  wgs84.importFromEPSG(4326);
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> to_earth(
      OGRCreateCoordinateTransformation(tif.data->GetSpatialRef(), &wgs84));
  ASSERT_TRUE(to_earth);
  const auto place_of = [&](double column, double row)
  {
    double x = t[0] + column * t[1] + row * t[2], y = t[3] + column * t[4] + row * t[5];
    EXPECT_TRUE(to_earth->Transform(1, &x, &y));
    return std::make_pair(x, y);
  };
  const double rows = tif.data->GetRasterYSize();
  const auto [longitude, latitude] = place_of(0, rows);
  EXPECT_NEAR(longitude, 11, 1e-9);
  EXPECT_NEAR(latitude, 48, 1e-9);
  // One kilometre north: a minute of arc of the meridian is 1852.2 m there.
  const auto [east, north] = place_of(1000, rows);
  EXPECT_NEAR(east, 11, 1e-9);
  EXPECT_NEAR(north, 48 + 1000 / 111'190.0, 1e-5);
  const auto [west, same] = place_of(0, 0);
  EXPECT_LT(west, 11);
  EXPECT_NEAR(same, 48, 1e-6);

  read_site(dir / "site.tif", *back, 0);
  ASSERT_TRUE(back->origin);
  EXPECT_EQ(back->origin->latitude_deg, 48);
  EXPECT_EQ(back->origin->altitude_m, 500);
  EXPECT_EQ(back->origin->heading_deg, 90);
  EXPECT_EQ(different_cells(*coarse, *back), 0);
  back->origin->longitude_deg = 120;
  expect_error(
      [&] { read_site(dir / "site.tif", *back, 0); },
      {"site.tif", "origin", "48 11 500 90", "48 120 500 90"});
}

TEST_F(SiteGeoTiff, says_units_statistics_and_classes_of_its_bands)
{
  for (int i = 0; i < 4; ++i)
    cell_at(*site, 300 * i, i) = measured(0.5F * static_cast<float>(i), kNow_s);
  write_site(dir / "site.tif", *site, 0);
  const Open tif(dir / "site.tif");
  auto* ground = tif.data->GetRasterBand(2);
  EXPECT_STREQ(ground->GetUnitType(), "m");
  EXPECT_STREQ(tif.data->GetRasterBand(4)->GetUnitType(), "m2");
  EXPECT_STREQ(tif.data->GetRasterBand(7)->GetUnitType(), "s");
  double min = 0, max = 0, mean = 0, deviation = 0;
  ASSERT_EQ(ground->GetStatistics(TRUE, FALSE, &min, &max, &mean, &deviation), CE_None);
  EXPECT_EQ(min, 0);
  EXPECT_EQ(max, 1.5);
  EXPECT_NEAR(mean, 0.75, 1e-12);
  EXPECT_NEAR(deviation, std::sqrt(0.3125), 1e-12);
  const char* const classes = tif.data->GetRasterBand(5)->GetMetadataItem("TALUS_CLASSES");
  ASSERT_TRUE(classes);
  EXPECT_SAYS(std::string(classes), "2 filled from two sides");
  EXPECT_STREQ(tif.item("TALUS_AXES"), "(none)") << "north is up";
}

TEST_F(SiteGeoTiff, writes_the_ways_of_a_floor_as_lines_and_points_with_times)
{
  cell_at(*site, 0, 0) = measured(0, kNow_s);
  site->origin = GeoOrigin{48, 11, 0, 90};
  site->ways = {
      {{0, 0, 0, 0, 1'760'000'000.5}, {3, 4, 0, 0, 1'760'000'010}}, {{7, 7, 1, 1}, {8, 7, 1, 1}}};
  write_way(dir / "site_way.gpkg", *site, 0);
  write_way(dir / "again.gpkg", *site, 0);
  EXPECT_EQ(read_bytes(dir / "site_way.gpkg"), read_bytes(dir / "again.gpkg"));
  GDALAllRegister();
  auto* data = static_cast<GDALDataset*>(
      GDALOpenEx((dir / "site_way.gpkg").c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(data);
  auto *lines = data->GetLayerByName("way"), *points = data->GetLayerByName("point");
  ASSERT_TRUE(lines && points);
  EXPECT_EQ(lines->GetFeatureCount(), 1);
  EXPECT_EQ(points->GetFeatureCount(), 2);
  const std::unique_ptr<OGRFeature> line(lines->GetNextFeature());
  EXPECT_EQ(line->GetFieldAsDouble("length_m"), 5);
  EXPECT_STREQ(line->GetFieldAsString("from_time"), "2025/10/09 08:53:20.500+00");
  const auto* path = line->GetGeometryRef()->toLineString();
  ASSERT_EQ(path->getNumPoints(), 2);
  EXPECT_NEAR(path->getX(1), -4, 1e-9) << "its x axis points north";
  EXPECT_NEAR(path->getY(1), 3, 1e-9);
  EXPECT_FALSE(lines->GetSpatialRef()->IsLocal());
  GDALClose(data);
  write_site(dir / "site.tif", *site, 0);
  read_site(dir / "site.tif", *in, 0);
  EXPECT_EQ(in->ways[0][0].stamp_s, 1'760'000'000.5) << "a map that goes on keeps the times";
  EXPECT_EQ(way_file_of("out/site_floor_1.tif"), "out/site_floor_1_way.gpkg");
}

TEST_F(SiteGeoTiff, names_its_floors_and_is_not_read_where_one_is_missing)
{
  cell_at(*site, 0, 0, 0) = measured(0);
  write_site_files(dir / "one.tif", dir / "one.png", *site);
  EXPECT_STREQ(Open(dir / "one.tif").item("TALUS_FLOORS"), "(none)");
  for (const int floor : {1, 3}) cell_at(*site, 0, 0, floor) = measured(3);
  write_site_files(dir / "site.tif", "", *site);
  EXPECT_STREQ(Open(dir / "site.tif").item("TALUS_FLOORS"), "0 1 3");
  EXPECT_EQ(info_of_site(dir / "site_floor_3.tif").floors, std::vector<int>());
  read_site_files(dir / "site.tif", *in);
  EXPECT_EQ(floors_of(*in), (std::vector<int>{0, 1, 3}));
  fs::remove(dir / "site_floor_3.tif");
  const auto none = empty_site(dir / "tiles_none");
  expect_error(
      [&] { read_site_files(dir / "site.tif", *none); },
      {"site_floor_3.tif: no such file", "site.tif", "3 floors"});
  EXPECT_TRUE(none->tiles.keys().empty());
}

TEST_F(SiteGeoTiff, a_guess_that_no_ray_has_proved_is_no_area)
{
  for (const int x : {0, 1, 2}) cell_at(*site, x, 0) = measured(1);
  for (const int x : {1, 2}) cell_at(*site, x, 0).cell.state = 3;
  cell_at(*site, 2, 0).cell.traversability = NAN;
  const KnownCells known = known_cells(*site);
  EXPECT_NEAR(known.area_m2, 2 * kResolution_m * kResolution_m, 1e-9);
  EXPECT_EQ(known.by_state[3], 1U);
}

TEST_F(SiteGeoTiff, thins_long_ways_evenly)
{
  cell_at(*site, 0, 0) = measured(0);
  std::vector<WayPoint> way;
  for (int i = 0; i < 100'001; ++i) way.push_back({static_cast<float>(i), 0, 0, 0});
  site->ways = {way, {{0, 0, 0, 0}, {5, 5, 0, 0}}};
  write_site(dir / "site.tif", *site, 0);
  read_site(dir / "site.tif", *in, 0);
  ASSERT_EQ(in->ways.size(), 2u);
  const bool long_first = in->ways[0].size() > 2;
  const auto &thinned = in->ways[long_first ? 0 : 1], &other = in->ways[long_first ? 1 : 0];
  EXPECT_LE(thinned.size(), 20'000u);
  EXPECT_GE(thinned.size(), 15'000u);
  EXPECT_EQ(thinned.front().x_m, 0);
  EXPECT_EQ(thinned.back().x_m, 100'000);
  EXPECT_EQ(other.back().x_m, 5);
  write_site(dir / "again.tif", *in, 0);
  EXPECT_EQ(read_bytes(dir / "again.tif"), read_bytes(dir / "site.tif"));
}

TEST_F(SiteGeoTiff, leaves_the_old_file_when_there_is_nothing_to_write)
{
  write_bytes(dir / "site.tif", "precious");
  site->tiles.at({0, 0, 0});
  expect_error([&] { write_site(dir / "site.tif", *site, 0); }, {"site.tif", "floor 0"});
  cell_at(*site, -1'999'999'999, -1'999'999'999) = measured(0);
  cell_at(*site, 1'999'999'999, 1'999'999'999) = measured(0);
  expect_error([&] { write_site(dir / "site.tif", *site, 0); }, {"site.tif", "cells"});
  EXPECT_EQ(read_bytes(dir / "site.tif"), "precious");
}

TEST_F(SiteGeoTiff, reading_says_what_is_wrong_with_a_file)
{
  const auto refused = [&](const std::string& name, const std::vector<std::string>& words)
  { expect_error([&] { read_site(dir / name, *site, 0); }, words); };
  refused("none.tif", {"none.tif", "no such file"});
  write_bytes(dir / "text.tif", "hello");
  refused("text.tif", {"text.tif", "GeoTIFF"});
  io::write_geotiff(dir / "map.tif", io::snapshot(ElevationMapper()));
  refused("map.tif", {"map.tif", "one window", "site.tif"});
  const auto coarse = empty_site(dir / "tiles_coarse", 0.1);
  cell_at(*coarse, 0, 0) = measured(0);
  write_site(dir / "coarse.tif", *coarse, 0);
  refused("coarse.tif", {"coarse.tif", "0.1 m", "0.05 m"});
  EXPECT_TRUE(site->tiles.keys().empty());
}

TEST_F(SiteGeoTiff, reading_refuses_a_file_wherever_it_is_cut_short)
{
  add_cells(*site);
  site->origin = GeoOrigin{48.0, 11.0, 500, 90};
  write_site(dir / "site.tif", *site, 0);
  const std::string bytes = read_bytes(dir / "site.tif");
  constexpr std::size_t kHead = 4096, kTrailer = 4;  // of the last block, which nobody reads
  ASSERT_GT(bytes.size(), kHead);
  const auto refused = [&](std::size_t size)
  {
    write_bytes(dir / "cut.tif", bytes.substr(0, size));
    EXPECT_THROW(read_site(dir / "cut.tif", *in, 0), std::runtime_error) << size;
  };
  for (std::size_t size = 0; size < kHead; size += 7) refused(size);
  for (std::size_t size = kHead; size < bytes.size() - kTrailer; size += bytes.size() / 40)
    refused(size);
}

TEST_F(SiteGeoTiff, reading_refuses_cells_that_are_none)
{
  const auto refused = [&](const char* name, const auto& change)
  {
    change(cell_at(*site, 3, 3) = with_obstacle(measured(1, kNow_s), 1));
    write_site(dir / name, *site, 0);
    expect_error([&] { read_site(dir / name, *in, 0); }, {name, "cells", "damaged"});
  };
  refused("state.tif", [](SiteCell& c) { c.cell.state = 5; });
  refused("ground.tif", [](SiteCell& c) { c.cell.ground_m = 2e9F; });
  refused("variance.tif", [](SiteCell& c) { c.cell.ground_variance_m2 = -1; });
  refused("elevation.tif", [](SiteCell& c) { c.cell.elevation_variance_m2 = NAN; });
  refused("score.tif", [](SiteCell& c) { c.cell.traversability = 1.5F; });
}

TEST_F(SiteGeoTiff, reading_refuses_a_bit_that_flipped)
{
  add_cells(*site);
  write_site(dir / "site.tif", *site, 0);
  {
    const Open tif(dir / "site.tif", true);
    auto* variance = tif.data->GetRasterBand(4);
    const int x = variance->GetXSize() / 2, y = variance->GetYSize() / 2;
    std::vector<float> values(64);
    const auto io = [&](GDALRWFlag flag)
    { return variance->RasterIO(flag, x, y, 8, 8, values.data(), 8, 8, GDT_Float32, 0, 0); };
    ASSERT_EQ(io(GF_Read), CE_None);
    const auto known =
        std::find_if(values.begin(), values.end(), [](float v) { return !std::isnan(v); });
    ASSERT_NE(known, values.end());
    *known = std::nextafter(*known, 1.0F);
    ASSERT_EQ(io(GF_Write), CE_None);
  }
  expect_error(
      [&] { read_site(dir / "site.tif", *in, 0); },
      {"site.tif", "m are not those that were written", "copy it again"});
}

TEST_F(SiteGeoTiff, reading_refuses_a_file_that_another_program_has_converted)
{
  cell_at(*site, 3, 3) = with_obstacle(measured(1, kNow_s), 1);
  write_site(dir / "site.tif", *site, 0);
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& word)
  {
    translate(dir / "site.tif", dir / "other.tif", arguments);
    expect_error(
        [&] { read_site(dir / "other.tif", *in, 0); },
        {"other.tif", word, "give", "as talus wrote it"});
    expect_error([&] { info_of_site(dir / "other.tif"); }, {"other.tif", word});
  };
  refused({"-ot", "Byte"}, "'traversability' holds Byte, not Float32");
  refused({"-ot", "Float64"}, "holds Float64");
  refused({"-ot", "Int16", "-a_nodata", "-1"}, "holds Int16");
  refused({"-a_scale", "2"}, "has a scale or an offset (2, 0)");
  refused({"-a_offset", "-1.5"}, "has a scale or an offset (1, -1.5)");
  refused({"-co", "NBITS=16"}, "rounded to 16 bits");
  refused({"-a_nodata", "-9999"}, "does not mark unknown cells with NaN");
  std::vector<std::string> eleven;
  for (const char* b : {"1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "2"})
    eleven.insert(eleven.end(), {"-b", b});
  refused(eleven, "has 11 bands, a site has 10");
  EXPECT_TRUE(in->tiles.keys().empty());
}

TEST_F(SiteGeoTiff, tells_what_is_reached_and_reads_files_that_did_not_yet)
{
  cell_at(*site, 3, 3) = cell_at(*site, 4, 3) = measured(1, kNow_s);
  set_reached(cell_at(*site, 4, 3).cell);
  write_site(dir / "site.tif", *site, 0);
  {
    const Open tif(dir / "site.tif");
    ASSERT_STREQ(tif.data->GetRasterBand(6)->GetDescription(), "reached");
    double least = -1, most = -1, mean = -1, deviation = -1;
    tif.data->GetRasterBand(6)->GetStatistics(TRUE, TRUE, &least, &most, &mean, &deviation);
    EXPECT_EQ(mean, 0.5);
  }
  std::vector<std::string> without;
  for (const char* b : {"1", "2", "3", "4", "5", "7", "8", "9", "10"})
    without.insert(without.end(), {"-b", b});
  translate(dir / "site.tif", dir / "old.tif", without);
  read_site(dir / "old.tif", *in, 0);
  EXPECT_EQ(different_cells(*site, *in), 0);
}

TEST_F(SiteGeoTiff, reading_refuses_a_file_that_another_program_has_cut)
{
  add_cells(*site);
  write_site(dir / "site.tif", *site, 0);
  translate(dir / "site.tif", dir / "cut.tif", {"-srcwin", "128", "128", "256", "256"});
  expect_error([&] { read_site(dir / "cut.tif", *in, 0); }, {"cut.tif", "another program"});
}
