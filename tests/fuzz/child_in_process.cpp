// Work that kerf does in a child process, done in the fuzzer, so that it sees what its inputs reach.
#include <cstdlib>

#include "base/files/child.h"
#include "kerf/error.h"

namespace kerf {

SharedMemory::SharedMemory(std::size_t bytes) : bytes_(bytes), start_(std::calloc(bytes + 1, 1)) {
  if (start_ == nullptr) throw Error("not enough memory");
}
SharedMemory::~SharedMemory() {
  std::free(start_);
}

std::string RunInChild(const std::string&, const ChildLimits&, const std::function<std::string(ChildReport&)>& work,
                       const std::function<void(double)>&) {
  ChildReport report(-1, nullptr);
  return work(report);
}

}  // namespace kerf
