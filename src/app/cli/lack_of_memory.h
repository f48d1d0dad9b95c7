// Handling of memory shortage without allocating memory.
#pragma once

namespace kerf::cli {

/// Limits the process's memory to what is free (files/memory.h). After this call, running out of memory where an
/// exception cannot propagate (in a thread, in a destructor, while VTK draws) ends the program in the same way as
/// elsewhere: with a message and exit code 1, after releasing devices and removing temporary files.
void HandleLackOfMemory();

/// Prints a message and ends the program with exit code 1 immediately, because destructors could allocate memory.
/// Does not allocate memory itself.
[[noreturn]] void EndWithoutMemory();

}  // namespace kerf::cli
