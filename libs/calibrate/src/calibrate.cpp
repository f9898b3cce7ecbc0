#include <talus/calibrate/calibrate.h>

#include <talus/calibrate/held_out.h>
#include <talus/calibrate/information.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::calibrate
{
namespace
{
constexpr int kMaxRounds = 6, kMinRounds = 3;
constexpr double kSettled = 0.3;  // a change of so many deviations is none
constexpr double kWorse = 1.005;  // thickness: more is worse, less is chance
constexpr double kSignificant = 3;  // deviations
constexpr double kClearGain = 0.95;  // of the thickness, or of the 95 %, of the held-out ground
constexpr double kMuchThinner = 0.7;  // where the sensor is turned

/** The rounds of association, solution and noise fit. */
class Calibration
{
 public:
  Calibration(const ScanSet& scans, const PoseTrack& track, const Options& options)
      : scans_(scans), track_(track), options_(options), v_(options.given)
  {
    if (options.use_contact) driven_ = driven_places(track, scans.base_height_m());
  }

  Result run();

 private:
  void approach();
  bool refine(int round, bool is_last);
  void associate_now(double least_cell_m, double max_range_m, std::size_t most_samples);
  void keep_the_rest();
  void finish(Result& result);
  void judge(Result& result) const;
  void require_heading(const Vector& estimate) const;

  const ScanSet& scans_;
  const PoseTrack& track_;
  const Options& options_;
  Vector v_;
  std::vector<DrivenPlace> driven_;
  NoiseModel noise_;
  NoiseFit fit_;
  Association association_;
  Information information_;
  Choice chosen_{};
};

void Calibration::associate_now(double least_cell_m, double max_range_m, std::size_t most_samples)
{
  AssociationOptions o;
  o.least_cell_m = least_cell_m;
  o.max_range_m = std::min(max_range_m, scans_.thinning().max_range_m);
  o.most_samples = most_samples;
  association_ = associate(scans_, track_, driven_, v_, noise_, o);
}

/** What the log does not show stays as it was given. */
void Calibration::keep_the_rest()
{
  for (std::size_t i = 0; i < kParameters; ++i)
    if (!chosen_[i])
      v_[static_cast<Eigen::Index>(i)] = options_.given[static_cast<Eigen::Index>(i)];
}

/** From a rough guess to within the reach of the noise model: near ground first, coarse scales. */
void Calibration::approach()
{
  v_ = level_mounting(scans_, options_.given);
  Choice tried{};
  tried[kZ] = tried[kPitch] = tried[kRoll] = true;
  struct Step
  {
    double scale_m, range_m;
    bool clock;
  };
  for (const Step step : {Step{0.1, 8, false}, Step{0.05, 12, true}, Step{0.03, HUGE_VAL, true}})
  {
    noise_ = uniform_noise(step.scale_m);
    associate_now(0.8, step.range_m, options_.most_samples / 3);
    if (step.scale_m == 0.1) require_ground(association_);
    tried[kTimeOffset] = step.clock;
    // As long as the ground is blurred, sigmas are too large to judge roll, pitch and z by; what
    // turns out not to be observable goes back to what was given at the end.
    chosen_ = tried;
    chosen_[kTimeOffset] =
        step.clock &&
        observable(gather_information(scans_, track_, v_, association_), tried)[kTimeOffset];
    v_ = solve(scans_, track_, v_, chosen_, association_);
  }
}

/** One round with everything that is observable. True: nothing changes any more. In the last round
 * what is not observable is as it was given; before, it stays where the approach left it. */
bool Calibration::refine(int round, bool is_last)
{
  if (is_last) keep_the_rest();
  associate_now(round == 0 ? 0.4 : 0.1, HUGE_VAL, options_.most_samples);
  require_ground(association_);
  Choice all;
  all.fill(true);
  const Choice before = chosen_;
  chosen_ =
      observable(gather_information(scans_, track_, v_, association_), is_last ? chosen_ : all);
  if (is_last) keep_the_rest();
  const Vector last = v_;
  v_ = solve(scans_, track_, v_, chosen_, association_);
  information_ = gather_information(scans_, track_, v_, association_);
  fit_ = fit_noise(scans_, track_, v_, association_, options_.noise_kind);
  noise_ = fit_.model;
  if (round + 1 < kMinRounds || chosen_ != before) return false;
  if (observable(information_, all) != chosen_) return false;
  const Matrix covariance = covariance_of(information_, chosen_);
  for (int i = 0; i < kParameters; ++i)
    if (std::abs(v_[i] - last[i]) > kSettled * std::sqrt(covariance(i, i))) return false;
  return true;
}

void Calibration::finish(Result& result)
{
  chosen_ = observable(information_, chosen_);  // where the rounds did not settle
  keep_the_rest();
  result.given = options_.given;
  result.estimate = v_;
  result.observable = chosen_;
  const Vector wider = disagreement_of_halves(scans_, track_, v_, chosen_, association_);
  result.covariance =
      wider.asDiagonal() * covariance_of(information_, chosen_) * wider.asDiagonal();
  result.sigma = result.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  result.noise = fit_;
  result.contact = association_.scatter;
  result.patches = association_.patches.size();
  result.samples = association_.samples.size();
  if (std::abs(v_[kTimeOffset]) > options_.max_time_offset_s)
    throw std::runtime_error(
        "seems to be " + fixed_text(v_[kTimeOffset], 3) +
        " s off against the trajectory, more than the " +
        fixed_text(options_.max_time_offset_s, 3) +
        " s looked for: put the stamps right first (rawlog-edit --remap-timestamps) or raise "
        "--max-offset");
  if (options_.use_contact) require_level_ground(scans_, v_);
  options_.progress(0.95, "held-out frames");
  judge(result);
}

/** Throws std::runtime_error where the held-out frames lie much better on the ground if the sensor
 * is turned by a quarter or half: from a yaw so wrong the fit finds no way. */
void Calibration::require_heading(const Vector& estimate) const
{
  for (const double turn_deg : {180, 90, -90})
  {
    Vector turned = estimate;
    turned[kYaw] += turn_deg * parameter_infos()[kYaw].per_unit;
    const auto [as_fitted, as_turned] = held_out_figures(scans_, track_, estimate, turned);
    if (as_turned.points > 0 && as_turned.thickness_m < kMuchThinner * as_fitted.thickness_m)
      throw std::runtime_error(
          "seems to be of a sensor whose yaw is given " + fixed_text(turn_deg, 0) +
          " degrees wrong: the ground that the held-out frames see is " +
          fixed_text(1000 * as_fitted.thickness_m, 0) + " mm thick as fitted, and " +
          fixed_text(1000 * as_turned.thickness_m, 0) +
          " mm with the sensor turned by that. Give its yaw to about 20 degrees (--mount)");
  }
}

/** What the held-out frames say of the estimate. Where they show no gain, changes within chance are
 * not made. */
void Calibration::judge(Result& result) const
{
  const auto compare = [&]
  { result.held_out = held_out_figures(scans_, track_, options_.given, result.estimate); };
  const auto loss = [&](double factor)
  { return result.held_out.after.thickness_m > factor * result.held_out.before.thickness_m; };
  require_heading(result.estimate);
  compare();
  if (result.held_out.before.points == 0)
  {
    // Nothing that both show; with the estimate alone there may be ground.
    result.held_out.after =
        held_out_figures(scans_, track_, result.estimate, result.estimate).after;
    result.gains_nothing =
        scans_.thinning().hold_out_every > 0 && result.held_out.after.points == 0;
    return;
  }
  if (loss(1))
  {
    for (int i = 0; i < kParameters; ++i)
      if (std::abs(result.estimate[i] - options_.given[i]) < kSignificant * result.sigma[i])
        result.estimate[i] = options_.given[i];
    compare();
  }
  result.gains_nothing = loss(kWorse);
  const auto& [before, after] = result.held_out;
  const bool is_clear = after.thickness_m < kClearGain * before.thickness_m ||
                        after.p95_m < kClearGain * before.p95_m;
  bool is_changed = false;
  for (int i = 0; i < kParameters; ++i)
    is_changed = is_changed || std::abs(result.estimate[i] - options_.given[i]) >
                                   parameter_infos()[static_cast<std::size_t>(i)].useful_sigma;
  result.is_doubtful = is_changed && (!is_clear || after.p95_m > kWorse * before.p95_m);
}

Result Calibration::run()
{
  require_motion(scans_, track_);
  options_.progress(0.05, "first guess");
  approach();
  Result result;
  for (bool done = false; !done && result.rounds < kMaxRounds; ++result.rounds)
  {
    options_.progress(
        0.15 + 0.8 * result.rounds / kMaxRounds, "round " + std::to_string(result.rounds + 1));
    done = refine(result.rounds, false);
  }
  refine(result.rounds++, true);
  finish(result);
  return result;
}
}  // namespace

Result calibrate(const ScanSet& scans, const PoseTrack& track, const Options& options)
{
  return Calibration(scans, track, options).run();
}

}  // namespace talus::calibrate
