#pragma once
#include "kernels/1_accept.h"

namespace talus::kernels
{
// Stage 1 keeps one point of each voxel: the one whose hashed coordinates are smallest, so that the
// order of the points does not matter. Two passes use an open-addressing table of voxels.

constexpr std::uint64_t kNoVoxel = ~0ull;

TALUS_HD std::uint64_t mix_bits(std::uint64_t v)
{
  v ^= v >> 30;
  v *= 0xbf58476d1ce4e5b9ull;
  v ^= v >> 27;
  v *= 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

struct VoxelTable
{
  std::uint64_t* key;  //!< kNoVoxel before the first pass
  std::uint64_t* winner;  //!< kNoVoxel before the first pass
  std::uint32_t mask;  //!< size - 1, a power of two at least twice the points
};

/** Enters one point into the table; `slot` keeps its place. */
template <class Atomics>
struct EnterVoxel
{
  const Config* config;
  const FrameContext* frame;
  const Body* body;
  PointsIn in;
  VoxelTable table;
  std::uint32_t* slot;

  TALUS_HD void operator()(int point_i) const
  {
    if (point_i >= frame->n_points) return;
    const Point p = in.at(point_i);
    if (!counts(p, point_i)) return;
    const std::uint64_t key = voxel_key(p);
    std::uint32_t s = static_cast<std::uint32_t>(mix_bits(key)) & table.mask;
    for (;;)
    {
      const std::uint64_t there = Atomics::compare_exchange(table.key + s, kNoVoxel, key);
      if (there == kNoVoxel || there == key) break;
      s = (s + 1) & table.mask;
    }
    slot[point_i] = s;
    Atomics::min(table.winner + s, fingerprint(p));
  }

  /** Whether a point passes all other tests of stage 1. */
  TALUS_HD bool counts(const Point& p, int point_i) const
  {
    const float rise_m = rise_above_sensor(pose_of_point(*frame, in.time_s, point_i), p);
    return accept(p, rise_m, *config).code == kAccepted && !is_body(p, *frame, *body);
  }

  /** A key of 21 bits for each coordinate in the sensor frame. */
  TALUS_HD std::uint64_t voxel_key(const Point& p) const
  {
    constexpr std::uint64_t mask = (1u << 21) - 1;
    const auto part = [&](float v)
    { return static_cast<std::uint64_t>(floor_to_int(v * config->inverse_voxel)) & mask; };
    return part(p.x_m) << 42 | part(p.y_m) << 21 | part(p.z_m);
  }

  static TALUS_HD std::uint64_t fingerprint(const Point& p)
  {
    const auto bits = [](float v)
    { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(ordered_from_float(v))); };
    return mix_bits(mix_bits(bits(p.x_m) << 32 | bits(p.y_m)) ^ bits(p.z_m));
  }
};

/** Keeps the chosen point of each voxel. */
template <class Atomics>
struct KeepVoxel
{
  EnterVoxel<Atomics> entered;
  std::uint8_t* kept;

  TALUS_HD void operator()(int point_i) const
  {
    if (point_i >= entered.frame->n_points) return;
    const Point p = entered.in.at(point_i);
    kept[point_i] = !entered.counts(p, point_i) || entered.table.winner[entered.slot[point_i]] ==
                                                       EnterVoxel<Atomics>::fingerprint(p);
  }
};

}  // namespace talus::kernels
