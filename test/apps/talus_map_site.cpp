// The command talus-map keeps all that a drive saw: site.tif, its options, and what goes wrong.
#include <mrpt/obs/CObservationGPS.h>
#include <talus/io/geotiff.h>
#include <talus/site/site_geotiff.h>

#include <filesystem>

#include "talus_map_run.h"

using namespace talus;
using namespace talus::test;

namespace
{
class TalusMapSite : public TalusMap
{
 protected:
  /** A drive along x at 1 m/s for so many tenths of a second, which begins at such a one. */
  void write_drive(const std::string& name, int scans, int first = 0) const
  {
    Objects objects;
    for (int i = first; i < first + scans; ++i)
      objects.push_back(floor_scan(kFirstStamp_s + 0.1 * i));
    write_log(path(name + ".rawlog"), objects, Packing::Gz);
    write_bytes(path(name + ".tum"), straight_tum(first + scans));
  }
  /** A command line with it must be refused, and make nothing. */
  void expect_refused(const std::string& arguments, int code, const std::string& word) const
  {
    const std::size_t before = entries();
    const CommandEnd failed = run(arguments + " --output bad");
    EXPECT_EQ(failed.code, code) << arguments << ": " << failed.err;
    EXPECT_TRUE(failed.says(word)) << "'" << word << "' not in: " << failed.err;
    EXPECT_EQ(entries(), before);
  }
  std::optional<site::GeoOrigin> origin_of(const std::string& file) const
  {
    site::Site site(0.05, 0, path("tiles"));
    site::read_site(path(file), site, 0);
    return site.origin;
  }
  double area_m2(const std::string& folder) const { return summary(folder)["site"]["area_m2"]; }
};
}  // namespace

TEST_F(TalusMapSite, export_writes_the_site_or_without_one_the_window_in_other_formats)
{
  write_drive("drive", 20);
  runs("drive.rawlog --output both --export ros,octomap");
  for (const char* name : {"both/site.yaml", "both/site.pgm", "both/site.bt", "both/site.tif"})
    EXPECT_TRUE(std::filesystem::exists(path(name))) << name;
  runs("drive.rawlog --output window --no-site --export ros");
  EXPECT_TRUE(std::filesystem::exists(path("window/map.pgm")));
  expect_refused("drive.rawlog --export rso", 2, "rso");
}

TEST_F(TalusMapSite, writes_all_that_the_drive_saw_and_says_how_much)
{
  write_drive("drive", 120);
  const CommandEnd done = runs("drive.rawlog --output out --threads 1 --traffic");
  EXPECT_SAYS(done.out, "  site    ");
  EXPECT_EQ(entries(), 2u + 10u) << "nothing hidden, and nothing moved";
  const auto j = summary("out")["site"];
  EXPECT_NEAR(j["area_m2"].get<double>(), (12 + 6) * 6, 4) << "not what is guessed around it";
  EXPECT_NEAR(j["length_m"].get<double>(), 11.9, 0.2);
  EXPECT_EQ(j["floors"], 1);
  EXPECT_GT(j["cells"]["measured"].get<int>(), 5000);
  site::Site site(0.05, 0, path("tiles"));
  site::read_site(path("out/site.tif"), site, 0);
  EXPECT_FALSE(site.tiles.keys().empty());
  EXPECT_FALSE(site.origin);
  EXPECT_SAYS(read_bytes(path("out/site.qml")), "<qgis");
  EXPECT_TRUE(exists("out/map.qml"));
  // The same bytes with little memory and with any number of threads; no styles over a user's own.
  std::filesystem::create_directory(path("other"));
  write_bytes(path("other/map.qml"), "mine");
  runs("drive.rawlog --output other --threads 3 --memory 4");
  for (const std::string name : {"site.tif", "map.tif", "map.png"})
    EXPECT_TRUE(read_bytes(path("out/" + name)) == read_bytes(path("other/" + name))) << name;
  EXPECT_EQ(read_bytes(path("other/map.qml")), "mine");
  runs("drive.rawlog --output without --no-site");
  EXPECT_FALSE(exists("without/site.tif") || exists("without/site.png"));
  EXPECT_FALSE(summary("without").contains("site"));
  EXPECT_EQ(read_bytes(path("out/map.tif")), read_bytes(path("without/map.tif")));
  expect_refused("drive.rawlog --no-site --traffic", 2, "--no-site");
}

