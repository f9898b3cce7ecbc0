#include <talus/input_file.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "world_parts.h"

namespace talus::sim
{
namespace
{
void check_path(const Fields& f, const Mover& mover, const World& world)
{
  const auto fail = [&](const char* into, const Collision& c, const char* remedy)
  {
    std::ostringstream what;
    what << std::fixed << std::setprecision(1) << "leads into " << into << ": at (" << c.x_m << ", "
         << c.y_m << ") after " << c.time_s << " s; " << remedy;
    f.fail("path", what.str());
  };
  if (const auto thing = first_collision(mover, world))
    fail("an object", *thing, "lead it around, or move the object");
  if (const auto robot = first_meeting(mover, world))
    fail("the robot", *robot, "lead it around, or let it come earlier or later");
}

Mover parse_mover(const Fields& f, bool person)
{
  Mover m;
  for (const auto& row : f.rows("path", 3))
  {
    if (!m.path.empty() && row[0] <= m.path.back().time_s)
      f.fail("path", "must be a list of [t_s, x_m, y_m] with ascending times");
    m.path.push_back({row[0], row[1], row[2]});
  }
  const double lift = f.number_or("lift_m", 0, kNotNegative);
  // What stands reaches a little into the ground, so that nothing shows under it on rough ground.
  const double bottom = lift > 0 ? lift : -0.05;
  if (person)
  {
    const double height = f.number_or("height_m", 1.75, kPositive);
    m.shapes = {make_cylinder(
        {0, 0, bottom}, {0, 0, lift + height}, f.number_or("radius_m", 0.25, kPositive))};
  }
  else
  {
    const Vec3 size = f.vector("size_m", kPositive);
    m.shapes = {make_box({0, 0, bottom}, {size.x, size.y, size.z + lift - bottom}, 0)};
  }
  m.shapes[0].reflectivity = f.number_or("reflectivity", 0.8, kShare);
  const Presence presence(f);
  m.shapes[0].from_s = presence.from_s;
  m.shapes[0].until_s = presence.until_s;
  return m;
}

}  // namespace

Presence::Presence(const Fields& f)
{
  from_s = f.number_or("from_s", from_s, kAny);
  until_s = f.number_or("until_s", until_s, kAny);
  if (until_s <= from_s) f.fail("until_s", "must be later than from_s");
}

std::vector<Mover> parse_movers(const YAML::Node& list, const std::string& file, const World& world)
{
  require_list(list, file, "movers", "person: {...}");
  std::vector<Mover> movers;
  for (const auto& entry : list)
  {
    const std::string name = only_key(entry, file, "movers", {"person", "box"});
    const bool person = name == "person";
    const std::string size = person ? "height_m radius_m" : "size_m";
    const Fields fields(
        entry[name], file, "movers." + name,
        "path " + size + " lift_m reflectivity" + kPresenceKeys);
    movers.push_back(parse_mover(fields, person));
    check_path(fields, movers.back(), world);
  }
  return movers;
}

namespace
{
/** Notes where a document begins, and where it begins to say something. */
class Beginning : public YAML::EventHandler
{
 public:
  YAML::Mark start, content;
  bool is_empty = true;

  void OnDocumentStart(const YAML::Mark& mark) override
  {
    start = mark;
    is_empty = true;
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { note(mark); }
  void OnScalar(
      const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string&) override
  {
    note(mark);
  }
  void OnSequenceStart(
      const YAML::Mark& mark, const std::string&, YAML::anchor_t,
      YAML::EmitterStyle::value) override
  {
    note(mark);
  }
  void OnMapStart(
      const YAML::Mark& mark, const std::string&, YAML::anchor_t,
      YAML::EmitterStyle::value) override
  {
    note(mark);
  }
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnDocumentEnd() override {}
  void OnSequenceEnd() override {}
  void OnMapEnd() override {}

 private:
  void note(const YAML::Mark& mark)
  {
    if (is_empty) content = mark;
    is_empty = false;
  }
};

/** The document of a text, which may hold no second one that says something. Throws
 * YAML::Exception, and std::runtime_error that names file, line and remedy. */
YAML::Node only_document(const std::string& text, const std::string& file)
{
  std::istringstream in(text);
  YAML::Parser parser(in);
  Beginning document;
  int last_start = -1;
  for (int number = 1; parser.HandleNextDocument(document); ++number)
  {
    // yaml-cpp takes a sign that begins nothing, such as ']', for an endless row of documents.
    if (document.start.pos == last_start)
      throw YAML::ParserException(document.start, "nothing begins so");
    last_start = document.start.pos;
    if (number > 1 && !document.is_empty)
      throw std::runtime_error(
          file + ":" + std::to_string(document.content.line + 1) +
          ": world: a second YAML document begins here; a file holds one world: remove it, or the "
          "'---' or '...' before it");
  }
  return YAML::Load(text);
}

std::string at_line(const std::string& file, const YAML::Exception& e)
{
  return file + ":" + std::to_string(std::max(1, e.mark.line + 1)) + ": ";
}

World world_from(const YAML::Node& root, const std::string& file)
{
  const Fields f(
      root, file, "world",
      "name description seed ground objects movers robot sensor sensors poses");
  World w;
  w.name = f.text_or("name", std::filesystem::path(file).stem().string());
  w.description = f.text_or("description", "");
  w.seed = static_cast<std::uint64_t>(f.whole_or("seed", 1, 0, 2000000000));
  parse_ground(f.node("ground"), file, w);
  w.robot = parse_robot(f.node("robot"), file);
  if (f.has("sensor") && f.has("sensors"))
    f.fail("sensors", "and key 'sensor' exclude each other: list all of them in 'sensors'");
  if (f.has("sensor")) w.sensors = {parse_sensor(f.node("sensor"), file)};
  if (f.has("sensors")) w.sensors = parse_sensors(f.node("sensors"), file);
  if (f.has("poses")) w.poses = parse_poses(f.node("poses"), file);
  if (f.has("objects")) parse_objects(f.node("objects"), file, w);
  if (f.has("movers")) w.movers = parse_movers(f.node("movers"), file, w);
  return w;
}

}  // namespace

World parse_world(const std::string& text, const std::string& file)
{
  try
  {
    return world_from(only_document(text, file), file);
  }
  catch (const YAML::DeepRecursion& e)  // yaml-cpp calls it a "bad file"
  {
    throw std::runtime_error(at_line(file, e) + "lists and maps are nested too deeply");
  }
  catch (const YAML::Exception& e)
  {
    throw std::runtime_error(at_line(file, e) + "not valid YAML: " + e.msg);
  }
}

World load_world(const std::string& path)
{
  constexpr std::uint64_t kMax_bytes = 1 << 20;  // takes a hundred times as much memory once parsed
  return parse_world(read_input_file(path, "world file", kMax_bytes), path);
}

}  // namespace talus::sim
