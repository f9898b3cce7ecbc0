#pragma once
#include <talus/baselines/fills.h>
#include <talus/baselines/window_truth.h>

#include <functional>

namespace talus::baselines
{
/** What to compare and how. */
struct EvaluationOptions
{
  Parameters parameters;
  std::vector<std::string> methods{"talus",   "paper", "octomap", "heightgrid",
                                   "highest", "cucpp", "cupy"};
  Backend backend = Backend::Cpu;  //!< of talus
  int evaluated_frames = 6;  //!< evenly over the drive, the last one included
  double evaluate_from = 0.3;  //!< share of the drive before the first evaluated frame
  double picture_at = 0.7;  //!< share of the drive at which the pictures are taken
  sim::DriveOptions drive;  //!< of simulated worlds
  /** Called after each frame of each step, such as "maps"; may be empty. */
  std::function<void(const char* step, int done, int total)> progress;
};

/** Everything of one frame that a picture shows. */
struct Snapshot
{
  Window window;
  Pose T_map_sensor;
  std::vector<float> true_label;  //!< with movers; empty without truth
  std::vector<std::pair<std::string, Surfaces>> maps;
};

/** One log or world through every method. */
struct Evaluation
{
  std::string name, sensor;  //!< see Sequence
  int frames = 0;
  bool has_truth = false;
  std::vector<Score> maps;  //!< as EvaluationOptions::methods
  std::vector<FillScore> fills;  //!< talus's first; empty when talus is not among the methods
  Snapshot snapshot;
  std::vector<Surfaces> last;  //!< after the last frame, as `maps`; only without truth
};

/** The truth about all that the windows of a drive cover. */
TruthMap truth_of(const sim::World& world, const EvaluationOptions& options);

/** Drives through a world and scores every method against its truth, at the truth's resolution =
 * that of the map. Throws what the simulator throws. */
Evaluation evaluate_world(const sim::World& world, const EvaluationOptions& options);

/** The same for scans that exist. `truth` may be nullptr: then cost and coverage only; `world` may
 * be nullptr: then movers and what could be seen are unknown, and only what was hit counts as
 * seen. */
Evaluation evaluate_sequence(
    const Sequence& sequence, const TruthMap* truth, const sim::World* world,
    const EvaluationOptions& options);

}  // namespace talus::baselines
