#include <talus/formats/map_strips.h>
#include <talus/formats/write.h>

#include "needed_layer.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace talus::formats
{
namespace
{
constexpr int kBlock = 256;  // cells along a side of the blocks of a site
constexpr int kColumns = 16 * kBlock;  // that are read at once; those without blocks cost little
constexpr std::size_t kStripValues = std::size_t{16} << 20;  // of a wide map: fewer rows

io::LayerStack joined_frame(io::LayerStack frame)
{
  frame.cells_x = (frame.cells_x + 1) / 2;
  frame.cells_y = (frame.cells_y + 1) / 2;
  frame.resolution_m *= 2;
  return frame;
}
}  // namespace

MapStrips::MapStrips(const io::LayerStack& whole)
    : frame_{whole.cells_x,
             whole.cells_y,
             whole.resolution_m,
             whole.min_x_m,
             whole.min_y_m,
             whole.names,
             {}},
      whole_(&whole)
{
}

MapStrips::MapStrips(const io::GeotiffFile& file, const std::vector<std::string>& bands)
    : frame_(file.frame()), file_(&file), bands_(bands)
{
  for (const std::string& band : file.bands())
    if (std::count(bands.begin(), bands.end(), band) > 0) frame_.names.push_back(band);
  if (!frame_.names.empty()) return;
  throw std::runtime_error(
      file.path() + ": has none of the bands of a map: give a map.tif or site.tif of talus-map");
}

void MapStrips::for_each(const std::function<void(const Strip&)>& f, int margin) const
{
  if (whole_) return f({*whole_, 0, 0, whole_->cells_y});
  const std::size_t of_row = frame_.names.size() * static_cast<std::size_t>(frame_.cells_x);
  const int most = static_cast<int>(std::min<std::size_t>(kBlock, kStripValues / of_row));
  const int rows = std::max(1, most >> joins_);
  for (int row = 0; row < frame_.cells_y; row += rows)
  {
    const int first = std::max(0, row - margin);
    const int begin = row - first, end = std::min(rows, frame_.cells_y - row) + begin;
    const int last = std::min(end + margin + first, frame_.cells_y);
    f({rows_of_file(first, last), first, begin, end});
  }
}

io::LayerStack MapStrips::rows_of_file(int first, int last) const
{
  const int side = 1 << joins_, columns = std::max(1, kColumns / side);
  const io::LayerStack all = file_->frame();
  io::LayerStack rows = frame_;
  rows.cells_y = last - first;
  rows.min_y_m += first * side * all.resolution_m;
  const auto cells =
      static_cast<std::size_t>(rows.cells_x) * static_cast<std::size_t>(rows.cells_y);
  rows.layers.resize(rows.names.size(), std::vector<float>(cells));
  for (int column = 0; column < rows.cells_x; column += columns)
  {
    const int x = column * side, y = first * side;
    io::LayerStack part = file_->read_part(
        x, y, std::min(columns * side, all.cells_x - x), std::min(last * side, all.cells_y) - y,
        bands_);
    require_sound_cells(part, file_->path());
    for (int i = 0; i < joins_; ++i) part = joined_cells(part);
    for (std::size_t k = 0; k < rows.layers.size(); ++k)
      for (int iy = 0; iy < part.cells_y; ++iy)
        std::copy_n(
            part.layers[k].begin() + std::ptrdiff_t{iy} * part.cells_x, part.cells_x,
            rows.layers[k].begin() + std::ptrdiff_t{iy} * rows.cells_x + column);
  }
  return rows;
}

MapStrips MapStrips::joined() const
{
  MapStrips to = *this;
  to.frame_ = joined_frame(frame_);
  ++to.joins_;
  if (!whole_) return to;
  to.owned_ = std::make_shared<const io::LayerStack>(joined_cells(*whole_));
  to.whole_ = to.owned_.get();
  return to;
}

io::LayerStack MapStrips::whole() const
{
  if (whole_) return *whole_;
  io::LayerStack all = frame_;
  all.layers.resize(all.names.size());
  for (auto& layer : all.layers)
    layer.reserve(static_cast<std::size_t>(all.cells_x) * static_cast<std::size_t>(all.cells_y));
  for_each(
      [&](const Strip& strip)
      {
        for (std::size_t i = 0; i < all.layers.size(); ++i)
          all.layers[i].insert(
              all.layers[i].end(), strip.map.layers[i].begin(), strip.map.layers[i].end());
      });
  return all;
}

}  // namespace talus::formats
