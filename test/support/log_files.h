#pragma once
// Shared by the specifications that read files: scratch folders, logs made on the spot, messages.
#include <gtest/gtest.h>
#include <mrpt/core/Clock.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/system/os.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace talus::test
{
/** An empty folder of one test, removed with everything in it. */
class ScratchDir
{
 public:
  ScratchDir()
  {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(testing::TempDir()) /
            (std::string("talus_") + info->test_suite_name() + "_" + info->name() + "_" +
             std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~ScratchDir() { std::filesystem::remove_all(path_); }
  ScratchDir(const ScratchDir&) = delete;
  ScratchDir& operator=(const ScratchDir&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

using Objects = std::vector<mrpt::serialization::CSerializable::Ptr>;

enum class Packing
{
  Plain,
  Gz
};

inline void write_log(const std::string& path, const Objects& objects, Packing packing)
{
  const auto write_all = [&objects](auto& file)
  {
    auto archive = mrpt::serialization::archiveFrom(file);
    for (const auto& object : objects) archive << *object;
  };
  if (packing == Packing::Gz)
  {
    mrpt::io::CFileGZOutputStream file(path);
    write_all(file);
  }
  else
  {
    mrpt::io::CFileOutputStream file(path);
    write_all(file);
  }
}

inline std::string read_bytes(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_bytes(const std::string& path, const std::string& bytes)
{
  std::ofstream(path, std::ios::binary) << bytes;
}

template <class Observation>
std::shared_ptr<Observation> observation_at(double time_s, const std::string& label = "sensor")
{
  auto obs = std::make_shared<Observation>();
  obs->timestamp = mrpt::Clock::fromDouble(time_s);
  obs->sensorLabel = label;
  return obs;
}

/** Runs `action`, which must throw; its message must hold every one of `words`. */
inline void expect_error(const std::function<void()>& action, const std::vector<std::string>& words)
{
  try
  {
    action();
    ADD_FAILURE() << "nothing was thrown";
  }
  catch (const std::exception& e)
  {
    const std::string message = e.what();
    for (const auto& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' not in: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "more than one line: " << message;
  }
}

/** A log that MRPT's Debian package mrpt-common installs; empty when it is not there. */
inline std::string stock_dataset(const std::string& name)
{
  const auto path = mrpt::system::find_mrpt_shared_dir() + "/datasets/" + name;
  return std::filesystem::exists(path) ? path : std::string();
}

/** A file of the folder with real scans: the environment variable TALUS_TEST_DATA, else the folder
 * that the build names; empty when it is not there. */
inline std::string real_data(const std::string& name)
{
  std::string folder;
#ifdef TALUS_TEST_DATA
  folder = TALUS_TEST_DATA;
#endif
  if (const char* chosen = std::getenv("TALUS_TEST_DATA")) folder = chosen;
  const auto path = folder + "/" + name;
  return !folder.empty() && std::filesystem::exists(path) ? path : std::string();
}

}  // namespace talus::test

#define EXPECT_SAYS(text, part) EXPECT_PRED_FORMAT2(testing::IsSubstring, part, text)
#define EXPECT_SAYS_NOT(text, part) EXPECT_PRED_FORMAT2(testing::IsNotSubstring, part, text)

#define TALUS_SKIP_WITHOUT(path) \
  if ((path).empty()) GTEST_SKIP() << "the recorded file of this test is not installed here"
