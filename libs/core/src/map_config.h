#pragma once
#include <talus/parameters.h>
#include "kernels/config.h"

#include <vector>

namespace talus
{
struct MapConfig
{
  kernels::Config config;
  kernels::Body body;
  std::vector<ChannelRule> channels;
  /** kernels::kClasses scores for each channel; empty: no class costs. */
  std::vector<float> class_scores;
};
MapConfig make_config(const Parameters& p);

}  // namespace talus
