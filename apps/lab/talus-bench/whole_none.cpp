#include "whole.h"

#include <stdexcept>

namespace talus::bench
{
std::unique_ptr<Whole> make_whole(double, double, const std::string&)
{
  throw std::runtime_error("--whole needs a talus that is built with TALUS_WITH_MRPT=ON");
}

}  // namespace talus::bench
