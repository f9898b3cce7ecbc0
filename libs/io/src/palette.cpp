#include <talus/io/palette.h>

#include <algorithm>
#include <cmath>

namespace talus::io
{
Rgb score_colour(float score)
{
  constexpr std::array<Rgb, 4> kStops{
      palette::kBlocked.rgb, palette::kHard.rgb, palette::kUneven.rgb, palette::kFree.rgb};
  constexpr double kFreeFrom = 0.9;
  if (std::isnan(score)) return palette::kNotJudged.rgb;
  const double at = std::clamp(score / kFreeFrom, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double part = at - static_cast<double>(below);
  Rgb colour{};
  for (std::size_t k = 0; k < 3; ++k)
    colour[k] = static_cast<std::uint8_t>(
        std::lround((1 - part) * kStops[below][k] + part * kStops[below + 1][k]));
  return colour;
}

}  // namespace talus::io