TEST_F(TalusMapSite, resume_goes_on_with_the_map_of_yesterday)
{
  write_drive("whole", 160);
  write_drive("monday", 80);
  write_drive("tuesday", 80, 80);
  runs("whole.rawlog");
  runs("monday.rawlog");
  runs("tuesday.rawlog --resume monday_map/site.tif");
  EXPECT_GT(area_m2("tuesday_map"), 0.85 * area_m2("whole_map")) << "without Monday's scans";
  EXPECT_LT(area_m2("monday_map"), 0.75 * area_m2("whole_map"));
  // ... and in its own folder.
  runs("tuesday.rawlog --resume tuesday_map/site.tif --output tuesday_map");
  EXPECT_GT(area_m2("tuesday_map"), 0.85 * area_m2("whole_map")) << "without Monday's scans";
}

TEST_F(TalusMapSite, resume_refuses_what_it_cannot_go_on_with_and_touches_nothing)
{
  write_drive("drive", 10);
  runs("drive.rawlog --output before");
  write_bytes(path("text.tif"), "no picture at all");
  expect_refused("drive.rawlog --resume none.tif", 1, "none.tif");
  expect_refused("drive.rawlog --resume text.tif", 1, "text.tif");
  expect_refused("drive.rawlog --resume before/map.tif", 1, "before/map.tif");
  expect_refused(
      "drive.rawlog -s resolution_m=0.1 --resume before/site.tif", 1, "resolution_m=0.05");
  expect_refused("drive.rawlog drive.rawlog --resume before/site.tif", 2, "takes one log");
  expect_refused("drive.rawlog --no-site --resume before/site.tif", 2, "--no-site");
  expect_refused("drive.rawlog --memory 0", 2, "--memory");
}

TEST_F(TalusMapSite, of_a_drive_in_two_halves_far_apart_is_a_file_for_each)
{
  write_drive("drive", 20);
  std::string tum;
  for (int i = 0; i < 20; ++i)
  {
    const double away_m = i < 12 ? 0.1 * i : 1e6 + 0.1 * i;
    char line[120];
    std::snprintf(
        line, sizeof line, "%.1f %.1f %.1f 0 0 0 0 1\n", kFirstStamp_s + 0.1 * i, away_m,
        i < 12 ? 0.0 : -1e6);
    tum += line;
  }
  write_bytes(path("far.tum"), tum);
  std::filesystem::create_directory(path("out"));
  write_bytes(path("out/site_floor_1_island_7.tif"), "old");
  const CommandEnd done = runs("drive.rawlog --trajectory far.tum --output out");
  EXPECT_FALSE(exists("out/site_floor_1_island_7.tif"));
  EXPECT_TRUE(exists("out/site_island_1.tif") && exists("out/site_island_1.png"));
  EXPECT_TRUE(done.says("the site map goes on far away: site_island_1.tif has ")) << done.err;
  EXPECT_EQ(summary("out")["site"]["islands"], 1);
  EXPECT_LT(summary("out")["site"]["length_m"], 3) << "the jump is not driven";
  const double area_of_both_m2 = area_m2("out");
  // It goes on with both.
  runs("drive.rawlog --resume out/site.tif --output on");
  EXPECT_GE(area_m2("on"), area_of_both_m2);
  EXPECT_EQ(summary("on")["site"]["islands"], 1);
}

TEST_F(TalusMapSite, that_cannot_be_written_takes_no_other_result_along)
{
  write_drive("drive", 10);
  std::string tum = straight_tum(9);
  tum += std::to_string(kFirstStamp_s + 0.9) + " 1000000 1000000 0 0 0 0 1\n";
  write_bytes(path("far.tum"), tum);
  fails(
      "drive.rawlog --trajectory far.tum --keep-far --output out", 1,
      {"the site map is not written: out/site.tif: the site spans",
       "everything but its site map is in out"});
  EXPECT_TRUE(exists("out/map.tif") && exists("out/map.png") && exists("out/timing.csv"));
  EXPECT_FALSE(exists("out/site.tif"));
  EXPECT_EQ(summary("out")["site"], nullptr);
}

