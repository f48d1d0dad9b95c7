// Label maps and segmentations, written byte by byte, without the libraries that the program uses to read them.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bone/import/ct_files.h"

namespace kerf::test {

/// A segment in the header of a .seg.nrrd, with the fields of 3D Slicer.
struct HeaderSegment {
  std::string name;
  std::string label;
  std::string layer = "0";
  std::string tags{};
};

inline std::string TagsOf(const std::string& type, const std::string& meaning) {
  return fmt::format(
      "Segmentation.Status:completed|TerminologyEntry:Segmentation category and type - 3D Slicer General Anatomy list~"
      "SCT^123037004^Anatomical Structure~SCT^{}^{}~^^~Anatomic codes - DICOM master list~^^~^^|",
      type, meaning);
}

/// Returns the header of a .seg.nrrd. With more than one layer, the list axis is the first.
inline std::string SegHeader(const Volume& lattice, const std::vector<HeaderSegment>& segments, std::size_t layers) {
  std::string text = fmt::format(
      "NRRD0004\n# Complete NRRD file format specification at:\ntype: unsigned char\ndimension: {}\n"
      "space: left-posterior-superior\nsizes:{} {} {} {}\nspace directions:{}",
      layers == 1 ? 3 : 4, layers == 1 ? "" : fmt::format(" {}", layers), lattice.size[0], lattice.size[1],
      lattice.size[2], layers == 1 ? "" : " none");
  for (int a = 0; a < 3; ++a) {
    const Vec3 d = lattice.axes_W[a] * lattice.spacing_mm[a];
    text += fmt::format(" ({:.17g},{:.17g},{:.17g})", d.x, d.y, d.z);
  }
  text += fmt::format("\nkinds:{} domain domain domain\nencoding: raw\nspace origin: ({:.17g},{:.17g},{:.17g})\n",
                      layers == 1 ? "" : " list", lattice.origin_W.x, lattice.origin_W.y, lattice.origin_W.z);
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const HeaderSegment& s = segments[n];
    text +=
        fmt::format("Segment{0}_Color:=0.5 0.6 0.7\nSegment{0}_Extent:=0 1 0 1 0 1\nSegment{0}_ID:=Segment_{0}\n", n);
    text += fmt::format("Segment{}_Name:={}\n", n, s.name);
    if (!s.label.empty()) text += fmt::format("Segment{}_LabelValue:={}\n", n, s.label);
    if (!s.layer.empty()) text += fmt::format("Segment{}_Layer:={}\n", n, s.layer);
    if (!s.tags.empty()) text += fmt::format("Segment{}_Tags:={}\n", n, s.tags);
  }
  return text + "Segmentation_MasterRepresentation:=Binary labelmap\n\n";
}

/// Returns the voxels of the layers as bytes; those of one voxel follow each other.
inline std::string LayerBytes(const std::vector<std::vector<std::int16_t>>& layers) {
  std::string bytes;
  for (std::size_t v = 0; v < layers[0].size(); ++v) {
    for (const auto& layer : layers) bytes += static_cast<char>(layer[v]);
  }
  return bytes;
}

/// Labels of the voxel centres on a lattice.
inline Volume MakeLabels(Volume lattice, const std::function<int(const Vec3&)>& label) {
  lattice.hu.clear();
  for (int k = 0; k < lattice.size[2]; ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i)
        lattice.hu.push_back(static_cast<std::int16_t>(label(lattice.WorldFromVoxel({i, j, k}))));
    }
  }
  return lattice;
}

inline void WriteSeg(const Volume& map, const std::vector<HeaderSegment>& segments, const std::string& path) {
  WriteBytes(path, SegHeader(map, segments, 1) + LayerBytes({map.hu}));
}

}  // namespace kerf::test
