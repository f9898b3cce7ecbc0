#pragma once
// Velodyne scans written byte by byte, so that a specification knows what each return must become;
// observations out of logs, and those that are refused.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <talus/mrpt/observation_points.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "log_files.h"

namespace talus::test
{
constexpr std::uint16_t kUpperBank = 0xeeff, kLowerBank = 0xddff;
constexpr std::uint8_t kStrongest = 0x37, kDual = 0x39;
constexpr std::uint8_t kVlp16 = 0x22, kHdl32 = 0x21;

/** One packet; all ranges are zero (no return) until set. */
class PacketWriter
{
 public:
  explicit PacketWriter(mrpt::obs::CObservationVelodyneScan::TVelodyneRawPacket& packet)
      : bytes_(reinterpret_cast<std::uint8_t*>(&packet))
  {
  }

  /** `azimuth`: clockwise, 0.01 degrees. */
  void set_block(int block, std::uint16_t header, std::uint16_t azimuth)
  {
    put(block * 100, header);
    put(block * 100 + 2, azimuth);
  }
  /** `range`: in units of the sensor, 2 mm. */
  void set_return(int block, int k, std::uint16_t range) { put(block * 100 + 4 + 3 * k, range); }
  void set_intensity(int block, int k, std::uint8_t intensity)
  {
    bytes_[block * 100 + 6 + 3 * k] = intensity;
  }
  void set_tail(std::uint32_t time_us, std::uint8_t mode, std::uint8_t model)
  {
    put(1200, static_cast<std::uint16_t>(time_us & 0xffff));
    put(1202, static_cast<std::uint16_t>(time_us >> 16));
    bytes_[1204] = mode;
    bytes_[1205] = model;
  }

 private:
  void put(int at, std::uint16_t value)
  {
    bytes_[at] = static_cast<std::uint8_t>(value & 0xff);
    bytes_[at + 1] = static_cast<std::uint8_t>(value >> 8);
  }

  std::uint8_t* bytes_;
};

/** A scan of `packets` packets without returns. Each `blocks_per_azimuth` blocks share an azimuth,
 * which grows by `step`; packet i has the time i * packet_us. */
inline mrpt::obs::CObservationVelodyneScan empty_scan(
    int packets, int blocks_per_azimuth, int step, std::uint8_t mode, std::uint8_t model,
    double packet_us, std::uint16_t second_header = kUpperBank)
{
  mrpt::obs::CObservationVelodyneScan scan;
  scan.minRange = 0.5;
  scan.maxRange = 100;
  scan.scan_packets.resize(packets);
  int azimuth = 0;
  for (int p = 0; p < packets; ++p)
  {
    auto& packet = scan.scan_packets[p];
    std::memset(static_cast<void*>(&packet), 0, sizeof packet);
    PacketWriter writer(packet);
    for (int b = 0; b < 12; ++b)
    {
      writer.set_block(
          b, b % 2 ? second_header : kUpperBank, static_cast<std::uint16_t>(azimuth % 36000));
      if ((b + 1) % blocks_per_azimuth == 0) azimuth += step;
    }
    writer.set_tail(static_cast<std::uint32_t>(p * packet_us), mode, model);
  }
  return scan;
}

/** The first of a log. */
template <class Observation>
std::shared_ptr<Observation> first_of(const std::string& path)
{
  mrpt::io::CFileGZInputStream file(path);
  mrpt::serialization::CSerializable::Ptr object;
  mrpt::serialization::archiveFrom(file) >> object;
  return std::dynamic_pointer_cast<Observation>(object);
}

inline void expect_refused(
    const mrpt::obs::CObservation& obs, const std::vector<std::string>& words)
{
  SensorPoints points;
  expect_error([&] { points_from_observation(obs, points); }, words);
}

/** `lasers` lasers, all horizontal and without corrections. */
inline mrpt::obs::VelodyneCalibration flat_calibration(std::size_t lasers)
{
  mrpt::obs::VelodyneCalibration calibration;
  calibration.laser_corrections.resize(lasers);
  return calibration;
}

}  // namespace talus::test
