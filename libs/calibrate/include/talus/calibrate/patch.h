#pragma once
#include <Eigen/Dense>

#include <cstdint>
#include <optional>
#include <vector>

namespace talus::calibrate
{
/** z = plane[0] + plane[1] (x - center.x) + plane[2] (y - center.y), map frame. */
using Plane = Eigen::Vector3d;

/** Where the robot drove over a patch: the ground must be there, and parallel to its base. */
struct Contact
{
  Eigen::Vector2d at_m;  //!< relative to the centre of the patch
  double height_m = 0;  //!< of the ground below the base
  Eigen::Vector2d slope;  //!< dz/dx, dz/dy of the base's xy-plane
  double time_s = 0;
};

/** A piece of ground that several frames see. */
struct Patch
{
  Eigen::Vector2d center_m;
  double size_m = 0;
  Plane plane;
  std::uint32_t first = 0, count = 0;  //!< of the association's samples
  int frames = 0;
  std::optional<Contact> contact;
};

/** A point on a patch. */
struct Sample
{
  std::uint32_t view = 0, point = 0;
  float range_m = 0, cosine = 0;  //!< of the angle between beam and normal
  float sigma_m = 0;  //!< of the distance from the plane
};

/** Standard deviations of what contact says, from how it scatters over the driven patches. */
struct ContactScatter
{
  double height_m = 0.01, slope = 0.01;
  int patches = 0;
};

struct Association
{
  std::vector<Patch> patches;
  std::vector<Sample> samples;
  ContactScatter scatter;
  bool along_beam = false;  //!< the noise acts along the beams, see NoiseModel
};

}  // namespace talus::calibrate
