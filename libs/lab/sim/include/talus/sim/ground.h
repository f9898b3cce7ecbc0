#pragma once
#include <talus/sim/geometry.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace talus::sim
{
/** Bounds of the curved share of a ground part on one of its pieces; all zero where it is flat. */
struct Curvature
{
  double max_slope = 0;  //!< largest |gradient| [m/m]
  double min_m = 0, max_m = 0;  //!< minimum and maximum height
};

/** One term of the ground; the heights of all terms add up. A part is made of pieces: inside a
 * piece its height is linear, or curved within known bounds; between pieces it may have a kink or a
 * vertical face. */
class GroundPart
{
 public:
  virtual ~GroundPart() = default;
  /** Height [m] at (x, y) in the map frame. */
  virtual double height_m(double x_m, double y_m) const = 0;
  /** Appends the ranges at which a ray, seen from above, goes from one piece to another. */
  virtual void breaks(const Ray&, std::vector<double>& /*ranges_m*/) const {}
  /** Whether height_m() is curved anywhere; if not, it is linear on every piece. */
  virtual bool curved() const { return false; }
  /** Bounds on the piece that holds (x, y); for curved parts only. */
  virtual Curvature curvature(double, double) const { return bounds(); }
  /** False where the part has no height of its own (beyond the border of an image). */
  virtual bool defined(double, double) const { return true; }
  /** Minimum and maximum height; infinite when unbounded. */
  virtual Curvature bounds() const = 0;
};

using GroundPartPtr = std::shared_ptr<const GroundPart>;

/** z + slope_x * x + slope_y * y. Slopes in m/m. */
GroundPartPtr make_plane(double z_m, double slope_x, double slope_y);

/** A corner of the profile of a strip: height at a distance u along its axis. */
struct Knot
{
  double u_m = 0, height_m = 0;
};
/** A profile extruded sideways: piecewise linear along the axis `yaw_rad` from (x_m, y_m), constant
 * before the first knot and after the last, two knots at one distance make a vertical face. Beyond
 * half the width to either side the height is 0 (vertical faces). Ramps, steps and ditches are
 * strips. */
GroundPartPtr make_strip(
    double x_m, double y_m, double yaw_rad, double width_m, std::vector<Knot> profile);

/** amplitude * sin(2 pi u / wavelength + phase), u along yaw. */
GroundPartPtr make_sine(double amplitude_m, double wavelength_m, double yaw_rad, double phase_rad);

/** Round hollow (negative height: pit) or mound with the profile of a cosine: height at the centre,
 * 0 from the radius on. */
GroundPartPtr make_mound(double x_m, double y_m, double radius_m, double height_m);

/** Smooth noise within +-amplitude: random heights on a lattice of `wavelength_m`, blended; every
 * further octave has half the wavelength and half the amplitude (all together within the
 * amplitude). */
GroundPartPtr make_roughness(
    double amplitude_m, double wavelength_m, int octaves, std::uint64_t seed);

/** Heights on a lattice, row 0 in the north (greatest y) as in a picture, blended bilinearly. */
struct HeightImage
{
  int width = 0, height = 0;
  std::vector<float> value;  //!< width * height, 0 (black) to 1 (white)
};
/** Black is min_m, white max_m; (x_m, y_m) is the centre of the south-west pixel. Beyond the image
 * the height of its border goes on. */
GroundPartPtr make_image(
    HeightImage image, double x_m, double y_m, double pixel_m, double min_m, double max_m);
/** Reads a PGM file (P2 or P5, 8 or 16 bit). Throws std::invalid_argument with file and reason. */
HeightImage read_pgm(const std::string& path);

/** The ground: one height for each (x, y) of the map frame. */
class Ground
{
 public:
  void add(GroundPartPtr part);

  /** Sum of the parts [m]. */
  double height_m(double x_m, double y_m) const;
  /** Whether every part has a height of its own here. */
  bool defined(double x_m, double y_m) const;

  /** Range [m] to where a ray with unit direction first meets the ground, nothing beyond `max_m`
   * or when it starts below the ground. Exact on linear pieces and vertical faces; on curved pieces
   * found by steps that the slope bound allows (at least 2 mm) and refined to 1e-9 m. */
  std::optional<double> cast(const Ray& ray, double max_m) const;

 private:
  struct Piece;
  double gap_m(const Ray& ray, const Piece& piece, double range_m) const;
  Piece piece(const Ray& ray, double from_m, double to_m) const;
  std::optional<double> cast_piece(const Ray& ray, const Piece& piece) const;
  std::optional<double> march(const Ray& ray, const Piece& piece, double from_m, double to_m) const;

  std::vector<GroundPartPtr> linear_, curved_;
  Curvature bounds_;  //!< of the sum
};

}  // namespace talus::sim
