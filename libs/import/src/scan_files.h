#pragma once
#include <cstdint>
#include <string>

#include "point_fields.h"

namespace talus::import
{
/** No scan has more bytes: a larger file is a map, or no scan at all. */
constexpr std::uint64_t kLargestScan_bytes = std::uint64_t{1} << 30;

// Each reads one file of a scan. Throws std::runtime_error that names the file, the line or byte,
// what is wrong and what to do. Takes no more memory than some times the bytes of the file (a
// compressed one: of what it unpacks to, which kLargestScan_bytes bounds).

/** Floats without a header. `fields`: their names in the order of a point; empty: those of KITTI
 * (x, y, z, reflectance), or of nuScenes (x, y, z, intensity, ring) for its `.pcd.bin`. Refused
 * where the numbers tell that a point has another count of them. */
void read_bin(const std::string& path, const std::vector<std::string>& fields, ScanFile& out);

/** The Point Cloud Library's: ascii, binary and binary_compressed, version 0.6 and 0.7. */
void read_pcd(const std::string& path, ScanFile& out);

/** The vertices of a PLY: ascii, and binary of either byte order. */
void read_ply(const std::string& path, ScanFile& out);

}  // namespace talus::import
