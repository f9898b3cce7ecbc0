#pragma once
#include <talus/io/geo_origin.h>
#include <talus/io/layer_stack.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace talus::formats
{
/** A place of a way [m, map frame]. */
struct PagePoint
{
  double x_m, y_m, z_m;
};

/** What a page shows beside the map. */
struct PageOptions
{
  std::string title;  //!< in UTF-8
  std::string date;  //!< when its newest cell was seen; may be empty
  std::vector<std::vector<PagePoint>> ways;  //!< that were driven
  std::optional<io::GeoOrigin> origin;  //!< where the map is on Earth
  const io::LayerStack* changes =
      nullptr;  //!< bands `kind` and `change_m`, of the same cells' size
  std::size_t max_bytes = std::size_t{30} << 20;  //!< cells are joined until the page is smaller
};

/** Of the names of bands those of channels (see channel_layer_names()): NAME and NAME_standing,
 * where both are there and NAME is one that a channel may have. */
std::vector<std::string> channel_bands(const std::vector<std::string>& names);

/** Throws where write_page() would for want of the package. */
void require_leaflet();

/** One file of HTML that any browser opens without a network: layers to switch (also those of
 * channels), zoom, the values under the pointer or the finger, and distance and height profile
 * between two places; as good on a phone. It brings Leaflet and its licence along, which Debian's
 * libjs-leaflet has. Throws std::runtime_error that names the file, the layer or the package which
 * is missing. */
void write_page(
    const std::string& path, const io::LayerStack& map, const PageOptions& options = PageOptions());

}  // namespace talus::formats
