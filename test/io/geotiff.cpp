#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <talus/io/geotiff.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "log_files.h"

namespace fs = std::filesystem;
using namespace talus;
using namespace talus::io;
using talus::test::expect_error;
using talus::test::read_bytes;
using talus::test::ScratchDir;
using talus::test::write_bytes;

namespace
{
const float kNan = std::numeric_limits<float>::quiet_NaN();

/** 3 x 2 cells, its heights 0..5 counted from the south-west corner eastwards. */
LayerStack small_stack()
{
  LayerStack s;
  s.cells_x = 3;
  s.cells_y = 2;
  s.resolution_m = 0.25;
  s.min_x_m = -1.5;
  s.min_y_m = 10;
  s.names = {"elevation", "state"};
  s.layers = {{0, 1, 2, 3, kNan, 5}, {1, 1, 2, 3, 0, 1}};
  return s;
}

struct Open
{
  explicit Open(const std::string& path)
  {
    GDALAllRegister();
    data = static_cast<GDALDataset*>(GDALOpen(path.c_str(), GA_ReadOnly));
  }
  ~Open() { GDALClose(data); }
  GDALDataset* data;
};
}  // namespace

TEST(GeoTiff, comes_back_with_the_same_bits_whole_and_part_by_part)
{
  const ScratchDir dir;
  const LayerStack out = small_stack();
  write_geotiff(dir / "map.tif", out);
  const LayerStack in = read_geotiff(dir / "map.tif");
  EXPECT_EQ(in.cells_x, 3);
  EXPECT_EQ(in.cells_y, 2);
  EXPECT_EQ(in.resolution_m, 0.25);
  EXPECT_EQ(in.min_x_m, -1.5);
  EXPECT_EQ(in.min_y_m, 10);
  EXPECT_EQ(in.names, out.names);
  ASSERT_EQ(in.layers.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(std::memcmp(in.layers[i].data(), out.layers[i].data(), 6 * sizeof(float)), 0) << i;
  for (const auto& entry : fs::directory_iterator(dir / ""))
    EXPECT_EQ(entry.path().filename(), "map.tif") << "a companion";
  const GeotiffFile file(dir / "map.tif");
  const LayerStack part = file.read_part(2, 1, 1, 1, {out.names[1]});
  EXPECT_EQ(part.min_x_m, -1);
  EXPECT_EQ(part.min_y_m, 10.25);
  EXPECT_EQ(part.layers, (std::vector<std::vector<float>>{{out.layers[1][5]}}));
  EXPECT_THROW(file.read_part(1, 1, 3, 1), std::invalid_argument);
}

TEST(GeoTiff, is_north_up_in_metres_of_the_map_frame)
{
  const ScratchDir dir;
  write_geotiff(dir / "map.tif", small_stack());
  const Open tif(dir / "map.tif");
  ASSERT_TRUE(tif.data);
  double t[6];
  ASSERT_EQ(tif.data->GetGeoTransform(t), CE_None);
  EXPECT_EQ(t[0], -1.5) << "west edge";
  EXPECT_EQ(t[3], 10.5) << "north edge";
  EXPECT_EQ(t[1], 0.25);
  EXPECT_EQ(t[5], -0.25);
  float first_row[3];
  ASSERT_EQ(
      tif.data->GetRasterBand(1)->RasterIO(
          GF_Read, 0, 0, 3, 1, first_row, 3, 1, GDT_Float32, 0, 0, nullptr),
      CE_None);
  EXPECT_EQ(first_row[0], 3) << "the north-west cell comes first";
  EXPECT_EQ(first_row[2], 5);
  const auto* frame = tif.data->GetSpatialRef();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->IsLocal());
  EXPECT_STREQ(frame->GetName(), "talus map frame");
  EXPECT_EQ(frame->GetLinearUnits(), 1.0);
}

