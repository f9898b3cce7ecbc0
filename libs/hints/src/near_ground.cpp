#include "near_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace talus::hints
{
namespace
{
constexpr int kSectors = 32, kRings = 6;
constexpr int kTrials = 80;
constexpr double kInlier_m = 0.1;  // rough ground keeps within it
constexpr double kBeyond_m = 0.25;  // farther below a plane nothing can be seen if it is ground
constexpr double kSteepest = 0.5;  // cosine of the tilt of a lowest plane
constexpr std::size_t kMinPoints = 12;
constexpr double kMinWidth_m = 0.7;  // standard deviation along the narrow side
constexpr std::size_t kMaxSupport = 256;

/** A fixed sequence: the same log gives the same hints. */
class Sequence
{
 public:
  std::size_t below(std::size_t n)
  {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>((state_ >> 33) % n);
  }

 private:
  std::uint64_t state_ = 20061;
};

/** The lowest point of each direction and distance in which there is any. */
std::vector<Vec3> lowest_points(
    const std::vector<Vec3>& points, const Vec3& sensor, double up, double far_m)
{
  std::array<const Vec3*, kSectors * kRings> lowest{};
  for (const Vec3& p : points)
  {
    const double dx = p.x - sensor.x, dy = p.y - sensor.y;
    const double r2 = dx * dx + dy * dy;
    if (r2 < kNear_m * kNear_m || r2 >= far_m * far_m) continue;
    const int ring = static_cast<int>((std::sqrt(r2) - kNear_m) / (far_m - kNear_m) * kRings);
    const int sector = static_cast<int>((std::atan2(dy, dx) / (2 * M_PI) + 0.5) * kSectors);
    auto& best = lowest[static_cast<std::size_t>(
        std::min(sector, kSectors - 1) * kRings + std::min(ring, kRings - 1))];
    if (!best || up * p.z < up * best->z) best = &p;
  }
  std::vector<Vec3> out;
  out.reserve(lowest.size());
  for (const Vec3* p : lowest)
    if (p) out.push_back(*p);
  return out;
}

bool plane_through(const Vec3& a, const Vec3& b, const Vec3& c, NearPlane& plane)
{
  const Vec3 n = cross(b - a, c - a);
  const double size = length(n);
  if (size < 0.2) return false;  // nearly a line: twice the area [m^2]
  plane.normal = {n.x / size, n.y / size, n.z / size};
  plane.offset_m = dot(plane.normal, a);
  return true;
}

void face(NearPlane& plane, const Vec3& toward, double side)
{
  if (side * dot(plane.normal, toward) >= 0) return;
  plane.normal = {-plane.normal.x, -plane.normal.y, -plane.normal.z};
  plane.offset_m = -plane.offset_m;
}

struct Score
{
  int on = 0, beyond = 0;
};

Score score_of(const NearPlane& plane, const std::vector<Vec3>& points)
{
  Score s;
  for (const Vec3& p : points)
  {
    const double d = plane.distance_m(p);
    s.on += std::abs(d) < kInlier_m;
    s.beyond += d < -kBeyond_m;
  }
  return s;
}

/** The best of many planes through three points, `faces` turns the normal of each (false: it is
 * none that is looked for). */
template <class Faces>
NearPlane best_plane(const std::vector<Vec3>& points, const Faces& faces, Score& best)
{
  NearPlane plane;
  if (points.size() < kMinPoints) return plane;
  Sequence sequence;
  int most = 0;
  for (int trial = 0; trial < kTrials; ++trial)
  {
    NearPlane candidate;
    const Vec3 &a = points[sequence.below(points.size())],
               &b = points[sequence.below(points.size())],
               &c = points[sequence.below(points.size())];
    if (!plane_through(a, b, c, candidate) || !faces(candidate)) continue;
    const Score s = score_of(candidate, points);
    if (s.on - s.beyond <= most) continue;
    most = s.on - s.beyond;
    best = s;
    plane = candidate;
    plane.found = true;
  }
  return plane;
}

/** Of points near a plane, in axes of the plane: sums of a least-squares fit of what is left over.
 */
struct Moments
{
  double n = 0, u = 0, v = 0, d = 0, uu = 0, uv = 0, vv = 0, ud = 0, vd = 0, dd = 0;
};

/** Two directions within the plane, at right angles. */
std::array<Vec3, 2> axes_of(const NearPlane& plane)
{
  const Vec3 other = std::abs(plane.normal.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Vec3 u = cross(plane.normal, other);
  const double size = length(u);
  u = {u.x / size, u.y / size, u.z / size};
  return {u, cross(plane.normal, u)};
}

Moments moments_of(
    const NearPlane& plane, const std::array<Vec3, 2>& axes, const std::vector<Vec3>& points)
{
  Moments m;
  for (const Vec3& p : points)
  {
    const double d = plane.distance_m(p);
    if (std::abs(d) >= kInlier_m) continue;
    const double u = dot(axes[0], p), v = dot(axes[1], p);
    m.n += 1, m.u += u, m.v += v, m.d += d;
    m.uu += u * u, m.uv += u * v, m.vv += v * v, m.ud += u * d, m.vd += v * d, m.dd += d * d;
  }
  return m;
}

/** One round of least squares over the points on the plane; false where they do not span one. */
bool refine(NearPlane& plane, const std::vector<Vec3>& points)
{
  const auto axes = axes_of(plane);
  const Moments m = moments_of(plane, axes, points);
  if (m.n < kMinPoints) return false;
  const double mu = m.u / m.n, mv = m.v / m.n, md = m.d / m.n;
  const double uu = m.uu / m.n - mu * mu, uv = m.uv / m.n - mu * mv, vv = m.vv / m.n - mv * mv;
  const double ud = m.ud / m.n - mu * md, vd = m.vd / m.n - mv * md;
  const double half = (uu + vv) / 2;
  const double narrow = half - std::sqrt((uu - vv) * (uu - vv) / 4 + uv * uv);
  if (narrow < kMinWidth_m * kMinWidth_m) return false;
  const double det = uu * vv - uv * uv;
  const double a = (ud * vv - vd * uv) / det, b = (vd * uu - ud * uv) / det;
  const Vec3 c{
      plane.normal.x * (plane.offset_m + md) + axes[0].x * mu + axes[1].x * mv,
      plane.normal.y * (plane.offset_m + md) + axes[0].y * mu + axes[1].y * mv,
      plane.normal.z * (plane.offset_m + md) + axes[0].z * mu + axes[1].z * mv};
  Vec3 n{
      plane.normal.x - a * axes[0].x - b * axes[1].x,
      plane.normal.y - a * axes[0].y - b * axes[1].y,
      plane.normal.z - a * axes[0].z - b * axes[1].z};
  const double size = length(n);
  plane.normal = {n.x / size, n.y / size, n.z / size};
  plane.offset_m = dot(plane.normal, c);
  plane.rms_m = std::sqrt(std::max(0.0, m.dd / m.n - md * md - a * ud - b * vd));
  return true;
}

void refine_or_drop(NearPlane& plane, const std::vector<Vec3>& points)
{
  for (int round = 0; round < 3 && plane.found; ++round) plane.found = refine(plane, points);
}
}  // namespace

NearPlane lowest_plane(
    const std::vector<Vec3>& points, const Vec3& sensor, double up, double far_m,
    double least_share)
{
  const auto lowest = lowest_points(points, sensor, up, far_m);
  const Vec3 z{0, 0, up};
  Score score;
  NearPlane plane = best_plane(
      lowest,
      [&](NearPlane& p)
      {
        face(p, z, 1);
        return dot(p.normal, z) > kSteepest;
      },
      score);
  plane.found = plane.found && score.on > least_share * static_cast<double>(lowest.size());
  refine_or_drop(plane, lowest);
  return plane;
}

bool is_flat_scan(const std::vector<Vec3>& points, const Vec3& sensor)
{
  constexpr double kFlat =
      1e-4;  // sine of the widest angle to the plane; real ground scatters by more
  constexpr std::size_t kTried = 64;  // points, for the plane
  Vec3 normal;
  double most = 0;
  const Vec3 a = points.empty() ? Vec3{} : points.front() - sensor;
  for (std::size_t i = 0; i < points.size(); i += points.size() / kTried + 1)
  {
    const Vec3 n = cross(a, points[i] - sensor);
    if (length(n) <= most) continue;
    most = length(n);
    normal = {n.x / most, n.y / most, n.z / most};
  }
  return std::all_of(
      points.begin(), points.end(),
      [&](const Vec3& p)
      { return std::abs(dot(normal, p - sensor)) <= kFlat * length(p - sensor); });
}

NearPlane supporting_plane(const std::vector<Vec3>& points, const Vec3& sensor)
{
  std::vector<Vec3> around;
  around.reserve(kMaxSupport);
  const std::size_t stride = points.size() / kMaxSupport + 1;
  for (std::size_t i = 0; i < points.size(); i += stride)
    if (const double r = length(points[i] - sensor); r > kNear_m && r < kFar_m)
      around.push_back(points[i]);
  Score score;
  NearPlane plane = best_plane(
      around,
      [&](NearPlane& p)
      {
        if (p.distance_m(sensor) < 0) face(p, p.normal, -1);
        return true;
      },
      score);
  plane.found = plane.found && 2 * static_cast<std::size_t>(score.on) > around.size() &&
                20 * static_cast<std::size_t>(score.beyond) < around.size();
  refine_or_drop(plane, around);
  return plane;
}

}  // namespace talus::hints
