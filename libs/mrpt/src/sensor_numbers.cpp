#include <talus/frame.h>
#include <talus/mrpt/sensor_numbers.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace talus
{
SensorNumbers::SensorNumbers(std::vector<std::string> labels) : labels_(std::move(labels)) {}

std::uint32_t SensorNumbers::number_of(const std::string& label)
{
  const auto known = std::find(labels_.begin(), labels_.end(), label);
  const auto number = static_cast<std::uint32_t>(known - labels_.begin());
  if (known != labels_.end()) return number;
  if (labels_.size() == kMaxSensors)
    throw std::invalid_argument(
        "'" + label + "' is a sensor label more than the " + std::to_string(kMaxSensors) +
        " that one map tells apart: a sensor keeps its label from scan to scan");
  labels_.push_back(label);
  return number;
}

}  // namespace talus
