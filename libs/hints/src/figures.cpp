#include "figures.h"

#include <algorithm>
#include <cmath>

namespace talus::hints
{
double Values::quantile(double share) const
{
  if (values_.empty()) return 0;
  std::vector<float> sorted = values_;
  const auto at = static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(at), sorted.end());
  return sorted[at];
}

NearPlane SensorFigures::ground() const
{
  NearPlane plane;
  if (ground_m.size() == 0) return plane;
  const double x = normal_x.median(), y = normal_y.median();
  plane.found = true;
  plane.normal = {x, y, std::sqrt(std::max(0.0, 1 - x * x - y * y))};
  plane.offset_m = plane.normal.z * ground_m.median();
  plane.rms_m = rms_m.median();
  return plane;
}

double SensorFigures::share(const Values& values) const
{
  return analysed == 0 ? 0 : static_cast<double>(values.size()) / static_cast<double>(analysed);
}

const SensorFigures* Figures::sensor_with_most_frames() const
{
  const auto most = std::max_element(
      sensors.begin(), sensors.end(),
      [](const SensorFigures& a, const SensorFigures& b) { return a.frames < b.frames; });
  return most == sensors.end() ? nullptr : &*most;
}

}  // namespace talus::hints
