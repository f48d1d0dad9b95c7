#include <fmt/format.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>

#include <cstring>

#include "kerf/error.h"
#include "mesh/read.h"
#include "mesh/vtk_mesh.h"

namespace kerf {
namespace {

constexpr std::size_t kHeaderBytes = 84;  // 80 of text, 4 of count
constexpr std::size_t kTriangleBytes = 50;

// A binary STL: 80 bytes of anything, a 32-bit count, and for each triangle a normal, three points (floats) and two
// bytes.
TriangleMesh ReadBinaryStl(std::string_view bytes) {
  const std::size_t count = (bytes.size() - kHeaderBytes) / kTriangleBytes;
  TriangleMesh mesh;
  mesh.points.reserve(3 * count);
  mesh.triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    const char* at = bytes.data() + kHeaderBytes + t * kTriangleBytes + 3 * sizeof(float);
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (int i = 0; i < 3; ++i) {
      float p[3];
      std::memcpy(p, at + static_cast<std::size_t>(i) * sizeof(p), sizeof(p));
      mesh.points.emplace_back(p[0], p[1], p[2]);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TriangleMesh ReadTextStl(const std::string& path) {
  QuietVtk();
  const vtkNew<vtkSTLReader> reader;
  reader->SetFileName(path.c_str());
  reader->MergingOff();  // ReadMesh merges
  reader->Update();
  if (reader->GetErrorCode() != 0 || reader->GetOutput()->GetNumberOfPolys() == 0) {
    throw Error(fmt::format("{}: not a whole text STL; export it again, best as a binary STL", path));
  }
  return MakeTriangleMesh(*reader->GetOutput(), path);
}

}  // namespace

TriangleMesh ReadStl(std::string_view bytes, const std::string& path) {
  // Some binary files begin with "solid" too, so the length decides first.
  if (bytes.size() >= kHeaderBytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof(count));
    const std::uint64_t expected = kHeaderBytes + std::uint64_t{count} * kTriangleBytes;
    if (bytes.size() == expected) return ReadBinaryStl(bytes);
    const bool text = bytes.substr(0, 5) == "solid" && bytes.substr(0, 1024).find("facet") != std::string_view::npos;
    if (!text) {
      throw Error(fmt::format(
          "{}: a binary STL that promises {} triangles ({} bytes), but the file has {} bytes; it is cut off "
          "or no STL",
          path, WithSeparators(count), WithSeparators(expected), WithSeparators(bytes.size())));
    }
  }
  if (bytes.substr(0, 5) != "solid") throw Error(fmt::format("{}: not an STL file", path));
  // VTK takes what it finds of a text that ends early.
  if (bytes.rfind("endsolid") == std::string_view::npos) {
    throw Error(fmt::format("{}: a text STL without its 'endsolid'; it is cut off", path));
  }
  return ReadTextStl(path);
}

}  // namespace kerf
