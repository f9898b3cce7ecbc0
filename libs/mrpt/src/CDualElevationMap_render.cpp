#include <talus/io/palette.h>
#include <talus/mrpt/CDualElevationMap.h>
#include TALUS_SCENE_HEADER(CSetOfObjects.h)
#include TALUS_SCENE_HEADER(CSetOfTriangles.h)

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include "surface_view.h"

namespace talus
{
using mrpt::img::TColor;
using mrpt_scene::CSetOfTriangles;
using mrpt_scene::TTriangle;
using nav::SurfaceView;

namespace
{
/** Lowest and highest height of the shown surfaces [m]. */
struct HeightSpan
{
  float low = 0, high = 1;

  explicit HeightSpan(const SurfaceView& map)
  {
    float a = INFINITY, b = -INFINITY;
    for (const auto* layer : {&map.ground, &map.elevation})
      for (const float z : *layer)
        if (!std::isnan(z))
        {
          a = std::min(a, z);
          b = std::max(b, z);
        }
    if (a <= b) low = a, high = std::max(b, a + 1e-3F);
  }
};

/** Draws one surface as two triangles between each four neighbouring known cells. */
class SurfacePainter
{
 public:
  SurfacePainter(
      const SurfaceView& map, const std::vector<float>& z,
      const CDualElevationMap::TRenderOptions& options)
      : map_(map), z_(z), options_(options), span_(map)
  {
    step_ = std::max(1, (map.window.cells + options.maxCells - 1) / options.maxCells);
  }

  /** `only_above`: only where a corner stands more than a cell's side above the ground. */
  CSetOfTriangles::Ptr draw(bool only_above) const
  {
    std::vector<TTriangle> triangles;
    for (int iy = 0; iy + step_ < map_.window.cells; iy += step_)
      for (int ix = 0; ix + step_ < map_.window.cells; ix += step_)
      {
        const std::array<Corner, 4> c{
            corner(ix, iy), corner(ix + step_, iy), corner(ix + step_, iy + step_),
            corner(ix, iy + step_)};
        const bool known =
            std::none_of(c.begin(), c.end(), [](const auto& k) { return std::isnan(k.p.z); });
        const bool above = std::any_of(c.begin(), c.end(), [](const auto& k) { return k.above; });
        if (!known || (only_above && !above)) continue;
        triangles.push_back(triangle(c[0], c[1], c[2]));
        triangles.push_back(triangle(c[0], c[2], c[3]));
      }
    auto mesh = CSetOfTriangles::Create();
    mesh->insertTriangles(triangles.begin(), triangles.end());  // one by one each takes a lock
    return mesh;
  }

 private:
  struct Corner
  {
    mrpt::math::TPoint3Df p;
    TColor color;
    bool above;
  };

  Corner corner(int ix, int iy) const
  {
    const std::size_t cell = map_.index(ix, iy);
    const float z = z_[cell];
    const bool above = z - map_.ground[cell] > map_.window.resolution_m;
    return {
        {static_cast<float>(map_.x_m(ix)), static_cast<float>(map_.y_m(iy)), z},
        color(cell, z, above),
        above};
  }

  TColor color(std::size_t cell, float z, bool above) const
  {
    if (options_.colorByTraversability) return traversability_color(cell, above);
    if (std::isnan(z)) return {128, 128, 128};
    return detail::color_of(
        mrpt::img::colormap(options_.colormap, (z - span_.low) / (span_.high - span_.low)));
  }

  /** As pictures show it. */
  TColor traversability_color(std::size_t cell, bool above) const
  {
    const float t = map_.traversability[cell];
    const bool measured = map_.state[cell] == static_cast<float>(CellState::Measured);
    const io::Rgb ground = measured ? io::score_colour(t) : io::pale(io::score_colour(t));
    const io::Rgb& c = above && !(t > 0.5F) ? io::palette::kStands.rgb : ground;
    return {c[0], c[1], c[2]};
  }

  static TTriangle triangle(const Corner& a, const Corner& b, const Corner& c)
  {
    TTriangle t(a.p, b.p, c.p);
    const std::array<const Corner*, 3> corners{&a, &b, &c};
    for (std::size_t i = 0; i < 3; i++) t.vertices[i].setColor(corners[i]->color);
    return t;
  }

  const SurfaceView& map_;
  const std::vector<float>& z_;
  const CDualElevationMap::TRenderOptions& options_;
  HeightSpan span_;
  int step_ = 1;
};

bool same_options(
    const CDualElevationMap::TRenderOptions& a, const CDualElevationMap::TRenderOptions& b)
{
  const auto all = [](const auto& o)
  {
    return std::tie(o.showGround, o.showElevation, o.colorByTraversability, o.colormap, o.maxCells);
  };
  return all(a) == all(b);
}
}  // namespace

void CDualElevationMap::getVisualizationInto(mrpt_scene::CSetOfObjects& outObj) const
{
  if (!genericMapParams.enableSaveAs3DObject || isEmpty()) return;
  renderOptions.validate();
  if (m_sceneCache.empty() || !same_options(renderOptions, m_sceneOptions)) drawScene();
  for (const auto& mesh : m_sceneCache) outObj.insert(mesh);
}

void CDualElevationMap::drawScene() const
{
  m_sceneCache.clear();
  m_sceneOptions = renderOptions;
  const SurfaceView map(view());
  const auto add = [&](const char* name, const std::vector<float>& z, bool only_above)
  {
    auto mesh = SurfacePainter(map, z, renderOptions).draw(only_above);
    mesh->setName(name);
    m_sceneCache.push_back(mesh);
  };
  if (renderOptions.showGround) add("ground", map.ground, false);
  if (renderOptions.showElevation) add("elevation", map.elevation, renderOptions.showGround);
}

}  // namespace talus
