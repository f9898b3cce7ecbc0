#pragma once
#include <talus/baselines/method.h>

#include <array>
#include <cstddef>
#include <vector>

namespace talus::baselines
{
/** Errors of heights beside the standard deviations that a map estimates for them. */
struct EstimateErrors
{
  std::vector<float> abs_m, estimated_m;  //!< the error and the estimated deviation, one a height

  /** Leaves out a height without a variance. */
  void add(float error_m, float variance_m2);
  void add(const EstimateErrors& other);
  std::size_t count() const { return abs_m.size(); }
  /** Share of the heights whose error is at most `deviations` estimated ones; NaN when empty. */
  double within(double deviations) const;
  /** Share of the heights within the deviations that hold `probability` of a normal distribution;
   * NaN when empty. True bars give `probability`, in (0, 1), back. */
  double share_within(double probability) const;
  double median_estimated_m() const;  //!< NaN when empty
  double true_m() const;  //!< what 68 % of the errors do not exceed; NaN when empty
};

/** Where heights come from: the states of a cell but the unknown one. */
constexpr int kHeightKinds = 4;
/** Names in files, in the order of CellState from Measured on. */
constexpr const char* kHeightKindNames[kHeightKinds] = {
    "measured", "two_sided", "one_sided", "presumed"};

/** The same for each kind of height, near to the robot and far from it. */
class HeightBars
{
 public:
  /** Adds the ground of cell `k` of a map with variances; `error_m` may have a sign. Nothing
   * is known of an unknown cell: it is left out. `reference_m2` is the variance of what the height
   * is compared with [m^2]. Near is within a quarter of the window's side around its middle. */
  void add(const Surfaces& map, std::size_t k, float error_m, float reference_m2 = 0);
  void add(const HeightBars& other);

  const EstimateErrors& near(int kind) const { return of_[kind][0]; }
  const EstimateErrors& far(int kind) const { return of_[kind][1]; }
  EstimateErrors all(int kind) const;
  bool empty() const;

 private:
  std::array<std::array<EstimateErrors, 2>, kHeightKinds> of_;
};

}  // namespace talus::baselines
