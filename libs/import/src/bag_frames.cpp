#include "bag_frames.h"

#include <mrpt/math/slerp.h>
#include <mrpt/poses/CPose3DQuat.h>

#include <algorithm>

#include "cdr_reader.h"

using mrpt::math::TPose3DQuat;
using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
constexpr std::int64_t kMinStep_ns = 5000000;  //!< 200 Hz; between them a robot goes straight
constexpr std::int64_t kHold_ns = 100000000;
constexpr std::size_t kMaxFrames = 10000;

CPose3D pose_of(const TPose3DQuat& pose) { return CPose3D(mrpt::poses::CPose3DQuat(pose)); }

mrpt::math::CQuaternionDouble rotation_of(const TPose3DQuat& p) { return {p.qr, p.qx, p.qy, p.qz}; }

CPose3D between(const StampedPose& a, const StampedPose& b, std::int64_t stamp_ns)
{
  const double t =
      static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
  mrpt::math::CQuaternionDouble q;
  mrpt::math::slerp(rotation_of(a.pose), rotation_of(b.pose), t, q);
  q.normalize();
  const auto mix = [t](double from, double to) { return from + t * (to - from); };
  return CPose3D(q, mix(a.pose.x, b.pose.x), mix(a.pose.y, b.pose.y), mix(a.pose.z, b.pose.z));
}
}  // namespace

std::string listed(const std::vector<std::string>& names)
{
  constexpr std::size_t kMax = 40, kMaxText = 60;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMax); ++i)
    list += (list.empty() ? "" : ", ") + names[i].substr(0, kMaxText);
  return names.empty() ? "none" : list + (names.size() > kMax ? ", ..." : "");
}

bool is_of_robot(const std::string& frame, const std::string& name)
{
  const auto slash = frame.rfind('/');
  return slash != std::string::npos && frame.substr(slash + 1) == name;
}

bool PoseHistory::add(std::int64_t stamp_ns, const TPose3DQuat& pose)
{
  if (!all_.empty())
  {
    const auto step_ns = stamp_ns - all_.back().stamp_ns;
    if (step_ns >= 0 && step_ns < kMinStep_ns) return false;
  }
  all_.push_back({stamp_ns, pose});
  return true;
}

void PoseHistory::sort()
{
  std::stable_sort(
      all_.begin(), all_.end(),
      [](const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; });
  const auto is_first = [&](const StampedPose& p)
  {
    bool is = true;
    for (std::size_t i = 0; i < 7; ++i) is = is && p.pose[i] == all_[0].pose[i];
    return is;
  };
  is_constant_ = std::all_of(all_.begin(), all_.end(), is_first);
}

void PoseHistory::forget_before(std::int64_t stamp_ns)
{
  const auto first = std::find_if(
      all_.begin(), all_.end(), [&](const StampedPose& p) { return p.stamp_ns >= stamp_ns; });
  all_.erase(all_.begin(), first);
}

std::optional<CPose3D> PoseHistory::at(std::int64_t stamp_ns) const
{
  const auto after = std::lower_bound(
      all_.begin(), all_.end(), stamp_ns,
      [](const StampedPose& p, std::int64_t t) { return p.stamp_ns < t; });
  const bool has_after = after != all_.end(), has_before = after != all_.begin();
  if (has_after && after->stamp_ns == stamp_ns) return pose_of(after->pose);
  if (has_after && has_before) return between(*(after - 1), *after, stamp_ns);
  if (has_after && after->stamp_ns - stamp_ns <= kHold_ns) return pose_of(after->pose);
  if (has_before && stamp_ns - (after - 1)->stamp_ns <= kHold_ns) return pose_of((after - 1)->pose);
  if (is_constant_ && !all_.empty()) return pose_of(all_[0].pose);
  return std::nullopt;
}

void FrameTree::add(const FrameTransform& transform, bool is_static)
{
  if (!transform.T_parent_child || transform.child == transform.parent.frame) return;
  const auto [at, is_new] = links_.try_emplace(transform.child);
  Link& link = at->second;
  if (links_.size() > kMaxFrames)
    throw CdrError("names one frame more than " + std::to_string(kMaxFrames) + " of TF");
  if (is_new) link.parent = transform.parent.frame;
  if (link.parent != transform.parent.frame)
  {
    conflicts_.insert(transform.child);
    return;
  }
  if (is_static)
    link.fixed = pose_of(*transform.T_parent_child);
  else if (!link.fixed && link.moving.add(transform.parent.stamp_ns, *transform.T_parent_child))
    ++size_;
}

void FrameTree::sort()
{
  for (auto& [child, link] : links_) link.moving.sort();
}

