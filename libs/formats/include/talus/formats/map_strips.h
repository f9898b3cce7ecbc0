#pragma once
#include <talus/io/geotiff.h>
#include <talus/io/layer_stack.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talus::formats
{
/** Some rows of a map. */
struct Strip
{
  const io::LayerStack& map;  //!< those rows, and beside them the margins that were asked for
  int first_row;  //!< of the whole map: where row 0 of `map` lies
  int begin, end;  //!< rows of `map` without the margins
};

/** Layers of a map by strips of rows, from the south: of a large site no layer is in memory as a
 * whole. What it is made of must outlive it. */
class MapStrips
{
 public:
  /** One strip. */
  MapStrips(const io::LayerStack& whole);  // NOLINT(google-explicit-constructor): is a map, too
  /** These bands of a file, as far as it has them; throws std::runtime_error where it has none. */
  MapStrips(const io::GeotiffFile& file, const std::vector<std::string>& bands);

  /** Where it lies, and the names of its layers, without these. */
  const io::LayerStack& frame() const { return frame_; }

  /** Calls f for each strip. Throws what f and GeotiffFile::read() throw, and std::runtime_error
   * that names the file where a cell has what no map has. */
  void for_each(const std::function<void(const Strip&)>& f, int margin = 0) const;

  /** The same with 2 x 2 cells joined into one: the mean of known heights of the ground, the min of
   * traversability and sparsity, the max of all else. Its cells lie at whole multiples of their
   * size from the corner. */
  MapStrips joined() const;

  /** All of it. */
  io::LayerStack whole() const;

 private:
  io::LayerStack rows_of_file(int first, int last) const;

  io::LayerStack frame_;
  const io::LayerStack* whole_ = nullptr;
  std::shared_ptr<const io::LayerStack> owned_;
  const io::GeotiffFile* file_ = nullptr;
  std::vector<std::string> bands_;
  int joins_ = 0;
};

}  // namespace talus::formats
