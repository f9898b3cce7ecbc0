#include "watched_trajectory.h"

#include <cmath>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::app
{
WatchedTrajectory::WatchedTrajectory(const std::string& path)
    : path_(path), taken_(now()), last_(taken_)
{
}

WatchedTrajectory::State WatchedTrajectory::now() const
{
  std::error_code none;
  State state{fs::last_write_time(path_, none), 0};
  const auto bytes = none ? 0 : fs::file_size(path_, none);
  if (!none) state.bytes = bytes;
  return state;
}

bool WatchedTrajectory::ends_with_a_line() const
{
  std::ifstream file(path_, std::ios::binary);
  file.seekg(-1, std::ios::end);
  return file.get() == '\n';
}

std::optional<Poses> WatchedTrajectory::take(double now_s)
{
  constexpr double kCalm_s = 0.5, kPatience_s = 5;  // a program that writes does so at once
  const State state = now();
  if (!(state == last_))
  {
    last_ = state;
    last_s_ = now_s;
  }
  const double calm_s = std::abs(now_s - last_s_);
  if (state.bytes == 0 || state == taken_ || calm_s < kCalm_s) return std::nullopt;
  if (!ends_with_a_line() && calm_s < kPatience_s) return std::nullopt;
  try
  {
    auto poses = io::Trajectory::load(path_).entries();
    taken_ = state;
    return poses;
  }
  catch (const std::runtime_error&)
  {
    if (calm_s < kPatience_s) return std::nullopt;
    taken_ = state;
    throw;
  }
}

}  // namespace talus::app