void FrameTree::keep_chains_of(const std::vector<std::string>& frames)
{
  constexpr std::size_t kLong = 10000;
  std::set<const Link*> kept;
  for (const auto& frame : frames)
    for (const auto* link : chain_to_root(frame)) kept.insert(link);
  size_ = 0;
  for (auto& [child, link] : links_)
  {
    if (kept.count(&link) == 0 && link.moving.all().size() > kLong) link.moving.clear();
    size_ += link.moving.all().size();
  }
}

void FrameTree::forget_before(std::int64_t stamp_ns)
{
  size_ = 0;
  for (auto& [child, link] : links_)
  {
    link.moving.forget_before(stamp_ns);
    size_ += link.moving.all().size();
  }
}

bool FrameTree::has(const std::string& frame) const
{
  return links_.count(frame) > 0 ||
         std::any_of(
             links_.begin(), links_.end(), [&](const auto& l) { return l.second.parent == frame; });
}

std::vector<std::string> FrameTree::frames() const
{
  std::set<std::string> all;
  for (const auto& [child, link] : links_) all.insert({child, link.parent});
  return {all.begin(), all.end()};
}

std::string FrameTree::named(const std::vector<std::string>& names) const
{
  for (const auto& name : names)
    if (has(name)) return name;
  for (const auto& name : names)
  {
    std::vector<std::string> found;
    for (const auto& frame : frames())
      if (is_of_robot(frame, name)) found.push_back(frame);
    if (found.size() == 1) return found[0];
  }
  return "";
}

FrameTree::Chain FrameTree::chain_to_root(const std::string& frame) const
{
  Chain chain;
  auto at = links_.find(frame);
  for (; at != links_.end() && chain.size() <= links_.size(); at = links_.find(at->second.parent))
    chain.push_back(&at->second);
  return chain.size() > links_.size() ? Chain() : chain;  // frames in a circle have no root
}

std::optional<std::pair<FrameTree::Chain, FrameTree::Chain>> FrameTree::chains(
    const std::string& a, const std::string& b) const
{
  auto from_a = chain_to_root(a), from_b = chain_to_root(b);
  const auto& root_a = from_a.empty() ? a : from_a.back()->parent;
  const auto& root_b = from_b.empty() ? b : from_b.back()->parent;
  if (root_a != root_b) return std::nullopt;
  while (!from_a.empty() && !from_b.empty() && from_a.back() == from_b.back())
  {
    from_a.pop_back();
    from_b.pop_back();
  }
  return std::make_pair(std::move(from_a), std::move(from_b));
}

bool FrameTree::connects(const std::string& a, const std::string& b) const
{
  return chains(a, b).has_value();
}

std::string FrameTree::child_towards(const std::string& parent, const std::string& frame) const
{
  auto at = links_.find(frame);
  for (auto left = links_.size(); at != links_.end() && left > 0; --left)
  {
    if (at->second.parent == parent) return at->first;
    at = links_.find(at->second.parent);
  }
  return "";
}

std::optional<CPose3D> FrameTree::T_along(const Chain& chain, std::int64_t stamp_ns)
{
  CPose3D T;
  for (const auto* link : chain)
  {
    const auto T_parent_child = link->fixed ? link->fixed : link->moving.at(stamp_ns);
    if (!T_parent_child) return std::nullopt;
    T = *T_parent_child + T;
  }
  return T;
}

std::optional<CPose3D> FrameTree::T_between(
    const std::string& from, const std::string& to, std::int64_t stamp_ns) const
{
  const auto both = chains(from, to);
  if (!both) return std::nullopt;
  const auto T_common_from = T_along(both->first, stamp_ns);
  const auto T_common_to = T_along(both->second, stamp_ns);
  if (!T_common_from || !T_common_to) return std::nullopt;
  return *T_common_to - *T_common_from;
}

std::optional<std::int64_t> FrameTree::known_until(
    const std::string& from, const std::string& to) const
{
  const auto both = chains(from, to);
  std::optional<std::int64_t> until;
  if (!both) return until;
  for (const auto* chain : {&both->first, &both->second})
    for (const auto* link : *chain)
      if (!link->fixed)
      {
        if (link->moving.all().empty()) return std::nullopt;
        const auto last = link->moving.all().back().stamp_ns;
        until = std::min(until.value_or(last), last);
      }
  return until;
}

std::vector<std::int64_t> FrameTree::times_between(
    const std::string& from, const std::string& to) const
{
  const auto both = chains(from, to);
  std::vector<std::int64_t> times;
  if (!both) return times;
  const PoseHistory* most = nullptr;
  for (const auto* chain : {&both->first, &both->second})
    for (const auto* link : *chain)
      if (!link->fixed && (!most || link->moving.all().size() > most->all().size()))
        most = &link->moving;
  if (!most) return times;
  times.reserve(most->all().size());
  for (const auto& pose : most->all()) times.push_back(pose.stamp_ns);
  return times;
}

}  // namespace talus::import
