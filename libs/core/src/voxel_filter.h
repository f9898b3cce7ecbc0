#pragma once
#include "map_buffers.h"

namespace talus
{
/** The part of stage 1 that keeps one point of each voxel. Returns 1 for each point that is kept;
 * null without a filter. */
template <class Executor>
const std::uint8_t* filter_voxels(MapBuffers<Executor>& map, Executor& executor)
{
  using Atomics = typename Executor::Atomics;
  if (!(map.host_config.inverse_voxel > 0)) return nullptr;
  executor.fill(map.voxel_key, kernels::kNoVoxel);
  executor.fill(map.voxel_winner, kernels::kNoVoxel);
  const auto mask = static_cast<std::uint32_t>(map.voxel_key.size() - 1);
  const kernels::EnterVoxel<Atomics> enter{
      map.config.data(),
      map.context.data(),
      map.body.data(),
      map.now->in,
      {map.voxel_key.data(), map.voxel_winner.data(), mask},
      map.voxel_slot.data()};
  executor.for_each(map.points(executor), enter);
  executor.for_each(
      map.points(executor), kernels::KeepVoxel<Atomics>{enter, map.voxel_kept.data()});
  return map.voxel_kept.data();
}

}  // namespace talus
