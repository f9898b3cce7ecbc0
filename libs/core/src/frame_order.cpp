#include <talus/frame_order.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus
{
FrameSequence::FrameSequence(double max_late_s) : max_late_s_(max_late_s)
{
  if (!(std::isfinite(max_late_s) && max_late_s >= 0))
    throw std::invalid_argument(
        "max_late_s is " + number_text(max_late_s) + ": must be a time of 0 s or more");
}

FrameOrder FrameSequence::next(double stamp_s, std::uint32_t sensor)
{
  if (!std::isfinite(stamp_s))
    throw std::invalid_argument("the time stamp of the frame is not finite");
  const auto known = std::find_if(
      newest_.begin(), newest_.end(), [&](const Newest& n) { return n.sensor == sensor; });
  if (known == newest_.end())
  {
    newest_.push_back({sensor, stamp_s});
    return FrameOrder::Newest;
  }
  const double before_s = known->stamp_s;
  if (stamp_s == before_s) return FrameOrder::Duplicate;
  if (stamp_s < before_s && before_s - stamp_s <= max_late_s_) return FrameOrder::Late;
  known->stamp_s = stamp_s;
  return stamp_s > before_s ? FrameOrder::Newest : FrameOrder::ClockSetBack;
}

}  // namespace talus
