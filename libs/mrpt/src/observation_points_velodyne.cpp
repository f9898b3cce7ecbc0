#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>

#include "observation_points_detail.h"

// MRPT's own decoder takes 16 of the 32 returns of a block (half of a VLP-16's points) and leaves
// the azimuth corrections out, hence this one. The layout is that of the user manuals: a packet has
// 12 blocks, a block an azimuth (clockwise, hundredths of a degree) and 32 returns.

using Scan = mrpt::obs::CObservationVelodyneScan;
using mrpt::obs::VelodyneCalibration;

namespace talus::detail
{
namespace
{
constexpr double kRadPerAzimuthUnit = M_PI / 18000;
constexpr int kBlocks = Scan::BLOCKS_PER_PACKET, kReturns = Scan::SCANS_PER_BLOCK;
constexpr int kModelHdl32 = 0x21, kModelVlp16 = 0x22, kModelVlp32c = 0x28;

/** The numbers in a packet, little-endian and not aligned. */
class Packet
{
 public:
  explicit Packet(const Scan::TVelodyneRawPacket& raw)
      : bytes_(reinterpret_cast<const std::uint8_t*>(&raw))
  {
  }

  int header(int block) const { return u16(block * Scan::SIZE_BLOCK); }
  int azimuth(int block) const { return u16(block * Scan::SIZE_BLOCK + 2); }
  int range(int block, int k) const { return u16(block * Scan::SIZE_BLOCK + 4 + 3 * k); }
  int intensity(int block, int k) const { return bytes_[block * Scan::SIZE_BLOCK + 6 + 3 * k]; }
  double time_us() const { return u16(1200) + 65536.0 * u16(1202); }
  int return_mode() const { return bytes_[1204]; }
  int model() const { return bytes_[1205]; }

 private:
  int u16(int at) const { return bytes_[at] | bytes_[at + 1] << 8; }

  const std::uint8_t* bytes_;
};

/** What all packets of a scan share. */
struct Decoder
{
  const Scan& scan;
  const VelodyneCalibration& calibration;
  int lasers;
  FiringTimes firing;
  double range_unit_m;
  double azimuth_correction_unit_rad;
  std::vector<float>* intensity;  //!< null: nobody asked for it
};

/** Blocks that share an azimuth form a slot: both banks of an HDL-64, both returns in dual mode. */
struct Slots
{
  int blocks = 1;  //!< a slot
  double duration_us = 0;

