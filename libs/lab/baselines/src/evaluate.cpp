#include <malloc.h>
#include <talus/baselines/evaluate.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace talus::baselines
{
namespace
{
constexpr double kTruthMargin_m = 1.0;  //!< around the outermost windows

double heap_mb()
{
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

template <typename F>
double timed_ms(F f)
{
  const auto start = std::chrono::steady_clock::now();
  f();
  const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
  return passed.count();
}

/** A map under test. */
struct Entry
{
  std::unique_ptr<Method> method;
  std::optional<MoverWatch> watch;
  Score score;
};

class Evaluator
{
 public:
  Evaluator(
      const Sequence& sequence, const TruthMap* truth, const sim::World* world,
      const EvaluationOptions& options)
      : sequence_(sequence), truth_(truth), world_(world), options_(options)
  {
    if (truth_) observed_.emplace(*truth_, options_.parameters);
    if (truth_ && world_ && !world_->movers.empty())
      movers_.emplace(*truth_, *world_, options_.parameters);
    if (world_) scene_.emplace(*world_, 0.0, false);
    if (world_) scanner_ = sim::Drive(*world_, options_.drive).scanner();
    for (const std::string& name : options_.methods) add(name);
    choose_frames();
  }

  Evaluation run()
  {
    const int total = static_cast<int>(sequence_.frames.size());
    for (int i = 0; i < total; ++i)
    {
      step(static_cast<std::size_t>(i));
      if (options_.progress) options_.progress("maps", i + 1, total);
    }
    result_.name = sequence_.name;
    result_.sensor = sequence_.sensor;
    result_.frames = total;
    result_.has_truth = truth_ != nullptr;
    for (Entry& e : entries_) result_.maps.push_back(std::move(e.score));
    return std::move(result_);
  }

 private:
  void add(const std::string& name)
  {
    const double before_mb = heap_mb();
    Entry e;
    e.method = make_method(name, options_.parameters, options_.backend);
    e.score.memory_mb = heap_mb() - before_mb;
    e.score.method = name;
    if (movers_) e.watch.emplace(*truth_);
    entries_.push_back(std::move(e));
  }

  void choose_frames()
  {
    const std::size_t n = sequence_.frames.size();
    if (n == 0) throw std::runtime_error("'" + sequence_.name + "': no frames to evaluate");
    evaluated_.assign(n, false);
    const double first = options_.evaluate_from * static_cast<double>(n - 1);
    const int count = std::max(options_.evaluated_frames, 1);
    for (int k = 0; k < count; ++k)
    {
      const double share = count == 1 ? 1.0 : static_cast<double>(k) / (count - 1);
      evaluated_[std::lround(first + share * (static_cast<double>(n - 1) - first))] = true;
    }
    picture_frame_ = static_cast<std::size_t>(options_.picture_at * static_cast<double>(n - 1));
    while (!evaluated_[picture_frame_]) ++picture_frame_;
  }

  void step(std::size_t i)
  {
    const ScanFrame& frame = sequence_.frames[i];
    if (observed_) observed_->add(frame);
    if (movers_) movers_->advance(frame);
    for (Entry& e : entries_)
    {
      const double before_mb = heap_mb();
      e.score.update_ms.push_back(timed_ms([&] { e.method->update(frame.view()); }));
      e.score.memory_mb += heap_mb() - before_mb;
    }
    std::optional<WindowTruth> here;
    if (evaluated_[i] && truth_)
      here = window_truth(
          *truth_, *observed_, movers_ ? &*movers_ : nullptr, sequence_.frames, i,
          options_.parameters, scene_ ? &*scene_ : nullptr, scanner_ ? &*scanner_ : nullptr);
    if (i == picture_frame_) start_snapshot(frame, here);
    for (Entry& e : entries_) look(e, i, here);
  }

  void look(Entry& e, std::size_t i, const std::optional<WindowTruth>& here)
  {
    const bool watch = movers_ && e.watch->has_work(*movers_, *truth_);
    if (!evaluated_[i] && !watch) return;
    Surfaces map;
    e.score.read_ms.push_back(timed_ms([&] { map = e.method->read(); }));
    if (watch) e.watch->look(*movers_, *truth_, map, e.score);
    if (!evaluated_[i]) return;
    if (here)
    {
      map.risk = e.method->risk();
      score_frame(map, *truth_, *here, *observed_, e.score);
    }
    else
      for (const std::uint8_t s : map.state) e.score.cover(static_cast<CellState>(s));
    if (e.score.method == "talus") compare_fills(map, here);
    if (i == picture_frame_) result_.snapshot.maps.emplace_back(e.score.method, map);
    if (!truth_ && i + 1 == sequence_.frames.size()) result_.last.push_back(std::move(map));
  }

  void compare_fills(const Surfaces& map, const std::optional<WindowTruth>& here)
  {
    const SparseGround sparse = measured_ground(map);
    Fills fills{{"talus", map.ground_m}};
    std::vector<double> ms{0};
    for (const FillMethod& m : fill_methods())
    {
      std::vector<float> filled;
      ms.push_back(timed_ms([&] { filled = m.fill(sparse); }));
      fills.emplace_back(m.name, std::move(filled));
    }
    result_.fills.resize(fills.size());
    for (std::size_t f = 0; f < fills.size(); ++f)
    {
      result_.fills[f].fill = fills[f].first;
      if (f > 0) result_.fills[f].ms.push_back(ms[f]);
      for (std::size_t k = 0; k < map.size(); ++k)
        if (std::isnan(sparse.ground_m[k]))
          result_.fills[f].coverage.add(!std::isnan(fills[f].second[k]));
    }
    if (here) score_fills(map, *here, fills);
  }

  void score_fills(const Surfaces& map, const WindowTruth& here, const Fills& fills)
  {
    for (std::size_t k = 0; k < map.size(); ++k)
    {
      const auto state = static_cast<CellState>(map.state[k]);
      const bool two_sided = state == CellState::FilledTwoSided;
      if (!two_sided && state != CellState::FilledOneSided) continue;
      if (here.at[k] < 0 || here.touched[k]) continue;
      const auto at = static_cast<std::size_t>(here.at[k]);
      bool all_known = truth_->surely_free(at);
      for (const auto& fill : fills) all_known &= !std::isnan(fill.second[k]);
      if (!all_known) continue;
      for (std::size_t f = 0; f < fills.size(); ++f)
      {
        FillScore& score = result_.fills[f];
        const float error = truth_->height_error_m(at, fills[f].second[k]);
        score.all.add(error);
        (two_sided ? score.two_sided : score.one_sided).add(error);
        if (here.could_see[k]) score.seen.add(error);
      }
    }
  }

  void start_snapshot(const ScanFrame& frame, const std::optional<WindowTruth>& here)
  {
    Snapshot& s = result_.snapshot;
    s.window =
        window_around(options_.parameters, pose_of_base(frame.T_map_sensor, frame.T_base_sensor));
    s.T_map_sensor = frame.T_map_sensor;
    if (!here) return;
    for (std::size_t k = 0; k < here->at.size(); ++k)
      s.true_label.push_back(here->blocked_now[k] ? 0.0f : here->free_now[k] ? 1.0f : NAN);
  }

  const Sequence& sequence_;
  const TruthMap* truth_;
  const sim::World* world_;
  const EvaluationOptions& options_;
  std::optional<Observed> observed_;
  std::optional<MoverTruth> movers_;
  std::optional<sim::Scene> scene_;
  std::optional<sim::Scanner> scanner_;
  std::vector<Entry> entries_;
  std::vector<bool> evaluated_;
  std::size_t picture_frame_ = 0;
  Evaluation result_;
};

}  // namespace

Evaluation evaluate_sequence(
    const Sequence& sequence, const TruthMap* truth, const sim::World* world,
    const EvaluationOptions& options)
{
  return Evaluator(sequence, truth, world, options).run();
}

TruthMap truth_of(const sim::World& world, const EvaluationOptions& options)
{
  const Parameters& p = options.parameters;
  const sim::Bounds path = sim::Drive(world, options.drive).path().bounds();
  const double margin_m = 0.5 * p.window_m + kTruthMargin_m;
  const sim::TruthWindow area = sim::window_around(path, margin_m, p.resolution_m);
  return TruthMap(sim::truth(world, area, 0.0, TruthMap::truth_options(p, false)), p);
}

Evaluation evaluate_world(const sim::World& world, const EvaluationOptions& options)
{
  const TruthMap truth = truth_of(world, options);
  const sim::Drive drive(world, options.drive);
  const auto progress = [&](int done, int total)
  {
    if (options.progress) options.progress("scans", done, total);
  };
  return evaluate_sequence(simulate(world, drive, progress), &truth, &world, options);
}

}  // namespace talus::baselines
