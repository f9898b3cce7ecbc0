#include <talus/risk.h>
#include "backend.h"
#include "kernels/7_risk.h"

namespace talus
{
std::vector<float> risk(const MapView& map)
{
  if (map.empty()) return {};
  const kernels::Config config = make_config(map.parameters()).config;
  const auto &slope = map.layer(Layer::Slope), &step = map.layer(Layer::Step),
             &roughness = map.layer(Layer::Roughness), &variance = map.layer(Layer::Variance),
             &traversability = map.layer(Layer::Traversability);
  std::vector<float> of_cells(traversability.size());
  for (std::size_t i = 0; i < of_cells.size(); i++)
    of_cells[i] =
        kernels::risk_of({slope[i], step[i], roughness[i], traversability[i], variance[i]}, config);
  return of_cells;
}

}  // namespace talus
