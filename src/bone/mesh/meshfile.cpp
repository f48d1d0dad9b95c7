#include "bone/mesh/meshfile.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "base/core/printable.h"
#include "base/files/extension.h"
#include "base/files/files.h"
#include "bone/mesh/limits.h"
#include "bone/mesh/read.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Stands in the files that kerf writes. Their coordinates are mm, and SPACE= is as in files of 3D Slicer.
constexpr std::string_view kUnitMark = "kerf surface, mm";
constexpr std::string_view kHeader = "kerf surface, mm SPACE=LPS";

/// Sets the unit that a text states, as in "UNITS=mm" or "# File units: centimeters".
void FindUnit(std::string_view text, MeshFile& file) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kNames{{{"mm", " mm millimeter millimetre "},
                                                                                 {"cm", " cm centimeter centimetre "},
                                                                                 {"m", " m meter metre "},
                                                                                 {"in", " in inch inche "},
                                                                                 {"um", " um micron micrometer "}}};
  std::string lower(text.substr(0, 200));
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (std::size_t at = 0; (at = lower.find("unit", at)) != lower.npos;) {
    at += 4;
    const std::size_t sign = std::min(lower.find_first_not_of("s \t", at), lower.size());
    if (sign == lower.size() || (lower[sign] != '=' && lower[sign] != ':')) continue;
    const std::size_t word = std::min(lower.find_first_not_of(" \t", sign + 1), lower.size());
    std::size_t end = std::min(lower.find_first_not_of("abcdefghijklmnopqrstuvwxyz", word), lower.size());
    if (end > word + 2 && lower[end - 1] == 's') --end;
    if (end == word) continue;
    const std::string name = " " + lower.substr(word, end - word) + " ";
    for (const auto& [unit, names] : kNames) {
      if (names.find(name) != names.npos) {
        file.unit = unit;
        return;
      }
    }
    const bool is_last = lower.find_first_not_of(std::string_view(" \t\r\0", 4), end) == lower.npos;
    if (lower[sign] == '=' || is_last) file.unknown_unit = text.substr(word, end - word);
  }
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

// Merges coinciding points, and removes triangles with fewer than three different points and points without triangles.
TriangleMesh Tidy(const TriangleMesh& raw, const std::string& path) {
  TriangleMesh mesh;
  mesh.triangles.reserve(raw.triangles.size());
  std::unordered_map<Vec3, std::uint32_t, PointHash> ids;
  ids.reserve(raw.points.size());
  const auto id_of = [&](std::uint32_t raw_id) {
    const Vec3 p = raw.points[raw_id] + Vec3{0.0};  // -0 becomes +0, so that both are one point
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
  if (mesh.triangles.empty()) {
    throw Error(fmt::format(
        "{}: contains {}", path,
        raw.triangles.empty() && !raw.points.empty()
            ? "points but no triangles; a point cloud can't be imported: make a surface of it in a mesh program"
            : "no triangles"));
  }
  return mesh;
}

// Formats an OBJ. VTK's own writer is not used because it keeps only six digits.
std::string FormatObj(const TriangleMesh& mesh) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "# {}\n", kHeader);
  for (const Vec3& p : mesh.points) {
    fmt::format_to(out, "v {} {} {}\n", static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
  }
  for (const auto& t : mesh.triangles) fmt::format_to(out, "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return fmt::to_string(text);
}

/// Appends the bytes of a number as they are in memory: little-endian, as in STL and binary PLY.
template <typename Number>
void Append(std::string& bytes, Number number) {
  static_assert(std::endian::native == std::endian::little);
  std::array<char, sizeof(number)> raw{};
  std::memcpy(raw.data(), &number, sizeof(number));
  bytes.append(raw.data(), raw.size());
}

void AppendPoint(std::string& bytes, const Vec3& p) {
  for (const double coordinate : {p.x, p.y, p.z}) Append(bytes, static_cast<float>(coordinate));
}

/// Returns whether two points are one in the precision of a file.
bool IsOne(const Vec3& a, const Vec3& b) {
  const auto is_same = [](double x, double y) { return static_cast<float>(x) == static_cast<float>(y); };
  return is_same(a.x, b.x) && is_same(a.y, b.y) && is_same(a.z, b.z);
}

/// Formats a binary STL with the same bytes behind the header as VTK's writer. Triangles of which two corners are one
/// point are left out: an STL has no points of its own, and programs that join equal corners would find edges of more
/// than two triangles.
std::string FormatStl(const TriangleMesh& mesh) {
  constexpr std::size_t kHeaderBytes = 80;
  std::string bytes(kHeader);
  bytes.reserve(kHeaderBytes + 4 + 50 * mesh.triangles.size());
  bytes.resize(kHeaderBytes + 4);
  std::uint32_t count = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    if (IsOne(mesh.points[a], mesh.points[b]) || IsOne(mesh.points[b], mesh.points[c]) ||
        IsOne(mesh.points[c], mesh.points[a])) {
      continue;
    }
    ++count;
    const Vec3 normal = glm::cross(mesh.points[c] - mesh.points[b], mesh.points[a] - mesh.points[b]);
    const double length = glm::length(normal);
    AppendPoint(bytes, length > 0 ? normal / length : normal);
    for (const auto corner : {a, b, c}) AppendPoint(bytes, mesh.points[corner]);
    Append(bytes, std::uint16_t{0});
  }
  std::memcpy(bytes.data() + kHeaderBytes, &count, sizeof(count));
  return bytes;
}

