// A snapshot in a log: what is read can be described, exported and written again.
#include <talus/mrpt/CObservationTraversability.h>

#include <sstream>

#include "archive.h"
#include "fuzz.h"

using namespace talus;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  CObservationTraversability snapshot;
  if (!fuzz::is_read([&] { fuzz::read_object(data, size, snapshot); })) return 0;
  const auto cells = static_cast<std::size_t>(snapshot.window.cells);
  for (const auto& layer : snapshot.layers)
    fuzz::require(layer.empty() || layer.size() == cells * cells, "a layer has all its cells");
  std::ostringstream text;
  snapshot.getDescriptionAsText(text);
  fuzz::require(!snapshot.exportTxtDataRow().empty(), "a snapshot has a row of its own");
  CObservationTraversability again;
  const std::string bytes = fuzz::bytes_of_object(snapshot);
  fuzz::read_object(bytes.data(), bytes.size(), again);
  fuzz::require(again.window.cells == snapshot.window.cells, "a snapshot read twice is the same");
  return 0;
}
