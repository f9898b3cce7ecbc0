#pragma once
#include <talus/frame.h>

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace talus
{
/** Makes frames of points whose x, y, z are stored together. One a sensor: it reuses its memory. */
class InterleavedPoints
{
 public:
  /** A frame of `size` points [m], sensor frame. The floats x, y, z of point k are at `first` + k *
   * `stride_bytes`, at any address, e.g. `frame(&cloud[0].x, cloud.size(), sizeof(cloud[0]))`; the
   * default stride is that of float[3]. NaN and infinities are allowed, as in Frame. It copies the
   * points; the frame is valid until the next call. Throws std::invalid_argument for a stride of
   * less than three floats, and for a null pointer with points. */
  Frame frame(const void* first, std::size_t size, std::size_t stride_bytes = 3 * sizeof(float))
  {
    if (stride_bytes < 3 * sizeof(float))
      throw std::invalid_argument(
          "points of three floats cannot be " + std::to_string(stride_bytes) + " bytes apart");
    if (!first && size > 0) throw std::invalid_argument("points at a null pointer");
    for (auto* values : {&x_m_, &y_m_, &z_m_}) values->resize(size);
    const auto* bytes = static_cast<const unsigned char*>(first);
    for (std::size_t k = 0; k < size; k++, bytes += stride_bytes)
    {
      float p[3];
      std::memcpy(p, bytes, sizeof(p));
      x_m_[k] = p[0];
      y_m_[k] = p[1];
      z_m_[k] = p[2];
    }
    Frame f;
    f.x_m = x_m_.data();
    f.y_m = y_m_.data();
    f.z_m = z_m_.data();
    f.size = size;
    return f;
  }

 private:
  std::vector<float> x_m_, y_m_, z_m_;
};

}  // namespace talus
