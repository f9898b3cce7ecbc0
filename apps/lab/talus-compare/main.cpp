#include <talus/io/atomic_file.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <utility>

#include "../../common/child_process.h"
#include "../../common/crash_context.h"
#include "../../common/log_name.h"
#include "../../common/output_folder.h"
#include "../../common/progress_bar.h"
#include "../../common/run_app.h"
#include "report.h"
#include "options.h"

namespace fs = std::filesystem;

namespace
{
using namespace talus::baselines;

constexpr const char* kSeal = "comparison.json";

/** The texts among the results, and the picture. */
constexpr std::pair<const char*, std::string (*)(const Comparison&)> kTexts[]{
    {"tables.md", tables_markdown}, {kSeal, comparison_json}};
constexpr const char* kPicture = "maps.png";

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
      // Its messages are printed when the log is read in earnest.
      if (std::freopen("/dev/null", "w", stderr)) read_log(path, o.log);
    }
    catch (const std::exception&)
    {
    }
    return 0;
  };
  if (const int signal = talus::app::run_in_child(trial).signal)
    throw std::runtime_error(talus::app::crash_text(path, signal));
}

/** What people say of each point of each scan: by the point, else by its cell; nothing where talus
 * is not compared. */
std::vector<std::vector<GroundTruth>> truth_of_points(
    const Sequence& sequence, const CommandOptions& o, const LabelMap& cells)
{
  const auto& methods = o.evaluation.methods;
  if (std::find(methods.begin(), methods.end(), "talus") == methods.end()) return {};
  if (!o.labels.empty()) return read_label_folder(o.labels, sequence);
  std::vector<std::vector<GroundTruth>> truth;
  if (o.truth.empty()) return truth;
  for (const ScanFrame& scan : sequence.frames) truth.push_back(ground_truth_of(scan, cells));
  return truth;
}

void compare_log(const std::string& path, const CommandOptions& o, Comparison& out)
{
  require_no_crash(path, o);
  const Sequence sequence = read_log(path, o.log);
  const EvaluationOptions& e = o.evaluation;
  if (!o.world.empty())
  {
    const auto world = world_of(o.world);
    const TruthMap truth = truth_of(world, e);
    out.evaluations.push_back(evaluate_sequence(sequence, &truth, &world, e));
    return;
  }
  LabelMap labels;
  if (!o.truth.empty())
  {
    labels.stack = read_truth_file(o.truth);
    if (!LabelMap::is_one(labels.stack))
    {
      const TruthMap truth = truth_from(labels.stack, o.truth, e.parameters);
      out.evaluations.push_back(evaluate_sequence(sequence, &truth, nullptr, e));
      return;
    }
  }
  const auto truth = truth_of_points(sequence, o, labels);
  out.evaluations.push_back(evaluate_sequence(sequence, nullptr, nullptr, e));
  const LabelMap* const by_people = o.truth.empty() ? nullptr : &labels;
  out.holdouts.push_back(hold_out(sequence, e, by_people));
  out.real_logs.push_back(
      {sequence.name, score_real_log(sequence, out.evaluations.back(), by_people, e.parameters)});
  if (!truth.empty())
    out.labelled.push_back({sequence.name, score_labels(sequence, truth, e.parameters, e.backend)});
}

/** Shows how far the comparison of one input is: a bar for each of its steps on a terminal, else
 * one line when it begins. */
class Progress
{
 public:
  Progress(std::string name, const CommandOptions& o) : name_(std::move(name)), wanted_(!o.quiet)
  {
    if (!wanted_ || ::isatty(STDERR_FILENO)) return;
    const std::size_t count = o.evaluation.methods.size();
    talus::app::print_error(
        name_ + ": " + std::to_string(count) + (count == 1 ? " method" : " methods"));
  }
  void show(const char* step, int done, int total)
  {
    if (step_ != step)
    {
      bar_.reset();
      bar_.emplace(name_ + ", " + step, wanted_);
      step_ = step;
    }
    bar_->show(
        static_cast<double>(done) / total,
        "frame " + std::to_string(done) + " of " + std::to_string(total));
  }

 private:
  std::string name_, step_;
  bool wanted_;
  std::optional<talus::app::ProgressBar> bar_;
};

