#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>

#include "base/core/foreign_format.h"
#include "base/core/number_text.h"
#include "bone/mesh/read.h"
#include "bone/mesh/words.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kTextBytes = 80;
constexpr std::size_t kHeaderBytes = 84;  // the text and the count
constexpr std::size_t kTriangleBytes = 50;

bool IsWord(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](unsigned char a, char b) { return std::tolower(a) == b; });
}

// Returns whether the file begins like a text. A binary file may also begin with "solid", but has zeros soon after.
bool LooksLikeText(std::string_view bytes) {
  constexpr std::size_t kBegin = 1000;
  const std::string_view begin = SkipByteOrderMark(bytes).substr(0, kBegin);
  const std::string_view word = Words(begin).Next();
  return (IsWord(word, "solid") || IsWord(word, "facet")) && begin.find('\0') == std::string_view::npos;
}

// Returns whether the bytes can be triangles: not only zeros, with finite coordinates of a surface's size.
bool HoldsTriangles(std::string_view bytes) {
  constexpr float kMost = 1e6F;
  bool any = false;
  for (std::size_t at = 0; at + kTriangleBytes <= bytes.size(); at += kTriangleBytes) {
    for (std::size_t n = 3; n < 12; ++n) {
      float value = 0;
      std::memcpy(&value, bytes.data() + at + n * sizeof(float), sizeof(value));
      if (!(std::abs(value) < kMost) || (value != 0 && std::abs(value) < 1 / kMost)) return false;
      any |= value != 0;
    }
  }
  return any;
}

// Returns the number of triangles that a binary file holds.
std::size_t CountTriangles(std::string_view bytes, const std::string& path, MeshFile& file) {
  std::uint32_t stated = 0;
  std::memcpy(&stated, bytes.data() + kTextBytes, sizeof(stated));
  const std::uint64_t expected = kHeaderBytes + std::uint64_t{stated} * kTriangleBytes;
  if (bytes.size() == expected) return stated;
  const std::size_t room = (bytes.size() - kHeaderBytes) / kTriangleBytes;
  const bool is_whole = (bytes.size() - kHeaderBytes) % kTriangleBytes == 0;
  if (stated > 0 && expected < bytes.size()) {
    const std::string_view rest = bytes.substr(expected);
    if (!is_whole || !HoldsTriangles(rest)) {
      file.notes.push_back(
          fmt::format("the file has {} bytes behind its triangles, which were ignored", WithSeparators(rest.size())));
      return stated;
    }
  }
  if (is_whole) {
    file.notes.push_back(
        fmt::format("the STL states {} triangles, but its length is that of {}; it was read by its length",
                    WithSeparators(stated), WithSeparators(room)));
    return room;
  }
  throw Error(
      fmt::format("{}: the binary STL states {} triangles ({} bytes), but the file has {} bytes; it is cut "
                  "off or not an STL",
                  path, WithSeparators(stated), WithSeparators(expected), WithSeparators(bytes.size())));
}

// Reads a binary STL: 80 bytes of text, a 32-bit count, and for each triangle a normal, three points (floats) and two
// bytes.
MeshFile ReadBinaryStl(std::string_view bytes, const std::string& path) {
  MeshFile file;
  ReadComment(bytes.substr(0, kTextBytes), file);
  const std::size_t count = CountTriangles(bytes, path, file);
  CheckTriangles(count, path);
  TriangleMesh& mesh = file.mesh;
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
  return file;
}

float ParseCoordinate(std::string_view word, const std::string& path) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  float value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  // A number too small for a float is 0, as in scanf().
  if (error == std::errc::result_out_of_range && word.find("e-") != std::string_view::npos) return 0;
  if (error != std::errc() || word.empty() || end != word.data() + word.size()) {
    throw Error(fmt::format("{}: not a valid text STL: expected a number in a vertex, but found {}{}", path,
                            word.empty() ? "the end of the file" : fmt::format("'{}'", word.substr(0, 40)),
                            DescribeForeignNumber(word)));
  }
  return value;
}

// Reads consecutive solids; the normals of facets are ignored.
MeshFile ReadTextStl(std::string_view bytes, const std::string& path) {
  MeshFile file;
  TriangleMesh& mesh = file.mesh;
  Words words(SkipByteOrderMark(bytes));
  std::uint32_t corners = 0;  // of the triangle that is being read
  bool in_facet = false;      // before its 'endloop'
  bool ended = false;         // behind 'endsolid'
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
      in_facet = false;
    } else if (IsWord(word, "solid") || IsWord(word, "endsolid") || IsWord(word, "facet")) {
      in_facet = IsWord(word, "facet");
      ended = IsWord(word, "endsolid");
      const std::string_view line = words.TakeLine();
      if (IsWord(word, "solid")) ReadComment(line, file);
    } else if (ended) {
      file.notes.emplace_back("the file has text behind its last 'endsolid', which was ignored");
      break;
    } else if (!IsWord(word, "outer") && !IsWord(word, "loop") && !IsWord(word, "endfacet")) {
      if (!mesh.triangles.empty() && words.Next().empty()) break;  // cut off in a word
      throw Error(fmt::format("{}: not a valid text STL: unexpected word '{}'", path, word.substr(0, 40)));
    }
  }
  if (in_facet || corners != 0) throw Error(fmt::format("{}: the text STL is cut off: a facet has no 'endloop'", path));
  if (!ended) {
    file.notes.push_back(fmt::format("the text STL has no 'endsolid', so it may be cut off; its {} were read",
                                     FormatCount(mesh.triangles.size(), "whole facet", "whole facets")));
  }
  return file;
}

}  // namespace

MeshFile ReadStl(std::string_view bytes, const std::string& path) {
  if (LooksLikeText(bytes)) return ReadTextStl(bytes, path);
  if (bytes.size() < kHeaderBytes) throw Error(fmt::format("{}: not an STL file", path));
  return ReadBinaryStl(bytes, path);
}

}  // namespace kerf
