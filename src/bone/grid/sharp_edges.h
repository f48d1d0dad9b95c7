// Sharp edges of a surface between the bone and a cut. Includes OpenVDB.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "bone/grid/parts_reader.h"

namespace kerf {

/// Moves the vertices of a bone's surface, one in each cell that the surface passes, to where its two fields are zero
/// (see BoneField). A surface of phi alone is rounded by up to half a voxel where the fields meet. Positions in voxels.
class SharpEdges {
 public:
  enum class Side : std::uint8_t { kWhole, kCut, kBoth };
  /// A vertex; on which surface it lies, or on the edge of both; the outward directions of the surfaces on which it
  /// lies, not of unit length, which are zero if there is no edge near; and the values of the two fields on the dual
  /// mesh there, in voxels: not quite zero where a surface bends, because a vertex is the mean of a cell's crossings.
  struct Vertex {
    Vec3 p_vox{0};
    Side side = Side::kWhole;
    Vec3 whole_outward{0}, cut_outward{0};
    double whole_level = 0, cut_level = 0;

    bool IsOn(Side surface) const { return side == surface || side == Side::kBoth; }
  };

  /// The bone must outlive this object and must not change.
  explicit SharpEdges(const BoneGrids& grids) : reader_(grids), h_(grids.voxel_mm()) {}

  /// Moves a vertex within its cell: onto the edge if it passes the cell, and otherwise to where the dual mesh of the
  /// larger field alone has it.
  Vertex Move(const Vec3& p_vox) const;
  /// Appends vertices on the edge where it lies between two vertices that are not on the same surface. A closed mesh
  /// stays closed.
  void SplitTriangles(std::vector<Vertex>& vertices, std::vector<std::array<std::uint32_t, 3>>& triangles) const;

 private:
  std::optional<Vertex> FindEdge(Vec3 p_vox, double whole_level, double cut_level) const;

  PartsReader reader_;
  double h_;
};

/// Does both to the whole surface of a bone; world frame, mm.
void SharpenEdges(const BoneGrids& bone, TriangleMesh& mesh);

}  // namespace kerf
