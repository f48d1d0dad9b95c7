#include "session/run/recorded_piece.h"

#include <array>

#include "base/compress/bytes.h"
#include "bone/grid/set_leaf.h"

namespace kerf {
namespace {

constexpr std::size_t kLeafBytes = 3 + 64;    // minimum: index and mask
constexpr std::size_t kMaxLeaves = 1u << 17;  // they use 4 kB of memory each, 0.5 GB in total

void Put(ByteWriter& out, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) out.Put(v[axis]);
}
Vec3 GetVec3(ByteReader& in) {
  Vec3 v;
  for (int axis = 0; axis < 3; ++axis) v[axis] = in.Get<double>();
  return v;
}

}  // namespace

std::string EncodePiece(const PieceJob& job) {
  ByteWriter out;
  out.PutSigned(job.id);
  out.PutNumber(job.crumbs);
  Put(out, job.move_mm);
  const PieceRemoval& removal = job.removal;
  Put(out, removal.bounds_W.lower);
  Put(out, removal.bounds_W.upper);
  for (const double mm3 : removal.mm3) out.Put(mm3);
  out.PutNumber(removal.leaves.size());
  for (const LeafChange& leaf : removal.leaves) {
    for (const int i : leaf.index) out.PutSigned(i);
    std::array<std::uint64_t, 8> changes{};
    for (std::size_t i = 0; i < 512; ++i) {
      if (leaf.without[i] != leaf.with[i]) changes[i / 64] |= std::uint64_t{1} << (i % 64);
    }
    for (const std::uint64_t bits : changes) out.Put(bits);
    for (std::size_t i = 0; i < 512; ++i) {
      if ((changes[i / 64] >> (i % 64) & 1) != 0) out.Put(leaf.without[i]);
    }
  }
  return out.Take();
}

PieceJob DecodePiece(std::string_view bytes, const Bone& bone) {
  ByteReader in(bytes);
  PieceJob job;
  job.id = static_cast<int>(in.GetSigned());
  job.crumbs = static_cast<std::size_t>(in.GetNumber());
  job.move_mm = GetVec3(in);
  PieceRemoval& removal = job.removal;
  removal.bounds_W.lower = GetVec3(in);
  removal.bounds_W.upper = GetVec3(in);
  for (double& mm3 : removal.mm3) mm3 = in.Get<double>();
  const std::size_t leaves = in.GetCount(kLeafBytes);
  if (leaves > kMaxLeaves) throw Error("has a piece of bone that is larger than a recording can hold");
  removal.leaves.resize(leaves);
  for (LeafChange& leaf : removal.leaves) {
    for (int& i : leaf.index) {
      const std::int64_t index = in.GetSigned();
      // This limit is larger than any bone, and eight times an index within it still fits into an int.
      if (index < -(1 << 24) || index > 1 << 24) throw Error("has a leaf outside the bone's limits");
      i = static_cast<int>(index);
    }
    GetCut(bone, leaf.index, leaf.with);
    leaf.without = leaf.with;
    std::array<std::uint64_t, 8> changes{};
    for (std::uint64_t& bits : changes) bits = in.Get<std::uint64_t>();
    for (std::size_t i = 0; i < 512; ++i) {
      if ((changes[i / 64] >> (i % 64) & 1) != 0) leaf.without[i] = in.Get<float>();
    }
  }
  if (in.left() != 0) throw Error("is longer than its content");
  return job;
}

}  // namespace kerf
