#include "cut/undo/leaf_pack.h"

#include <cstring>
#include <string_view>
#include <utility>

#include "base/compress/pack.h"
#include "kerf/error.h"

namespace kerf {

void LeafPack::Add(const std::array<int, 3>& index, const float* values) {
  ++count_;
  if (values == nullptr) {
    inside_.push_back(index);
    return;
  }
  if (waiting_.leaves.empty()) {
    waiting_.leaves.reserve(kRun);
    waiting_.packed.reserve(kRun * kLeafBytes);
  }
  waiting_.leaves.push_back(index);
  const std::size_t at = waiting_.packed.size();
  waiting_.packed.resize(at + kLeafBytes);
  std::memcpy(waiting_.packed.data() + at, values, kLeafBytes);
  if (waiting_.leaves.size() == kRun) Close();
}

void LeafPack::Close() {
  if (waiting_.leaves.empty()) return;
  Run run;
  run.leaves = std::exchange(waiting_.leaves, {});
  run.leaves.shrink_to_fit();
  run.packed = Pack(std::exchange(waiting_.packed, {}));
  run.packed.shrink_to_fit();
  packed_bytes_ += run.packed.capacity() + run.leaves.capacity() * sizeof(run.leaves[0]);
  runs_.push_back(std::move(run));
}

void LeafPack::ForEachInside(const std::function<void(const std::array<int, 3>&)>& visit) const {
  for (const auto& leaf : inside_) visit(leaf);
}

void LeafPack::ForEachWanted(const std::function<bool(const std::array<int, 3>&)>& wants,
                             const std::function<void(const std::array<int, 3>&, const char*)>& visit) const {
  std::vector<bool> wanted;
  const auto look = [&](const Run& run, bool packed) {
    wanted.clear();
    bool any = false;
    for (const auto& leaf : run.leaves) {
      wanted.push_back(wants(leaf));
      any = any || wanted.back();
    }
    if (!any) return;
    const std::string unpacked = packed ? Unpack(run.packed, kRun * kLeafBytes) : std::string();
    const std::string_view bytes = packed ? unpacked : run.packed;
    if (bytes.size() != run.leaves.size() * kLeafBytes) throw Error("the data kept for undo are damaged");
    for (std::size_t i = 0; i < run.leaves.size(); ++i) {
      if (wanted[i]) visit(run.leaves[i], bytes.data() + i * kLeafBytes);
    }
  };
  for (const Run& run : runs_) look(run, true);
  look(waiting_, false);
}

std::size_t LeafPack::CalcMemoryBytes() const {
  return packed_bytes_ + inside_.capacity() * sizeof(inside_[0]) + runs_.capacity() * sizeof(Run) +
         waiting_.packed.capacity() + waiting_.leaves.capacity() * sizeof(inside_[0]);
}

}  // namespace kerf
