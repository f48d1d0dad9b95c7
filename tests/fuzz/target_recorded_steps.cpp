#include "base/compress/pack.h"
#include "loop/record/step.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(recorded_steps) {
  Takes([&] { Unpack(bytes, std::size_t{1} << 20); });
  RecordedBlock block;
  if (!Takes([&] { block = DecodeBlock(bytes); })) return;
  // Writing and reading again gives the same, whatever the original encoding was.
  const std::string once = EncodeBlock(block);
  if (EncodeBlock(DecodeBlock(once)) != once) Finding("read and written again it is another");
}

}  // namespace kerf::fuzz
