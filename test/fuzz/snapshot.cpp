// A snapshot in a log: what is read can be described, exported and written again.
#include <talus/mrpt/CObservationTraversability.h>

#include <sstream>

#include "archive.h"
#include "fuzz.h"

using namespace talus;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  CObservationTraversability snapshot;
  std::ostringstream text;
  const bool whole = fuzz::is_read(
      [&]
      {
        fuzz::read_object(data, size, snapshot);
        for (std::size_t i = 0; i < kLayerCount; i++)  // packed until somebody asks
          snapshot.layer(static_cast<Layer>(i));
      });
  if (!whole) return 0;
  const auto cells = static_cast<std::size_t>(snapshot.window.cells);
  for (std::size_t i = 0; i < kLayerCount; i++)
    if (snapshot.has_layer(static_cast<Layer>(i)))
      fuzz::require(
          snapshot.layer(static_cast<Layer>(i)).size() == cells * cells,
          "a layer has all its cells");
  snapshot.getDescriptionAsText(text);
  fuzz::require(!snapshot.exportTxtDataRow().empty(), "a snapshot has a row of its own");
  fuzz::require(fuzz::keeps_its_bytes(snapshot), "a snapshot read twice is the same");
  return 0;
}
