// Limits oneTBB to the calling thread under ThreadSanitizer. Debian's oneTBB is not built for the sanitizer, which
// therefore cannot track how the library's threads exchange work and would report false races. The number of our own
// threads does not change.
#if defined(__SANITIZE_THREAD__)
#include <tbb/global_control.h>

namespace {
const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
}  // namespace
#endif
