#include "outputs.h"

#include <mrpt/core/format.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>

using Json = nlohmann::ordered_json;

namespace talus::calibrate
{
namespace
{
constexpr std::array<const char*, kNoiseParameters> kNoiseNames{
    "c_beam_m", "a_beam", "lambda_t", "ground_roughness_m"};

constexpr double kMinCBeam_m = 1e-4;  // the least that the map takes

double shown(const Vector& v, int i)
{
  return v[i] / parameter_infos()[static_cast<std::size_t>(i)].per_unit;
}

std::array<double, kNoiseParameters> values_of(const NoiseModel& m)
{
  return {m.c_beam_m, m.a_beam, m.lambda_t, m.ground_m};
}

Json parameters_json(const Result& r)
{
  Json all;
  for (int i = 0; i < kParameters; ++i)
  {
    const auto& info = parameter_infos()[static_cast<std::size_t>(i)];
    const bool seen = r.observable[static_cast<std::size_t>(i)];
    all[info.name] = {
        {"unit", info.unit},
        {"given", shown(r.given, i)},
        {"estimate", shown(r.estimate, i)},
        {"sigma", seen ? Json(shown(r.sigma, i)) : Json()},
        {"observable", seen}};
  }
  return all;
}

Json noise_json(const NoiseFit& fit)
{
  Json all{{"along", fit.model.along_beam ? "beam" : "height"}};
  const auto values = values_of(fit.model);
  for (std::size_t i = 0; i < kNoiseParameters; ++i)
    all[kNoiseNames[i]] = {
        {"estimate", values[i]},
        {"sigma", fit.constrained[i] ? Json(fit.sigma[i]) : Json()},
        {"told_from_zero", fit.constrained[i]}};
  all["outlier_share"] = fit.outlier_share;
  all["log_likelihood"] = fit.log_likelihood;
  all["points"] = fit.points;
  return all;
}

Json figures_json(const HeldOutFigures& f)
{
  Json bins = Json::array();
  for (const auto& b : f.by_range)
    bins.push_back(
        {{"from_m", b.from_m},
         {"to_m", b.to_m},
         {"points", b.points},
         {"thickness_m", b.thickness_m},
         {"offset_m", b.offset_m}});
  return {
      {"points", f.points}, {"thickness_m", f.thickness_m}, {"p95_m", f.p95_m}, {"by_range", bins}};
}

std::string c_beam_line(const NoiseFit& fit)
{
  return mrpt::format("c_beam_m = %.5g", std::max(fit.model.c_beam_m, kMinCBeam_m)) +
         (fit.constrained[kCBeam] ? mrpt::format("   # +- %.2g m\n", fit.sigma[kCBeam])
                                  : "   # not significant: the minimum that the map takes\n");
}

std::string lambda_line(const NoiseFit& fit)
{
  if (!fit.turns)
    return "# lambda_t: the sensor never tilts in this log, which does not show it: left as it "
           "is\n";
  return mrpt::format("lambda_t = %.4g", fit.model.lambda_t) +
         (fit.constrained[kLambdaT] ? mrpt::format("   # +- %.2g\n", fit.sigma[kLambdaT])
                                    : "   # no growth of errors with the turn was seen\n");
}
}  // namespace

std::string calibration_ini(const AppOptions& options, const LoadedLog& log, const Result& r)
{
  const auto& m = r.noise.model;
  std::string text = "# From " + options.log + ", sensor '" + log.label + "', by talus-calibrate " +
                     TALUS_VERSION + ".\n# Paste into the INI file of the map.\n\n" +
                     "[CDualElevationMap_insertOpts]\n";
  text += mrpt::format(
      "# errors along the %s, 1-sigma behind each value\n", m.along_beam ? "beam" : "vertical");
  text += c_beam_line(r.noise);
  text += r.noise.constrained[kABeam]
              ? mrpt::format("a_beam = %.5g   # +- %.2g\n", m.a_beam, r.noise.sigma[kABeam])
              : std::string("a_beam = 0   # no growth with range was seen\n");
  text += lambda_line(r.noise);
  text += mrpt::format(
      "\n# Time offset: %.4f s, %s. Added to the stamps of the log it gives the trajectory's "
      "time.\n",
      r.estimate[kTimeOffset],
      r.observable[kTimeOffset] ? mrpt::format("+- %.2g s", r.sigma[kTimeOffset]).c_str()
                                : "not observable in this log, kept as given");
  return text;
}

std::string mounting_text(const Result& r)
{
  app::Mounting m{};
  for (const int i : {kX, kY, kZ, kYaw, kPitch, kRoll})
    m[static_cast<std::size_t>(i - kX)] = shown(r.estimate, i);
  return app::text_of_mounting(m);
}

std::string sensors_pose_ini(const LoadedLog& log, const Result& r)
{
  std::string text = "# rawlog-edit --sensors-pose THIS -i LOG.rawlog -o FIXED.rawlog\n";
  if (r.is_doubtful) text += "# NOT RECOMMENDED: see the warnings in calibration.json\n";
  text += "# metres and degrees\n[" + log.label + "]\nsensorLabel = " + log.label + "\n";
  for (const auto& [key, i] :
       {std::pair{"pose_x", kX},
        {"pose_y", kY},
        {"pose_z", kZ},
        {"pose_yaw", kYaw},
        {"pose_pitch", kPitch},
        {"pose_roll", kRoll}})
    text += mrpt::format("%s = %.6f", key, shown(r.estimate, i)) +
            (r.observable[i] ? mrpt::format("   // +- %.2g\n", shown(r.sigma, i))
                             : std::string("   // not observable, as given\n"));
  return text;
}

std::string calibration_json(const AppOptions& options, const LoadedLog& log, const Result& r)
{
  const Json all{
      {"version", TALUS_VERSION},
      {"log", options.log},
      {"sensor", log.label},
      {"poses", log.pose_source},
      {"frames", log.scans.frames()},
      {"points_read", log.scans.points_in()},
      {"points_kept", log.scans.points()},
      {"base_height_m", options.base_height_m},
      {"contact",
       {{"used", options.fit.use_contact},
        {"patches", r.contact.patches},
        {"height_scatter_m", r.contact.height_m},
        {"slope_scatter", r.contact.slope}}},
      {"mount", mounting_text(r)},
      {"recommended", !r.is_doubtful},
      {"parameters", parameters_json(r)},
      {"noise", noise_json(r.noise)},
      {"held_out",
       {{"before", figures_json(r.held_out.before)}, {"after", figures_json(r.held_out.after)}}},
      {"rounds", r.rounds},
      {"patches", r.patches},
      {"residuals", r.samples},
      {"warnings", r.warnings}};
  return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace talus::calibrate
