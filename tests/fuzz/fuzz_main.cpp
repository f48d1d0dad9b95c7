// libFuzzer's entry point for one target, whose function is KERF_FUZZ_RUN.
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace kerf::fuzz {
void KERF_FUZZ_RUN(std::string_view bytes);
}  // namespace kerf::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kerf::fuzz::KERF_FUZZ_RUN({reinterpret_cast<const char*>(data), size});
  return 0;
}
