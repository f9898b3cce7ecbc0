// Makes pictures of the pages.
//   sheets WORLDS FOLDER: what each stage makes of a frame, and what a parameter changes, as
//     FOLDER/stages.png and FOLDER/parameters.png
//   labels WORLDS FILE: scans of a street, coloured by what each point is
//   channels WORLDS FILE: classes of points, and a map in which two of them cost
//   drive EYE TARGET FOLDER MAPS...: maps of talus-map --every as a drive that is seen from EYE
//     (x,y,z in m), as FOLDER/drive_000.png ...
#include "sheet.h"

#include <talus/baselines/method.h>
#include <talus/io/map_picture.h>
#include <talus/sim/world.h>

#include <picture_style.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace talus::pictures
{
namespace
{
constexpr double kSide_m = 8;
constexpr int kStage_px = 240, kParameter_px = 160;

/** The scans of a world up to the place of a picture. */
class Worlds
{
 public:
  explicit Worlds(std::string folder) : folder_(std::move(folder)) {}

  const std::vector<baselines::ScanFrame>& frames(const std::string& name)
  {
    if (const auto known = frames_.find(name); known != frames_.end()) return known->second;
    const auto world = sim::load_world(folder_ + "/" + name + ".yaml");
    return frames_[name] = baselines::simulate(world, sim::Drive(world)).frames;
  }

 private:
  std::string folder_;
  std::map<std::string, std::vector<baselines::ScanFrame>> frames_;
};

/** The map after this share of the frames. */
io::LayerStack map_of(
    const std::vector<baselines::ScanFrame>& frames, double share, const Parameters& parameters)
{
  ElevationMapper map(parameters);
  const auto count = static_cast<std::size_t>(share * static_cast<double>(frames.size()));
  for (std::size_t i = 0; i < count; ++i) map.update(frames[i].view());
  return io::snapshot(map);
}

Parameters with(const std::string& name, const std::string& value)
{
  Parameters p;
  if (!name.empty()) set_parameter(p, name, value);
  p.validate();
  return p;
}

/** Keeps the values of a layer where the state is one of these. */
void keep_where(io::LayerStack& stack, std::vector<float>& values, float least, float most)
{
  const auto& states = *stack.find("state");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(states[i] >= least && states[i] <= most))
      values[i] = std::numeric_limits<float>::quiet_NaN();
}

std::vector<float>& layer(io::LayerStack& stack, const std::string& name)
{
  for (std::size_t i = 0; i < stack.names.size(); ++i)
    if (stack.names[i] == name) return stack.layers[i];
  throw std::invalid_argument("there is no layer " + name);
}

/** The window after one scan alone: what it has points of. */
io::LayerStack one_scan(const std::vector<baselines::ScanFrame>& frames, double share)
{
  const auto i = static_cast<std::size_t>(share * static_cast<double>(frames.size())) - 1;
  return map_of({frames[i]}, 1, Parameters());
}

Tile tile(const char* title, const char* words, const io::LayerStack& map, const char* layer)
{
  return {title, words, layer_image(map, layer, kSide_m, kStage_px)};
}

std::vector<Tile> stages(Worlds& worlds)
{
  const auto& frames = worlds.frames("demo");
  constexpr double kShare = 0.75;
  const auto scan = one_scan(frames, kShare), map = map_of(frames, kShare, Parameters());
  const auto people = map_of(worlds.frames("person"), kShare, Parameters());
  io::LayerStack measured = map, inferred = map;
  keep_where(measured, layer(measured, "ground_elevation"), 1, 1);
  keep_where(inferred, layer(inferred, "state"), 1, 1);
  return {
      tile("1  Accept", "one scan: tops of what it hit", scan, "elevation"),
      tile("2, 3  Roll, update", "all scans so far: tops", map, "elevation"),
      tile("3  Update", "measured ground", measured, "ground_elevation"),
      tile("1  Accept", "variance of the ground", map, "variance"),
      tile("4  Classify", "what is to be inferred: white", inferred, "state"),
      tile("5  Cleanup", "people walked here: no trail", people, "traversability"),
      tile("6  Fill", "where the ground comes from", map, "state"),
      tile("6  Fill", "measured and filled ground", map, "ground_elevation"),
      tile("7  Traversability", "slope, step, roughness; ditches", map, "traversability")};
}

/** Two tiles of a sheet: a map with the defaults, and one with this parameter. */
struct Effect
{
  const char *world, *name, *value, *layer;
  double share = 0.75;
};

const Effect kEffects[]{
    {"demo", "window_m", "5", "traversability"},
    {"demo", "resolution_m", "0.2", "traversability"},
    {"demo", "min_range_m", "3", "state"},
    {"demo", "max_range_m", "3", "state"},
    {"demo", "max_height_m", "-0.5", "elevation"},
    {"demo", "voxel_m", "0.4", "state"},
    {"demo", "c_beam_m", "0.05", "variance"},
    {"branches", "clearance_m", "1.8", "traversability"},
    {"person", "cleanup_frames", "100", "traversability"},
    {"demo", "fill_search_m", "0.3", "state"},
    {"demo", "object_size_m", "0.2", "traversability"},
    {"demo", "feature_radius_m", "0.4", "traversability"},
    {"slope", "slope_threshold_rad", "0.25", "traversability"},
    {"demo", "step_threshold_m", "0.05", "traversability"},
    {"rocks", "roughness_threshold_m", "0.02", "traversability"}};

std::vector<Tile> effects(Worlds& worlds)
{
  std::vector<Tile> tiles;
  for (const Effect& e : kEffects)
  {
    const auto& frames = worlds.frames(e.world);
    const std::string value = parameter_text(Parameters(), *find_parameter(e.name));
    for (const auto& [name, shown] :
         {std::pair<std::string, std::string>{"", value}, {e.name, e.value}})
    {
      const auto map = map_of(frames, e.share, with(name, shown));
      tiles.push_back(
          {name.empty() ? e.name + (std::string(": ") + e.layer) : "", shown,
           layer_image(map, e.layer, kSide_m, kParameter_px)});
    }
  }
  return tiles;
}
void write_sheets(const std::string& world_folder, const std::string& folder)
{
  Worlds worlds(world_folder);
  io::write_png(folder + "/stages.png", draw_sheet(stages(worlds), 3, 3, "worlds demo, person"));
  io::write_png(
      folder + "/parameters.png", draw_sheet(effects(worlds), 6, 2, "8 x 8 m of simulated worlds"));
}

void write_labels(const std::string& world_folder, const std::string& file)
{
  Worlds worlds(world_folder);
  auto frames = worlds.frames("street");
  frames.resize(frames.size() * 3 / 4);
  const Camera camera{{0.5, -8, 7.5}, {5.6, 0.7, 0.2}, 1000, {1100, 560}};
  io::write_png(file, draw_labelled_scans(frames, 12, camera));
}

/** A made-up segmenter: grass to the left of the robot's way, gravel to the right, a path between.
 */
float class_at(double y_m)
{
  constexpr float kPath = 6, kGrass = 14, kGravel = 9;
  return y_m > 2.5 ? kGrass : y_m < -1 ? kGravel : kPath;
}

io::LayerStack map_of_classes(const std::vector<baselines::ScanFrame>& frames, const char* costs)
{
  Parameters p = with("", "");
  p.channels = channels_from("label:vote");
  p.channel_cost = channel_costs_from(costs);
  ElevationMapper map(p);
  for (const baselines::ScanFrame& scan : frames)
  {
    Frame frame = scan.view();
    std::vector<float> classes;
    const auto& m = frame.T_map_sensor.m;
    for (std::size_t i = 0; i < frame.size; ++i)
      classes.push_back(
          class_at(m[4] * frame.x_m[i] + m[5] * frame.y_m[i] + m[6] * frame.z_m[i] + m[7]));
    frame.channels[0] = classes.data();
    map.update(frame);
  }
  return io::snapshot(map);
}

void write_channels(const std::string& world_folder, const std::string& file)
{
  Worlds worlds(world_folder);
  auto frames = worlds.frames("demo");
  frames.resize(frames.size() * 3 / 4);
  const auto free = map_of_classes(frames, ""), dear = map_of_classes(frames, "label:14=0,9=0.5");
  const std::vector<Tile> tiles{
      tile("label", "grass above, gravel below, a path", free, "label"),
      tile("traversability", "without costs", free, "traversability"),
      tile("traversability", "channel_cost = label:14=0,9=0.5", dear, "traversability")};
  io::write_png(file, draw_sheet(tiles, 3, 3, "world demo, 8 x 8 m", SheetLegend::Scores));
}

cv::Vec3d place_from(const std::string& text)
{
  cv::Vec3d p;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf", &p[0], &p[1], &p[2]) != 3)
    throw std::invalid_argument("'" + text + "' must be x,y,z in metres");
  return p;
}

int run(const std::vector<std::string>& args)
{
  static const std::map<std::string, void (*)(const std::string&, const std::string&)> kinds{
      {"sheets", write_sheets}, {"labels", write_labels}, {"channels", write_channels}};
  if (args.size() == 3 && kinds.count(args[0]))
  {
    kinds.at(args[0])(args[1], args[2]);
    return 0;
  }
  if (args.size() > 4 && args[0] == "drive")
  {
    const Camera camera{place_from(args[1]), place_from(args[2]), 900, {1200, 500}};
    write_drive({args.begin() + 4, args.end()}, camera, args[3]);
    return 0;
  }
  std::fprintf(
      stderr,
      "usage: talus-pictures sheets WORLDS FOLDER\n"
      "       talus-pictures labels WORLDS FILE\n"
      "       talus-pictures channels WORLDS FILE\n"
      "       talus-pictures drive EYE TARGET FOLDER MAPS...\n");
  return 2;
}
}  // namespace
}  // namespace talus::pictures

int main(int argc, char** argv)
{
  try
  {
    return talus::pictures::run({argv + 1, argv + argc});
  }
  catch (const std::exception& e)
  {
    std::fprintf(stderr, "talus-pictures: %s\n", e.what());
    return 1;
  }
}
