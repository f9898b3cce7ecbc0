#pragma once
#include <talus/io/hidden_folder.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

// How results get from a hidden folder to their place beside it: whatever moment a run is killed
// at, the next one sees from the hidden folder how far it was, and ends it. So the place has the
// results of one run; the seal, the file among them that says that they are complete, vanishes
// first and appears last.
namespace talus::app
{
/** Of the hidden folders that hold results until they are complete. */
constexpr const char* kRunPrefix = ".talus-run.";

/** Of the labels of points: the table of numbers, which is their seal, and the log of clouds. */
constexpr const char* kLabelTable = "labels.yaml";
constexpr const char* kLabelledLog = "labels.rawlog";

/** Whether a name is of those that a run keeps for itself while it works: never put in place. */
bool is_internal(const std::filesystem::path& path);

/** What has been moved, so that it can be moved back. */
class Moves
{
 public:
  void move(const std::filesystem::path& from, const std::filesystem::path& to);
  /** Moves back what can be. */
  void undo() noexcept;

 private:
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> done_;
};

/** Lets a hidden folder know a file of io::AtomicFile that belongs to its results. */
void link_elsewhere(const std::filesystem::path& hidden, const io::HiddenFolder& elsewhere);

/** From now on the results are complete: whoever finds the hidden folder puts them in place.
 * Throws std::runtime_error, also where one of them would replace a folder, a device or a pipe. */
void begin_placing(const std::filesystem::path& hidden, const std::string& seal, Moves& done);

/** Moves everything to its place; goes on where another process was killed. Files of the same name,
 * and snapshots and floors where there are new ones, are set aside. Throws std::runtime_error. */
void place(const std::filesystem::path& hidden, Moves& done);

/** Whether a file of this name belongs to a site map: site.tif, a picture, a way, traffic, another
 * floor or island. */
bool is_site_file(const std::filesystem::path& name);

/** Whether a file of this name is site.tif, or that of another floor or island. */
bool is_site_map(const std::filesystem::path& name);
/** Where what is replaced waits until all is in place. */
std::filesystem::path replaced_in(const std::filesystem::path& hidden);

/** What was done about hidden folders of runs that were killed. */
struct Swept
{
  std::size_t removed = 0;
  std::size_t placed = 0;  //!< of these the results were complete, and are in place now
};

/** Ends what runs that were killed have left in a folder. Needs its FolderLock. Throws
 * std::runtime_error where complete results cannot be placed. */
Swept sweep(const std::filesystem::path& folder);

}  // namespace talus::app
