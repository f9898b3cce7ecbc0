#pragma once
#include "backend.h"

#include <memory>

namespace talus::test
{
/** The device's schedule in plain loops. */
std::unique_ptr<BackendInterface> make_device_schedule(const MapConfig& config);
}  // namespace talus::test