/// Formats a binary PLY. `point_colours`: empty, or one for each point.
std::string FormatPly(const TriangleMesh& mesh, const std::vector<Rgb8>& point_colours) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\n{}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      kHeader, mesh.points.size(),
      point_colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n",
      mesh.triangles.size());
  text.reserve(text.size() + 15 * mesh.points.size() + 13 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    AppendPoint(text, mesh.points[i]);
    if (point_colours.empty()) continue;
    for (const auto channel : point_colours[i]) Append(text, channel);
  }
  for (const auto& t : mesh.triangles) {
    Append(text, std::uint8_t{3});
    for (const auto corner : t) Append(text, static_cast<std::int32_t>(corner));
  }
  return text;
}

}  // namespace

void CheckTriangles(std::size_t count, const std::string& path) {
  if (count <= kMaxTriangles) return;
  throw Error(fmt::format("{}: has more than the {} triangles that kerf reads; reduce it", path,
                          WithSeparators(kMaxTriangles)));
}

std::string WithSeparators(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3)
    text.insert(static_cast<std::size_t>(at), 1, ',');
  return text;
}

void ReadComment(std::string_view text, MeshFile& file) {
  constexpr std::string_view kKey = "SPACE=";
  constexpr std::size_t kLongestWord = 40;
  const auto is_border = [](char c) { return c == ' ' || c == '\t' || c == '\0' || c == '\r'; };
  if (text.find(kUnitMark) != text.npos && file.unit.empty()) file.unit = "mm";
  if (file.unit.empty()) FindUnit(text, file);
  for (std::size_t at = text.find(kKey); at != text.npos && file.space.empty(); at = text.find(kKey, at + 1)) {
    if (at > 0 && !is_border(text[at - 1])) continue;
    const std::string_view value = text.substr(at + kKey.size(), kLongestWord);
    const auto end = std::find_if(value.begin(), value.end(), is_border);
    const std::string word = Printable(std::string(value.begin(), end));
    (word == "RAS" || word == "LPS" ? file.space : file.unknown_space) = word;
  }
}

MeshFile ReadMeshFile(const std::string& path) {
  const std::string extension = LowerExtension(path);
  if (extension != ".stl" && extension != ".obj" && extension != ".ply") FailExtension(path);
  const std::string bytes = ReadTextFile(path, kMaxMeshFileBytes);
  const bool is_wide = bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF");
  if (is_wide && bytes.size() > 3 && (bytes[2] == '\0') != (bytes[3] == '\0')) {
    throw Error(fmt::format("{}: the file is text in UTF-16, which kerf doesn't read; save it as UTF-8", path));
  }
  MeshFile file = extension == ".stl"   ? ReadStl(bytes, path)
                  : extension == ".obj" ? ReadObj(bytes, path)
                                        : ReadPly(bytes, path);
  file.mesh = Tidy(file.mesh, path);
  return file;
}

void TurnToLps(MeshFile& file) {
  if (file.space.empty() && !file.unknown_space.empty()) {
    file.notes.push_back(
        fmt::format("the file says SPACE={}, which kerf does not know: LPS was assumed; --frame states another",
                    file.unknown_space));
  }
  if (file.space != "RAS") return;
  for (Vec3& p : file.mesh.points) p = Vec3(-p.x, -p.y, p.z) + 0.0;  // + 0.0: no negative zeros
  file.space = "LPS";
  file.notes.emplace_back("the file says SPACE=RAS, so x and y were turned to LPS");
}

TriangleMesh ReadMesh(const std::string& path) {
  MeshFile file = ReadMeshFile(path);
  TurnToLps(file);
  return std::move(file.mesh);
}

void WriteMesh(const TriangleMesh& mesh, const std::string& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".obj") {
    WriteTextFile(path, FormatObj(mesh));
  } else if (extension == ".stl") {
    WriteTextFile(path, FormatStl(mesh));
  } else if (extension == ".ply") {
    WriteTextFile(path, FormatPly(mesh, {}));
  } else {
    FailExtension(path);
  }
}

void WriteColouredMesh(const TriangleMesh& mesh, const std::vector<Rgb8>& point_colours, const std::string& path) {
  if (LowerExtension(path) != ".ply") throw Error(fmt::format("{}: colours can only be written to a .ply", path));
  if (point_colours.size() != mesh.points.size()) {
    throw Error(fmt::format("{}: {} colours for {} points", path, point_colours.size(), mesh.points.size()));
  }
  WriteTextFile(path, FormatPly(mesh, point_colours));
}

}  // namespace kerf
