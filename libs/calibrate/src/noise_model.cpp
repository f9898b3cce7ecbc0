#include <talus/calibrate/noise_model.h>

#include <algorithm>

namespace talus::calibrate
{
namespace
{
constexpr double kMinDeviation_m = 2e-4;  // no sensor is better; keeps weights finite
}

double NoiseModel::variance_m2(double range_m, double cosine, double half_turn) const
{
  const double sensor = (c_beam_m + a_beam * range_m) * (along_beam ? cosine : 1.0);
  const double turn = lambda_t * range_m * half_turn;
  const double variance = sensor * sensor + turn * turn + ground_m * ground_m;
  return std::max(variance, kMinDeviation_m * kMinDeviation_m);
}

NoiseModel uniform_noise(double deviation_m)
{
  NoiseModel n;
  n.along_beam = false;
  n.c_beam_m = n.a_beam = 0;
  n.ground_m = deviation_m;
  return n;
}

}  // namespace talus::calibrate
