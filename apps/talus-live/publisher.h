#pragma once
#include "drive_map.h"
#include "whole_grid.h"

#include <talus/live/network.h>

#include <string>
#include <utility>
#include <vector>

namespace talus::app
{
/** Tells the robot its map, on topics below /talus. */
class Publisher
{
 public:
  /** `layers`: of /talus/grid_map; none: it is not published. */
  Publisher(live::Participant& network, std::vector<std::string> layers);

  /** Of the map after its newest frame, whose poses are in `frame`. The window as it is shown. */
  io::LayerStack publish_window(const DriveMap& map, const std::string& frame);
  /** The same of all else, with that window. */
  void publish_rest(DriveMap& map, const io::LayerStack& window, const std::string& frame);

  /** From now on the map is another one, with this occupancy, made at these poses. */
  void begin_anew(WholeGrid whole, const std::vector<io::Trajectory::Entry>& poses);

  /** The layers that both read with each frame. */
  std::vector<Layer> layers() const;

 private:
  void publish_whole(DriveMap& map, const live::Header& header);
  void note_pose(double stamp_s, const mrpt::poses::CPose3D& T_map_base);
  io::LayerStack window_of(const DriveMap& map) const;

  std::vector<std::string> layers_;
  live::Publication map_, map_updates_, window_, obstacles_, path_, grid_map_;
  WholeGrid whole_{kOccupancy.close_islands_m};
  WholeGrid::Area published_;  //!< of the whole map, as it was published last
  int map_listeners_ = 0;
  double whole_s_ = -1e9;  //!< stamp of the frame with which the whole map was published last
  std::vector<std::pair<double, mrpt::poses::CPose3D>> poses_;
};

}  // namespace talus::app
