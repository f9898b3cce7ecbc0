#include "options.h"

#include "../../common/command_line.h"
#include "../../common/run_app.h"
#include "../../common/settings.h"

#include <talus/mrpt/parameters_ini.h>
#include <talus/parameters.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

namespace talus::baselines
{
namespace
{
std::string footer()
{
  std::string text = "Methods:\n";
  const auto add = [&text](std::string name, std::size_t width, const char* description)
  {
    name.resize(width, ' ');
    text += "  " + name + description + "\n";
  };
  for (const MethodInfo& m : method_list()) add(m.name, 12, m.description);
  text += "Fills, compared with talus's on the same cells:\n";
  for (const FillMethod& m : fill_methods()) add(m.name, 15, m.description);
  return text +
         "\nExamples:\n"
         "  talus-compare datasets/worlds/table.yaml --output out\n"
         "      simulates the world, prints tables and budgets; out/tables.md,\n"
         "      comparison.json, maps.png\n"
         "  talus-compare datasets/worlds/*.yaml --output out --methods talus --set "
         "fill_samples=4\n"
         "  talus-compare out/demo.rawlog --world datasets/worlds/demo.yaml --output out\n"
         "  talus-compare street.rawlog --config car.ini --output out\n"
         "      without truth: cost, coverage, and held-out points to measure the fills\n"
         "  talus-compare city.rawlog --truth city_labels.tif --config car.ini --output out\n"
         "      against labels of people: what is taken for ground, and what is blocked\n"
         "  talus-compare 00.rawlog --labels dataset/sequences/00/labels --methods talus --output "
         "out\n"
         "      points against labels of people: precision, recall and F1 of the ground\n"
         "  talus-compare datasets/worlds/*.yaml --methods talus --without 27,30 --output out\n"
         "      what two rules are worth; needs a build with -DTALUS_RULE_SWITCHES=ON\n"
         "\nExit codes: 0 done, 1 an input failed (or, with --check, a budget that is not expected "
         "to),\n"
         "2 wrong usage, 128 + N stopped by signal N.";
}

void add_inputs(CLI::App& app, CommandOptions& o)
{
  const auto text = [&app](const char* name, std::string& value, const char* help, const char* type)
  { return app::add_text(app, name, value, type, help); };
  app.add_option("INPUT", o.inputs, "Worlds (.yaml), which are simulated, or rawlogs")
      ->required()
      ->check(app::not_empty());
  text("--output", o.output, "Folder of the files; made if it does not exist", "DIR")->required();
  text("--world", o.world, "World that the rawlog was made from: truth of every frame", "FILE");
  text(
      "--truth", o.truth,
      "truth.tif of the rawlog, as talus-sim writes it; or labels: bands ground and label", "FILE");
  text(
      "--labels", o.labels,
      "Labels of people for each point of the rawlog, SemanticKITTI's 000000.label ...: scores "
      "those of talus as Patchwork++ does",
      "DIR");
  text("--trajectory", o.log.trajectory, "Poses of the rawlog; default: LOG.tum beside it", "FILE");
  text("--sensor", o.log.sensor, "Only scans with this label", "LABEL");
  app::add_checked(
      app, "--frames", o.log.frames, "At most so many frames of each input", "N",
      CLI::Range(1, 100000));
}

void add_methods(CLI::App& app, CommandOptions& o)
{
  app.add_option("--methods", o.evaluation.methods, "Which to run, see below; default: all")
      ->delimiter(',')
      ->type_name("NAME,...");
  app::add_text(app, "--config", o.config, "FILE", "Parameters, as talus-map takes them");
  app.add_option("-s,--set", o.settings, "One parameter; can be given several times")
      ->type_name("NAME=VALUE")
      ->take_all();
  app.add_option(
         "--without", o.without_rules,
         "Leave rules of talus out, by their numbers in kernels/rules.md")
      ->delimiter(',')
      ->envname(kWithoutRulesVariable)
      ->type_name("RULE,...");
  app.add_option_function<std::string>(
         "--backend", [&o](const std::string& s) { o.evaluation.backend = backend_from_text(s); },
         "Of talus: auto, cpu or cuda; default cpu")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->type_name("NAME");
  app::add_number(
      app, "--evaluate", o.evaluation.evaluated_frames, 1, 10000, "N",
      "How many frames are compared with the truth");
}

constexpr const char* kOfWorlds[] = {"--scanner", "--seed", "--noise", "--pose-noise", "--z-drift"};
/** What is accepted holds for the map as it ships, in the drive of the world. */
constexpr const char* kNotToBeAccepted[] = {
    "--without", "--config", "--set", "--frames", "--evaluate"};

void add_expectations(CLI::App& app, CommandOptions& o)
{
  app.add_flag(
      "--check", o.check,
      "Exit code 1 when a budget fails that is not expected to, or is clearly worse");
  app::add_text(
      app, "--expected", o.expected, "FILE",
      std::string("Failures that are expected; default: ") + kExpectedFailures +
          " beside the worlds or one folder up");
  app::add_text(
      app, "--accept", o.accept, "FILE",
      "Write what fails into this file of expected failures; rows of other worlds stay");
}

void add_drive(CLI::App& app, sim::DriveOptions& d)
{
  app::add_optional(
      app, "--scanner", d.scanner, "Of simulated worlds: scanner instead of the world's")
      ->type_name("NAME");
  app::add_checked(app, "--seed", d.seed, "Seed of the noise", "N", app::whole_of_64_bits());
  app::add_checked(
      app, "--noise", d.noise_m, "Standard deviation of a range [m]", "M", app::between(0, 10));
  app::add_checked(
      app, "--pose-noise", d.pose_noise_m, "Noise of the poses in x, y, z [m]", "M",
      app::between(0, 10));
  app::add_checked(
      app, "--z-drift", d.z_drift, "Climb of the poses, metres a metre driven", "M/M",
      app::between(-1, 1));
}

/** An option that would do nothing with these inputs, and why; empty: there is none. */
std::string idle_option(const CLI::App& app, const CommandOptions& o)
{
  const auto& in = o.inputs;
  const auto world = std::find_if(in.begin(), in.end(), is_world);
  const auto log = std::find_if_not(in.begin(), in.end(), is_world);
  const auto given = [&](const char* name) { return app.count(name) > 0; };
  for (const char* name : kOfWorlds)
    if (log != in.end() && given(name))
      return std::string(name) + " is for simulated worlds, and '" + *log + "' is a log";
  for (const char* name : {"--world", "--truth", "--labels", "--trajectory", "--sensor"})
    if (world != in.end() && given(name))
      return std::string(name) + " is for logs, and '" + *world + "' is a world";
  const auto& methods = o.evaluation.methods;
  if (given("--labels") && in.size() > 1) return "--labels is for one log";
  for (const char* name : {"--without", "--accept", "--expected", "--labels"})
    if (given(name) && std::find(methods.begin(), methods.end(), "talus") == methods.end())
      return std::string(name) + " is for talus, and --methods leaves it out";
  for (const char* name : {"--accept", "--expected"})
    if (log != in.end() && given(name))
      return std::string(name) + " is for simulated worlds, and '" + *log + "' is a log";
  if (given("--accept"))
  {
    for (const char* name : kNotToBeAccepted)
      if (given(name)) return std::string(name) + " makes another map than the one to --accept";
    for (const char* name : kOfWorlds)
      if (given(name)) return std::string(name) + " makes another drive than the one to --accept";
    if (given("--expected")) return "--expected does nothing beside --accept";
  }
  if (given("--world") && given("--truth")) return "--truth does nothing beside --world";
  if (given("--world") && given("--labels")) return "--labels does nothing beside --world";
  return {};
}

/** Why the rules of --without cannot be left out; empty: they can. */
std::string why_rules_stay(const std::vector<int>& rules)
{
  const std::vector<int> known = switchable_rules();
  if (known.empty())
    return "--without: the rules of this build have no switches: use the talus-compare of a build "
           "with -DTALUS_RULE_SWITCHES=ON";
  for (const int rule : rules)
  {
    if (std::binary_search(known.begin(), known.end(), rule)) continue;
    std::string text =
        "--without: no rule " + std::to_string(rule) + " has a switch. These have one:";
    for (const int other : known) text += " " + std::to_string(other);
    return text;
  }
  return {};
}

/** What all options together mean. */
void finish(const CLI::App& app, CommandOptions& o)
{
  o.evaluation.drive.frames = o.log.frames;
  const std::string idle = idle_option(app, o);
  if (!idle.empty())
    throw CLI::ValidationError(idle + ": leave it out, or compare the inputs apart");
  if (o.without_rules.empty()) return;
  if (const std::string why = why_rules_stay(o.without_rules); !why.empty())
    throw CLI::ValidationError(why);
  const std::set<int> rules(o.without_rules.begin(), o.without_rules.end());
  o.without_rules.assign(rules.begin(), rules.end());
  std::string list;
  for (const int rule : rules) list += (list.empty() ? "" : ",") + std::to_string(rule);
  ::setenv(kWithoutRulesVariable, list.c_str(), 1);  // of this process and of its children
}
}  // namespace

bool is_world(const std::string& path)
{
  const std::filesystem::path extension = std::filesystem::path(path).extension();
  return extension == ".yaml" || extension == ".yml";
}

void add_options(CLI::App& app, CommandOptions& options)
{
  app.description(
      "Runs logs and simulated worlds through talus and other maps, and says which is right.");
  add_inputs(app, options);
  add_methods(app, options);
  add_drive(app, options.evaluation.drive);
  add_expectations(app, options);
  app.add_flag("--quiet", options.quiet, "Print errors only");
  app.footer(footer());
  app.final_callback([&app, &options] { finish(app, options); });
}

void load_parameters_into(CommandOptions& o)
{
  const app::Settings settings = app::load_settings(o.config, o.settings);
  for (const std::string& warning : settings.warnings) app::print_error("warning: " + warning);
  o.evaluation.parameters = settings.parameters;
}

}  // namespace talus::baselines
