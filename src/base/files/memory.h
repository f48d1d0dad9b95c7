// What memory this program has, and what it may still have.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace kerf {

/// Memory of this program that is in use, bytes; 0 where the system does not tell.
std::size_t ReadResidentBytes();
/// What this program has asked of the heap and not given back, bytes: other than of what is resident, the system's
/// pages have no part in it.
std::size_t ReadHeapBytes();
/// What this program may still ask for, bytes: the least of what the machine has free (with its swap), what its control
/// group leaves and what `ulimit -v` and `ulimit -d` leave. The largest number where the system does not tell.
std::uint64_t ReadAvailableBytes();
/// From here on a request for more than there is fails (std::bad_alloc) instead of ending this program or another one
/// by the system's hand. For the start of a program. Returns ReadAvailableBytes().
std::uint64_t LimitMemory();
/// Throws Error with a sentence when `bytes` are more than there are: "WHAT needs about 12.3 GB of memory and 4.2 GB
/// are free; REMEDY". For asking before long work; a prediction may be off by a half.
void CheckMemory(double bytes, const std::string& what, const std::string& remedy);

/// The same for what the limits of this program leave (`ulimit -v`: address space; `ulimit -d`, which LimitMemory()
/// sets: data), for libraries that crash where they get none.
void CheckLimits(double address_bytes, double data_bytes, const std::string& what, const std::string& remedy);
/// What ends the program for EndsWithoutMemory; it needs no memory itself. For the start of a program.
void SetEndWithoutMemory(void (*end)());
/// While one exists, in any thread, a request for memory that fails ends this program by the function that was set,
/// instead of throwing std::bad_alloc. For libraries whose objects an exception leaves half made, as VTK's: taking them
/// down again is a fault of memory. Does nothing where no function was set.
class EndsWithoutMemory {
 public:
  EndsWithoutMemory();
  ~EndsWithoutMemory();
  EndsWithoutMemory(const EndsWithoutMemory&) = delete;
  EndsWithoutMemory& operator=(const EndsWithoutMemory&) = delete;
};

}  // namespace kerf