TEST_F(TalusMapSite, the_map_of_the_window_lies_where_the_site_does)
{
  write_drive("drive", 20);
  runs("drive.rawlog --output here");
  runs("drive.rawlog --output there --origin 36.8383,-2.4045,52,30");
  const auto here = io::read_geotiff(path("here/map.tif"));
  const auto there = io::read_geotiff(path("there/map.tif"));
  EXPECT_NE(read_bytes(path("here/map.tif")), read_bytes(path("there/map.tif")));
  EXPECT_NEAR(here.min_x_m, there.min_x_m, 1e-9);
  EXPECT_NEAR(here.min_y_m, there.min_y_m, 1e-9);
  EXPECT_EQ(here.names, there.names);
  for (const char* file : {"there/map.tif", "there/site.tif"})
  {
    EXPECT_SAYS(read_bytes(path(file)), "north is not up") << file;
    EXPECT_SAYS(read_bytes(path(file)), "36.8383 -2.4045 52 30") << file;
  }
  EXPECT_TRUE(exists("there/site_way.gpkg"));
}

TEST_F(TalusMapSite, origin_says_where_on_earth_the_map_is)
{
  write_drive("drive", 10);
  runs("drive.rawlog --output a --origin 36.8383,-2.4045");
  runs("drive.rawlog --output b --origin -33.5,151.25,52,-30");
  const auto a = origin_of("a/site.tif"), b = origin_of("b/site.tif");
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->latitude_deg, 36.8383, 1e-9);
  EXPECT_NEAR(a->longitude_deg, -2.4045, 1e-9);
  EXPECT_EQ(a->altitude_m, 0);
  EXPECT_NEAR(b->latitude_deg, -33.5, 1e-9);
  EXPECT_NEAR(b->altitude_m, 52, 1e-6);
  EXPECT_NEAR(b->heading_deg, -30, 1e-6);
  // One place and heading in another text is no other origin.
  const CommandEnd same =
      runs("drive.rawlog --output c --resume b/site.tif --origin -33.5,151.25,52,330");
  EXPECT_EQ(same.err, "");
  const CommandEnd moved = runs("drive.rawlog --output d --resume b/site.tif --origin -90,-180");
  EXPECT_SAYS(moved.err, "another origin on Earth, -33.5");
  ASSERT_TRUE(origin_of("d/site.tif"));
  EXPECT_EQ(origin_of("d/site.tif")->longitude_deg, 180);
  for (const auto& [origin, words] : std::map<std::string, std::string>{
           {"91,0", "the latitude 91 is not in [-90, 90]"},
           {"0,181", "the longitude 181 is not in"},
           {"36.8", "LAT,LON[,ALT[,HEADING]]"},
           {"36.8,2,3,4,5", "LAT,LON[,ALT[,HEADING]]"},
           {"36.8,east", "'east' is no number"},
           {"nan,0", "'nan' is no number"},
           {"''", "--origin"}})
    expect_refused("drive.rawlog --origin " + origin, 2, words);
}

TEST_F(TalusMapSite, takes_the_origin_from_the_gps_of_the_log)
{
  // The robot drives along x, which points north; the antenna is 1 m ahead of its base.
  constexpr double kNorth_m = 110968.7;  // of a degree of latitude there
  Objects objects;
  for (int i = 0; i < 150; ++i)
  {
    objects.push_back(floor_scan(kFirstStamp_s + 0.1 * i));
    auto gps = observation_at<mrpt::obs::CObservationGPS>(kFirstStamp_s + 0.1 * i, "gps");
    mrpt::obs::gnss::Message_NMEA_GGA gga;
    gga.fields.latitude_degrees = 36.8383 + (0.1 * i + 1) / kNorth_m;
    gga.fields.longitude_degrees = -2.4045;
    gga.fields.altitude_meters = 52;
    gga.fields.fix_quality = i < 5 ? 0 : 1;
    if (i < 5) gga.fields.latitude_degrees = 0;
    gps->setMsg(gga);
    gps->sensorPose = mrpt::poses::CPose3D(1, 0, 2, 0, 0, 0);
    objects.push_back(gps);
  }
  write_log(path("drive.rawlog"), objects, Packing::Gz);
  write_bytes(path("drive.tum"), straight_tum(150));
  const CommandEnd done = runs("drive.rawlog --output out");
  EXPECT_EQ(done.err, "");
  const auto origin = origin_of("out/site.tif");
  ASSERT_TRUE(origin);
  EXPECT_NEAR((origin->latitude_deg - 36.8383) * kNorth_m, 0, 0.05);
  EXPECT_NEAR(origin->longitude_deg, -2.4045, 1e-7);
  EXPECT_NEAR(origin->altitude_m, 50, 0.01);
  EXPECT_NEAR(origin->heading_deg, 90, 0.1);
}
