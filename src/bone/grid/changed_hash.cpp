#include "bone/grid/changed_hash.h"

#include <bit>
#include <cstring>

#include "base/core/hash.h"

namespace kerf {
namespace {

/// Returns a key with 21 bits per axis; never 0.
std::uint64_t KeyOf(const std::array<int, 3>& index) {
  std::uint64_t key = 1;
  for (const int i : index) key = key << 21 | (static_cast<std::uint32_t>(i) & 0x1fffff);
  return key;
}

/// Uses four independent chains, so that no multiplication waits for the previous one.
std::uint64_t HashValues(const float* values) {
  constexpr std::uint64_t kFactor = 0x9fb21c651e98df25u;  // odd
  std::array<std::uint64_t, 4> chain{1, 2, 3, 4};
  for (std::size_t i = 0; i < 512; i += 8) {
    std::array<std::uint64_t, 4> word;
    std::memcpy(word.data(), values + i, sizeof(word));
    for (std::size_t k = 0; k < 4; ++k) chain[k] = std::rotl((chain[k] ^ word[k]) * kFactor, 29);
  }
  return MixHash(chain[0] ^ MixHash(chain[1] ^ MixHash(chain[2] ^ MixHash(chain[3]))));
}

}  // namespace

ChangedHash::ChangedHash(std::size_t leaves)
    : slots_(2 * std::bit_ceil(leaves > 0 ? leaves : 1)), max_leaves_(leaves) {}

void ChangedHash::Take(const ChangedLeaf& leaf) {
  const std::uint64_t key = KeyOf(leaf.index);
  std::size_t at = MixHash(key) & (slots_.size() - 1);
  while (slots_[at].key != key && slots_[at].key != 0) at = (at + 1) & (slots_.size() - 1);
  Slot& slot = slots_[at];
  if (slot.key == 0) {
    if (count_ == max_leaves_) return;
    slot.key = key;
    ++count_;
  }
  const std::uint64_t hash = MixHash(key ^ HashValues(leaf.values));
  sum_ += hash - slot.hash;
  slot.hash = hash;
}

}  // namespace kerf
