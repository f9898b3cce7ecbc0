// A saved map, with the state of its pipeline: what is read can be shown, written and gone on with.
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <sstream>

#include "archive.h"
#include "fuzz.h"

namespace
{
using namespace talus;

/** Some points around the middle of the window. */
void insert_a_scan(CDualElevationMap& map)
{
  const Window w = map.mapper().window();
  const double half_m = 0.5 * w.cells * w.resolution_m;
  mrpt::obs::CObservationPointCloud scan;
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int i = 0; i < 20; i++)
    points->insertPoint(0.3F * static_cast<float>(i % 5), 0.2F * static_cast<float>(i / 5), -0.5F);
  scan.pointcloud = points;
  map.insertObservation(
      scan, mrpt::poses::CPose3D(w.min_x_m() + half_m, w.min_y_m() + half_m, 0.5, 0.1, 0, 0));
}

void use(CDualElevationMap& map)
{
  std::ostringstream text;
  map.insertionOptions.dumpToTextStream(text);
  map.likelihoodOptions.dumpToTextStream(text);
  map.renderOptions.dumpToTextStream(text);
  fuzz::require(!map.asString().empty(), "a map says what it is");
  mrpt::opengl::CSetOfObjects scene;
  map.getVisualizationInto(scene);
  fuzz::require(fuzz::keeps_its_bytes(map), "a map read twice is the same");
  // A window that is wide, and may be, takes its memory with the next frame.
  if (map.insertionOptions.cells() > 512) return;
  insert_a_scan(map);
  fuzz::require(fuzz::keeps_its_bytes(map), "a map that went on is one that can be read");
}
}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  CDualElevationMap map;
  if (fuzz::is_read([&] { fuzz::read_object(data, size, map); })) use(map);
  return 0;
}
