// Memory that this program uses, and memory that it may still use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace kerf {

/// Returns the memory of this program that is in use, bytes; 0 if the system does not report it.
std::size_t ReadResidentBytes();
/// Returns the heap memory that this program has allocated and not freed, bytes. Unlike resident memory, it does not
/// depend on the system's paging.
std::size_t ReadHeapBytes();
/// Returns how many bytes this program may still allocate: the minimum of the machine's free memory (with swap) and
/// what remains of the limits of the control group, `ulimit -v` and `ulimit -d`. Returns the largest number if the
/// system does not report them.
std::uint64_t ReadAvailableBytes();
/// Makes requests for more than the available memory fail (std::bad_alloc) from now on; otherwise the system would kill
/// this program or another. Call at the start of a program. Returns ReadAvailableBytes().
std::uint64_t LimitMemory();
/// Throws kerf::Error with a sentence if `bytes` exceeds the available memory: "WHAT needs about 12.3 GB of memory and
/// 4.2 GB are free; REMEDY". Call it before lengthy work. `bytes` may be a rough estimate, off by half.
void CheckMemory(double bytes, const std::string& what, const std::string& remedy);

/// Does the same for what remains of this program's limits (`ulimit -v`: address space; `ulimit -d`, which
/// LimitMemory() sets: data), for libraries that crash when an allocation fails.
void CheckLimits(double address_bytes, double data_bytes, const std::string& what, const std::string& remedy);
/// Sets the function that ends the program for ExitOnBadAlloc; it must not allocate memory. Call at the start of a
/// program.
void SetBadAllocHandler(void (*handler)());
/// While an object exists, a failed memory request in any thread calls the function set above, which ends this program,
/// instead of throwing std::bad_alloc. For libraries such as VTK whose objects an exception leaves half constructed, so
/// that their destruction is undefined behaviour. Does nothing if no function was set.
class ExitOnBadAlloc {
 public:
  ExitOnBadAlloc();
  ~ExitOnBadAlloc();
  ExitOnBadAlloc(const ExitOnBadAlloc&) = delete;
  ExitOnBadAlloc& operator=(const ExitOnBadAlloc&) = delete;
};

}  // namespace kerf
