#include "outputs.h"

#include <mrpt/core/format.h>

namespace talus::calibrate
{
namespace
{
std::string parameter_line(const Result& r, int i)
{
  const auto& info = parameter_infos()[static_cast<std::size_t>(i)];
  const double given = r.given[i] / info.per_unit, estimate = r.estimate[i] / info.per_unit;
  if (!r.observable[static_cast<std::size_t>(i)])
    return mrpt::format(
        "  %-12s %10.4f %-4s not observable in this log: kept\n", info.name, given, info.unit);
  return mrpt::format(
      "  %-12s %10.4f %-4s +- %.4f (given %.4f)\n", info.name, estimate, info.unit,
      r.sigma[i] / info.per_unit, given);
}

std::string noise_line(const char* name, double value, double sigma, bool constrained)
{
  return constrained ? mrpt::format("  %-12s %10.5f      +- %.5f\n", name, value, sigma)
                     : mrpt::format("  %-12s %10.5f      not significant\n", name, value);
}
}  // namespace

std::string console_report(const AppOptions& options, const LoadedLog& log, const Result& r)
{
  std::string text = mrpt::format(
      "%s: %d frames of '%s', %zu patches of ground, %zu residuals, %d rounds\n",
      options.log.c_str(), log.scans.frames(), log.label.c_str(), r.patches, r.samples, r.rounds);
  for (int i = 0; i < kParameters; ++i) text += parameter_line(r, i);
  const auto& fit = r.noise;
  text += mrpt::format("  noise along the %s\n", fit.model.along_beam ? "beam" : "vertical");
  text += noise_line("c_beam_m", fit.model.c_beam_m, fit.sigma[kCBeam], fit.constrained[kCBeam]);
  text += noise_line("a_beam", fit.model.a_beam, fit.sigma[kABeam], fit.constrained[kABeam]);
  text += fit.turns
              ? noise_line(
                    "lambda_t", fit.model.lambda_t, fit.sigma[kLambdaT], fit.constrained[kLambdaT])
              : std::string("  lambda_t     not observable: the sensor never tilts\n");
  const auto &before = r.held_out.before, &after = r.held_out.after;
  text += mrpt::format(
      "  held-out ground thickness %.4f -> %.4f m, p95 %.4f -> %.4f m (%zu points)\n",
      before.thickness_m, after.thickness_m, before.p95_m, after.p95_m, after.points);
  if (r.is_doubtful) return text + "  not recommended: see the warning\n";
  const std::string mount = mounting_text(r);
  return text + "  to paste: talus-calibrate --mount " + mount + ", talus-import --mount '" +
         log.label + "=" + mount + "'\n";
}

}  // namespace talus::calibrate
