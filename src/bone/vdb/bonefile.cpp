#include "bone/vdb/bonefile.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <vector>

#include "base/core/errno_text.h"
#include "base/files/files.h"
#include "bone/grid/grids.h"
#include "bone/grid/shared_leaves.h"
#include "bone/material/region_table.h"
#include "bone/vdb/limits.h"
#include "bone/vdb/vdb_check.h"
#include "bone/vdb/vdb_checksum.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kFormat = 2;
constexpr int kFormatOfInt32Regions = 1;  // the same, except that the grid "region" was of type int32
constexpr float kMaxHu = 100'000;
constexpr char kNotePrefix[] = "note_";

/// OpenVDB's writer, on a stream that kerf opens, because the stream that OpenVDB itself opens does not detect a full
/// disk.
class Writer : public openvdb::io::Archive {
 public:
  void Write(std::ostream& out, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& meta) const {
    write(out, grids, /*seekable=*/true, meta);
  }
};

/// OpenVDB's stream reader, which skips grids that are not wanted.
class Reader : public openvdb::io::Archive {
 public:
  /// The stream must not be read after the reader is destroyed.
  explicit Reader(std::istream& in) {
    readHeader(in);
    openvdb::io::setStreamMetadataPtr(in, of_stream_, /*transfer=*/false);
    openvdb::io::setVersion(in, libraryVersion(), fileVersion());
    openvdb::io::setDataCompression(in, compression());
    meta_.readMeta(in);
    grid_count_ = readGridCount(in);
  }

  const openvdb::MetaMap& meta() const { return meta_; }

  /// Reads the grids with these names; if several have the same name, the last one.
  std::map<std::string, openvdb::GridBase::Ptr> ReadGrids(std::istream& in, const std::set<std::string>& wanted) {
    std::map<std::string, openvdb::GridBase::Ptr> found;
    NamedGridMap by_unique_name;
    std::vector<openvdb::io::GridDescriptor> descriptors;
    for (int n = 0; n < grid_count_; ++n) {
      openvdb::io::GridDescriptor descriptor;
      const openvdb::GridBase::Ptr grid = descriptor.read(in);
      if (inputHasGridOffsets() && wanted.count(descriptor.gridName()) == 0) {
        // Seeks forward only, so that the loop ends.
        if (descriptor.getEndPos() <= in.tellg()) throw openvdb::IoError("a grid that ends before it begins");
        descriptor.seekToEnd(in);
        continue;
      }
      readGrid(grid, descriptor, in);
      found[descriptor.gridName()] = grid;
      by_unique_name[descriptor.uniqueName()] = grid;
      descriptors.push_back(descriptor);
    }
    for (const auto& descriptor : descriptors) connectInstance(descriptor, by_unique_name);
    return found;
  }

 private:
  openvdb::io::StreamMetadata::Ptr of_stream_ =
      std::make_shared<openvdb::io::StreamMetadata>();  // the stream points here
  openvdb::MetaMap meta_;
  int grid_count_ = 0;
};

[[noreturn]] void Refuse(const std::string& path, const std::string& why) {
  throw Error(fmt::format("{}: {}", path, why));
}

std::string StringMeta(const openvdb::MetaMap& meta, const std::string& name, const std::string& path) {
  const auto value = meta.getMetadata<openvdb::StringMetadata>(name);
  if (!value) Refuse(path, fmt::format("not a kerf bone: its metadata has no \"{}\"", name));
  return value->value();
}

/// Returns the grid's voxel size. Its transform must be a uniform scale without translation or rotation.
double VoxelSize(const openvdb::GridBase& grid, const std::string& path) {
  const auto& transform = grid.constTransform();
  const double h = transform.voxelSize()[0];
  const openvdb::Vec3d one = transform.indexToWorld(openvdb::Vec3d(1, 1, 1));
  const openvdb::Vec3d zero = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
  const bool plain = zero.length() == 0 && (one - openvdb::Vec3d(h, h, h)).length() <= 1e-9 * h;
  constexpr Range kFileVoxelRange_mm{0.002, 10};
  if (!plain || !kFileVoxelRange_mm.Contains(h)) {
    Refuse(path, fmt::format("grid \"{}\" must have cubic voxels of {} along the world axes", grid.getName(),
                             ShowRange(kFileVoxelRange_mm, "mm")));
  }
  return h;
}

