// What the program does when it is told to end.
#pragma once

namespace kerf::cli {

/// From now on a signal that ends the program (SIGHUP, SIGINT, SIGTERM; those that are ignored stay so) removes what is
/// half written first, and a file that grows beyond the process's limit fails to be written (SIGXFSZ).
void HandleSignals();

}  // namespace kerf::cli
