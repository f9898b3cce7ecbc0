#include <talus/input_file.h>
#include <talus/sim/ground.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace talus::sim
{
namespace
{
class Image : public GroundPart
{
 public:
  Image(HeightImage image, double x, double y, double pixel, double min, double max)
      : image_(std::move(image)), x_(x), y_(y), pixel_(pixel), min_(min), scale_(max - min)
  {
    const auto [low, high] = std::minmax_element(image_.value.begin(), image_.value.end());
    const double a = min_ + scale_ * *low, b = min_ + scale_ * *high;
    double steepest = 0;
    for (int r = 0; r < image_.height; ++r)
      for (int c = 0; c < image_.width; ++c)
        steepest = std::max(
            {steepest, std::abs(value(c + 1, r) - value(c, r)),
             std::abs(value(c, r + 1) - value(c, r))});
    bounds_ = {
        std::abs(scale_) * steepest / pixel_ * std::sqrt(2.0), std::min(a, b), std::max(a, b)};
  }

  double height_m(double x, double y) const override
  {
    const double u = std::clamp((x - x_) / pixel_, 0.0, image_.width - 1.0);
    const double v = std::clamp((y - y_) / pixel_, 0.0, image_.height - 1.0);
    const int c = static_cast<int>(u), r = static_cast<int>(v);
    const double wu = u - c, wv = v - r;
    const double south = value(c, r) * (1 - wu) + value(c + 1, r) * wu;
    const double north = value(c, r + 1) * (1 - wu) + value(c + 1, r + 1) * wu;
    return min_ + scale_ * (south * (1 - wv) + north * wv);
  }
  bool curved() const override { return true; }
  Curvature bounds() const override { return bounds_; }
  bool defined(double x, double y) const override
  {
    return x >= x_ && y >= y_ && x <= x_ + pixel_ * (image_.width - 1) &&
           y <= y_ + pixel_ * (image_.height - 1);
  }

 private:
  /** Column from the west, row from the south; beyond the border its value goes on. */
  double value(int column, int row) const
  {
    const int c = std::min(column, image_.width - 1), r = std::min(row, image_.height - 1);
    return image_.value[static_cast<std::size_t>(image_.height - 1 - r) * image_.width + c];
  }

  HeightImage image_;
  double x_, y_, pixel_, min_, scale_;
  Curvature bounds_;
};

/** The next number of a PGM header; comments run from # to the end of the line. */
int header_number(std::istream& in)
{
  while ((in >> std::ws) && in.peek() == '#') in.ignore(1 << 20, '\n');
  int value = -1;
  in >> value;
  return value;
}

/** A pixel takes a byte or more: what is too short shows before memory is taken for it. */
void require_room(std::istream& in, double pixels, const std::string& path)
{
  const auto begin = in.tellg();
  const auto size = in.seekg(0, std::ios::end).tellg() - begin;
  in.seekg(begin);
  if (static_cast<double>(size) < pixels)
    throw std::invalid_argument("'" + path + "' ends before its last pixel");
}

void read_pixels(
    std::istream& in, bool as_text, int white, const std::string& path, HeightImage& image)
{
  require_room(in, static_cast<double>(image.width) * image.height, path);
  image.value.resize(static_cast<std::size_t>(image.width) * image.height);
  for (float& v : image.value)
  {
    int grey = 0;
    if (as_text)
      in >> grey;
    else
    {
      grey = in.get();
      if (white > 255) grey = grey * 256 + in.get();
    }
    if (!in) throw std::invalid_argument("'" + path + "' ends before its last pixel");
    if (grey < 0 || grey > white)
      throw std::invalid_argument(
          "'" + path + "' has a pixel of " + std::to_string(grey) + ", white is " +
          std::to_string(white));
    v = static_cast<float>(grey) / static_cast<float>(white);
  }
}

}  // namespace

GroundPartPtr make_image(
    HeightImage image, double x_m, double y_m, double pixel_m, double min_m, double max_m)
{
  return std::make_shared<Image>(std::move(image), x_m, y_m, pixel_m, min_m, max_m);
}

HeightImage read_pgm(const std::string& path)
{
  require_readable_file(path, "height image");
  std::ifstream in(path, std::ios::binary);
  std::string magic(2, ' ');
  in.read(magic.data(), 2);
  HeightImage image;
  image.width = header_number(in);
  image.height = header_number(in);
  const int white = header_number(in);
  if ((magic != "P2" && magic != "P5") || image.width < 1 || image.height < 1 ||
      image.width > 20000 || image.height > 20000 || white < 1 || white > 65535)
    throw std::invalid_argument("'" + path + "' is not a grey PGM image of up to 20000 x 20000");
  in.get();
  read_pixels(in, magic == "P2", white, path, image);
  return image;
}

}  // namespace talus::sim