TEST(GeoTiff, of_degrees_or_with_a_value_for_no_data_is_refused)
{
  const ScratchDir dir;
  const auto convert = [&](const std::function<void(GDALDataset&)>& change)
  {
    write_geotiff(dir / "map.tif", small_stack());
    GDALAllRegister();
    auto* data = static_cast<GDALDataset*>(GDALOpen((dir / "map.tif").c_str(), GA_Update));
    change(*data);
    GDALClose(data);
  };
  convert(
      [](GDALDataset& d)
      {
        OGRSpatialReference wgs84;
        wgs84.SetWellKnownGeogCS("WGS84");
        d.SetSpatialRef(&wgs84);
      });
  expect_error([&] { read_geotiff(dir / "map.tif"); }, {"map.tif", "0.25 degrees", "gdalwarp"});
  convert([](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(0); });
  expect_error([&] { read_geotiff(dir / "map.tif"); }, {"map.tif", "value 0 no data", "NaN"});
  convert([](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(-9999); });
  EXPECT_NO_THROW(read_geotiff(dir / "map.tif"));
  convert(
      [](GDALDataset& d)
      {
        OGRSpatialReference of_web_maps;
        of_web_maps.importFromEPSG(3857);
        d.SetSpatialRef(&of_web_maps);
      });
  expect_error([&] { read_geotiff(dir / "map.tif"); }, {"map.tif", "other units", "gdalwarp"});
}

TEST(GeoTiff, that_was_brought_to_another_system_has_no_origin_of_the_map_frame)
{
  const ScratchDir dir;
  write_geotiff(dir / "map.tif", small_stack(), {}, GeoOrigin{36.8, -2.4, 52, 30});
  EXPECT_TRUE(GeotiffFile(dir / "map.tif").origin());
  EXPECT_NEAR(GeotiffFile(dir / "map.tif").frame().min_x_m, -1.5, 1e-9);
  GDALAllRegister();
  auto* data = static_cast<GDALDataset*>(GDALOpen((dir / "map.tif").c_str(), GA_Update));
  OGRSpatialReference utm;
  utm.importFromEPSG(32630);
  data->SetSpatialRef(&utm);
  double north_up[] = {553091, 0.25, 0, 4077093, 0, -0.25};
  data->SetGeoTransform(north_up);
  GDALClose(data);
  EXPECT_FALSE(GeotiffFile(dir / "map.tif").origin());
  EXPECT_EQ(GeotiffFile(dir / "map.tif").frame().min_x_m, 553091);
}

TEST(GeoTiff, has_the_bands_of_all_maps_first_with_units_statistics_and_classes)
{
  const ScratchDir dir;
  LayerStack stack = small_stack();
  stack.names = {"elevation",        "state",          "slope",   "colour",
                 "ground_elevation", "traversability", "variance"};
  stack.layers.resize(7, stack.layers[0]);
  write_geotiff(dir / "map.tif", stack, {{"LOG", "a.rawlog"}});
  const LayerStack in = read_geotiff(dir / "map.tif");
  EXPECT_EQ(
      in.names, (std::vector<std::string>{
                    "traversability", "ground_elevation", "elevation", "variance", "state", "slope",
                    "colour"}));
  const Open tif(dir / "map.tif");
  const auto band = [&](int i) { return tif.data->GetRasterBand(i); };
  EXPECT_STREQ(tif.data->GetMetadataItem("LOG"), "a.rawlog");
  EXPECT_STREQ(tif.data->GetMetadataItem("COMPRESSION", "IMAGE_STRUCTURE"), "DEFLATE");
  EXPECT_STREQ(tif.data->GetMetadataItem("PREDICTOR", "IMAGE_STRUCTURE"), "3");
  EXPECT_EQ(band(2)->GetRasterDataType(), GDT_Float32);
  int has_nodata = 0;
  EXPECT_TRUE(std::isnan(band(2)->GetNoDataValue(&has_nodata)));
  EXPECT_TRUE(has_nodata);
  EXPECT_STREQ(band(1)->GetUnitType(), "");
  EXPECT_STREQ(band(2)->GetUnitType(), "m");
  EXPECT_STREQ(band(4)->GetUnitType(), "m2");
  EXPECT_EQ(
      std::string(band(5)->GetMetadataItem("TALUS_CLASSES")).find("0 unknown, 1 measured"), 0u);
  double min = 0, max = 0, mean = 0, deviation = 0;
  ASSERT_EQ(band(3)->GetStatistics(TRUE, FALSE, &min, &max, &mean, &deviation), CE_None);
  EXPECT_EQ(min, 0);
  EXPECT_EQ(max, 5);
  EXPECT_NEAR(mean, 11.0 / 5, 1e-12);
  EXPECT_NEAR(deviation, std::sqrt(39.0 / 5 - 2.2 * 2.2), 1e-12);
  EXPECT_STREQ(band(3)->GetMetadataItem("STATISTICS_VALID_PERCENT"), "83.33");
}

