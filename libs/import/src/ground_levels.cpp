#include "ground_levels.h"

#include <talus/io/quantile.h>

#include <algorithm>
#include <cmath>

namespace talus::import
{
namespace
{
constexpr double kColumn_m = 0.25;
constexpr float kGap_m = 0.6F;  // between what stands on a surface and the next one
constexpr float kClimb_m = 0.25F;  // from column to column: a step, and a slope of 45 degrees
constexpr int kAcross = 4;  // columns without points
constexpr int kNear = 8;  // columns
constexpr int kDirections[8][2] = {{1, 0}, {0, 1},  {-1, 0},  {0, -1},
                                   {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};

int index_of(double m) { return static_cast<int>(std::floor(m / kColumn_m)); }
}  // namespace

std::uint64_t GroundLevels::key(int x, int y)
{
  return std::uint64_t{static_cast<std::uint32_t>(x)} << 32 | static_cast<std::uint32_t>(y);
}

std::vector<GroundLevels::Level>* GroundLevels::column(int x, int y)
{
  const auto found = columns_.find(key(x, y));
  return found == columns_.end() ? nullptr : &found->second;
}

GroundLevels::GroundLevels(const ScanFile& cloud)
{
  std::vector<std::pair<std::uint64_t, float>> points;
  points.reserve(cloud.x_m.size());
  for (std::size_t i = 0; i < cloud.x_m.size(); ++i)
    points.emplace_back(
        key(index_of(cloud.x_m[i]), index_of(cloud.y_m[i])), static_cast<float>(cloud.z_m[i]));
  std::sort(points.begin(), points.end());
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i == 0 || points[i].first != points[i - 1].first ||
        points[i].second - points[i - 1].second > kGap_m)
      columns_[points[i].first].push_back({points[i].second});
}

/** All that connects with a level and was not reached. */
std::vector<GroundLevels::Node> GroundLevels::spread(Node from)
{
  std::vector<Node> reached{from};
  (*column(from.x, from.y))[from.level].is_reached = true;
  for (std::size_t i = 0; i < reached.size(); ++i)
  {
    const Node at = reached[i];
    const float bottom_m = (*column(at.x, at.y))[at.level].bottom_m;
    for (const auto& direction : kDirections)
    {
      bool is_found = false;
      for (int far = 1; far <= kAcross && !is_found; ++far)
      {
        const int x = at.x + far * direction[0], y = at.y + far * direction[1];
        auto* levels = column(x, y);
        for (std::size_t l = 0; levels && l < levels->size(); ++l)
          if (Level& level = (*levels)[l]; std::abs(level.bottom_m - bottom_m) <= kClimb_m)
          {
            is_found = true;
            if (!level.is_reached) reached.push_back({x, y, l});
            level.is_reached = true;
          }
      }
    }
  }
  return reached;
}

bool GroundLevels::reach_from(double x_m, double y_m, double z_m)
{
  constexpr float kMax_m = 3, kAbove_m = 0.1F;
  const int x0 = index_of(x_m), y0 = index_of(y_m);
  const auto z = static_cast<float>(z_m);
  for (int ring = 0; ring <= kNear; ++ring)
    for (int x = x0 - ring; x <= x0 + ring; ++x)
      for (int y = y0 - ring; y <= y0 + ring; ++y)
      {
        auto* levels =
            std::max(std::abs(x - x0), std::abs(y - y0)) == ring ? column(x, y) : nullptr;
        for (std::size_t l = levels ? levels->size() : 0; l-- > 0;)
          if ((*levels)[l].bottom_m <= z + kAbove_m && (*levels)[l].bottom_m >= z - kMax_m)
          {
            if (!(*levels)[l].is_reached) spread({x, y, l});
            return true;
          }
      }
  return false;
}

bool GroundLevels::is_above_ground(const Node& node)
{
  const float bottom_m = (*column(node.x, node.y))[node.level].bottom_m;
  for (int x = node.x - kNear; x <= node.x + kNear; ++x)
    for (int y = node.y - kNear; y <= node.y + kNear; ++y)
      if (const auto* levels = column(x, y))
        for (const Level& level : *levels)
          if (level.is_reached && level.bottom_m < bottom_m - 2 * kClimb_m) return true;
  return false;
}

void GroundLevels::reach_rest()
{
  grounds_.clear();
  constexpr std::size_t kMin = 400, kAbove = 20;  // columns: 25 m2; one in this count
  struct Surface
  {
    std::vector<Node> nodes;
    float height_m;
  };
  std::vector<Surface> surfaces;
  const auto mark = [this](const std::vector<Node>& nodes, bool is_reached)
  {
    for (const Node& n : nodes) (*column(n.x, n.y))[n.level].is_reached = is_reached;
  };
  std::vector<Node> left;
  for (const auto& [at, levels] : columns_)
    for (std::size_t l = 0; l < levels.size(); ++l)
      if (!levels[l].is_reached)
        left.push_back({static_cast<int>(at >> 32), static_cast<int>(at & 0xffffffffU), l});
  std::size_t largest = 0;
  for (const Node& from : left)
  {
    if ((*column(from.x, from.y))[from.level].is_reached) continue;
    surfaces.push_back({spread(from), 0});
    auto& nodes = surfaces.back().nodes;
    std::vector<float> heights_m;
    heights_m.reserve(nodes.size());
    for (const Node& n : nodes) heights_m.push_back((*column(n.x, n.y))[n.level].bottom_m);
    surfaces.back().height_m = io::quantile(std::move(heights_m), 0.5);
    largest = std::max(largest, nodes.size());
  }
  for (const Surface& surface : surfaces) mark(surface.nodes, false);
  // Of the large ones the lowest is no ceiling.
  const auto rank = [=](const Surface& s)
  { return std::pair(2 * s.nodes.size() < largest, s.height_m); };
  std::sort(
      surfaces.begin(), surfaces.end(),
      [&](const Surface& a, const Surface& b) { return rank(a) < rank(b); });
  for (const Surface& surface : surfaces)
  {
    const auto& nodes = surface.nodes;
    const auto above = static_cast<std::size_t>(std::count_if(
        nodes.begin(), nodes.end(), [this](const Node& n) { return is_above_ground(n); }));
    if (nodes.size() >= kMin && above * kAbove < nodes.size()) mark(nodes, true);
  }
}

std::optional<double> GroundLevels::below(double x_m, double y_m, double z_m)
{
  constexpr float kLower_m = kClimb_m;  // points that lie below the ground near by
  const int x0 = index_of(x_m), y0 = index_of(y_m);
  const auto [known, is_new] = grounds_.try_emplace(key(x0, y0));
  auto& grounds_m = known->second;
  for (int ring = 0; is_new && ring <= kNear && grounds_m.empty(); ++ring)
    for (int x = x0 - ring; x <= x0 + ring; ++x)
      for (int y = y0 - ring; y <= y0 + ring; ++y)
        if (std::max(std::abs(x - x0), std::abs(y - y0)) == ring)
          if (const auto* levels = column(x, y))
            for (const Level& level : *levels)
              if (level.is_reached) grounds_m.push_back(level.bottom_m);
  std::optional<double> ground_m;
  for (const float m : grounds_m)
    if (m <= static_cast<float>(z_m) + kLower_m &&
        m > static_cast<float>(ground_m.value_or(-HUGE_VAL)))
      ground_m = m;
  return ground_m;
}

bool GroundLevels::has_storeys() const
{
  return std::any_of(
      columns_.begin(), columns_.end(),
      [](const auto& column)
      {
        const auto& levels = column.second;
        return std::count_if(
                   levels.begin(), levels.end(), [](const Level& l) { return l.is_reached; }) > 1;
      });
}

}  // namespace talus::import
