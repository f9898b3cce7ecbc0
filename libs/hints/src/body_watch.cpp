#include "body_watch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "near_ground.h"
#include "thresholds.h"
#include "voxels.h"

namespace talus::hints
{
namespace
{
constexpr std::size_t kMaxMapVoxels = 300000;
constexpr double kMapReach_m = 10;  // of the points that show whether something stays
constexpr double kMinFar_m = 2, kMaxFar_m = 8;  // from where a place is looked at again
constexpr std::size_t kMaxTried = 40;  // voxels of a part, against kTriedFrames frames
constexpr std::size_t kTriedFrames = 16;
constexpr double kMaxExtent_m = 3;  // of a part; a longer one looks like what is passed
constexpr double kBoxMargin_m = 0.05;
constexpr std::size_t kMaxBoxes = 8;

int count_bits(std::uint64_t v)
{
  int n = 0;
  for (; v; v &= v - 1) ++n;
  return n;
}

BodyBox box_of(const std::vector<std::uint64_t>& voxels)
{
  BodyBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  const double margin_m = kBodyVoxel_m / 2 + kBoxMargin_m;
  for (const auto key : voxels)
  {
    const Vec3 p = middle_of(key, kBodyVoxel_m);
    box.min_x_m = std::min(box.min_x_m, p.x - margin_m);
    box.max_x_m = std::max(box.max_x_m, p.x + margin_m);
    box.min_y_m = std::min(box.min_y_m, p.y - margin_m);
    box.max_y_m = std::max(box.max_y_m, p.y + margin_m);
    box.min_z_m = std::min(box.min_z_m, p.z - margin_m);
    box.max_z_m = std::max(box.max_z_m, p.z + margin_m);
  }
  for (double* limit :
       {&box.min_x_m, &box.max_x_m, &box.min_y_m, &box.max_y_m, &box.min_z_m, &box.max_z_m})
    *limit = std::round(*limit * 100) / 100;  // to be read by people
  return box;
}

/** Goes on beyond what is looked at: no part of a robot. */
bool is_cut(const BodyBox& b)
{
  const double far_m =
      std::max({-b.min_x_m, b.max_x_m, -b.min_y_m, b.max_y_m, -b.min_z_m, b.max_z_m});
  return far_m > kBodyReach_m;
}

double extent_m(const BodyBox& b)
{
  return std::hypot(b.max_x_m - b.min_x_m, b.max_y_m - b.min_y_m);
}
}  // namespace

bool BodyWatch::wants(const Pose& T_map_base) const
{
  if (poses_.size() >= kBodyFrames) return false;
  return poses_.empty() || length(origin_of(T_map_base) - origin_of(poses_.back())) >= kBodyStep_m;
}

void BodyWatch::add(
    const std::vector<Vec3>& near, const std::vector<Vec3>& all, const Pose& T_map_base)
{
  const std::uint64_t bit = std::uint64_t{1} << poses_.size();
  if (!poses_.empty()) path_m_ += length(origin_of(T_map_base) - origin_of(poses_.back()));
  poses_.push_back(T_map_base);
  for (const Vec3& p : near)
  {
    Voxel& voxel = body_[voxel_of(p, kBodyVoxel_m)];
    voxel.frames |= bit;
    ++voxel.points;
  }
  for (const Vec3& p : all)
    if (dot(p, p) < kMapReach_m * kMapReach_m && map_.size() < kMaxMapVoxels)
      map_[voxel_of(moved(T_map_base, p), kMapVoxel_m)] |= bit;
}

bool BodyWatch::is_conclusive() const
{
  return poses_.size() >= kMinBodyFrames && path_m_ >= kMinBodyPath_m &&
         heading_span_rad(poses_) >= kMinBodyTurn_deg * M_PI / 180;
}

std::vector<BodyBox> BodyWatch::boxes(const NearPlane& ground, const Vec3& sensor) const
{
  if (!is_conclusive()) return {};
  const double height_m = ground.distance_m(sensor);
  std::vector<std::pair<std::uint64_t, BodyBox>> found;
  for (const Part& part : parts(ground))
  {
    if (!is_hit_always(part) || !is_in_reach(part, sensor, height_m)) continue;
    if (stands_apart(part, sensor) || !keeps_its_place(part) || !moves_along(part)) continue;
    std::uint64_t points = 0;
    for (const Key key : part) points += body_.at(key).points;
    found.emplace_back(points, box_of(part));
  }
  std::sort(
      found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (found.size() > kMaxBoxes) found.resize(kMaxBoxes);
  std::vector<BodyBox> boxes;
  boxes.reserve(found.size());
  for (const auto& [points, box] : found) boxes.push_back(box);
  return boxes;
}

/** What is hit in many frames and is not the ground, in pieces that hang together. */
std::vector<BodyWatch::Part> BodyWatch::parts(const NearPlane& ground) const
{
  const double least = kVoxelShare * static_cast<double>(poses_.size());
  std::set<Key> left;
  for (const auto& [key, voxel] : body_)
    if (count_bits(voxel.frames) >= least &&
        ground.distance_m(middle_of(key, kBodyVoxel_m)) > kBodyAbove_m)
      left.insert(key);
  std::vector<Part> parts;
  while (!left.empty())
  {
    Part part{*left.begin()};
    left.erase(left.begin());
    for (std::size_t next = 0; next < part.size(); ++next)
      for_neighbours(
          part[next], 2,
          [&](Key key)
          {
            if (left.erase(key)) part.push_back(key);
          });
    parts.push_back(std::move(part));
  }
  return parts;
}

bool BodyWatch::is_hit_always(const Part& part) const
{
  std::uint64_t frames = 0;
  for (const Key key : part) frames |= body_.at(key).frames;
  return count_bits(frames) >= kPartShare * static_cast<double>(poses_.size());
}

/** No robot is much wider than its sensor is high. */
bool BodyWatch::is_in_reach(const Part& part, const Vec3& sensor, double height_m) const
{
  const double reach_m = std::max(kMinReach_m, kReachHeights * height_m);
  return std::all_of(
      part.begin(), part.end(),
      [&](Key key)
      {
        const Vec3 p = middle_of(key, kBodyVoxel_m) - sensor;
        return std::hypot(p.x, p.y) <= reach_m;
      });
}

/** Whether ground is seen between the sensor and a part. */
bool BodyWatch::stands_apart(const Part& part, const Vec3& sensor) const
{
  double shares = 0;
  for (const Key key : part) shares += before_.share_before(middle_of(key, kBodyVoxel_m), sensor);
  return shares > kMaxGroundBefore * static_cast<double>(part.size());
}

/** The mean place in the base frame of what is hit in and around a part in some of the frames. */
Vec3 BodyWatch::mean_place(const std::set<Key>& around, std::uint64_t frames) const
{
  Vec3 sum;
  double n = 0;
  for (const Key key : around)
  {
    const auto found = body_.find(key);
    if (found == body_.end()) continue;
    const double hits = count_bits(found->second.frames & frames);
    const Vec3 p = middle_of(key, kBodyVoxel_m);
    sum = {sum.x + hits * p.x, sum.y + hits * p.y, sum.z + hits * p.z};
    n += hits;
  }
  return n > 0 ? Vec3{sum.x / n, sum.y / n, sum.z / n} : Vec3{HUGE_VAL, 0, 0};
}

/** Whether it is hit at the same place whichever way the robot heads and turns. */
bool BodyWatch::keeps_its_place(const Part& part) const
{
  std::set<Key> around;
  for (const Key key : part) for_neighbours(key, 2, [&](Key near) { around.insert(near); });
  const auto splits = splits_by_heading(poses_);
  return std::all_of(
      splits.begin(), splits.end(),
      [&](const FrameSplit& split)
      {
        const Vec3 one = mean_place(around, split.one), other = mean_place(around, split.other);
        return std::hypot(one.x - other.x, one.y - other.y) <= kMaxShift_m;
      });
}

/** Whether the map keeps nothing where it was. */
bool BodyWatch::moves_along(const Part& part) const
{
  const BodyBox box = box_of(part);
  if (is_cut(box) || extent_m(box) > kMaxExtent_m) return false;
  const double least_m = std::max(kMinFar_m, 1.5 * extent_m(box));
  std::size_t tried = 0, stayed = 0;
  const std::size_t frame_step = poses_.size() / kTriedFrames + 1;
  const std::size_t voxel_step = part.size() / kMaxTried + 1;
  for (std::size_t f = 0; f < poses_.size(); f += frame_step)
  {
    const std::uint64_t others = far_frames(f, least_m);
    if (!others) continue;
    for (std::size_t v = 0; v < part.size(); v += voxel_step)
    {
      ++tried;
      stayed += stays(moved(poses_[f], middle_of(part[v], kBodyVoxel_m)), others);
    }
  }
  return tried > 0 && static_cast<double>(stayed) <= kMaxPersisting * static_cast<double>(tried);
}

/** Those that saw the surroundings of one frame's robot from elsewhere. */
std::uint64_t BodyWatch::far_frames(std::size_t frame, double least_m) const
{
  std::uint64_t far = 0;
  for (std::size_t i = 0; i < poses_.size(); ++i)
  {
    const double apart_m = length(origin_of(poses_[i]) - origin_of(poses_[frame]));
    if (apart_m >= least_m && apart_m <= kMaxFar_m) far |= std::uint64_t{1} << i;
  }
  return far;
}

bool BodyWatch::stays(const Vec3& at_map, std::uint64_t frames) const
{
  bool hit = false;
  for_neighbours(
      voxel_of(at_map, kMapVoxel_m), 1,
      [&](Key key)
      {
        const auto found = map_.find(key);
        hit = hit || (found != map_.end() && (found->second & frames));
      });
  return hit;
}

}  // namespace talus::hints