  int of(int block) const { return block / blocks; }
};

/** How far the head has turned, and how late it is, when a return of a block is taken. */
struct Delay
{
  double sin = 0, cos = 1;  //!< of the clockwise turn since the block's azimuth, corrected
  double us = 0;  //!< since the block's first firing
};

const VelodyneCalibration& calibration_of(const Scan& scan)
{
  if (!scan.calibration.empty()) return scan.calibration;
  const int model = Packet(scan.scan_packets.front()).model();
  if (model == kModelVlp16) return VelodyneCalibration::LoadDefaultCalibration("VLP16");
  if (model == kModelHdl32) return VelodyneCalibration::LoadDefaultCalibration("HDL32");
  fail(
      scan, "it has no calibration, and there is no default one for model number " +
                std::to_string(model) + ". Record it with the calibration file of the sensor");
}

/** Calibrations from XML hold degrees, those from YAML radians: the elevations, which come with
 * their sine, tell which. */
double correction_unit_rad(const VelodyneCalibration& calibration)
{
  double misfit_deg = 0, misfit_rad = 0;
  for (const auto& laser : calibration.laser_corrections)
  {
    const double v = laser.verticalCorrection;
    misfit_deg += std::abs(std::sin(v * M_PI / 180) - laser.sinVertCorrection);
    misfit_rad += std::abs(std::sin(v) - laser.sinVertCorrection);
  }
  return misfit_rad < misfit_deg ? 1.0 : M_PI / 180;
}

Decoder make_decoder(const Scan& scan, std::vector<float>* intensity)
{
  const auto& calibration = calibration_of(scan);
  const auto lasers = calibration.laser_corrections.size();
  const bool is_vlp32c = Packet(scan.scan_packets.front()).model() == kModelVlp32c;
  if (lasers != 16 && lasers != 32 && lasers != 64)
    fail(
        scan, "its calibration has " + std::to_string(lasers) +
                  " lasers; 16, 32 and 64 are known. Record it with the file of the sensor");
  const auto firing = lasers == 16   ? kFiringVlp16
                      : lasers == 64 ? kFiringHdl64
                      : is_vlp32c    ? kFiringVlp32c
                                     : kFiringHdl32;
  const double range_unit_m = lasers == 32 && is_vlp32c ? 0.004 : 0.002;
  return {scan,     calibration,  static_cast<int>(lasers),
          firing,   range_unit_m, correction_unit_rad(calibration),
          intensity};
}

/** An HDL-64 has no return mode in its packets, but their azimuths show dual returns. */
bool is_dual(const Packet& packet, int lasers)
{
  if (lasers == 64) return packet.azimuth(0) == packet.azimuth(2);
  return packet.return_mode() == Scan::RETMODE_DUAL;
}

Slots slots_of(const Packet& packet, const Decoder& decoder)
{
  Slots slots;
  slots.blocks = (decoder.lasers == 64 ? 2 : 1) * (is_dual(packet, decoder.lasers) ? 2 : 1);
  slots.duration_us = decoder.firing.cycle_us * (decoder.lasers == 16 ? 2 : 1);
  return slots;
}

/** Speed of the head in a packet [rad/us], clockwise. The median of the steps from azimuth to
 * azimuth: a single one is only good to 0.01 degrees. */
double turn_rate(const Packet& packet, const Slots& slots)
{
  std::array<int, kBlocks> steps{};
  std::size_t n = 0;
  for (int b = slots.blocks; b < kBlocks; b += slots.blocks)
    steps[n++] = (36000 + packet.azimuth(b) - packet.azimuth(b - slots.blocks) % 36000) % 36000;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(steps.begin(), middle, steps.begin() + static_cast<std::ptrdiff_t>(n));
  return *middle * kRadPerAzimuthUnit / slots.duration_us;
}

/** One a return of both banks: index 32 and up is the lower bank of an HDL-64. */
std::array<Delay, 64> delays_of(const Decoder& decoder, double turn_rate_rad_us)
{
  std::array<Delay, 64> delays;
  const int returns = decoder.lasers == 64 ? 64 : 32;
  for (int i = 0; i < returns; ++i)
  {
    const int laser = i % decoder.lasers, cycle = i / decoder.lasers;  // a VLP-16 fires twice
    const auto& corrections = decoder.calibration.laser_corrections[laser];
    auto& d = delays[i];
    d.us = cycle * decoder.firing.cycle_us + decoder.firing.of(laser);
    const double turn = turn_rate_rad_us * d.us -
                        corrections.azimuthCorrection * decoder.azimuth_correction_unit_rad;
    d.sin = std::sin(turn);
    d.cos = std::cos(turn);
  }
  return delays;
}

/** Time of a packet after the first one [us]. The clock of the sensor starts anew every hour; where
 * it stands still, the packets follow each other without a pause. */
double packet_time_us(const Scan& scan, std::size_t index, const Slots& slots)
{
  const auto& packets = scan.scan_packets;
  const double first = Packet(packets.front()).time_us(), now = Packet(packets[index]).time_us();
  if (Packet(packets.back()).time_us() == first)
    return static_cast<double>(index) * slots.duration_us * (kBlocks / slots.blocks);
  constexpr double kHour_us = 3600e6;
  return now >= first ? now - first : now - first + kHour_us;
}

/** Number of the first laser of a block, or -1 for a block that is not of this sensor. */
int first_laser(const Packet& packet, int block, int lasers)
{
  if (packet.azimuth(block) >= Scan::ROTATION_MAX_UNITS) return -1;
  if (packet.header(block) == Scan::UPPER_BANK) return 0;
  return lasers == 64 && packet.header(block) == Scan::LOWER_BANK ? 32 : -1;
}

/** True when an earlier block of the same slot holds the same return: in dual mode a ray with one
 * echo reports it twice. */
bool is_repeated(const Packet& packet, int block, int k, const Slots& slots)
{
  for (int other = slots.of(block) * slots.blocks; other < block; ++other)
    if (packet.header(other) == packet.header(block) &&
        packet.range(other, k) == packet.range(block, k))
      return true;
  return false;
}

/** A return into a point: x forward, y left, z up; s, c: of the clockwise azimuth. The beam leaves
 * the sensor beside its axis, by the horizontal and vertical offsets, at right angles to the beam.
 */
void add_return(
    double range_m, double s, double c, const VelodyneCalibration::PerLaserCalib& laser,
    SensorPoints& out)
{
  const double up = laser.verticalOffsetCorrection, side = laser.horizontalOffsetCorrection;
  const double xy = range_m * laser.cosVertCorrection - up * laser.sinVertCorrection;
  const double z = range_m * laser.sinVertCorrection + up * laser.cosVertCorrection;
  add_point(out, xy * c + side * s, -xy * s + side * c, z);
}

/** All returns of a block that begins `block_us` after the scan. False: of another sensor. */
bool read_block(
    const Decoder& decoder, const Packet& packet, int block, const Slots& slots,
    const std::array<Delay, 64>& delays, double block_us, SensorPoints& out)
{
  const int first = first_laser(packet, block, decoder.lasers);
  if (first < 0) return false;
  const double azimuth = packet.azimuth(block) * kRadPerAzimuthUnit;
  const double s = std::sin(azimuth), c = std::cos(azimuth);
  for (int k = 0; k < kReturns; ++k)
  {
    const int units = packet.range(block, k);
    if (units == 0 || is_repeated(packet, block, k, slots)) continue;
    const auto number = static_cast<std::size_t>((first + k) % decoder.lasers);
    const auto& laser = decoder.calibration.laser_corrections[number];
    const double range_m = units * decoder.range_unit_m + laser.distanceCorrection;
    if (range_m < decoder.scan.minRange || range_m > decoder.scan.maxRange) continue;
    const auto& d = delays[first + k];
    add_return(range_m, s * d.cos + c * d.sin, c * d.cos - s * d.sin, laser, out);
    out.time_s.push_back(static_cast<float>((block_us + d.us) * 1e-6));
    if (decoder.intensity)
      decoder.intensity->push_back(static_cast<float>(packet.intensity(block, k)));
  }
  return true;
}

/** All blocks of a packet; returns how many are of this sensor. */
int read_packet(const Decoder& decoder, std::size_t index, SensorPoints& out)
{
  const Packet packet(decoder.scan.scan_packets[index]);
  const auto slots = slots_of(packet, decoder);
  const auto delays = delays_of(decoder, turn_rate(packet, slots));
  const double packet_us = packet_time_us(decoder.scan, index, slots);
  int blocks_read = 0;
  for (int block = 0; block < kBlocks; ++block)
  {
    const double block_us = packet_us + slots.of(block) * slots.duration_us;
    blocks_read += read_block(decoder, packet, block, slots, delays, block_us, out) ? 1 : 0;
  }
  return blocks_read;
}

/** Scans that were stored decoded, without their packets. */
void read_decoded(const Scan& scan, SensorPoints& out)
{
  const auto& cloud = scan.point_cloud;
  out.x_m = cloud.x;
  out.y_m = cloud.y;
  out.z_m = cloud.z;
  if (auto* intensity = channel_of(out, kIntensity);
      intensity && cloud.intensity.size() == cloud.x.size())
    intensity->assign(cloud.intensity.begin(), cloud.intensity.end());
  if (cloud.timestamp.size() != cloud.x.size()) return;
  for (const auto& time : cloud.timestamp)
    out.time_s.push_back(
        static_cast<float>(std::chrono::duration<double>(time - scan.timestamp).count()));
}

}  // namespace

void read_points(const Scan& obs, SensorPoints& out)
{
  if (obs.scan_packets.empty()) return read_decoded(obs, out);
  const auto decoder = make_decoder(obs, channel_of(out, kIntensity));
  int blocks_read = 0;
  for (std::size_t i = 0; i < obs.scan_packets.size(); ++i)
    blocks_read += read_packet(decoder, i, out);
  if (blocks_read == 0)
    fail(
        obs, "none of its " + std::to_string(obs.scan_packets.size()) +
                 " packets has a block of a Velodyne. The log is damaged, or of another sensor");
}

}  // namespace talus::detail