/// Throws kerf::Error if the active voxels are too far apart: later steps would take practically forever.
void CheckSides(const openvdb::GridBase& grid, const std::string& path) {
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  if (box.empty()) return;
  const openvdb::Coord sides = box.dim();
  if (std::max({sides.x(), sides.y(), sides.z()}) <= kMaxVdbSide_vox) return;
  Refuse(path, fmt::format("grid \"{}\" has {} x {} x {} voxels; kerf reads up to {} along a side", grid.getName(),
                           sides.x(), sides.y(), sides.z(), kMaxVdbSide_vox));
}

/// Returns the first value of a voxel or tile for which is_good(value, whether it is active) is false. It is called for
/// several leaves at the same time.
template <typename Grid, typename IsGood>
std::optional<typename Grid::ValueType> FindFault(const Grid& grid, IsGood&& is_good) {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  openvdb::tree::LeafManager<const typename Grid::TreeType> leaves(grid.tree());
  std::vector<std::optional<typename Grid::ValueType>> faults(leaves.leafCount());
  leaves.foreach ([&](const Leaf& leaf, std::size_t n) {
    for (openvdb::Index i = 0; i < Leaf::SIZE && !faults[n]; ++i) {
      if (!is_good(leaf.getValue(i), leaf.isValueOn(i))) faults[n] = leaf.getValue(i);
    }
  });
  for (const auto& fault : faults) {
    if (fault) return fault;
  }
  auto tile = grid.cbeginValueAll();
  tile.setMaxDepth(Grid::TreeType::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (!is_good(*tile, tile.isValueOn())) return *tile;
  }
  return std::nullopt;
}

/// Converts the regions, which files store as floats: Debian's build of the Python module opens only grids of float,
/// bool and vec3s, and rejects the whole file because of another type. Integers up to 255 are exact.
openvdb::Int32Grid::Ptr ReadRegions(const openvdb::GridBase::Ptr& grid, const std::string& path) {
  if (auto regions = openvdb::gridPtrCast<openvdb::Int32Grid>(grid)) return regions;
  const auto stored = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
  if (!stored) Refuse(path, "grid \"region\" must be of type float or int32");
  const auto is_region = [](float value, bool) { return value >= 0 && value <= 255 && value == std::floor(value); };
  if (const std::optional<float> fault = FindFault(*stored, is_region)) {
    Refuse(path, fmt::format("grid \"region\" has the value {}, which is not a region number", *fault));
  }
  return std::make_shared<openvdb::Int32Grid>(*stored);
}

/// Throws kerf::Error unless phi is the larger of the two fields in each leaf that has both, and the other entries of
/// "cut" are tiles that mark leaves of phi.
void CheckParts(const BoneGrids& grids, const std::string& path) {
  const auto disagree = [&]() { Refuse(path, "grids \"whole\" and \"cut\" do not belong to grid \"phi\""); };
  // A grid of a file can be an instance of another one, which shares its voxels.
  const auto phi_tree = grids.phi->constTreePtr(), whole_tree = grids.whole->constTreePtr();
  const auto cut_tree = grids.cut->constTreePtr();
  if (whole_tree == cut_tree || whole_tree == phi_tree || cut_tree == phi_tree) disagree();
  for (const auto& grid : {grids.whole, grids.cut}) {
    CheckSides(*grid, path);
    if (VoxelSize(*grid, path) != VoxelSize(*grids.phi, path)) disagree();
    if (grid->background() != -grids.phi->background()) disagree();
  }
  if (grids.whole->tree().leafCount() != grids.cut->tree().leafCount()) disagree();
  const float band = grids.phi->background();
  const auto phi = grids.phi->getConstAccessor();
  for (auto leaf = grids.cut->tree().cbeginLeaf(); leaf; ++leaf) {
    const auto* whole = grids.whole->tree().probeConstLeaf(leaf->origin());
    if (whole == nullptr) disagree();
    for (openvdb::Index i = 0; i < 512; ++i) {
      const float is = phi.getValue(leaf->offsetToGlobalCoord(i));
      const float cut = leaf->getValue(i);
      // Also refuses what is not a number.
      if (!(std::abs(cut) <= band * 1.001f) || !(std::abs(whole->getValue(i)) <= band * 1.001f)) disagree();
      if (is != std::max(whole->getValue(i), cut) && !(is >= band && std::max(whole->getValue(i), cut) >= band)) {
        disagree();
      }
    }
  }
  auto tile = grids.cut->cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (!tile.isValueOn() && *tile == -band) continue;
    openvdb::CoordBBox box;
    if (!tile.getBoundingBox(box) || box.dim() != openvdb::Coord(8, 8, 8) || *tile != band) disagree();
    if (phi.probeConstLeaf(box.min()) == nullptr && phi.getValue(box.min()) < 0) disagree();
  }
}

