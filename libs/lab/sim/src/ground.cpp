#include <talus/sim/ground.h>

#include <algorithm>
#include <limits>

namespace talus::sim
{
namespace
{
constexpr double kMinStep_m = 0.002;
constexpr double kPrecision_m = 1e-9;
}  // namespace

/** A stretch of a ray over which all parts keep to one piece. The gap is the height of the ray
 * above the ground: gap_0 + gap_rate * range - (sum of the curved parts). */
struct Ground::Piece
{
  double from_m = 0, to_m = 0;
  double gap_0_m = 0, gap_rate = 0;
  Curvature curve;  //!< of the sum of the curved parts
};

void Ground::add(GroundPartPtr part)
{
  const Curvature b = part->bounds();
  bounds_.min_m += b.min_m;
  bounds_.max_m += b.max_m;
  (part->curved() ? curved_ : linear_).push_back(std::move(part));
}

double Ground::height_m(double x_m, double y_m) const
{
  double h = 0;
  for (const auto& p : linear_) h += p->height_m(x_m, y_m);
  for (const auto& p : curved_) h += p->height_m(x_m, y_m);
  return h;
}

bool Ground::defined(double x_m, double y_m) const
{
  return std::all_of(
      curved_.begin(), curved_.end(), [&](const auto& p) { return p->defined(x_m, y_m); });
}

double Ground::gap_m(const Ray& ray, const Piece& piece, double range_m) const
{
  double gap = piece.gap_0_m + piece.gap_rate * range_m;
  if (piece.curve.max_slope == 0) return gap - piece.curve.min_m;
  const Vec3 p = ray.at(range_m);
  for (const auto& c : curved_) gap -= c->height_m(p.x, p.y);
  return gap;
}

Ground::Piece Ground::piece(const Ray& ray, double from_m, double to_m) const
{
  // The linear share is known from two points well inside, away from the faces at the ends.
  const double t1 = from_m + 0.25 * (to_m - from_m), t2 = from_m + 0.75 * (to_m - from_m);
  const Vec3 p1 = ray.at(t1), p2 = ray.at(t2);
  double h1 = 0, h2 = 0;
  for (const auto& p : linear_)
  {
    h1 += p->height_m(p1.x, p1.y);
    h2 += p->height_m(p2.x, p2.y);
  }
  Piece out;
  out.from_m = from_m;
  out.to_m = to_m;
  const double slope = (h2 - h1) / (t2 - t1);
  out.gap_rate = ray.direction.z - slope;
  out.gap_0_m = ray.origin_m.z - (h1 - slope * t1);
  for (const auto& p : curved_)
  {
    const Curvature c = p->curvature(p1.x, p1.y);
    out.curve.max_slope += c.max_slope;
    out.curve.min_m += c.min_m;
    out.curve.max_m += c.max_m;
  }
  return out;
}

std::optional<double> Ground::march(
    const Ray& ray, const Piece& piece, double from_m, double to_m) const
{
  const double along = std::hypot(ray.direction.x, ray.direction.y);
  const double closing = std::max(piece.curve.max_slope * along - piece.gap_rate, 1e-9);
  double t = from_m, gap = gap_m(ray, piece, t);
  if (gap <= 0) return t;
  while (t < to_m)
  {
    double next = std::min(t + std::max(gap / closing, kMinStep_m), to_m);
    double next_gap = gap_m(ray, piece, next);
    if (next_gap > 0)
    {
      t = next;
      gap = next_gap;
      continue;
    }
    while (next - t > kPrecision_m)
    {
      const double middle = 0.5 * (t + next), secant = t + (next - t) * gap / (gap - next_gap);
      for (const double probe : {secant, middle})
      {
        if (probe <= t || probe >= next) continue;
        const double g = gap_m(ray, piece, probe);
        if (std::abs(g) < kPrecision_m) return probe;
        (g > 0 ? t : next) = probe;
        (g > 0 ? gap : next_gap) = g;
      }
    }
    return next;
  }
  return std::nullopt;
}

std::optional<double> Ground::cast_piece(const Ray& ray, const Piece& piece) const
{
  // Where the linear gap falls to `level`: from there on the curved share can, or must, be met.
  const auto falls_to = [&](double level)
  {
    if (piece.gap_0_m + piece.gap_rate * piece.from_m <= level) return piece.from_m;
    if (piece.gap_rate >= 0) return std::numeric_limits<double>::infinity();
    return (level - piece.gap_0_m) / piece.gap_rate;
  };
  const double from = falls_to(piece.curve.max_m);
  if (from > piece.to_m) return std::nullopt;
  if (piece.curve.max_slope == 0) return from;
  return march(ray, piece, from, std::min(piece.to_m, falls_to(piece.curve.min_m) + kMinStep_m));
}

std::optional<double> Ground::cast(const Ray& ray, double max_m) const
{
  const Vec3& o = ray.origin_m;
  if (o.z <= height_m(o.x, o.y)) return std::nullopt;
  double from = 0;
  if (o.z > bounds_.max_m)
  {
    if (ray.direction.z >= 0) return std::nullopt;
    from = std::max(0.0, (bounds_.max_m - o.z) / ray.direction.z - kMinStep_m);
  }
  thread_local std::vector<double> breaks;
  breaks.clear();
  for (const auto* parts : {&linear_, &curved_})
    for (const auto& p : *parts) p->breaks(ray, breaks);
  breaks.push_back(max_m);
  std::sort(breaks.begin(), breaks.end());
  for (const double b : breaks)
  {
    const double to = std::min(b, max_m);
    if (to - from < kPrecision_m) continue;  // also breaks behind the origin
    if (const auto hit = cast_piece(ray, piece(ray, from, to))) return hit;
    from = to;
  }
  return std::nullopt;
}

}  // namespace talus::sim
