#include <talus/io/summary_json.h>

#include <talus/io/atomic_file.h>
#include <talus/io/quantile.h>
#include <nlohmann/json.hpp>
#include <talus/number_text.h>

#include <cmath>

using Json = nlohmann::ordered_json;

namespace talus::io
{
namespace
{
/** Median, p99 and maximum of one figure of every frame; null for no frames. */
template <typename Get>
Json spread(const std::vector<FrameReport>& frames, Get get)
{
  std::vector<double> values;
  values.reserve(frames.size());
  for (const auto& f : frames) values.push_back(get(f));
  return {
      {"median", quantile(values, 0.5)},
      {"p99", quantile(values, 0.99)},
      {"max", quantile(values, 1.0)}};
}

Json milliseconds(const std::vector<FrameReport>& frames)
{
  Json ms;
  ms["total"] = spread(frames, [](const FrameReport& f) { return f.total_ms; });
  for (int i = 0; i < kStageCount; ++i)
    ms[kStageNames[i]] = spread(frames, [i](const FrameReport& f) { return f.stage_ms[i]; });
  return ms;
}

Json points(const PointTotals& total)
{
  Json reasons;
  for (int i = 0; i < kRejectCount; ++i) reasons[kRejectNames[i]] = total.rejected[i];
  return {{"in", total.in}, {"accepted", total.accepted}, {"rejected", reasons}};
}

Json parameters(const Parameters& p)
{
  Json all;
  for (const auto& info : parameter_table())
  {
    if (info.is_text())
      all[info.name] = parameter_text(p, info);
    else if (info.is_integer)
      all[info.name] = static_cast<std::int64_t>(info.get(p));
    else
      all[info.name] = info.get(p);
  }
  return all;
}

Json window(const LayerStack& s)
{
  return {
      {"cells", {s.cells_x, s.cells_y}},
      {"resolution_m", s.resolution_m},
      {"x_m", {s.min_x_m, s.min_x_m + s.cells_x * s.resolution_m}},
      {"y_m", {s.min_y_m, s.min_y_m + s.cells_y * s.resolution_m}}};
}

Json site(const SiteSummary& s)
{
  return {
      {"area_m2", s.area_m2},
      {"length_m", s.length_m},
      {"floors", s.floors},
      {"islands", s.islands},
      {"cells",
       {{"measured", s.cells[1]},
        {"filled_two_sided", s.cells[2]},
        {"filled_one_sided", s.cells[3]},
        {"presumed", s.cells[4]}}}};
}

Json counts(const std::map<std::string, std::size_t>& by_name)
{
  Json object = Json::object();
  for (const auto& [name, count] : by_name) object[name.empty() ? "(no label)" : name] = count;
  return object;
}

std::size_t total(const std::map<std::string, std::size_t>& by_name)
{
  std::size_t sum = 0;
  for (const auto& entry : by_name) sum += entry.second;
  return sum;
}

std::string header()
{
  std::string line = "stamp_s,points_in,points_accepted";
  for (const char* reason : kRejectNames) line += std::string(",rejected_") + reason;
  for (const char* stage : kStageNames) line += std::string(",") + stage + "_ms";
  return line + ",total_ms\n";
}

std::string row_of(const FrameReport& f)
{
  std::string row = fixed_text(f.stamp_s, 6);
  row += "," + std::to_string(f.points_in) + "," + std::to_string(f.points_accepted);
  for (const auto count : f.rejected) row += "," + std::to_string(count);
  for (const double ms : f.stage_ms) row += "," + fixed_text(ms, 4);
  return row + "," + fixed_text(f.total_ms, 4) + "\n";
}
}  // namespace

Coverage coverage_of(const LayerStack& stack)
{
  const auto* state = stack.find(layer_name(Layer::State));
  if (!state || state->empty()) return {};
  std::array<std::size_t, kCellStates> count{};
  for (const float s : *state)
    ++count[s >= 1 && s < kCellStates ? static_cast<std::size_t>(s) : std::size_t{0}];
  const auto part = [&](CellState s)
  {
    return static_cast<double>(count[static_cast<std::size_t>(s)]) /
           static_cast<double>(state->size());
  };
  return {
      part(CellState::Measured), part(CellState::FilledTwoSided), part(CellState::FilledOneSided),
      part(CellState::Presumed), part(CellState::Unknown)};
}

PointTotals totals_of(const std::vector<FrameReport>& frames)
{
  PointTotals sum;
  for (const auto& f : frames)
  {
    sum.in += f.points_in;
    sum.accepted += f.points_accepted;
    for (int i = 0; i < kRejectCount; ++i) sum.rejected[i] += f.rejected[i];
  }
  return sum;
}

std::string summary_json(const RunSummary& run, const LayerStack& stack)
{
  const Coverage c = coverage_of(stack);
  Json j;
  j["program"] = "talus-map";
  j["version"] = run.version;
  j["log"] = run.log;
  if (!run.imported.empty()) j["imported"] = run.imported;
  j["backend"] = run.backend;
  j["threads"] = run.threads;
  j["poses"] = run.pose_source;
  j["frames"] = run.frames.size();
  j["skipped"] = total(run.skipped);
  j["skipped_by_reason"] = counts(run.skipped);
  j["frames_deskewed"] = run.frames_deskewed;
  j["stamps_backwards"] = run.stamps_backwards;
  j["snapshots"] = run.snapshots;
  j["sensors"] = counts(run.sensors);
  j["unsupported_observations"] = counts(run.unsupported);
  j["points"] = points(totals_of(run.frames));
  j["milliseconds"] = milliseconds(run.frames);
  j["wall_seconds"] = run.wall_s;
  j["coverage"] = {
      {"known", 1 - c.unknown},
      {"measured", c.measured},
      {"filled_two_sided", c.filled_two_sided},
      {"filled_one_sided", c.filled_one_sided},
      {"presumed", c.presumed},
      {"unknown", c.unknown}};
  j["window"] = window(stack);
  if (run.site) j["site"] = site(*run.site);
  j["parameters"] = parameters(run.parameters);
  j["warnings"] = run.warnings;
  j["hints"] = run.hints;
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_summary_json(const std::string& path, const RunSummary& run, const LayerStack& stack)
{
  write_file(path, summary_json(run, stack));
}

std::string timing_csv(const std::vector<FrameReport>& frames)
{
  std::string text = header();
  for (const auto& f : frames) text += row_of(f);
  return text;
}

void write_timing_csv(const std::string& path, const std::vector<FrameReport>& frames)
{
  write_file(path, timing_csv(frames));
}

}  // namespace talus::io
