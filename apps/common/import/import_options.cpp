#include "import_log.h"

#include "../command_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace talus::import
{
std::string read_mounting(const std::string& text, SourceOptions& options)
{
  const auto sign = text.rfind('=');
  const std::string label = sign == std::string::npos ? "" : text.substr(0, sign);
  app::Mounting v{};
  try
  {
    v = app::mounting_from_text(text.substr(sign + 1));
  }
  catch (const std::invalid_argument& wrong)
  {
    return (label.empty() ? "" : label + ": ") + wrong.what();
  }
  const auto radians = [](double degrees) { return degrees * M_PI / 180; };
  options.mountings[label] =
      mrpt::poses::CPose3D(v[0], v[1], v[2], radians(v[3]), radians(v[4]), radians(v[5]));
  return "";
}

namespace
{
/** An option with two words; `value` is whether it is the second, `first` whether the first was
 * said. */
void add_choice(
    CLI::App& app, const char* name, const std::array<std::string, 2>& words, bool& value,
    const std::string& help, bool* first = nullptr)
{
  app.add_option_function<std::string>(
         name,
         [&value, first, words](const std::string& word)
         {
           value = word == words[1];
           if (first) *first = word == words[0];
         },
         help)
      ->check(CLI::IsMember({words[0], words[1]}).description(""))
      ->type_name(words[0] + "|" + words[1]);
}

/** What is wrong with the names of fields, or "". */
std::string mistake_in_fields(const std::vector<std::string>& fields)
{
  for (const char* axis : {"x", "y", "z"})
    if (std::count(fields.begin(), fields.end(), axis) != 1)
      return std::string("they have no ") + axis + ", or more than one";
  constexpr std::size_t kMax = 64;
  if (fields.size() > kMax) return "more than 64";
  if (std::find(fields.begin(), fields.end(), "") != fields.end()) return "one has no name";
  return "";
}

void add_fields(CLI::App& app, SourceOptions& o)
{
  app.add_option_function<std::vector<std::string>>(
         "--fields",
         [&o](const std::vector<std::string>& fields)
         {
           if (const auto wrong = mistake_in_fields(fields); !wrong.empty())
             throw CLI::ValidationError("--fields", wrong);
           o.fields = fields;
         },
         "The floats of a point in .bin files, such as x,y,z,intensity,ring (else KITTI's four)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAMES");
}

void add_options_of_all(CLI::App& app, SourceOptions& o)
{
  app::add_text(
      app, "--values", o.values, "NAME",
      "The value of each point that the log keeps: rgb, or a field such as label, which .bin "
      "scans have in .label files beside them; semantickitti: these in 16 classes (else the "
      "intensity)");
  app::add_text(
      app, "--poses", o.poses, "FILE",
      "Of the base: TUM text or an MRPT .simplemap; of KITTI's camera: 12 numbers a line");
  add_choice(
      app, "--poses-of", {"base", "sensor"}, o.poses_of_sensor,
      "Whose poses they are: SLAM programs often write those of the (first) sensor");
  add_choice(
      app, "--clouds-in", {"sensor", "map"}, o.clouds_in_map,
      "The frame of the points; those in the map are brought back by the poses. A file alone: a "
      "scan, "
      "or the map of a whole drive",
      &o.is_one_scan);
  app.add_flag(
      "--partial", o.partial,
      "Read what is whole: of a bag that is cut or damaged, of a folder with fewer poses than "
      "scans");
  app.add_option_function<std::vector<std::string>>(
         "--mount",
         [&o](const std::vector<std::string>& all)
         {
           for (const auto& text : all)
             if (const auto wrong = read_mounting(text, o); !wrong.empty())
               throw CLI::ValidationError("--mount", wrong);
         },
         "Where a sensor is on the base [m, degrees]; again for each, then with their labels")
      ->allow_extra_args(false)
      ->type_name(std::string("[LABEL=]") + app::kMountingForm);
  app::add_number(
      app, "--scale", o.scale, 1e-6, 1e6, "METRES",
      "Metres of one unit of the points: 0.001 where these are millimetres");
  app::add_number(
      app, "--rate", o.rate_hz, 0.001, 1e6, "HZ", "Scans a second, where nothing says their times");
}

void add_options_of_bags(CLI::App& app, SourceOptions& o)
{
  app.add_option(
         "--topic", o.topics,
         "Of a bag: only this PointCloud2 topic, or poses of this topic; again for each")
      ->allow_extra_args(false)
      ->check(app::not_empty())
      ->type_name("NAME");
  app.add_option(
         "--base-frame", o.base_frame,
         "Of a bag: the base in TF (else base_link, base_footprint or the child of odometry)")
      ->type_name("NAME");
  app.add_option("--map-frame", o.map_frame, "Of a bag: the map in TF (else map, or odom)")
      ->type_name("NAME");
  auto* recorded = app.add_flag(
      "--recorded-times", o.recorded_times,
      "Of a bag: scans have the time at which they were recorded, not that of the sensor's clock "
      "(which is so by itself where that clock is not that of the poses)");
  app.add_flag("--stamped-times", o.stamped_times, "Of a bag: scans always have their stamps")
      ->excludes(recorded);
}
}  // namespace

void add_import_options(CLI::App& app, ImportOptions& options)
{
  add_options_of_all(app, options.source);
  add_fields(app, options.source);
  add_options_of_bags(app, options.source);
}

}  // namespace talus::import
