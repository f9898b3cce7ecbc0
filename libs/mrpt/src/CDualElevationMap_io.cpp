#include <talus/mrpt/CDualElevationMap.h>
#include TALUS_MRPT_SCENE_HEADER
#include TALUS_SCENE_HEADER(CSetOfObjects.h)
#include <talus/io/geotiff.h>
#include <talus/io/map_picture.h>
#include <talus/site/site_files.h>

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "warn_once.h"
#include "whole_map.h"

namespace talus
{
namespace
{
/** Whole or not at all: written beside, then renamed. */
void write_scene(const std::string& path, const mrpt_scene::CSetOfObjects::Ptr& objects)
{
  MrptScene scene;
  scene.insert(objects);
  const std::string part = path + ".part";
  std::error_code error;
  const bool written = scene.saveToFile(part);
  if (written) std::filesystem::rename(part, path, error);
  if (written && !error) return;
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  throw std::runtime_error(
      path + ": the scene cannot be written (is the folder there and writable?)");
}
}  // namespace

void CDualElevationMap::saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const
{
  if (isEmpty())
  {
    detail::warn_once(filNamePrefix + ": the map is empty, no files written");
    return;
  }
  const io::LayerStack stack = io::snapshot(mapper());
  io::write_geotiff(filNamePrefix + ".tif", stack);

  io::PictureOptions picture;
  picture.title = std::filesystem::path(filNamePrefix).filename().string();
  picture.has_robot = true;
  picture.robot_x_m = m_T_map_base.x();
  picture.robot_y_m = m_T_map_base.y();
  picture.robot_yaw_rad = m_T_map_base.yaw();
  io::write_map_picture(filNamePrefix + ".png", stack, picture);

  if (m_whole)
    site::write_site_files(
        filNamePrefix + "_site.tif", filNamePrefix + "_site.png",
        m_whole->site_in_hindsight(std::as_const(*this).mapper()));
  if (genericMapParams.enableSaveAs3DObject)
    write_scene(filNamePrefix + ".3Dscene", getVisualization());
}

}  // namespace talus
