#pragma once
#include <talus/layers.h>
#include <talus/point_labels.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace talus::io
{
/** Red, green, blue. */
using Rgb = std::array<std::uint8_t, 3>;

/** A colour, and what it means, as legends say it. */
struct NamedColour
{
  const char* name;  //!< in legends
  Rgb rgb;  //!< the colour
};

/** A colour as ground has it that was only inferred. */
constexpr Rgb pale(const Rgb& c)
{
  const auto half = [](int v) { return static_cast<std::uint8_t>((v + 255) / 2); };
  return {half(c[0]), half(c[1]), half(c[2])};
}

/** The colours of all pictures, pages, windows and styles. Ground is like paper where it drives
 * well and goes over yellow and orange to red where it does not; what stands is dark; what was
 * inferred is pale. Orange is ground that is hard to drive, and nothing else. Who sees no red or no
 * green tells all of one list apart, too. */
namespace palette
{
/// @name Ground by its traversability; see score_colour()
/// @{
inline constexpr NamedColour kBlocked{"blocked", {165, 20, 38}};  //!< 0
inline constexpr NamedColour kHard{"hard", {222, 90, 45}};  //!< 0.3
inline constexpr NamedColour kUneven{"uneven", {248, 190, 95}};  //!< 0.6
inline constexpr NamedColour kFree{"free", {216, 207, 186}};  //!< 0.9 to 1
/// @}
/** An object that blocks. */
inline constexpr NamedColour kStands{"stands in the way", {38, 42, 58}};
/** As free ground has it. */
inline constexpr NamedColour kInferred{"pale: filled, or not reached", pale(kFree.rgb)};
/** Known ground without a traversability. */
inline constexpr NamedColour kNotJudged{"not judged", {172, 164, 204}};
/** The same on maps, where free guesses from one side count as not judged. */
inline constexpr NamedColour kGuessed{"not judged, or guessed", pale(kNotJudged.rgb)};
/** Nothing is known. */
inline constexpr NamedColour kNotSeen{"not seen", {247, 248, 250}};
/** A ditch or an edge that was seen from afar. */
inline constexpr NamedColour kMayDrop{"may drop", {170, 84, 196}};
/** Where the robot was. */
inline constexpr NamedColour kPath{"path driven", {0, 56, 140}};
/// @name On drives of a simulated robot
/// @{
/** In the costmap, over the truth. */
inline constexpr NamedColour kKnownBlocked{"blocked, as the robot knows", {0, 125, 125}};
/** Points. */
inline constexpr NamedColour kGiven{"obstacles given to the navigator", {48, 24, 240}};
/// @}
/** Where the ground height comes from, by CellState; the last one: measured and not reached. */
inline constexpr std::array<NamedColour, kCellStates + 1> kStates{
    {{"not seen", kNotSeen.rgb},
     {"measured", {122, 106, 74}},
     {"filled, 2 sides", {188, 166, 112}},
     {"filled, 1 side", {128, 178, 205}},
     {"presumed", {70, 150, 140}},
     {"measured, not reached", {90, 70, 130}}}};
/** What changed, by the numbers of the band `kind`; the first: nothing. */
inline constexpr std::array<NamedColour, 5> kChanges{
    {{"as before", kFree.rgb},
     {"built up", {50, 125, 205}},
     {"dug away", {90, 40, 130}},
     {"object gone", {80, 195, 185}},
     {"object new", {190, 20, 50}}}};
/** What a point is, by PointLabel. */
inline constexpr std::array<NamedColour, kPointLabelCount> kLabels{
    {{"not taken", {90, 90, 90}},
     {"ground", {176, 146, 92}},
     {"stands", kStands.rgb},
     {"hangs", {110, 185, 235}},
     {"moved away", kMayDrop.rgb},
     {"below ground", kBlocked.rgb},
     {"outside", {190, 190, 190}}}};
}  // namespace palette

/** The colour of a score or traversability: palette::kBlocked at 0, palette::kFree from 0.9 on,
 * and palette::kNotJudged for NaN. Values beyond count as the ends. */
Rgb score_colour(float score);

}  // namespace talus::io
