#include "sheet.h"

#include <talus/io/palette.h>
#include <talus/sim/geometry.h>

#include <picture_legend.h>

#include <algorithm>
#include <string>

namespace talus::pictures
{
namespace
{
struct Dot
{
  cv::Vec3d pixel;  //!< and how far ahead [m]
  cv::Vec3b colour;
};

/** Without those that say nothing. */
void add_dots(
    const ElevationMapper& map, const baselines::ScanFrame& scan, const Camera& camera,
    std::vector<Dot>& dots)
{
  const std::vector<PointLabel> labels = label_points(map, scan.view());
  for (std::size_t i = 0; i < labels.size(); ++i)
  {
    if (labels[i] == PointLabel::NotTaken || labels[i] == PointLabel::Outside) continue;
    const sim::Vec3 p = sim::transform(scan.T_map_sensor, {scan.x_m[i], scan.y_m[i], scan.z_m[i]});
    const cv::Vec3d pixel = camera.pixel({p.x, p.y, p.z});
    if (pixel[2] > 0)
      dots.push_back(
          {pixel, io::bgr(io::palette::kLabels[static_cast<std::size_t>(labels[i])].rgb)});
  }
}

io::Legend legend_of_labels()
{
  io::Legend legend;
  for (std::size_t l = 1; l < kPointLabelCount - 1; ++l) legend.swatch(io::palette::kLabels[l]);
  legend.mark({0, 0}, "world street", [](io::Canvas&, cv::Point) {});
  return legend;
}
}  // namespace

cv::Mat draw_labelled_scans(
    const std::vector<baselines::ScanFrame>& frames, std::size_t every, const Camera& camera)
{
  constexpr int kEdge = 24, kBelow = 44;
  ElevationMapper map;
  for (const auto& frame : frames) map.update(frame.view());
  std::vector<Dot> dots;
  for (std::size_t back = 0; back < frames.size(); back += every)
    add_dots(map, frames[frames.size() - 1 - back], camera, dots);
  std::sort(
      dots.begin(), dots.end(), [](const Dot& a, const Dot& b) { return a.pixel[2] > b.pixel[2]; });
  io::Canvas page(camera.size.width, camera.size.height + kBelow);
  cv::Mat image(camera.size, CV_8UC3, cv::Scalar(255, 255, 255));
  const cv::Rect inside({0, 0}, camera.size);
  for (const Dot& dot : dots)
  {
    const cv::Rect square(cvRound(dot.pixel[0]) - 1, cvRound(dot.pixel[1]) - 1, 2, 2);
    image(square & inside).setTo(cv::Scalar(dot.colour));
  }
  page.paste(image, 0, 0);
  legend_of_labels().draw(
      page, {kEdge, camera.size.height + (kBelow - 18) / 2}, camera.size.width - 2 * kEdge);
  return page.image();
}

}  // namespace talus::pictures
