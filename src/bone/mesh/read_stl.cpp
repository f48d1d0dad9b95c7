#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>

#include "bone/mesh/read.h"
#include "bone/mesh/words.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kHeaderBytes = 84;  // 80 bytes of text, 4 of count
constexpr std::size_t kTriangleBytes = 50;

// Reads a binary STL: 80 arbitrary bytes, a 32-bit count, and for each triangle a normal, three points (floats) and two
// bytes.
TriangleMesh ReadBinaryStl(std::string_view bytes, const std::string& path) {
  const std::size_t count = (bytes.size() - kHeaderBytes) / kTriangleBytes;
  CheckTriangles(count, path);
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

bool IsWord(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](unsigned char a, char b) { return std::tolower(a) == b; });
}

float ParseCoordinate(std::string_view word, const std::string& path) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  float value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  // A number too small for a float is 0, as in scanf().
  if (error == std::errc::result_out_of_range && word.find("e-") != std::string_view::npos) return 0;
  if (error != std::errc() || word.empty() || end != word.data() + word.size()) {
    throw Error(fmt::format("{}: not a valid text STL: expected a number in a vertex, but found {}", path,
                            word.empty() ? "the end of the file" : fmt::format("'{}'", word.substr(0, 40))));
  }
  return value;
}

// Reads consecutive solids; the normals of facets are ignored.
TriangleMesh ReadTextStl(std::string_view bytes, const std::string& path) {
  TriangleMesh mesh;
  Words words(bytes);
  std::uint32_t corners = 0;  // of the triangle that is being read
  for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
    if (IsWord(word, "vertex")) {
      if (corners == 3) throw Error(fmt::format("{}: a facet of the text STL has more than three corners", path));
      Vec3 p{0};
      for (int i = 0; i < 3; ++i) p[i] = static_cast<double>(ParseCoordinate(words.Next(), path));
      mesh.points.push_back(p);
      ++corners;
    } else if (IsWord(word, "endloop")) {
      if (corners != 3)
        throw Error(fmt::format("{}: not a valid text STL: a facet has {} of 3 corners", path, corners));
      const auto end = static_cast<std::uint32_t>(mesh.points.size());
      mesh.triangles.push_back({end - 3, end - 2, end - 1});
      CheckTriangles(mesh.triangles.size(), path);
      corners = 0;
    } else if (IsWord(word, "solid") || IsWord(word, "endsolid") || IsWord(word, "facet")) {
      words.SkipLine();
    } else if (!IsWord(word, "outer") && !IsWord(word, "loop") && !IsWord(word, "endfacet")) {
      throw Error(fmt::format("{}: not a valid text STL: unexpected word '{}'", path, word.substr(0, 40)));
    }
  }
  if (corners != 0) throw Error(fmt::format("{}: not a valid text STL: a facet has no 'endloop'", path));
  return mesh;
}

}  // namespace

TriangleMesh ReadStl(std::string_view bytes, const std::string& path) {
  // Some binary files also begin with "solid", so the length is checked first.
  if (bytes.size() >= kHeaderBytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof(count));
    const std::uint64_t expected = kHeaderBytes + std::uint64_t{count} * kTriangleBytes;
    if (bytes.size() == expected) return ReadBinaryStl(bytes, path);
    const bool text = bytes.substr(0, 5) == "solid" && bytes.substr(0, 1024).find("facet") != std::string_view::npos;
    if (!text) {
      throw Error(
          fmt::format("{}: the binary STL states {} triangles ({} bytes), but the file has {} bytes; it is cut "
                      "off or not an STL",
                      path, WithSeparators(count), WithSeparators(expected), WithSeparators(bytes.size())));
    }
  }
  if (bytes.substr(0, 5) != "solid") throw Error(fmt::format("{}: not an STL file", path));
  if (bytes.rfind("endsolid") == std::string_view::npos) {
    throw Error(fmt::format("{}: the text STL has no 'endsolid'; it is cut off", path));
  }
  return ReadTextStl(bytes, path);
}

}  // namespace kerf
