#include "session/run/results_folder.h"

#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(results_folder) {
  static const MemoryFolder folder;
  folder.Write("summary.json", bytes);
  // A run removes these files if it does not write them again.
  for (const std::string& name : ReadEarlierResults(folder.path())) {
    if (name.empty() || name.find('/') != std::string::npos || name == "." || name == "..") {
      Finding("a name that leads out of the folder");
    }
  }
}

}  // namespace kerf::fuzz
