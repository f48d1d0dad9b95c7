// Under ThreadSanitizer oneTBB works in the calling thread alone: Debian's is not built for the sanitizer, which
// doesn't see how the library's threads hand work to each other, and would report races there that are none. Threads of
// our own stay as many as they are.
#if defined(__SANITIZE_THREAD__)
#include <tbb/global_control.h>

namespace {
const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
}  // namespace
#endif
