#include <talus/hints/highest_ray.h>
#include <talus/number_text.h>

#include <cmath>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
std::string metres(double m, int digits) { return fixed_text(m, digits) + " m"; }
}  // namespace

double HighestRay::height_m(double from_base_m) const
{
  return sensor_m + slope * (from_base_m - ahead_m);
}

std::string seen_ahead(const HighestRay& ray, double height_m)
{
  const double rise_m = height_m - ray.sensor_m;
  const bool is_above = rise_m > 0;
  if (ray.slope <= 0 && is_above) return "nowhere";
  if (ray.slope >= 0 && !is_above) return "everywhere";
  const double at_m = ray.ahead_m + rise_m / ray.slope;
  return is_above ? "from " + metres(at_m, 1) + " on" : "up to " + metres(at_m, 1);
}

std::optional<std::string> unseen_ahead(const HighestRay& ray, double clearance_m)
{
  const double seen_m = ray.height_m(kLooksAhead_m);
  if (ray.slope >= 0 || seen_m >= clearance_m) return {};
  return "the highest ray ahead looks " + fixed_text(-std::atan(ray.slope) * 180 / M_PI, 0) +
         " degrees down from " + metres(ray.sensor_m, 2) +
         ", below clearance_m = " + number_text(clearance_m) + ": " + metres(kLooksAhead_m, 0) +
         " ahead and farther nothing between " + metres(seen_m, 2) + " and " +
         metres(clearance_m, 2) +
         " is seen, such as the board of a table: tilt the sensor less, mount it higher, or add "
         "another";
}

}  // namespace talus::hints
