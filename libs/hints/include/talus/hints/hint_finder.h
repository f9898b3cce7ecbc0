#pragma once
#include <talus/frame.h>
#include <talus/frame_report.h>
#include <talus/hints/hint.h>
#include <talus/parameters.h>

#include <memory>
#include <string>
#include <vector>

namespace talus::hints
{
struct Figures;
struct NearPlane;

/** How much a finder may look at. */
enum class Effort
{
  Little,  //!< beside a map: less than 2 % of its time
  Much  //!< every frame, for suggestions
};

/** Watches the frames of a map for what a wrong configuration shows of itself. The same frames
 * give the same hints. */
class HintFinder
{
 public:
  /** Of a map with these parameters. */
  explicit HintFinder(const Parameters& parameters, Effort effort = Effort::Little);
  ~HintFinder();
  /** What was moved from can only be assigned to or destroyed. */
  HintFinder(HintFinder&&) noexcept;
  /** As the constructor. */
  HintFinder& operator=(HintFinder&&) noexcept;

  /** A frame that the map has taken, in the order in which it did, with what became of it. `sensor`
   * is the label of its sensor. Its poses must be finite. */
  void add(const Frame& frame, const std::string& sensor, const FrameReport& report);

  /** That were added. */
  std::size_t frames() const;

  /** What is certain by now, causes only: what follows from another hint is not among them.
   * `known_share`: of the cells of the window, those that are measured or filled, in the map as it
   * is now; NaN: not known. */
  std::vector<Hint> find(double known_share) const;

  /** Parameters that suit the log, whatever those of the map are; those of height and size only
   * where it shows any ground. */
  std::vector<Suggestion> suggest() const;

 private:
  struct Scratch;
  void look_at(const Frame& frame, std::size_t sensor);
  void look_at_walls(const Frame& frame, std::size_t sensor, const Pose& T_map_base);
  void watch_body(
      const Frame& frame, std::size_t sensor, const NearPlane& lowest, const Pose& T_map_base);
  std::size_t number_of(const std::string& label);

  Parameters parameters_;
  Effort effort_;
  std::unique_ptr<Figures> figures_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace talus::hints
