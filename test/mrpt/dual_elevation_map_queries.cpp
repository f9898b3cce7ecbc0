#include <talus/io/geotiff.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <mrpt/obs/CObservationOdometry.h>

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "message_of.h"
#include "room_for_maps.h"
#include TALUS_SCENE_HEADER(CSetOfObjects.h)
#include TALUS_SCENE_HEADER(CSetOfTriangles.h)

using namespace talus_test;
namespace fs = std::filesystem;

namespace
{
/** A folder of this process, gone with the object. */
struct TemporaryFolder
{
  TemporaryFolder() { fs::create_directories(path); }
  ~TemporaryFolder() { fs::remove_all(path); }
  fs::path path = fs::temp_directory_path() / ("talus_save_" + std::to_string(getpid()));
};
}  // namespace

TEST(DualElevationMapQueries, the_true_pose_is_the_likeliest_of_all_around_it)
{
  const auto map = map_of_room();
  const CPose3D truth(0.05, 0.02, 0, 0.15, 0, 0);
  const auto scan = scan_of_room(truth);
  ASSERT_TRUE(map.canComputeObservationLikelihood(scan));
  const double best = map.computeObservationLikelihood(scan, truth);
  for (int axis = 0; axis < 6; axis++)
    for (const double amount : {-4.0, -2.0, -1.0, 1.0, 2.0, 4.0})
    {
      const double step = axis < 3 ? 0.05 * amount : 0.035 * amount;  // one cell; two degrees
      double d[6] = {0, 0, 0, 0, 0, 0};
      d[axis] = step;
      const CPose3D wrong = truth + CPose3D(d[0], d[1], d[2], d[3], d[4], d[5]);
      EXPECT_GT(best, map.computeObservationLikelihood(scan, wrong))
          << "axis " << axis << " by " << step;
    }
}

TEST(DualElevationMapQueries, the_likelihood_counts_the_points_that_an_insertion_accepts)
{
  auto map = map_of_room(1);
  auto& p = map.insertionOptions;
  const auto& s = kT_base_sensor;
  p.body_boxes_m = {
      {s.x() - 0.5, s.x() + 0.75, s.y() - 0.5, s.y() + 0.5, s.z() - 0.5, s.z() + 0.5}};
  p.max_range_m = 2.7;
  p.min_range_m = 0.6;
  p.max_height_m = 1.1;
  map.likelihoodOptions.decimation = 1;
  const auto next = [](float v) { return std::nextafter(v, 9.0F); };
  for (const TPoint3D& at :
       {TPoint3D(0.75, 0, 0), TPoint3D(next(0.75F), 0, 0), TPoint3D(0.7, 0.5, 0),
        TPoint3D(0.7, -0.5, 0.5), TPoint3D(0.6F, 0.7, 0), TPoint3D(2.7F, 0, 0),
        TPoint3D(next(2.7F), 0, 0), TPoint3D(next(next(2.7F)), 0, 0), TPoint3D(0, 0.6F, 0),
        TPoint3D(0, 1, 1.1F), TPoint3D(0, 1, next(1.1F)), TPoint3D(0, 0.6, -0.3)})
  {
    const auto obs = cloud({at}, kT_base_sensor);
    const double likelihood = map.computeObservationLikelihood(obs, CPose3D());
    auto copy = map;
    ASSERT_TRUE(copy.insertObservation(obs, CPose3D()));
    EXPECT_EQ(likelihood != 0, copy.lastReport().points_accepted == 1) << at;
  }
}

TEST(DualElevationMapQueries, labels_say_what_each_point_of_an_observation_is)
{
  using talus::PointLabel;
  const auto map = map_of_room();
  const CPose3D pose(0.05, 0.02, 0, 0.15, 0, 0);
  const auto scan = scan_of_room(pose);
  const auto labels = map.labelPoints(scan, pose);
  const auto world = room();
  ASSERT_EQ(labels.size(), world.size());
  for (std::size_t i = 0; i < labels.size(); i++)
    if (world[i].z == 0 || world[i].z > 0.2)
    {
      EXPECT_EQ(labels[i], world[i].z == 0 ? PointLabel::Ground : PointLabel::Stands) << world[i];
    }
  EXPECT_TRUE(map.labelPoints(mrpt::obs::CObservationOdometry(), pose).empty());
  EXPECT_EQ(map.labelPoints(scan, CPose3D(50, 0, 0, 0, 0, 0)).front(), PointLabel::Outside);
  EXPECT_EQ(CDualElevationMap().labelPoints(scan).front(), PointLabel::Outside);

  talus::SensorPoints points;
  ASSERT_TRUE(talus::points_from_observation(scan, points));
  const auto cloud = talus::labelled_cloud(points, labels);
  ASSERT_EQ(cloud->size(), labels.size());
  EXPECT_THROW(talus::labelled_cloud(points, {}), std::invalid_argument);
}

