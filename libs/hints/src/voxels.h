#pragma once
#include <cmath>
#include <cstdint>

#include "base_points.h"

// Cubes of space by their place, packed into one number: three indices of 21 bits.
namespace talus::hints
{
constexpr int kVoxelBias = 1 << 20;

inline std::uint64_t packed_voxel(std::int64_t x, std::int64_t y, std::int64_t z)
{
  const auto part = [](std::int64_t i)
  { return static_cast<std::uint64_t>(i + kVoxelBias) & 0x1fffffU; };
  return part(x) << 42 | part(y) << 21 | part(z);
}

/** One of the three indices of a voxel: of x at bit 42, y at 21, z at 0. */
inline std::int64_t voxel_index(std::uint64_t key, int shift)
{
  return static_cast<std::int64_t>((key >> shift) & 0x1fffffU) - kVoxelBias;
}

/** The voxel that a point is in. */
inline std::uint64_t voxel_of(const Vec3& p, double size_m)
{
  const auto index = [&](double v) { return static_cast<std::int64_t>(std::floor(v / size_m)); };
  return packed_voxel(index(p.x), index(p.y), index(p.z));
}

/** The middle of a voxel. */
inline Vec3 middle_of(std::uint64_t key, double size_m)
{
  const auto at = [&](int shift)
  { return (static_cast<double>(voxel_index(key, shift)) + 0.5) * size_m; };
  return {at(42), at(21), at(0)};
}

/** Calls f(key) for a voxel and all that are up to `reach` voxels away along each axis. */
template <class F>
void for_neighbours(std::uint64_t key, int reach, const F& f)
{
  for (int dx = -reach; dx <= reach; ++dx)
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dz = -reach; dz <= reach; ++dz)
        f(packed_voxel(
            voxel_index(key, 42) + dx, voxel_index(key, 21) + dy, voxel_index(key, 0) + dz));
}

}  // namespace talus::hints
