#pragma once
// Bags of ROS 2 that make_bags.py writes, and what is in them.
#include <talus/import/scan_source.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "formats.h"
#include "log_files.h"
#include "message_of.h"

namespace talus::test
{
inline bool has_program(const std::string& name)
{
  return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

/** Why no bags can be made here; empty: they can. */
inline const std::string& why_no_bags()
{
  static const std::string why = []() -> std::string
  {
    for (const char* program : {"python3", "zstd", "lz4"})
      if (!has_program(program)) return std::string("there is no ") + program + " that makes bags";
    return "";
  }();
  return why;
}

/** What a test begins with: a folder `dir` with bags of these names. */
#define MAKE_BAGS(names)                                                              \
  if (const auto why = talus::test::why_no_bags(); !why.empty()) GTEST_SKIP() << why; \
  const talus::test::ScratchDir dir;                                                  \
  ASSERT_TRUE(talus::test::make_bags(dir, names))

/** Writes bags of these names, separated by blanks, into a folder. */
inline bool make_bags(const ScratchDir& dir, const std::string& names)
{
  const std::string script = TALUS_SOURCE_DIR "/test/import/make_bags.py";
  return std::system(("python3 -S '" + script + "' '" + (dir / "") + "' " + names).c_str()) == 0;
}

constexpr double kBagStart_s = 1.7e9;

/** All scans of a source. */
inline std::vector<import::ImportedScan> all_of(import::ScanSource& source)
{
  std::vector<import::ImportedScan> scans;
  import::ImportedScan scan;
  while (source.next(scan)) scans.push_back(scan);
  return scans;
}

inline std::vector<import::ImportedScan> scans_of(
    const std::string& path, const std::string& topic, const import::SourceOptions& options = {})
{
  const auto source = import::open_bag_source({path}, options);
  std::vector<import::ImportedScan> scans;
  for (const auto& scan : all_of(*source))
    if (scan.sensor_label == topic) scans.push_back(scan);
  return scans;
}

inline std::string error_of(const std::string& path, const import::SourceOptions& options = {})
{
  const std::string error = message_of([&] { all_of(*import::open_bag_source({path}, options)); });
  return error == "no error" ? "" : error;
}

inline std::string remarks_of(const std::string& path, const import::SourceOptions& options = {})
{
  const auto source = import::open_bag_source({path}, options);
  all_of(*source);
  std::string all;
  for (const auto& remark : source->remarks()) all += remark + "\n";
  return all;
}

inline bool holds(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

}  // namespace talus::test
