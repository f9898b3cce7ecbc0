#include <talus/frame_order.h>
#include <talus/number_text.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace talus
{
FrameSequence::FrameSequence(double max_late_s) : max_late_s_(max_late_s)
{
  if (!(std::isfinite(max_late_s) && max_late_s >= 0))
    throw std::invalid_argument(
        "max_late_s is " + number_text(max_late_s) + ": must be a time of 0 s or more");
}

FrameOrder FrameSequence::next(double stamp_s)
{
  if (!std::isfinite(stamp_s))
    throw std::invalid_argument("the time stamp of the frame is not finite");
  FrameOrder order = FrameOrder::Newest;
  if (started_ && stamp_s == newest_s_)
    order = FrameOrder::Duplicate;
  else if (started_ && stamp_s < newest_s_)
    order = newest_s_ - stamp_s <= max_late_s_ ? FrameOrder::Late : FrameOrder::ClockSetBack;
  if (order == FrameOrder::Newest || order == FrameOrder::ClockSetBack) newest_s_ = stamp_s;
  started_ = true;
  return order;
}

}  // namespace talus
