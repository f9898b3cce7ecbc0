// Seeds of the binary formats: fuzz_seeds FOLDER writes a folder a target. Made here, not kept in
// the repository, so that they are of the version that reads them.
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/CObservationTraversability.h>

#include "../support/log_files.h"
#include "../support/room_for_maps.h"
#include "../support/scan_formats.h"

namespace
{
using namespace talus::test;
namespace fs = std::filesystem;
using talus::CDualElevationMap;

CDualElevationMap small_map(int frames)
{
  talus::Parameters p;
  p.window_m = 2;
  p.resolution_m = 0.25;
  CDualElevationMap map(p, talus::Backend::Cpu);
  for (int i = 0; i < frames; i++)
  {
    const mrpt::poses::CPose3D pose(0.03 * i, -0.02 * i, 0, 0.1 * i, 0, 0);
    map.insertObservation(talus_test::scan_of_room(pose), pose);
  }
  return map;
}

template <class Object>
void write_object(const fs::path& file, const Object& object)
{
  mrpt::io::CFileOutputStream stream(file.string());
  auto out = mrpt::serialization::archiveFrom(stream);
  out << object;
}

void write_maps(const fs::path& folder)
{
  fs::create_directories(folder / "saved_map");
  fs::create_directories(folder / "snapshot");
  write_object(folder / "saved_map/empty", small_map(0));
  write_object(folder / "saved_map/room", small_map(3));
  const auto map = small_map(2);
  write_object(folder / "snapshot/none", talus::CObservationTraversability());
  write_object(folder / "snapshot/room", talus::CObservationTraversability(map.mapper(), {}));
}

mrpt::obs::CSensoryFrame::Ptr frame(double time_s)
{
  auto all = std::make_shared<mrpt::obs::CSensoryFrame>();
  all->insert(observation_at<mrpt::obs::CObservationOdometry>(time_s, "odometry"));
  all->insert(observation_at<mrpt::obs::CObservationRobotPose>(time_s, "pose"));
  return all;
}

void write_logs(const fs::path& folder)
{
  fs::create_directories(folder);
  auto text = observation_at<mrpt::obs::CObservationComment>(1000);
  text->text = "a log";
  const Objects log{
      text, observation_at<mrpt::obs::CObservationRobotPose>(1000.1),
      std::make_shared<mrpt::obs::CActionCollection>(), frame(1000.2),
      observation_at<mrpt::obs::CObservationOdometry>(1000.3)};
  write_log(folder / "plain", log, Packing::Plain);
  write_log(folder / "gz", log, Packing::Gz);
}

void write_simplemaps(const fs::path& folder)
{
  fs::create_directories(folder);
  mrpt::maps::CSimpleMap map;
  for (int i = 0; i < 2; i++)
  {
    const auto pose = std::make_shared<mrpt::poses::CPose3DPDFGaussian>();
    pose->mean = mrpt::poses::CPose3D(i, 0, 0, 0, 0, 0);
    map.insert(pose, frame(1000 + i));
  }
  map.saveToFile((folder / "gz").string());
  write_object(folder / "plain", map);
}

/** The first byte says of which kind: see import_files.cpp. */
void write_scans(const fs::path& folder)
{
  fs::create_directories(folder);
  Points p;
  for (int i = 0; i < 3; i++)
  {
    for (auto* numbers : {&p.x, &p.y, &p.z, &p.intensity, &p.time})
      numbers->push_back(0.5F * static_cast<float>(i));
    p.ring.push_back(static_cast<std::uint16_t>(i));
  }
  const std::string pcd(1, '\0'), ply(1, '\1'), bin(1, '\2');
  write_bytes(folder / "pcd_ascii", pcd + pcd_ascii(p));
  write_bytes(folder / "pcd_binary", pcd + pcd_binary(p, "1 2 3 1 0 0 0"));
  write_bytes(folder / "pcd_compressed", pcd + pcd_compressed(p));
  const auto no_z = [](std::string bytes)
  { return bytes.replace(bytes.find("COUNT 1 1 1"), 11, "COUNT 1 1 0"); };
  write_bytes(folder / "pcd_ascii_count", pcd + no_z(pcd_ascii(p)));
  write_bytes(folder / "pcd_binary_count", pcd + no_z(pcd_binary(p)));
  write_bytes(folder / "pcd_compressed_count", pcd + no_z(pcd_compressed(p)));
  write_bytes(folder / "ply_ascii", ply + ply_ascii(p));
  write_bytes(folder / "ply_little", ply + ply_little(p));
  write_bytes(folder / "ply_big", ply + ply_big(p));
  write_bytes(folder / "kitti", bin + kitti_bin(p));
  write_bytes(
      folder / "times",
      "\3"
      "1.5\n2011-09-26 13:02:25.951199337\n");
  write_bytes(
      folder / "calib",
      "\4"
      "P0: 1 2\nTr: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n");
  write_bytes(
      folder / "poses",
      "\4"
      "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 -1 0 0 1 0 0 1 0 0 2\n");
}
}  // namespace

int main(int, char** arguments)
{
  const fs::path folder = arguments[1];
  write_maps(folder);
  write_logs(folder / "rawlog");
  write_simplemaps(folder / "simplemap");
  write_scans(folder / "import_files");
}