void CheckGrids(const BoneGrids& grids, const std::string& path) {
  const double h = VoxelSize(*grids.phi, path);
  VoxelSize(*grids.region, path);
  CheckSides(*grids.phi, path);
  CheckSides(*grids.region, path);
  const float band = grids.phi->background();
  if (!(std::abs(static_cast<double>(band) - kHalfBandVoxels * h) <= 1e-3 * h)) {
    Refuse(path, fmt::format("grid \"phi\" has the background {} but {} mm (3 voxels) is expected", band, 3 * h));
  }
  if (FindFault(*grids.phi, [band](float value, bool) { return std::abs(value) <= band * 1.001f; })) {
    Refuse(path, "grid \"phi\" contains a value that is not a distance within its band");
  }
  auto tile = grids.phi->cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (std::abs(*tile) != band) Refuse(path, "grid \"phi\" has a tile that is neither air nor bone");
  }
  if (grids.cut) CheckParts(grids, path);
  std::array<bool, 256> known{};
  for (int id = 0; id < 256; ++id) known[static_cast<std::size_t>(id)] = id == 0 || grids.materials.Contains(id);
  const auto is_known = [&known](int id, bool active) {
    return !active || (id >= 0 && id < 256 && known[static_cast<std::size_t>(id)]);
  };
  if (const std::optional<int> fault = FindFault(*grids.region, is_known)) {
    Refuse(path, fmt::format("grid \"region\" refers to region {}, which is not in the region table", *fault));
  }
  if (!grids.hu) return;
  if (VoxelSize(*grids.hu, path) < 0.05) Refuse(path, "grid \"hu\" has voxels below 0.05 mm");
  if (grids.hu->tree().hasActiveTiles()) {
    Refuse(path, "grid \"hu\" has active tiles, which kerf never writes; it was rewritten by another program");
  }
  for (auto it = grids.hu->cbeginValueOn(); it; ++it) {
    if (!(std::abs(*it) <= kMaxHu)) Refuse(path, "grid \"hu\" contains a value that is not a CT number");
  }
}

}  // namespace

Bone ReadBone(const std::string& path, const ReadBoneOptions& options) {
  std::error_code failed;
  const auto bytes = std::filesystem::file_size(path, failed);
  if (failed == std::errc::no_such_file_or_directory) {
    Refuse(path, fmt::format("there is no such file; 'kerf import INPUT -o {}' makes it from a CT or a closed surface",
                             path));
  }
  std::error_code unknown;
  const std::filesystem::file_status status = std::filesystem::status(path, unknown);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    Refuse(path, "is not a regular file");
  }
  if (failed) Refuse(path, fmt::format("can't be read: {}", failed.message()));
  if (bytes > kMaxVdbFileBytes) Refuse(path, "can't be read: it is larger than 8 GiB");
  std::ifstream in(path, std::ios::binary);
  if (!in) Refuse(path, fmt::format("can't be read: {}", FormatErrno(errno)));
  return ReadBone(in, path, options);
}

