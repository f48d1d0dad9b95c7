// Children that a process of Python forks (os.fork, multiprocessing).
#pragma once

namespace kerf::python {

/// Makes children able to end by sys.exit(). Call once, when the module is loaded.
void PrepareForks();

}  // namespace kerf::python
