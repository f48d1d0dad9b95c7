#include "base/compress/pack.h"
#include "loop/record/step.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(recorded_steps) {
  Accepts([&] { Unpack(bytes, std::size_t{1} << 20); });
  RecordedBlock block;
  if (!Accepts([&] { block = DecodeBlock(bytes); })) return;
  // Encoding and decoding again must give the same block, regardless of the original encoding.
  const std::string once = EncodeBlock(block);
  if (EncodeBlock(DecodeBlock(once)) != once) Finding("a block changes when it is read and written");
}

}  // namespace kerf::fuzz
