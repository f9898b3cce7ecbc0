#include <talus/io/atomic_file.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iostream>

#include "log_sequence.h"
#include "options.h"
#include "pictures.h"
#include "report.h"

namespace fs = std::filesystem;

namespace
{
using namespace talus::baselines;

void make_folder(const std::string& path)
{
  std::error_code error;
  fs::create_directories(path, error);
  if (!fs::is_directory(path))
    throw std::runtime_error(
        "'" + path + "' cannot be made a folder" + (error ? ": " + error.message() : "") +
        "; give another --output");
  if (access(path.c_str(), W_OK) != 0)
    throw std::runtime_error("'" + path + "' is not writable; give another --output");
}

void show_progress(const std::string& what, int done, int total)
{
  const int width = 40, filled = width * done / total;
  std::fprintf(
      stderr, "\r%-20s [%s%s] %d/%d%s", what.c_str(), std::string(filled, '#').c_str(),
      std::string(width - filled, '.').c_str(), done, total, done == total ? "\n" : "");
}

bool is_world(const std::string& path)
{
  const fs::path extension = fs::path(path).extension();
  return extension == ".yaml" || extension == ".yml";
}

void compare_log(const std::string& path, const CommandOptions& o, Comparison& out)
{
  const Sequence sequence = read_log(path, o.trajectory, o.sensor);
  const EvaluationOptions& e = o.evaluation;
  if (!o.world.empty())
  {
    const auto world = talus::sim::load_world(o.world);
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
    if (!o.quiet && isatty(STDERR_FILENO))
      named.evaluation.progress = [&](int done, int total)
      { show_progress(fs::path(path).stem().string(), done, total); };
    if (is_world(path))
      out.evaluations.push_back(evaluate_world(talus::sim::load_world(path), named.evaluation));
    else
      compare_log(path, named, out);
    return true;
  }
  catch (const std::exception& e)
  {
    std::cerr << "talus-compare: " << e.what() << "\n";
    return false;
  }
}

void write_files(const CommandOptions& o, const Comparison& c)
{
  const auto write = [&](const char* name, const std::string& text)
  { talus::io::write_file((fs::path(o.output) / name).string(), text); };
  write("methods.csv", methods_csv(c));
  write("fills.csv", fills_csv(c));
  write("comparison.json", comparison_json(c));
  write_maps_picture((fs::path(o.output) / "maps.png").string(), c.evaluations);
  write_fills_picture((fs::path(o.output) / "fills.png").string(), c.evaluations);
  if (!o.markdown.empty()) write_accuracy_page(o.markdown, c);
}

int run(CommandOptions& o, const std::string& command)
{
  load_parameters_into(o);
  for (const std::string& name : o.evaluation.methods) make_method(name, o.evaluation.parameters);
  make_folder(o.output);
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
  CLI::App app{
      "Runs logs and simulated worlds through talus and other maps, and says which is right.",
      "talus-compare"};
  CommandOptions options;
  add_options(app, options);
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& e)
  {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try
  {
    return run(options, command_text(argc, argv));
  }
  catch (const std::exception& e)
  {
    std::cerr << "talus-compare: " << e.what() << "\n";
    return 1;
  }
}
