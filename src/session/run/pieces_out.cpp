#include "session/run/pieces_out.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bone/grid/join.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

/// Returns the box around all leaves whose values may change when the piece is removed.
Box3 CalcReachedBox(const PieceFinder& finder, int id, double voxel_mm) {
  std::array<int, 3> lowest{1 << 30, 1 << 30, 1 << 30}, highest{-(1 << 30), -(1 << 30), -(1 << 30)};
  finder.ForEachLeaf(id, [&](const std::array<int, 3>& index, const LeafMask&) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], index[axis] - 1);
      highest[axis] = std::max(highest[axis], index[axis] + 2);
    }
  });
  const double leaf_mm = 8 * voxel_mm;
  return {leaf_mm * Vec3(lowest[0], lowest[1], lowest[2]), leaf_mm * Vec3(highest[0], highest[1], highest[2])};
}

/// Returns the mean position of the piece's voxels.
Vec3 CalcMiddle(const PieceFinder& finder, int id, double voxel_mm) {
  Vec3 sum(0);
  double count = 0;
  finder.ForEachLeaf(id, [&](const std::array<int, 3>& index, const LeafMask& mask) {
    for (int i = 0; i < 512; ++i) {
      if ((mask[static_cast<std::size_t>(i / 64)] >> (i % 64) & 1) == 0) continue;
      sum += Vec3(8 * index[0] + i / 64, 8 * index[1] + i / 8 % 8, 8 * index[2] + i % 8);
      count += 1;
    }
  });
  return count > 0 ? voxel_mm / count * sum : sum;
}

Vec3 CalcMove(const FragmentWatch& watch, int id, double voxel_mm) {
  const FragmentsParams& params = watch.params();
  if (params.pieces != PieceFate::kMoved) return Vec3(0);
  if (params.move_mm != Vec3(0)) return params.move_mm;
  const PieceFinder& finder = watch.finder();
  const int largest = finder.found().pieces.front().id;
  const Vec3 direction = CalcMiddle(finder, id, voxel_mm) - CalcMiddle(finder, largest, voxel_mm);
  return params.apart_mm * (glm::length(direction) > 0 ? glm::normalize(direction) : Vec3(0, 0, 1));
}

}  // namespace

std::optional<PieceJob> PreparePiece(const FragmentWatch& watch, const Bone& bone, const std::set<int>& excluded,
                                     const std::function<bool(const Box3&)>& is_clear) {
  const PieceFinder& finder = watch.finder();
  const FoundPieces& found = finder.found();
  const auto can_be_taken_out = [&](int id) {
    return excluded.count(id) == 0 && is_clear(CalcReachedBox(finder, id, bone.voxel_mm()));
  };
  for (std::size_t i = 1; watch.params().pieces != PieceFate::kHeld && i < found.pieces.size(); ++i) {
    const int id = found.pieces[i].id;
    if (found.pieces[i].from == 0 || !can_be_taken_out(id)) continue;
    return PieceJob{id, 0, CalcMove(watch, id, bone.voxel_mm()), MakePieceRemoval(bone, finder, id)};
  }
  if (watch.params().remove_dust && found.dust_count > 0 && can_be_taken_out(kAllDust)) {
    return PieceJob{kAllDust, found.dust_count, Vec3(0), MakePieceRemoval(bone, finder, kAllDust)};
  }
  return {};
}

Bone PutBack(const Bone& bone, std::span<const PieceOut> out) {
  std::vector<const Bone*> pieces;
  for (const PieceOut& piece : out) pieces.push_back(&piece.bone);
  return JoinBones(bone, pieces);
}

PieceOut FinishPiece(PieceJob&& job, const FragmentsParams& params, double time_s) {
  PieceOut out;
  out.id = job.id;
  out.fate = job.id == kAllDust ? PieceFate::kDeleted : params.pieces;
  out.time_s = time_s;
  for (const double mm3 : job.removal.mm3) out.volume_mm3 += mm3;
  out.crumbs = job.crumbs;
  out.move_mm = job.move_mm;
  if (out.fate != PieceFate::kDeleted) out.bone = std::move(job.removal.piece);
  return out;
}

std::vector<double> CalcVolumes(std::span<const Bone> bones) {
  std::vector<double> volumes_mm3;
  for (const Bone& bone : bones) volumes_mm3.push_back(bone.CalcVolume());
  return volumes_mm3;
}

std::vector<ResultPiece> ListPieces(std::span<const Bone> in_bone, std::span<const double> volumes_mm3,
                                    std::span<const PieceOut> out) {
  std::vector<ResultPiece> pieces;
  for (std::size_t i = 0; i < in_bone.size(); ++i) pieces.push_back({&in_bone[i], nullptr, volumes_mm3[i]});
  for (const PieceOut& piece : out) {
    if (piece.fate != PieceFate::kDeleted) pieces.push_back({&piece.bone, &piece, piece.volume_mm3});
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const ResultPiece& a, const ResultPiece& b) { return a.volume_mm3 > b.volume_mm3; });
  return pieces;
}

TriangleMesh MakeSurfaceOut(const PieceOut& piece) {
  TriangleMesh mesh = ExtractSurface(piece.bone);
  for (Vec3& p : mesh.points) p += piece.move_mm;
  return mesh;
}

}  // namespace kerf
