#include "changes.h"
#include "picture_sheet.h"

#include <talus/io/map_picture.h>
#include <talus/number_text.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace talus::site
{
namespace
{
using io::bgr;
constexpr const auto& kKinds = io::palette::kChanges;
const io::NamedColour kOnlyOne{"not seen both times", io::pale(kKinds[0].rgb)},
    kStands{"stands on the ground", io::pale(io::palette::kStands.rgb)};

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
  cv::Mat3b image(r.ground_m.size(), bgr(io::palette::kNotSeen.rgb));
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      if (marks.kind(y, x) != 0)
        image(y, x) = bgr(kKinds[marks.kind(y, x)].rgb);
      else if (r.obstacle(y, x) != 0)
        image(y, x) = bgr(kStands.rgb);
      else
        image(y, x) =
            io::lit(bgr((marks.common(y, x) != 0 ? kKinds[0] : kOnlyOne).rgb), shade(y, x));
  return image;
}

void add_kinds(io::Legend& legend, const ChangeSums& sums)
{
  for (const Change c : {Change::Built, Change::Dug, Change::Gone, Change::Appeared})
  {
    const io::NamedColour& kind = kKinds[static_cast<std::size_t>(c)];
    legend.swatch(bgr(kind.rgb), std::string(kind.name) + ": " + area_text(sums.area_m2(c)));
  }
  legend.new_row();
  for (const auto& colour : {kKinds[0], kStands, kOnlyOne, io::palette::kNotSeen})
    legend.swatch(colour);
}

/** Name and date, as far as they are known. */
std::string when(const Site& site, std::uint32_t newest_s)
{
  const std::string date = io::date_text(newest_s);
  return site.name + (site.name.empty() || date.empty() ? "" : ", ") + date;
}

std::vector<std::string> subtitles(
    const std::string& before, const std::string& after, const ChangeSums& sums, double step_m)
{
  const std::string times =
      before.empty() || after.empty() ? "" : "from " + before + " to " + after;
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
      path, sheet.finish(
                "What changed",
                subtitles(when(from, before_s), when(to, raster.newest_s), sums, step_m)));
}

}  // namespace talus::site
