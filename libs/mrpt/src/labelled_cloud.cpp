#include <talus/mrpt/labelled_cloud.h>
#include <talus/mrpt/version_compat.h>

#include <stdexcept>

namespace talus
{
mrpt::maps::CPointsMap::Ptr labelled_cloud(
    const SensorPoints& points, const std::vector<PointLabel>& labels)
{
  const std::size_t size = points.x_m.size();
  if (labels.size() != size)
    throw std::invalid_argument("labelled_cloud: there must be a label for each point");
  const auto cloud = detail::make_cloud_with_intensity(size);
  for (std::size_t i = 0; i < size; i++)
  {
    cloud->setPointFast(i, points.x_m[i], points.y_m[i], points.z_m[i]);
    detail::set_intensity(*cloud, i, static_cast<float>(labels[i]));
  }
  return cloud;
}

}  // namespace talus
