// What is said and done when there is no memory left, which itself must need none.
#pragma once

namespace kerf::cli {

/// Limits the memory to what is free (files/memory.h). From here on a program that has run out of it where an exception
/// can't get out (in a thread, in a destructor, while VTK draws) ends as one that has anywhere else: with the sentence
/// and exit code 1, its devices let go and its temporaries removed.
void HandleLackOfMemory();

/// Says so and ends the program with exit code 1, at once: what is left to be taken down may ask for memory. Needs
/// none.
[[noreturn]] void EndWithoutMemory();

}  // namespace kerf::cli
