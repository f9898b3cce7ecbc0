// talus-replay: a recorded drive as topics of ROS 2, as if the robot drove now.
#include "../../common/child_process.h"
#include "../../common/command_line.h"
#include "../../common/run_app.h"
#include "events.h"

#include <talus/import/scan_source.h>
#include <talus/import/scan_stream.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <optional>
#include <thread>

namespace app = talus::app;
namespace live = talus::live;
using Clock = std::chrono::steady_clock;

namespace
{
/** What the command line says. */
struct Options
{
  std::string source;
  app::RawlogTopics rawlog;
  double rate = 1;
  int wait_for = 1;  //!< listeners
  bool best_effort = false;  //!< clouds as most sensors send them
  std::optional<int> domain;
  bool quiet = false;
};

constexpr const char* kFooter =
    "SOURCE is a ROS 2 bag (a folder, .db3 or .mcap), all of whose messages are published, or a\n"
    "rawlog: its scans on topics with the labels of their sensors, and its poses on /tf.\n"
    "ROS_DOMAIN_ID and the other variables count as in ROS.\n"
    "\nExamples:\n"
    "  talus-replay --odometry drive.rawlog\n"
    "  talus-replay bag/ --rate 2 --domain 7\n"
    "  talus-replay drive.rawlog --trajectory odometry.tum --slam drive.tum --slam-every 60\n"
    "\nExit codes: 0 done, 1 the source or the network failed, 2 wrong usage.";

void add_options(CLI::App& cli, Options& o)
{
  cli.description("Publishes a recorded drive on the network of ROS 2.");
  cli.footer(kFooter);
  cli.add_option("SOURCE", o.source, "ROS 2 bag or rawlog")->required()->check(app::not_empty());
  cli.add_option(
         "--trajectory", o.rawlog.trajectory, "Poses of a rawlog (else LOG.tum, or its own)")
      ->type_name("FILE");
  auto* odometry =
      cli.add_flag("--odometry", o.rawlog.as_odometry, "Poses of a rawlog on /odom, not on /tf");
  auto* slam =
      cli.add_option(
             "--slam", o.rawlog.slam,
             "Poses of a rawlog are odometry, which a SLAM corrects by this trajectory: "
             "map -> odom jumps, and /slam/path (nav_msgs/Path) tells all poses until then")
          ->excludes(odometry)
          ->check(app::not_empty())
          ->type_name("FILE");
  cli.add_option("--slam-every", o.rawlog.slam_every_s, "How often it does [s]")
      ->needs(slam)
      ->check(app::between(0.01, 1e6))
      ->capture_default_str()
      ->type_name("S");
  cli.add_option(
         "--rate", o.rate, "Times faster than it was recorded; 0: as fast as it can be read")
      ->check(app::between(0.0, 1e6))
      ->capture_default_str()
      ->type_name("N");
  cli.add_option(
         "--wait", o.wait_for,
         "Each topic of clouds, frames or odometry waits for so many listeners, 2 s, the first one "
         "10 s")
      ->check(CLI::Range(0, 100))
      ->capture_default_str()
      ->type_name("N");
  cli.add_flag("--best-effort", o.best_effort, "Clouds as most sensors send them: not repeated");
  cli.add_option("--domain", o.domain, "Of the network (default: ROS_DOMAIN_ID, else 0)")
      ->check(CLI::Range(0, 232))
      ->type_name("N");
  cli.add_flag("--quiet", o.quiet, "Print errors only");
}

/** Publishes events at their times. */
class Replay
{
 public:
  explicit Replay(const Options& options)
      : options_(options),
        network_(options.domain.value_or(live::domain_of_environment()), "talus_replay")
  {
  }
  std::size_t play(app::Events& events);

 private:
  live::Publication& publication_of(const app::Event& event);
  void wait_for_listeners(const live::Publication& publication);
  void wait_until(double time_s);

  const Options& options_;
  live::Participant network_;
  std::map<std::string, std::unique_ptr<live::Publication>> publications_;  //!< by topic
  Clock::time_point begin_;
  std::optional<double> first_s_;
};

live::Publication& Replay::publication_of(const app::Event& event)
{
  constexpr int kDepth = 100;
  auto& publication = publications_[event.topic];
  if (publication) return *publication;
  const bool is_cloud = talus::import::ScanStream::is_cloud(event.type);
  const live::Quality quality{!is_cloud || !options_.best_effort, event.is_kept, kDepth};
  publication = std::make_unique<live::Publication>(network_, event.topic, event.type, quality);
  network_.announce();
  if (talus::import::ScanStream::reads(event.topic, event.type)) wait_for_listeners(*publication);
  return *publication;
}

/** The clock of the recording stands still meanwhile. Not all topics need have a listener. */
void Replay::wait_for_listeners(const live::Publication& publication)
{
  constexpr auto kStep = std::chrono::milliseconds(5);
  const auto max_wait = std::chrono::seconds(publications_.size() == 1 ? 10 : 2);
  for (const auto end = Clock::now() + max_wait;
       Clock::now() < end && publication.subscribers() < options_.wait_for && !app::stop_signal();)
    std::this_thread::sleep_for(kStep);
}

void Replay::wait_until(double time_s)
{
  if (options_.rate == 0) return;
  if (!first_s_)
  {
    first_s_ = time_s;
    begin_ = Clock::now();
  }
  const std::chrono::duration<double> since((time_s - *first_s_) / options_.rate);
  std::this_thread::sleep_until(begin_ + std::chrono::duration_cast<Clock::duration>(since));
}

std::size_t Replay::play(app::Events& events)
{
  constexpr double kFlush_s = 2;
  app::Event event;
  std::size_t count = 0;
  while (!app::stop_signal() && events.next(event))
  {
    const auto before = Clock::now();
    auto& publication = publication_of(event);
    if (first_s_) begin_ += Clock::now() - before;
    wait_until(event.time_s);
    publication.write(std::move(event.message));
    ++count;
  }
  for (const auto& [topic, publication] : publications_) publication->flush(kFlush_s);
  return count;
}

int run(const Options& options)
{
  const bool is_bag = talus::import::Input(options.source).is_bag();
  const auto events = is_bag ? app::events_of_bag(options.source)
                             : app::events_of_rawlog(options.source, options.rawlog);
  Replay replay(options);
  const auto count = replay.play(*events);
  if (!options.quiet) std::cout << "published " << count << " messages\n";
  return 0;
}
}  // namespace

int main(int argc, char** argv) { return app::run_app("talus-replay", argc, argv, run); }