TEST(DualElevationMapQueries, matching_ratio_is_high_at_the_true_pose_and_low_elsewhere)
{
  const auto map = map_of_room();
  CSimplePointsMap points;
  for (const auto& p : room())
    points.insertPoint(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
  const mrpt::maps::TMatchingRatioParams params;
  EXPECT_GT(map.compute3DMatchingRatio(&points, CPose3D(), params), 0.97F);
  EXPECT_LT(map.compute3DMatchingRatio(&points, CPose3D(0, 0, 1, 0, 0, 0), params), 0.1F);
  EXPECT_EQ(CDualElevationMap().compute3DMatchingRatio(&points, CPose3D(), params), 0.0F);
  EXPECT_GT(map.compute3DMatchingRatio(&map, CPose3D(), params), 0.99F);
}

TEST(DualElevationMapQueries, pairs_points_with_the_surfaces_where_the_other_map_is_shifted)
{
  const auto map = map_of_room();
  CSimplePointsMap corner;  // of the first box, in a frame 4 cm off
  const CPose3D T_map_other(0.04, 0, 0, 0, 0, 0);
  for (float y = -0.4F; y < 0.4F; y += 0.05F)
    for (const float z : {0.15F, 0.25F, 0.45F}) corner.insertPoint(1.02F, y, z);
  mrpt::tfest::TMatchingPairList pairs;
  mrpt::maps::TMatchingParams params;
  params.maxDistForCorrespondence = 0.2F;
  mrpt::maps::TMatchingExtraResults extra;
  map.determineMatching3D(&corner, T_map_other, pairs, params, extra);
  EXPECT_GT(extra.correspondencesRatio, 0.5F);
  ASSERT_GT(pairs.size(), 20U);
  for (const auto& p : pairs)
    EXPECT_LT(
        std::hypot(p.global.x - p.local.x - 0.04, p.global.y - p.local.y, p.global.z - p.local.z),
        0.2);

  pairs.clear();
  map.determineMatching3D(&corner, CPose3D(0, 0, 2, 0, 0, 0), pairs, params, extra);
  EXPECT_TRUE(pairs.empty()) << "two metres above";
}

TEST(DualElevationMapQueries, what_stands_is_found_from_above_and_the_ground_is_not)
{
  const auto map = map_of_room();
  EXPECT_LT(map.squareDistanceToClosestCorrespondence(1.3F, 0), 0.01F) << "on a box";
  const float far2 = map.squareDistanceToClosestCorrespondence(0.02F, 0);
  EXPECT_NEAR(std::sqrt(far2), 1.0, 0.08) << "a metre before it";
  EXPECT_TRUE(std::isinf(CDualElevationMap().squareDistanceToClosestCorrespondence(0, 0)));

  CSimplePointsMap side;  // of the first box, and of the bare floor
  for (float y = -0.4F; y < 0.4F; y += 0.05F) side.insertPoint(1.05F, y, 0.3F);
  side.insertPoint(-1, -1, 0);
  mrpt::tfest::TMatchingPairList pairs;
  mrpt::maps::TMatchingParams params;
  mrpt::maps::TMatchingExtraResults extra;
  params.maxDistForCorrespondence = 0.1F;
  params.maxAngularDistForCorrespondence = 0;
  map.determineMatching2D(&side, mrpt::poses::CPose2D(), pairs, params, extra);
  EXPECT_EQ(pairs.size(), side.size() - 1);
}

#if MRPT_VERSION >= 0x020b03
TEST(DualElevationMapQueries, programs_find_the_neighbours_of_a_place)
{
  const auto map = map_of_room();
  const mrpt::maps::NearestNeighborsCapable& neighbours = map;
  ASSERT_TRUE(neighbours.nn_has_indices_or_ids());
  EXPECT_EQ(neighbours.nn_index_count(), map.getAsSimplePointsMap()->size());
  mrpt::math::TPoint3Df found;
  float distance2 = 0;
  std::uint64_t index = 0;
  neighbours.nn_prepare_for_3d_queries();
  ASSERT_TRUE(neighbours.nn_single_search({1.3F, 0, 0.6F}, found, distance2, index));
  EXPECT_NEAR(found.z, 0.45, 0.02) << "the top of the box";
  std::vector<mrpt::math::TPoint3Df> all;
  std::vector<float> distances2;
  std::vector<std::uint64_t> indices;
  neighbours.nn_radius_search({1.3F, 0, 0.45F}, 0.01F, all, distances2, indices, 0);
  EXPECT_GT(all.size(), 5U);
}
#endif

TEST(DualElevationMapQueries, its_points_map_and_bounding_box_hold_what_was_measured)
{
  const auto map = map_of_room();
  const auto* points = map.getAsSimplePointsMap();
  ASSERT_NE(points, nullptr);
  EXPECT_GT(points->size(), 8000U);  // 5 m x 5 m of 0.05 m cells are 10,000
  const auto box = map.boundingBox();
  EXPECT_NEAR(box.max.z, 0.45, 0.02);
  EXPECT_NEAR(box.min.z, 0.0, 0.05);
  EXPECT_GT(box.max.x, 2.45);
  EXPECT_LE(box.max.x, map.mapper().window().min_x_m() + 6.001);  // filled ground counts too
}

TEST(DualElevationMapQueries, the_scene_holds_both_surfaces_and_honours_the_generic_options)
{
  auto map = map_of_room();
  auto scene = map.getVisualization();
  const auto triangles = [&](const char* name) -> std::size_t
  {
    const auto mesh =
        std::dynamic_pointer_cast<talus::mrpt_scene::CSetOfTriangles>(scene->getByName(name));
    return mesh ? mesh->getTrianglesCount() : 0;
  };
  EXPECT_GT(triangles("ground"), 10000U);
  EXPECT_GT(triangles("elevation"), 200U);
  EXPECT_LT(triangles("elevation"), triangles("ground"));
  map.renderOptions.showGround = false;
  map.renderOptions.colorByTraversability = false;
  map.renderOptions.maxCells = 60;
  scene = map.getVisualization();
  EXPECT_EQ(triangles("ground"), 0U);
  EXPECT_LT(triangles("elevation"), 7000U);
  map.genericMapParams.enableSaveAs3DObject = false;
  EXPECT_TRUE(map.getVisualization()->empty());
}

TEST(DualElevationMapQueries, the_scene_follows_the_map_and_its_options)
{
  auto map = map_of_room(1);
  const auto ground = [&]
  {
    return std::dynamic_pointer_cast<talus::mrpt_scene::CSetOfTriangles>(
        map.getVisualization()->getByName("ground"));
  };
  const auto first = ground();
  EXPECT_EQ(ground(), first) << "nothing changed: drawn once";
  map.renderOptions.colorByTraversability = false;
  const auto by_height = ground();
  EXPECT_NE(by_height, first);
  map.insertObservation(scan_of_room(CPose3D(0.5, 0, 0, 0, 0, 0)), CPose3D(0.5, 0, 0, 0, 0, 0));
  EXPECT_NE(ground(), by_height);
  map.clear();
  EXPECT_EQ(ground(), nullptr);
}

TEST(DualElevationMapQueries, saving_writes_geotiff_picture_and_scene)
{
  const auto map = map_of_room();
  const TemporaryFolder temporary;
  const fs::path& folder = temporary.path;
  map.saveMetricMapRepresentationToFile((folder / "room").string());
  for (const char* ending : {".tif", ".png", ".3Dscene"})
    EXPECT_GT(fs::file_size(folder / (std::string("room") + ending)), 1000U) << ending;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 3);

  const auto stack = talus::io::read_geotiff((folder / "room.tif").string());
  const auto* elevation = stack.find("elevation");
  ASSERT_NE(elevation, nullptr);
  const auto& expected = map.mapper().layer(Layer::Elevation);
  ASSERT_EQ(elevation->size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); i++)
    ASSERT_EQ(std::memcmp(&(*elevation)[i], &expected[i], sizeof(float)), 0) << i;
}

TEST(DualElevationMapQueries, an_empty_map_saves_nothing_and_an_unwritable_place_is_named)
{
  const TemporaryFolder temporary;
  const fs::path& folder = temporary.path;
  CDualElevationMap().saveMetricMapRepresentationToFile((folder / "empty").string());
  EXPECT_TRUE(fs::is_empty(folder));
  const auto save = [&]
  { map_of_room(1).saveMetricMapRepresentationToFile((folder / "missing" / "room").string()); };
  EXPECT_TRUE(has(message_of(save), "missing/room"));
}
