#pragma once
#include <talus/baselines/method.h>

#include <array>
#include <vector>

namespace talus::baselines
{
constexpr float kFloat_m = 1e-6f;  //!< rounding of heights of some metres in float

/** 2 x 2 m of cells of 0.1 m around the origin. */
inline Parameters small_window()
{
  Parameters p;
  p.window_m = 2.0;
  p.resolution_m = 0.1;
  p.feature_radius_m = 0.2;
  return p;
}

/** Points of the map frame, seen from 0.5 m above its origin. */
class Scan
{
 public:
  explicit Scan(std::vector<std::array<float, 3>> points, double stamp_s = 0)
  {
    frame_.stamp_s = stamp_s;
    frame_.T_map_sensor.m[11] = kSensor_m;
    for (const auto& p : points)
    {
      x_.push_back(p[0]);
      y_.push_back(p[1]);
      z_.push_back(p[2] - static_cast<float>(kSensor_m));
    }
  }
  Frame view()
  {
    frame_.x_m = x_.data(), frame_.y_m = y_.data(), frame_.z_m = z_.data();
    frame_.size = x_.size();
    return frame_;
  }

 private:
  static constexpr double kSensor_m = 0.5;
  Frame frame_;
  std::vector<float> x_, y_, z_;
};

inline float at(const Surfaces& s, const std::vector<float>& layer, double x_m, double y_m)
{
  return layer[cell_index(s.window, x_m, y_m)];
}

}  // namespace talus::baselines
