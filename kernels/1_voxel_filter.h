#pragma once
#include "kernels/1_accept.h"
#include "kernels/map.h"

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

/** Enters one point into the table; `slot` keeps its index. */
template <class Atomics>
struct EnterVoxel
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    if (point_i >= m.frame->n_points) return;
    const Point p = m.in.at(point_i);
    if (!counts(p, point_i)) return;
    const std::uint64_t key = voxel_key(p);
    std::uint32_t s = static_cast<std::uint32_t>(mix_bits(key)) & m.voxel_mask;
    for (;;)
    {
      const std::uint64_t there = Atomics::compare_exchange(m.voxel_key + s, kNoVoxel, key);
      if (there == kNoVoxel || there == key) break;
      s = (s + 1) & m.voxel_mask;
    }
    m.voxel_slot[point_i] = s;
    Atomics::min(m.voxel_winner + s, fingerprint(p));
  }

  TALUS_HD bool counts(const Point& p, int point_i) const
  {
    const float rise_m = rise_above_sensor(pose_of_point(*m.frame, m.in.time_s, point_i), p);
    return accept(p, rise_m, m.k).code == kAccepted && !is_body(p, *m.frame, *m.body);
  }

  /** A key of 21 bits for each coordinate in the sensor frame. */
  TALUS_HD std::uint64_t voxel_key(const Point& p) const
  {
    constexpr std::uint64_t mask = (1u << 21) - 1;
    const auto part = [&](float v)
    { return static_cast<std::uint64_t>(floor_to_int(v * m.k.inverse_voxel)) & mask; };
    return part(p.x_m) << 42 | part(p.y_m) << 21 | part(p.z_m);
  }

  static TALUS_HD std::uint64_t fingerprint(const Point& p)
  {
    const auto bits = [](float v)
    { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(ordered_from_float(v))); };
    return mix_bits(mix_bits(bits(p.x_m) << 32 | bits(p.y_m)) ^ bits(p.z_m));
  }
};

template <class Atomics>
struct KeepVoxel
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    if (point_i >= m.frame->n_points) return;
    const EnterVoxel<Atomics> entered{m};
    const Point p = m.in.at(point_i);
    m.voxel_kept[point_i] = !entered.counts(p, point_i) ||
                            m.voxel_winner[m.voxel_slot[point_i]] == entered.fingerprint(p);
  }
};

}  // namespace talus::kernels
