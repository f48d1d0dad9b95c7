#include "bone/import/packed_segments.h"
#include "target.h"

namespace kerf::fuzz {

/// The first byte is the number of bytes of pixels.
KERF_FUZZ_TARGET(packed_segments) {
  if (bytes.empty()) return;
  const std::string pixels(static_cast<unsigned char>(bytes[0]), '\x5a');
  Accepts([&] {
    const DicomSegments read = UnpackSegments(std::string(bytes.substr(1)), pixels, kHalfFraction, "f.dcm");
    const std::size_t slice = static_cast<std::size_t>(read.size[0]) * static_cast<std::size_t>(read.size[1]);
    const std::size_t count = read.pixels.size() + read.labels.size();
    if (count != read.frames.size() * slice) Finding("the pixels are not those of the frames");
    if (count > 8 * pixels.size()) Finding("more pixels than bytes hold");
  });
}

}  // namespace kerf::fuzz
