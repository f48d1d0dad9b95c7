#include "loop/record/recording.h"
#include "target.h"

namespace kerf::fuzz {
namespace {

/// Makes a recording from repeated groups: a kind, a length in two bytes, and that many bytes. Each group becomes a
/// block with correct checksums and, in version 2, digests, which a fuzzer would not guess.
std::string MakeFile(std::string_view bytes, int version) {
  std::string file(version == 1 ? kRecordingMagic1 : kRecordingMagic);
  BlockLink link = FirstLink();
  for (std::uint32_t number = 0; bytes.size() >= 3; ++number) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
    const std::size_t size = std::min<std::size_t>(byte(1) | byte(2) << 8, bytes.size() - 3);
    const auto kind = static_cast<BlockKind>(byte(0));
    const std::string block = FormatBlock(kind, bytes.substr(3, size), number, version == 1 ? nullptr : &link, 1);
    link = LinkAfter(kind, block, {});
    file += block;
    bytes.remove_prefix(3 + size);
  }
  return file + std::string(bytes);
}

void Read(const std::string& path) {
  Accepts([&] {
    RecordingReader reader(path);
    reader.DescribeDamage();
    reader.ReadFiles();
    std::uint64_t steps = 0;
    RecordedBlock block;
    for (std::size_t i = 0; reader.ReadBlock(i, block); ++i) {
      steps += block.steps.size();
      for (const RecordedState& state : block.states) {
        if (state.step - block.first_step >= block.steps.size())
          Finding("a state refers to a step that does not exist");
      }
    }
    if (steps != reader.steps()) Finding("a wrong number of steps");
    if (!(reader.duration_s() >= 0)) Finding("an invalid duration");
    reader.ReadPiece(1);
  });
}

}  // namespace

KERF_FUZZ_TARGET(recording) {
  static const MemoryFolder folder;
  for (const int version : {1, 2}) Read(folder.Write("made.kerf", MakeFile(bytes, version)));
  Read(folder.Write("raw.kerf", bytes));
}

}  // namespace kerf::fuzz
