#include "cli/signals.h"

#include <csignal>

#include "files/files.h"

namespace kerf::cli {
namespace {

extern "C" void RemoveTemporariesAndEnd(int number) {
  RemoveTemporaries();
  raise(number);  // SA_RESETHAND: ends the program once the handler returns
}

}  // namespace

void HandleSignals() {
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int number : {SIGHUP, SIGINT, SIGTERM}) {
    struct sigaction before {};
    if (sigaction(number, nullptr, &before) != 0 || before.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = RemoveTemporariesAndEnd;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(number, &action, nullptr);
  }
}

}  // namespace kerf::cli
