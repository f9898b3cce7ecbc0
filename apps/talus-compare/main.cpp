#include <talus/io/atomic_file.h>

#include <cstdio>
#include <filesystem>
#include <iostream>

#include "../common/child_process.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "../common/progress_bar.h"
#include "../common/suspect.h"
#include "log_sequence.h"
#include "options.h"
#include "pictures.h"
#include "report.h"

namespace fs = std::filesystem;

namespace
{
using namespace talus::baselines;

bool is_world(const std::string& path)
{
  const fs::path extension = fs::path(path).extension();
  return extension == ".yaml" || extension == ".yml";
}

constexpr const char* kLessToCompare = "Try a shorter log or way, or fewer --methods";

talus::sim::World world_of(const std::string& path)
{
  return talus::app::guarded(
      path, talus::app::kCompareWithSource, [&] { return talus::sim::load_world(path); });
}

/** A damaged log can crash MRPT: reads it in another process first. */
void require_no_crash(const std::string& path, const CommandOptions& o)
{
  const auto trial = [&]
  {
    try
    {
      // What it says is told when the log is read in earnest.
      if (std::freopen("/dev/null", "w", stderr)) read_log(path, o.trajectory, o.sensor);
    }
    catch (const std::exception&)
    {
    }
    return 0;
  };
  if (const int signal = talus::app::run_in_child(trial).signal)
    throw std::runtime_error(talus::app::crash_text(path, signal));
}

void compare_log(const std::string& path, const CommandOptions& o, Comparison& out)
{
  require_no_crash(path, o);
  const Sequence sequence = read_log(path, o.trajectory, o.sensor);
  const EvaluationOptions& e = o.evaluation;
  if (!o.world.empty())
  {
    const auto world = world_of(o.world);
    const TruthMap truth = truth_of(world, e);
    out.evaluations.push_back(evaluate_sequence(sequence, &truth, &world, e));
  }
  else if (!o.truth.empty())
  {
    const TruthMap truth = read_truth(o.truth, e.parameters);
    out.evaluations.push_back(evaluate_sequence(sequence, &truth, nullptr, e));
  }
  else
  {
    out.evaluations.push_back(evaluate_sequence(sequence, nullptr, nullptr, e));
    out.holdouts.push_back(hold_out(sequence, e, o.holdout));
  }
}

/** Compares one input; says what went wrong and returns false. */
bool compare_input(const std::string& path, const CommandOptions& o, Comparison& out)
{
  try
  {
    CommandOptions named = o;
    const std::string name =
        is_world(path) ? talus::app::name_of_world(path) : talus::app::name_of_log(path);
    talus::app::ProgressBar bar(name, !o.quiet);
    named.evaluation.progress = [&](int done, int total)
    { bar.show(static_cast<double>(done) / total, "frame " + std::to_string(done)); };
    if (is_world(path))
      out.evaluations.push_back(evaluate_world(world_of(path), named.evaluation));
    else
      compare_log(path, named, out);
    return true;
  }
  catch (const std::exception& e)
  {
    std::cerr << "talus-compare: " << talus::app::failure_text(e, path, kLessToCompare) << "\n";
    return false;
  }
}

/** Whether everything can be written, before hours of work. */
void check_outputs(const CommandOptions& o)
{
  const talus::app::OutputFolder trial(o.output);
  std::vector<std::string> outputs;
  for (const char* name : {"methods.csv", "fills.csv", "comparison.json", "maps.png", "fills.png"})
    outputs.push_back((fs::path(o.output) / name).string());
  if (!o.markdown.empty()) outputs.push_back(o.markdown);
  std::vector<std::string> inputs = o.inputs;
  for (const std::string& more : {o.world, o.truth, o.trajectory, o.config}) inputs.push_back(more);
  for (const std::string& output : outputs) talus::app::require_apart(output, inputs);
  if (o.markdown.empty()) return;
  accuracy_page(o.markdown, {});  // throws when something else stands there
  const talus::io::AtomicFile trial_page(o.markdown);
}

void write_results(const std::string& folder, const Comparison& c)
{
  const fs::path to(folder);
  const auto write = [&](const char* name, const std::string& text)
  { talus::io::write_file((to / name).string(), text); };
  write("methods.csv", methods_csv(c));
  write("fills.csv", fills_csv(c));
  write("comparison.json", comparison_json(c));
  write_maps_picture((to / "maps.png").string(), c.evaluations);
  write_fills_picture((to / "fills.png").string(), c.evaluations);
}

/** All files appear together. */
void write_files(const CommandOptions& o, const Comparison& c)
{
  talus::app::OutputFolder folder(o.output);
  try
  {
    write_results(folder.staging(), c);
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(folder.told(e.what()));
  }
  folder.commit(
      [&]
      {
        if (!o.markdown.empty()) talus::io::write_file(o.markdown, accuracy_page(o.markdown, c));
      });
}

int run(CommandOptions& o, const std::string& command)
{
  load_parameters_into(o);
  for (const std::string& name : o.evaluation.methods) make_method(name, o.evaluation.parameters);
  check_outputs(o);
  Comparison c;
  c.command = command;
  bool all_read = true;
  for (const std::string& input : o.inputs) all_read &= compare_input(input, o, c);
  if (c.evaluations.empty()) return 1;
  write_files(o, c);
  const int failed = failed_budgets(c);
  if (!o.quiet)
    std::cout << tables_text(c) << budget_text(c) << failed << " budgets do not hold -> "
              << o.output << "\n";
  return all_read && !(o.check && failed > 0) ? 0 : 1;
}

/** The command line as a person would type it. */
std::string command_text(int argc, char** argv)
{
  std::string text = "talus-compare";
  for (int i = 1; i < argc; ++i) text += std::string(" ") + argv[i];
  return text;
}

}  // namespace

int main(int argc, char** argv)
{
  const talus::app::PrintableOutput printable;
  CommandOptions options;
  if (const auto exit_code = parse_options(argc, argv, options)) return *exit_code;
  if (options.quiet) std::clog.setstate(std::ios::failbit);  // tells which backend was taken
  try
  {
    return run(options, command_text(argc, argv));
  }
  catch (const std::exception& e)
  {
    std::cerr << "talus-compare: " << talus::app::failure_text(e, options.output, kLessToCompare)
              << "\n";
    return 1;
  }
}