TEST(GeoTiff, lies_on_earth_where_its_origin_is_known_and_comes_back)
{
  const ScratchDir dir;
  const LayerStack out = small_stack();
  for (const double heading_deg : {0.0, 90.0, 30.0, -135.5})
  {
    write_geotiff(dir / "map.tif", out, {}, GeoOrigin{48, 11, 500, heading_deg});
    const Open tif(dir / "map.tif");
    EXPECT_FALSE(tif.data->GetSpatialRef()->IsLocal());
    EXPECT_EQ(tif.data->GetMetadataItem("TALUS_AXES") == nullptr, heading_deg == 0);
    double t[6];
    ASSERT_EQ(tif.data->GetGeoTransform(t), CE_None);
    const double h = heading_deg * std::acos(-1) / 180;
    EXPECT_NEAR(t[0], -1.5 * std::cos(h) - 10.5 * std::sin(h), 1e-9);
    EXPECT_NEAR(t[3], -1.5 * std::sin(h) + 10.5 * std::cos(h), 1e-9);
    const LayerStack in = read_geotiff(dir / "map.tif");
    EXPECT_NEAR(in.min_x_m, out.min_x_m, 1e-9);
    EXPECT_NEAR(in.min_y_m, out.min_y_m, 1e-9);
    EXPECT_NEAR(in.resolution_m, out.resolution_m, 1e-12);
    EXPECT_EQ(in.layers[0][1], 1);
  }
}

TEST(GeoTiff, leaves_the_old_file_when_the_new_one_cannot_be_written)
{
  const ScratchDir dir;
  write_bytes(dir / "map.tif", "precious");
  LayerStack broken = small_stack();
  broken.layers[1].pop_back();
  expect_error([&] { write_geotiff(dir / "map.tif", broken); }, {"map.tif", "state", "3 x 2"});
  expect_error([&] { write_geotiff(dir / "map.tif", LayerStack{}); }, {"map.tif", "no cells"});
  EXPECT_EQ(read_bytes(dir / "map.tif"), "precious");
  expect_error([&] { read_geotiff(dir / "map.tif"); }, {"map.tif", "GeoTIFF"});
  expect_error([&] { write_geotiff(dir / "none/map.tif", small_stack()); }, {"none/map.tif"});
}

TEST(GeoTiff, reading_refuses_bands_that_another_program_has_converted)
{
  const ScratchDir dir;
  GDALAllRegister();
  const auto refused = [&](GDALDataType type, double scale, const std::string& word)
  {
    auto* tif = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        (dir / "other.tif").c_str(), 4, 4, 1, type, nullptr);
    ASSERT_TRUE(tif);
    double t[6] = {0, 0.5, 0, 10, 0, -0.5};
    tif->SetGeoTransform(t);
    tif->GetRasterBand(1)->SetDescription("ground");
    if (scale != 1) tif->GetRasterBand(1)->SetScale(scale);
    GDALClose(tif);
    expect_error([&] { read_geotiff(dir / "other.tif"); }, {"other.tif", "'ground'", word});
  };
  refused(GDT_Byte, 1, "holds Byte, not Float32");
  refused(GDT_Float64, 1, "holds Float64");
  refused(GDT_Float32, 0.5, "has a scale");
}

TEST(GeoTiff, reading_refuses_a_place_that_is_none_and_more_cells_than_fit)
{
  const ScratchDir dir;
  GDALAllRegister();
  const auto write = [&](const std::string& path, int cells, double west)
  {
    const char* const nothing_written[] = {"SPARSE_OK=TRUE", nullptr};
    auto* tif = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        path.c_str(), cells, cells, 1, GDT_Float32, const_cast<char**>(nothing_written));
    ASSERT_TRUE(tif);
    double t[6] = {west, 0.5, 0, 10, 0, -0.5};
    tif->SetGeoTransform(t);
    GDALClose(tif);
  };
  write(dir / "sound.tif", 4, 0);
  EXPECT_EQ(read_geotiff(dir / "sound.tif").cells_x, 4);
  write(dir / "nowhere.tif", 4, kNan);
  expect_error([&] { read_geotiff(dir / "nowhere.tif"); }, {"nowhere.tif", "north-up"});
  write(dir / "huge.tif", 100'000, 0);
  expect_error([&] { read_geotiff(dir / "huge.tif"); }, {"huge.tif", "2^30 cells"});
}
