#include "setting.h"

#include <map>
#include <utility>

namespace talus::bench
{
namespace
{
const std::vector<Layer> kTwoLayers{Layer::Traversability, Layer::Elevation};
const std::vector<Layer> kSixLayers{Layer::Traversability, Layer::Elevation, Layer::GroundElevation,
                                    Layer::Variance,       Layer::State,     Layer::Slope};
constexpr double kResolution_m = 0.05;
constexpr double kRoll_m = 0.1004;  //!< two cells, and nowhere at the edge of one

const std::vector<Scan>& drive(const Setting& s)
{
  static std::map<std::string, std::vector<Scan>> made;
  const double radius_m = 0.55 * s.cells * kResolution_m;
  const std::string key =
      std::to_string(s.points) + "/" + std::to_string(s.cells) + "/" + std::to_string(s.apart_m);
  auto& scans = made[key];
  if (scans.empty()) scans = make_drive(s.points, radius_m, s.points > 200000 ? 3 : 8, s.apart_m);
  return scans;
}
}  // namespace

std::vector<Setting> settings()
{
  std::vector<Setting> all{
      {"S1", 14400, 160, kTwoLayers},
      {"S1/6_layers", 14400, 160, kSixLayers},
      {"S2", 131072, 1000, kTwoLayers},
      {"S2/6_layers", 131072, 1000, kSixLayers}};
  for (const auto& [name, layers] :
       {std::pair{"two_in_flight", kTwoLayers}, {"6_layers/two_in_flight", kSixLayers}})
  {
    all.push_back({std::string("S1/") + name, 14400, 160, layers});
    all.back().overlapped = true;
    all.push_back({std::string("S2/") + name, 131072, 1000, layers});
    all.back().overlapped = true;
  }
  for (const auto& [name, handed_over] :
       {std::pair{"roll", HandedOver::Nothing},
        {"roll/read", HandedOver::Read},
        {"roll/read_and_written", HandedOver::ReadAndWritten}})
    for (const std::size_t i : {0, 2})
    {
      Setting s = all[i];
      s.name += std::string("/") + name;
      s.apart_m = kRoll_m;
      s.cells_handed_over = handed_over;
      all.push_back(s);
    }
  for (const std::size_t points : {10240, 51200, 204800, 819200, 2048000})
    all.push_back({"points/" + std::to_string(points), points, 400, kTwoLayers});
  for (const int cells : {160, 400, 1000, 2000, 4000})
    all.push_back({"cells/" + std::to_string(cells), 131072, cells, kTwoLayers});
  return all;
}

Parameters parameters(const Setting& s)
{
  Parameters p;
  p.resolution_m = kResolution_m;
  p.window_m = s.cells * kResolution_m;
  return p;
}

const Scan& scan_at(const Setting& s, int i)
{
  const auto& scans = drive(s);
  const int last = static_cast<int>(scans.size()) - 1, at = i % (2 * last);
  return scans[static_cast<std::size_t>(at <= last ? at : 2 * last - at)];
}

}  // namespace talus::bench
