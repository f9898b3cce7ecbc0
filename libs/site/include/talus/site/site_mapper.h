#pragma once
#include <talus/elevation_mapper.h>
#include <talus/site/site.h>
#include <talus/site/traffic_map.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace talus::site
{
struct Strip;
struct TilePart;
class Hindsight;

/** Keeps in a site what leaves the window of a map, and gives back what comes again. One drive.
 *
 * Floors. Where rays show another floor, as after a lift, the map starts anew: its new ground then
 * chooses the floor that agrees with it, else a new one. On ramps what leaves the window chooses:
 * where more of it contradicts what is kept of the floor than agrees, the robot is on another one;
 * and what comes back is restored only where it goes on the ground beside it. Heights contradict
 * if they are a floor apart; then what was measured before stays. What
 * has drifted away from the ground of now is not restored.
 *
 * Channels. Those of the map become channels of the site, see add_channels(); what is kept of them
 * is given back where the map does not know better.
 *
 * Hindsight. Some scans are kept for a while. When the robot is far away, and with look_back(),
 * what their rays passed through far more often than they hit it is cleared, since it moved; and
 * guesses that they do not prove are left unjudged. */
class SiteMapper
{
 public:
  /** Of the base, map frame. */
  struct Position
  {
    /** [m] */
    double x_m = 0, y_m = 0, z_m = 0;
  };
  /** Why the floor has to be chosen. */
  enum class Choice : std::uint8_t
  {
    None,
    Appeared,  //!< the first frame, or none of the cells of before is in the window
    LeftFloor
  };
  /** What it knows between two frames, beside the site. */
  struct State
  {
    /** On which the robot is, and how many there are. */
    int floor = 0, floors = 1;
    /** Why the floor has to be chosen, if it has to. */
    Choice choice = Choice::None;
    Position base;  //!< in the last frame
    Position calm;  //!< where the base was lately, before it rose or sank
    int frames_calm = 0;  //!< while the floor is to be chosen
    double stamp_s = 0;  //!< of the last frame
    double kept_s = -std::numeric_limits<double>::infinity();  //!< when the whole window was kept
  };

  /** Begins a way in `site`. `restores`: cells that come back are restored; else what was kept
   * stays until the cell leaves again. */
  explicit SiteMapper(Site& site, bool restores = true);
  ~SiteMapper();

  /** map.update(frame), and what leaves with it is kept, what came back restored: its total_ms
   * counts all. `is_mapped` is called once the window stays as it is; hindsight has time. Throws as
   * update() and add_channels(), and std::runtime_error as TileStore. */
  FrameReport update(
      ElevationMapper& map, const Frame& frame, const std::function<void()>& is_mapped = {});
  /** Keeps the cells of the window as they are: at the end of a drive, or between. */
  void keep_window(const ElevationMapper& map);
  /** Corrects all that is kept by what came later: at the end of a drive, after keep_window(). */
  void look_back(const ElevationMapper& map);
  /** Counts where things move, before the first frame. It looks at every cell, which takes longer.
   */
  void note_traffic();
  /** What look_back() leaves behind; null without note_traffic(). */
  const Traffic* traffic() const;
  /** To go on later, with the site that it has now. */
  const State& state() const { return state_; }
  /** With what state() gave. */
  void go_on(const State& state) { state_ = state; }
  /** Where the robot is; on ramps it changes when what the robot came from leaves the window. */
  int floor() const { return state_.floor; }

 private:
  /** Where the ground of a cell should be for it to be of the same floor; NaN: anywhere. */
  struct Reference
  {
    float ground_m, within_m;
  };
  /** Of a strip that comes back. */
  struct Stretch
  {
    std::vector<float> off_m, off_beside_m;  //!< what was kept above the same cells, and others
    bool has_drifted;
  };
  struct Votes
  {
    int agree = 0, contradict = 0;
  };

  FrameReport update_kept(ElevationMapper& map, const Frame& frame);
  void begin(const Position& base);
  void keep_before(const ElevationMapper& map, const Window& after, const Position& base);
  void ask_for_entered(const Window& before, const Window& after);
  void keep_leaving(const ElevationMapper& map, const Window& before);
  void restore_entered(ElevationMapper& map, const Window& before, const Window& after);
  bool was_here(const CellRect& cells) const;
  void wait_for_floor(ElevationMapper& map);
  bool choose_floor(const ElevationMapper& map);
  void keep_all(const ElevationMapper& map);
  void follow(const Position& base);
  void add_to_way();

  void take_channels(const ElevationMapper& map);
  void store_channels(const CellRect& cells, std::size_t first, const TilePart& part);
  void read(const ElevationMapper& map, const CellRect& rect);
  void take_up(const ElevationMapper& map, const CellRecords& records, const Window& window);
  // Of what take_up() has taken up last: `cells` is one of its rectangles, its first record
  // `first`.
  void keep(const CellRect& cells, std::size_t first);
  bool is_at_edge_of_window(const CellRect& cells, std::size_t i) const;
  void store(const CellRect& cells, std::size_t first);
  void refer_to_beside(const Strip& strip, std::size_t first, std::size_t first_beside);
  Votes votes(int floor, const CellRect& cells, std::size_t first);
  std::optional<int> other_floor(const CellRect& cells, std::size_t first, int min_agree);
  int references(const CellRect& cells, std::size_t first) const;
  int new_floor() const;
  int floor_without(const CellRect& cells, std::size_t first);
  void find_drifted(int floor, const CellRect& cells, std::size_t first);
  bool take_back(const CellRect& cells, std::size_t first);
  bool take_back_from(int floor, const CellRect& cells, std::size_t first);
  bool take_back_channels(std::size_t i, const ChannelRecord& kept, bool takes_all);
  void write_back(ElevationMapper& map, std::size_t cells);

  Site& site_;
  bool restores_;
  State state_;
  std::unique_ptr<Hindsight> hindsight_;

  // Kept so that nothing is allocated.
  std::vector<CellRect> rects_;
  FrameCells with_frame_;  //!< what leaves, see keep_before(), and what has come into the window
  Window window_;  //!< in which the records are
  int margin_cells_ = 0;
  CellRecords records_;  //!< in the memory of the map
  const ChannelRecord* channels_ = nullptr;  //!< of the same cells, if the map has channels
  std::vector<std::size_t> channel_places_;  //!< by layer of its channels, that of the site
  std::vector<ChannelRecord> given_back_;  //!< what is restored of channels, by layer of the map
  std::vector<bool> is_kept_;  //!< of the cells that store() got last; empty without channels
  std::vector<Reference> references_;
  std::vector<float> beside_m_;
  std::vector<Stretch> stretches_;
};

}  // namespace talus::site
