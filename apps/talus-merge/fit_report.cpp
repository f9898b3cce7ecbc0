#include "fit_report.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

namespace talus::site
{
namespace
{
constexpr double kDoubtful = 0.05;  //!< of an overlap
constexpr double kDegrees = 180 / 3.14159265358979323846;

std::string with_sign(double value, int decimals)
{
  const double unit = std::pow(10, -decimals);
  const double rounded = std::round(value / unit) * unit + 0.0;  // no -0
  return (rounded < 0 ? "" : "+") + fixed_text(rounded, decimals);
}

std::string percent(double share) { return fixed_text(100 * share, 1) + " %"; }

std::string text_of(const MapShift& shift)
{
  return "moved by x " + with_sign(shift.x_m, 3) + " m, y " + with_sign(shift.y_m, 3) + " m, z " +
         with_sign(shift.z_m, 4) + " m, yaw " + with_sign(shift.yaw_rad * kDegrees, 2) + " degrees";
}

std::string both(const MapFit& fit, const std::vector<std::string>& paths)
{
  return paths[fit.first] + " and " + paths[fit.second];
}
}  // namespace

std::string text_of_fit(const MapFit& fit, const std::vector<std::string>& paths)
{
  std::string text = both(fit, paths) + ": overlap " + fixed_text(fit.overlap_m2, 2) + " m2, ";
  if (std::isnan(fit.offset_z_m)) return text + "no ground that both have measured";
  text += "the second lies " + with_sign(fit.offset_z_m, 4) + " m in z (median), " +
          percent(fit.ground_disagrees) + " of the ground disagrees";
  return fit.standing_m2 > 0 ? text + ", " + percent(fit.standing_disagrees) + " of what stands"
                             : text;
}

std::string warning_of_fit(
    const MapFit& fit, const std::vector<std::string>& paths, bool is_aligned)
{
  if (fit.fits()) return "";
  const std::string what = "warning: " + both(fit, paths) + " do not fit: offset in z " +
                           with_sign(fit.offset_z_m, 3) + " m, " + percent(fit.ground_disagrees) +
                           " of the ground and " + percent(fit.standing_disagrees) +
                           " of what stands disagree; ";
  return what + (is_aligned ? "more than an offset lies between them: check the poses of the drives"
                            : "where the poses lie in other frames, --align brings them together");
}

bool is_doubtful(const MapFit& fit)
{
  return std::max(fit.ground_disagrees, fit.standing_disagrees) > kDoubtful;
}

std::string warning_of_alignment(
    const MapFit& fit, const std::vector<std::string>& paths, const align::Alignment& a)
{
  if (!a.overlaps || !a.shift.moves_cells()) return "";
  return "warning: " + both(fit, paths) + " fit better where the second is " + text_of(a.shift) +
         "; --align does that";
}

std::string text_of_alignment(const align::Alignment& a, const std::string& path)
{
  if (!a.overlaps) return path + ": not moved, it shares no measured ground with the others";
  std::string text = path + ": ";
  if (a.shift.moves())
    text += text_of(a.shift);
  else
    text += "not moved";
  if (a.rest_x_m != 0 || a.rest_y_m != 0)
    text += " (the estimate is x " + with_sign(a.shift.x_m + a.rest_x_m, 3) + " m, y " +
            with_sign(a.shift.y_m + a.rest_y_m, 3) +
            " m, but cells move as a whole: to have the rest, too, move the poses of its drive)";
  std::string unobservable;
  for (const std::string& name : a.unobservable)
    unobservable += (unobservable.empty() ? "" : ", ") + name;
  return unobservable.empty() ? text
                              : text + "; left, since nothing there determines it: " + unobservable;
}

}  // namespace talus::site
