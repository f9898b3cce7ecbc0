#include <talus/io/score_colour.h>

#include <cstddef>

namespace talus::io
{
std::array<std::uint8_t, 3> label_colour(PointLabel label)
{
  static constexpr std::array<std::array<std::uint8_t, 3>, kPointLabelCount> kColours{
      {{90, 90, 90},
       {0, 158, 115},
       {213, 94, 0},
       {86, 180, 233},
       {204, 121, 167},
       {240, 228, 66},
       {190, 190, 190}}};
  return kColours[static_cast<std::size_t>(label)];
}

}  // namespace talus::io
