#include "changes.h"
#include "picture_sheet.h"

#include <talus/io/map_picture.h>
#include <talus/number_text.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::site
{
namespace
{
const cv::Vec3b kGround(214, 212, 210), kOnlyOne(238, 234, 230), kStands(128, 122, 120);
/** BGR, by Change. */
const std::array<cv::Vec3b, kChangeCount> kColours{
    {{0, 0, 0}, {184, 110, 30}, {26, 128, 240}, {120, 170, 40}, {46, 30, 200}}};
const std::array<const char*, kChangeCount> kWords{
    "", "built up", "dug away", "object gone", "object new"};

struct Marks
{
  cv::Mat1b kind;  //!< the largest change of a pixel
  cv::Mat1b common;  //!< whether both have seen it
};

Marks marks_of(Site& from, Site& to, int floor, double step_m, const RasterPlace& place)
{
  Marks m{
      cv::Mat1b(place.height, place.width, uchar{0}),
      cv::Mat1b(place.height, place.width, uchar{0})};
  cv::Mat1f largest_m(place.height, place.width, 0.0F);
  for_each_compared_tile(
      from, to, floor, step_m,
      [&](const TileKey& key, const std::vector<CellChange>& changes)
      {
        for (int i = 0; i < kTileCells * kTileCells; ++i)
        {
          const CellChange& c = changes[static_cast<std::size_t>(i)];
          if (std::isnan(c.change_m)) continue;
          const cv::Point at(
              place.column_of(cell_of_tile(key.x, i % kTileCells)),
              place.row_of(cell_of_tile(key.y, i / kTileCells)));
          if (!place.contains(at)) continue;
          m.common(at) = 1;
          if (c.kind == Change::None || std::abs(c.change_m) <= largest_m(at)) continue;
          largest_m(at) = std::abs(c.change_m);
          m.kind(at) = static_cast<uchar>(c.kind);
        }
      });
  // A cell among a thousand is to be seen, too.
  if (place.pixels_per_cell == 1) cv::dilate(m.kind, m.kind, cv::Mat());
  return m;
}

cv::Mat3b colours_of_cells(const SiteRaster& r, const Marks& marks, double pixel_m)
{
  const cv::Mat1f shade = io::hill_shade(r.ground_m, pixel_m);
  cv::Mat3b image(r.ground_m.size(), kNotSeen);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      if (marks.kind(y, x) != 0)
        image(y, x) = kColours[marks.kind(y, x)];
      else if (r.obstacle(y, x) != 0)
        image(y, x) = kStands;
      else
        image(y, x) = io::lit(marks.common(y, x) != 0 ? kGround : kOnlyOne, shade(y, x));
  return image;
}

void add_kinds(io::Legend& legend, const ChangeSums& sums)
{
  for (const Change c : {Change::Built, Change::Dug, Change::Gone, Change::Appeared})
  {
    const auto i = static_cast<std::size_t>(c);
    legend.swatch(kColours[i], std::string(kWords[i]) + ": " + area_text(sums.area_m2(c)));
  }
  legend.new_row();
  legend.swatch(kGround, "as before");
  legend.swatch(kStands, "stands on the ground");
  legend.swatch(kOnlyOne, "not seen both times");
  legend.swatch(kNotSeen, "not seen");
}

std::vector<std::string> subtitles(
    std::uint32_t before_s, std::uint32_t after_s, const ChangeSums& sums, double step_m)
{
  std::string times;
  if (!time_text(before_s).empty() && !time_text(after_s).empty())
    times = "from " + time_text(before_s) + " to " + time_text(after_s);
  double seen_m2 = 0;
  for (const std::size_t cells : sums.cells) seen_m2 += sums.cell_m2 * static_cast<double>(cells);
  const std::string seen = area_text(seen_m2) + " seen both times; changed: by more than " +
                           number_text(step_m, 3) + " m";
  return times.empty() ? std::vector<std::string>{seen} : std::vector<std::string>{times, seen};
}
}  // namespace

void write_changes_picture(
    const std::string& path, Site& from, Site& to, int floor, double step_m, const ChangeSums& sums)
{
  const RasterPlace place(known_box(to, floor), page_turn(to, floor), to.resolution_m);
  const SiteRaster raster(to, floor, place);
  std::uint32_t before_s = 0;
  for_each_known(
      from, floor,
      [&](std::int64_t, std::int64_t, const SiteCell& s)
      { before_s = std::max(before_s, s.seen_s); });
  const Marks marks = marks_of(from, to, floor, step_m, place);
  PictureSheet sheet(place);
  sheet.paint(colours_of_cells(raster, marks, place.pixel_m), raster.measured);
  add_kinds(sheet.legend(), sums);
  sheet.add_scale_and_north(to.origin);
  io::write_png(
      path, sheet.finish("What changed", subtitles(before_s, raster.newest_s, sums, step_m)));
}

}  // namespace talus::site