Bone ReadBone(std::istream& in, const std::string& path, const ReadBoneOptions& options) {
  std::set<std::string> wanted = {"phi", "region", "whole", "cut"};
  if (options.hu) wanted.insert("hu");
  CheckVdb(in, path, wanted);
  Bone bone;  // also initialises OpenVDB
  BoneGrids& grids = GridsOf(bone);
  try {
    // The stream throws at its end; otherwise OpenVDB would continue with arbitrary counts from memory.
    in.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
    Reader file(in);
    const openvdb::MetaMap* meta = &file.meta();
    const auto format = meta->getMetadata<openvdb::Int32Metadata>("kerf_format");
    if (!format) Refuse(path, "not a kerf bone: its metadata has no \"kerf_format\"");
    if (format->value() != kFormat && format->value() != kFormatOfInt32Regions) {
      Refuse(path, fmt::format("written in format {}; this kerf reads formats {} and {}", format->value(),
                               kFormatOfInt32Regions, kFormat));
    }
    if (StringMeta(*meta, "units", path) != "mm") Refuse(path, "its lengths are not in mm");
    grids.materials = ParseRegionTable(StringMeta(*meta, "region_table", path), path + " (region table)");
    for (auto it = meta->beginMeta(); it != meta->endMeta(); ++it) {
      if (it->first.starts_with(kNotePrefix)) grids.notes[it->first.substr(sizeof kNotePrefix - 1)] = it->second->str();
    }
    auto found = file.ReadGrids(in, wanted);
    if (!found["phi"] || !found["region"]) Refuse(path, "not a kerf bone: grids \"phi\" and \"region\" are needed");
    grids.phi = openvdb::gridPtrCast<openvdb::FloatGrid>(found["phi"]);
    grids.region = ReadRegions(found["region"], path);
    grids.hu = openvdb::gridPtrCast<openvdb::FloatGrid>(found["hu"]);
    if (!grids.phi) Refuse(path, "grid \"phi\" must be of type float");
    grids.whole = openvdb::gridPtrCast<openvdb::FloatGrid>(found["whole"]);
    grids.cut = openvdb::gridPtrCast<openvdb::FloatGrid>(found["cut"]);
    if (found["whole"] || found["cut"]) {
      if (!grids.whole || !grids.cut) Refuse(path, "grids \"whole\" and \"cut\" must both be there, of type float");
    }
    if (found["hu"] && !grids.hu) Refuse(path, "grid \"hu\" must be of type float");
  } catch (const Error&) {
    throw;
  } catch (const std::ios_base::failure&) {
    CheckReadable(in, path);
    Refuse(path, "not a valid OpenVDB file (it ends early)");
  } catch (const std::exception& e) {
    CheckReadable(in, path);
    // OpenVDB's own exceptions, and those of the standard library if a damaged file contains absurd sizes.
    Refuse(path, fmt::format("not a valid OpenVDB file ({})", e.what()));
  }
  CheckGrids(grids, path);
  if (bone.empty()) Refuse(path, "the bone is empty: no voxel lies inside");
  return bone;
}

Bone CopyAsStored(const Bone& bone, const ReadBoneOptions& options) {
  Bone copy = CopySharing(bone);
  BoneGrids& grids = GridsOf(copy);
  if (grids.stored_materials) grids.materials = *grids.stored_materials;
  grids.stored_materials.reset();
  grids.modulus.reset();
  grids.by_modulus.fill(false);
  if (!options.hu) grids.hu.reset();
  return copy;
}

void WriteBone(const Bone& bone, const std::string& path) {
  const BoneGrids& grids = GridsOf(bone);
  openvdb::MetaMap meta;
  meta.insertMeta("kerf_format", openvdb::Int32Metadata(kFormat));
  meta.insertMeta(std::string(kVdbChecksumName), openvdb::StringMetadata(MakeBlankVdbChecksum()));
  meta.insertMeta("units", openvdb::StringMetadata("mm"));
  meta.insertMeta("frame", openvdb::StringMetadata("LPS: x to the patient's left, y to the back, z to the head"));
  meta.insertMeta("region_table",
                  openvdb::StringMetadata(FormatRegionTable(grids.stored_materials.value_or(grids.materials))));
  for (const auto& [key, value] : grids.notes) meta.insertMeta(kNotePrefix + key, openvdb::StringMetadata(value));
  WriteAtomically(path, [&](const std::string& temporary) {
    try {
      std::ofstream out;
      out.exceptions(std::ios::badbit | std::ios::failbit);
      out.open(temporary, std::ios::binary | std::ios::trunc);
      openvdb::GridCPtrVec stored = {grids.phi, std::make_shared<const openvdb::FloatGrid>(*grids.region)};
      if (grids.cut) stored.insert(stored.end(), {grids.whole, grids.cut});
      if (grids.hu) stored.push_back(grids.hu);
      Writer().Write(out, stored, meta);
      out.close();
      StampVdb(temporary);
    } catch (const openvdb::Exception& e) {
      throw Error(fmt::format("{}: can't be written: {}", path, e.what()));
    } catch (const std::ios_base::failure&) {
      throw Error(fmt::format("{}: can't be written: {}", path, FormatErrno(errno)));
    }
  });
}

}  // namespace kerf
