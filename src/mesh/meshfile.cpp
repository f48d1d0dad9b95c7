#include "mesh/meshfile.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPLYWriter.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSTLWriter.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <system_error>
#include <unordered_map>

#include "files/files.h"
#include "kerf/error.h"
#include "mesh/limits.h"
#include "mesh/read.h"
#include "mesh/vtk_mesh.h"

namespace kerf {
namespace {

std::string LowerExtension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

[[noreturn]] void FailExtension(const std::string& path) {
  throw Error(fmt::format("{}: a surface's name must end in .stl, .obj or .ply", path));
}

struct PointHash {
  std::size_t operator()(const Vec3& p) const {
    std::uint64_t h = 0;
    for (int i = 0; i < 3; ++i) h = (h ^ std::bit_cast<std::uint64_t>(p[i])) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
    return h;
  }
};

// Coinciding points become one, triangles with fewer than three different points go, points of no triangle go.
TriangleMesh Tidy(const TriangleMesh& raw, const std::string& path) {
  TriangleMesh mesh;
  mesh.triangles.reserve(raw.triangles.size());
  std::unordered_map<Vec3, std::uint32_t, PointHash> ids;
  ids.reserve(raw.points.size());
  const auto id_of = [&](std::uint32_t raw_id) {
    const Vec3 p = raw.points[raw_id] + Vec3{0.0};  // -0 becomes +0, so that the two are one point
    const auto [at, is_new] = ids.try_emplace(p, static_cast<std::uint32_t>(mesh.points.size()));
    if (is_new) mesh.points.push_back(p);
    return at->second;
  };
  for (std::size_t i = 0; i < raw.triangles.size(); ++i) {
    const auto& t = raw.triangles[i];
    for (const std::uint32_t id : t) {
      const Vec3& p = raw.points[id];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        throw Error(
            fmt::format("{}: triangle {} has a point that is not finite ({}, {}, {})", path, i + 1, p.x, p.y, p.z));
      }
    }
    const std::array<std::uint32_t, 3> tidy{id_of(t[0]), id_of(t[1]), id_of(t[2])};
    if (tidy[0] != tidy[1] && tidy[1] != tidy[2] && tidy[2] != tidy[0]) mesh.triangles.push_back(tidy);
  }
  if (mesh.triangles.empty()) throw Error(fmt::format("{}: holds no triangle", path));
  return mesh;
}

// VTK's own writer keeps six digits only.
std::string FormatObj(const TriangleMesh& mesh) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "# kerf surface, mm\n");
  for (const Vec3& p : mesh.points) {
    fmt::format_to(out, "v {} {} {}\n", static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
  }
  for (const auto& t : mesh.triangles) fmt::format_to(out, "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return fmt::to_string(text);
}

void WriteStl(vtkSTLWriter& writer, const std::string& path) {
  QuietVtk();
  WriteAtomically(path, [&](const std::string& temporary) {
    writer.SetFileName(temporary.c_str());
    if (writer.Write() != 1 || writer.GetErrorCode() != 0) {
      throw Error(fmt::format("{}: can't be written (is the folder there, and the disk not full?)", path));
    }
  });
}

/// Of a binary PLY of triangles whose properties are floats and bytes, from its header.
std::uintmax_t CalcPlyBytes(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::uintmax_t bytes = 0;
  std::uintmax_t count = 0;
  for (std::string line; std::getline(in, line);) {
    bytes += line.size() + 1;
    std::istringstream words(line);
    std::string word, type;
    words >> word >> type;
    if (word == "element") words >> count;
    if (word == "property") bytes += count * (type == "list" ? 1 + 3 * sizeof(std::int32_t) : type == "uchar" ? 1 : 4);
    if (word == "end_header") return bytes;
  }
  return std::numeric_limits<std::uintmax_t>::max();
}

void WritePly(vtkPLYWriter& writer, const std::string& path) {
  QuietVtk();
  WriteAtomically(path, [&](const std::string& temporary) {
    writer.SetFileName(temporary.c_str());
    // Of a full disk VTK says nothing here.
    std::error_code failed;
    if (writer.Write() != 1 || std::filesystem::file_size(temporary, failed) != CalcPlyBytes(temporary)) {
      throw Error(fmt::format("{}: can't be written (is the folder there, and the disk not full?)", path));
    }
  });
}

}  // namespace

void CheckTriangles(std::size_t count, const std::string& path) {
  if (count <= kMaxTriangles) return;
  throw Error(fmt::format("{}: has more than the {} triangles that kerf reads; make it coarser", path,
                          WithSeparators(kMaxTriangles)));
}

std::string WithSeparators(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3)
    text.insert(static_cast<std::size_t>(at), 1, ',');
  return text;
}

TriangleMesh ReadMesh(const std::string& path) {
  const std::string extension = LowerExtension(path);
  if (extension != ".stl" && extension != ".obj" && extension != ".ply") FailExtension(path);
  const std::string bytes = ReadTextFile(path, kMaxMeshFileBytes);
  if (extension == ".stl") return Tidy(ReadStl(bytes, path), path);
  if (extension == ".obj") return Tidy(ReadObj(bytes, path), path);
  return Tidy(ReadPly(bytes, path), path);
}

void WriteMesh(const TriangleMesh& mesh, const std::string& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".obj") {
    WriteTextFile(path, FormatObj(mesh));
  } else if (extension == ".stl") {
    const vtkNew<vtkSTLWriter> writer;
    writer->SetFileTypeToBinary();
    writer->SetInputData(MakePolyData(mesh));
    WriteStl(*writer.Get(), path);
  } else if (extension == ".ply") {
    const vtkNew<vtkPLYWriter> writer;
    writer->SetFileTypeToBinary();
    writer->SetInputData(MakePolyData(mesh));
    WritePly(*writer.Get(), path);
  } else {
    FailExtension(path);
  }
}

void WriteColouredMesh(const TriangleMesh& mesh, const std::vector<Rgb8>& point_colours, const std::string& path) {
  if (LowerExtension(path) != ".ply") throw Error(fmt::format("{}: colours can only be written to a .ply", path));
  if (point_colours.size() != mesh.points.size()) {
    throw Error(fmt::format("{}: {} colours for {} points", path, point_colours.size(), mesh.points.size()));
  }
  const auto data = MakePolyData(mesh);
  const vtkNew<vtkUnsignedCharArray> colours;
  colours->SetName("colours");
  colours->SetNumberOfComponents(3);
  colours->SetNumberOfTuples(static_cast<vtkIdType>(point_colours.size()));
  for (std::size_t i = 0; i < point_colours.size(); ++i) {
    colours->SetTypedTuple(static_cast<vtkIdType>(i), point_colours[i].data());
  }
  data->GetPointData()->SetScalars(colours);
  const vtkNew<vtkPLYWriter> writer;
  writer->SetFileTypeToBinary();
  writer->SetArrayName("colours");
  writer->SetInputData(data);
  WritePly(*writer.Get(), path);
}

}  // namespace kerf
