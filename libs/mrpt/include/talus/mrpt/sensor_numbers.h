#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace talus
{
/** Frame::sensor of the sensors of one map, by their labels: in the order in which they appear. */
class SensorNumbers
{
 public:
  SensorNumbers() = default;
  /** Of a map that has these already. */
  explicit SensorNumbers(std::vector<std::string> labels);

  /** Throws std::invalid_argument for one sensor more than a map tells apart, kMaxSensors. */
  std::uint32_t number_of(const std::string& label);

  /** The place of each is its number. */
  const std::vector<std::string>& labels() const { return labels_; }

 private:
  std::vector<std::string> labels_;  //!< the place is the number
};

}  // namespace talus
