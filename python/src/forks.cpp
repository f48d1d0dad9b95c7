#include "forks.h"

#include <dlfcn.h>
#include <link.h>

#include <cstddef>
#include <cstring>
#include <string>

namespace kerf::python {
namespace {

int FindLog4cplus(dl_phdr_info* info, std::size_t, void* path) {
  if (std::strstr(info->dlpi_name, "/liblog4cplus") == nullptr) return 0;
  *static_cast<std::string*>(path) = info->dlpi_name;
  return 1;
}

}  // namespace

/// OpenVDB brings log4cplus, which starts threads for deferred messages; OpenVDB writes none of these. A child has only
/// the thread that forked, and at its exit log4cplus would wait for the others forever. Therefore they are ended now.
/// The library is found at run time, because OpenVDB can be built without it.
void PrepareForks() {
  std::string path;
  if (dl_iterate_phdr(FindLog4cplus, &path) == 0) return;
  void* library = dlopen(path.c_str(), RTLD_LAZY | RTLD_NOLOAD);
  if (library == nullptr) return;
  if (void* shut_down = dlsym(library, "_ZN9log4cplus18shutdownThreadPoolEv")) {
    reinterpret_cast<void (*)()>(shut_down)();
  }
  dlclose(library);
}

}  // namespace kerf::python
