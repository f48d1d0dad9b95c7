// Changes the contents of a recording while keeping all checksums and digests correct.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "loop/record/block_reader.h"
#include "loop/record/blocks.h"
#include "loop/record/step.h"

namespace kerf::test {

/// Copies a recording. `change` is called with the kind and the bytes of each block and may modify the bytes.
inline void ForgeRecording(const std::string& from, const std::string& to,
                           const std::function<void(BlockKind, std::string&)>& change) {
  BlockReader reader(from);
  BlockFile file(to);
  for (const BlockPlace& place : reader.places()) {
    std::string bytes = reader.Read(place);
    change(place.kind, bytes);
    if (place.kind == BlockKind::kSeal) bytes = FormatSeal(MakeSeal(file.digest(), std::nullopt));
    file.Append(place.kind, bytes);
  }
  file.Close();
}

/// Does the same for the blocks of steps.
inline void ForgeSteps(const std::string& from, const std::string& to,
                       const std::function<void(RecordedBlock&)>& change) {
  ForgeRecording(from, to, [&](BlockKind kind, std::string& bytes) {
    if (kind != BlockKind::kSteps) return;
    RecordedBlock block = DecodeBlock(bytes);
    change(block);
    bytes = EncodeBlock(block);
  });
}

}  // namespace kerf::test
