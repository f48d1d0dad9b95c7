#include "base/compress/pack.h"
#include "loop/record/step.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(recorded_steps) {
  Takes([&] { Unpack(bytes, std::size_t{1} << 20); });
  RecordedBlock block;
  if (!Takes([&] { block = DecodeBlock(bytes); })) return;
  // Encoding and decoding again must give the same block, regardless of the original encoding.
  const std::string once = EncodeBlock(block);
  if (EncodeBlock(DecodeBlock(once)) != once) Finding("reading and writing changed it");
}

}  // namespace kerf::fuzz
