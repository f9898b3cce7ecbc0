#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "world_parts.h"

namespace talus::sim
{
namespace
{
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

struct Kind
{
  const char* keys;
  GroundPartPtr (*make)(const Fields&);
};

GroundPartPtr plane(const Fields& f)
{
  const Range slope{-80, 80};
  return make_plane(
      f.number_or("z_m", 0, kAny), std::tan(radians(f.number_or("slope_x_deg", 0, slope))),
      std::tan(radians(f.number_or("slope_y_deg", 0, slope))));
}

/** A strip at `at_m`, `width_m` wide, whose profile runs along yaw_deg + `turned_deg`. */
GroundPartPtr strip(const Fields& f, double width_m, double turned_deg, std::vector<Knot> profile)
{
  const auto at = f.numbers("at_m", 2, kAny);
  const double yaw = radians(f.number_or("yaw_deg", 0, kAny) + turned_deg);
  return make_strip(at[0], at[1], yaw, width_m, std::move(profile));
}

GroundPartPtr ramp(const Fields& f)
{
  const double length = f.number("length_m", kPositive), height = f.number("height_m", kAny);
  std::vector<Knot> profile{{0, 0}, {length, height}};
  if (f.has("top_m"))
  {
    const double top_end = length + f.number("top_m", kNotNegative);
    profile.push_back({top_end, height});
    profile.push_back({top_end + f.number_or("down_m", 0, kNotNegative), 0});
  }
  else if (f.has("down_m"))
    profile.push_back({length + f.number("down_m", kNotNegative), 0});
  return strip(f, f.number_or("width_m", kUnlimited, kPositive), 0, profile);
}

GroundPartPtr step(const Fields& f)
{
  const double height = f.number("height_m", kAny);
  std::vector<Knot> profile{{0, 0}, {0, height}};
  if (f.has("length_m"))
  {
    const double length = f.number("length_m", kPositive);
    profile.push_back({length, height});
    profile.push_back({length, 0});
  }
  return strip(f, f.number_or("width_m", kUnlimited, kPositive), 0, profile);
}

GroundPartPtr ditch(const Fields& f)
{
  const double half = 0.5 * f.number("width_m", kPositive), depth = f.number("depth_m", kPositive);
  const double bank = f.number_or("bank_m", 0, {0, half});
  const double length = f.number_or("length_m", kUnlimited, kPositive);
  return strip(
      f, length, 90, {{-half, 0}, {bank - half, -depth}, {half - bank, -depth}, {half, 0}});
}

GroundPartPtr sine(const Fields& f)
{
  return make_sine(
      f.number("amplitude_m", kNotNegative), f.number("wavelength_m", kPositive),
      radians(f.number_or("yaw_deg", 0, kAny)), radians(f.number_or("phase_deg", 0, kAny)));
}

GroundPartPtr mound(const Fields& f, const char* key, double sign)
{
  const auto at = f.numbers("at_m", 2, kAny);
  return make_mound(at[0], at[1], f.number("radius_m", kPositive), sign * f.number(key, kPositive));
}

GroundPartPtr roughness(const Fields& f)
{
  return make_roughness(
      f.number("amplitude_m", kNotNegative), f.number("wavelength_m", {0.01, 1e6}),
      f.whole_or("octaves", 1, 1, 8),
      static_cast<std::uint64_t>(f.whole_or("seed", 1, 0, 2000000000)));
}

GroundPartPtr image(const Fields& f)
{
  f.node("file");
  const auto beside = std::filesystem::path(f.file()).parent_path() / f.text_or("file", "");
  const auto at = f.numbers_or("at_m", {0, 0}, kAny);
  try
  {
    return make_image(
        read_pgm(beside.string()), at[0], at[1], f.number("pixel_m", kPositive),
        f.number("min_m", kAny), f.number("max_m", kAny));
  }
  catch (const std::exception& e)
  {
    f.fail("file", std::string(e.what()));
  }
}

const std::map<std::string, Kind> kKinds{
    {"plane", {"z_m slope_x_deg slope_y_deg", plane}},
    {"ramp", {"at_m yaw_deg length_m height_m width_m top_m down_m", ramp}},
    {"step", {"at_m yaw_deg height_m width_m length_m", step}},
    {"ditch", {"at_m yaw_deg width_m depth_m bank_m length_m", ditch}},
    {"sine", {"amplitude_m wavelength_m yaw_deg phase_deg", sine}},
    {"pit", {"at_m radius_m depth_m", [](const Fields& f) { return mound(f, "depth_m", -1); }}},
    {"mound", {"at_m radius_m height_m", [](const Fields& f) { return mound(f, "height_m", 1); }}},
    {"roughness", {"amplitude_m wavelength_m octaves seed", roughness}},
    {"image", {"file at_m pixel_m min_m max_m", image}}};

}  // namespace

void parse_ground(const YAML::Node& list, const std::string& file, World& world)
{
  if (!list.IsSequence() || list.size() == 0)
    fail_at(list, file, "ground", "must be a list of parts, e.g. `- plane: {z_m: 0}`");
  require_max_size(list, file, "ground", 1000);
  std::vector<std::string> names;
  names.reserve(kKinds.size());
  for (const auto& k : kKinds) names.push_back(k.first);
  std::vector<std::pair<GroundPartPtr, Presence>> parts;
  std::set<double> changes_s;
  for (const auto& entry : list)
  {
    const std::string name = only_key(entry, file, "ground", names);
    const Kind& kind = kKinds.at(name);
    const Fields f(entry[name], file, "ground." + name, kind.keys + std::string(kPresenceKeys));
    parts.emplace_back(kind.make(f), Presence(f));
    for (const double t : {parts.back().second.from_s, parts.back().second.until_s})
      if (t > 0 && std::isfinite(t)) changes_s.insert(t);
  }
  const auto ground_at = [&](double time_s)
  {
    Ground ground;
    for (const auto& [part, presence] : parts)
      if (presence.holds(time_s)) ground.add(part);
    return ground;
  };
  world.ground = ground_at(0);
  for (const double t : changes_s) world.ground_changes.push_back({t, ground_at(t)});
}

}  // namespace talus::sim