/** Compares one input; says what went wrong and returns false. */
bool compare_input(const std::string& path, const CommandOptions& o, Comparison& out)
{
  try
  {
    CommandOptions named = o;
    const std::string name =
        is_world(path) ? talus::app::name_of_world(path) : talus::app::name_of_log(path);
    Progress progress(name, o);
    named.evaluation.progress = [&](const char* step, int done, int total)
    { progress.show(step, done, total); };
    if (is_world(path))
      out.evaluations.push_back(evaluate_world(world_of(path), named.evaluation));
    else
      compare_log(path, named, out);
    return true;
  }
  catch (const std::exception& e)
  {
    talus::app::print_error(talus::app::failure_text(e, path, kLessToCompare));
    return false;
  }
}

void require_outputs_apart(const CommandOptions& o)
{
  std::vector<std::string> outputs;
  for (const auto& text : kTexts) outputs.push_back((fs::path(o.output) / text.first).string());
  outputs.push_back((fs::path(o.output) / kPicture).string());
  std::vector<std::string> inputs = o.inputs;
  for (const std::string& more : {o.world, o.truth, o.log.trajectory, o.config, o.expected})
    inputs.push_back(more);
  if (!o.accept.empty()) outputs.push_back(o.accept);
  talus::app::require_apart("", outputs, inputs);
}

void write_results(const Comparison& c, const talus::app::OutputFolder& folder)
{
  const fs::path to(folder.staging());
  for (const auto& [name, text] : kTexts) talus::io::write_file((to / name).string(), text(c));
  write_maps_picture((to / kPicture).string(), c.evaluations);
}

/** How the child ends. */
enum Ending
{
  kDone = 0,
  kFailed = 1,
  kWrittenButFailed = 2  // an input could not be read, or a budget does not hold
};

/** What is known not to hold in the worlds. */
ExpectedFailures expected_failures(const CommandOptions& o)
{
  const std::string& named = o.accept.empty() ? o.expected : o.accept;
  if (!named.empty())
    return o.accept.empty() || fs::exists(named) ? ExpectedFailures::read(named)
                                                 : ExpectedFailures();
  ExpectedFailures all;
  std::set<fs::path> read;
  for (const std::string& input : o.inputs)
  {
    if (!is_world(input)) continue;
    const fs::path folder = fs::absolute(input).lexically_normal().parent_path();
    for (const fs::path& file :
         {folder / kExpectedFailures, folder.parent_path() / kExpectedFailures})
      if (fs::exists(file) && read.insert(file).second)
        all.add(ExpectedFailures::read(file.string()));
  }
  return all;
}

/** Notes what fails now. */
void accept(const std::string& file, Comparison& c)
{
  for (const Evaluation& e : c.evaluations) c.expected.accept(e.name, check_budgets(e));
  talus::io::write_file(file, c.expected.text());
}

void print(const Comparison& c, const CommandOptions& o)
{
  const std::string words = budget_words(c);
  std::cout << tables_text(c) << budget_text(c) << surprises_text(c)
            << (words.empty() ? "" : words + " ") << "-> " << o.output << "\n";
}

Ending compare(
    const CommandOptions& o, const std::string& command, const talus::app::OutputFolder& folder)
{
  for (const std::string& name : o.evaluation.methods) make_method(name, o.evaluation.parameters);
  Comparison c;
  c.command = command;
  c.expected = expected_failures(o);
  c.without_rules = o.without_rules;
  bool all_read = true;
  for (const std::string& input : o.inputs) all_read &= compare_input(input, o, c);
  if (c.evaluations.empty()) return kFailed;
  if (!o.accept.empty()) accept(o.accept, c);
  write_results(c, folder);
  if (!o.quiet) print(c, o);
  return all_read && !(o.check && unexpected_failures(c) > 0) ? kDone : kWrittenButFailed;
}

/** The exit code. */
int run(CommandOptions& o, const std::string& command)
{
  if (o.quiet) std::clog.setstate(std::ios::failbit);  // names the backend
  load_parameters_into(o);
  require_outputs_apart(o);
  talus::app::OutputFolder folder(o.output);  // made before hours of work
  const int code = talus::app::run_command_in_child(
      o.inputs.front(), kLessToCompare, [&] { return compare(o, command, folder); },
      [&](const std::string& text) { talus::app::print_error(folder.shown(text)); });
  if (code == kFailed || talus::app::stop_signal()) return code;
  folder.commit(kSeal);
  return code == kDone ? 0 : 1;
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
  CommandOptions options;
  return talus::app::run_app(
      "talus-compare", argc, argv, [&](CLI::App& app) { add_options(app, options); },
      [&] { return run(options, command_text(argc, argv)); });
}
