#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/core/foreign_format.h"
#include "bone/mesh/read.h"
#include "bone/mesh/words.h"
#include "kerf/error.h"

namespace kerf {
namespace {

template <typename Number>
bool ParseWord(std::string_view word, Number& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

/// Reads the points and faces of an OBJ line by line.
class ObjReader {
 public:
  ObjReader(std::string_view bytes, const std::string& path) : lines_(SkipByteOrderMark(bytes)), path_(path) {}

  MeshFile Read() {
    std::string_view line;
    while (NextLine(line)) {
      const std::string_view keyword = Words(line).Next();
      // Everything else (normals, textures, groups, lines, materials) does not affect the shape.
      if (keyword.starts_with('#')) ReadComment(line, file_);
      if (keyword == "v") ReadPoint(Join(line));
      if (keyword.starts_with("v;")) {
        Fail(fmt::format("expected three numbers after 'v'{}", DescribeForeignNumber(keyword.substr(1))));
      }
      if (keyword == "f") ReadFace(Join(line));
    }
    return std::move(file_);
  }

 private:
  bool NextLine(std::string_view& line) {
    ++next_number_;
    number_ = next_number_;
    return lines_.Next(line);
  }

  /// Appends the lines in which `line` is continued: each but the last ends in a backslash.
  std::string_view Join(std::string_view line) {
    if (!line.ends_with('\\')) return line;
    joined_.clear();
    while (line.ends_with('\\')) {
      joined_.append(line.substr(0, line.size() - 1)).push_back(' ');
      ++next_number_;
      if (!lines_.Next(line)) line = {};
    }
    return joined_.append(line);
  }

  void ReadPoint(std::string_view line) {
    Words words(line);
    words.Next();  // the keyword
    Vec3 p{0};
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = words.Next();
      if (word.empty()) Fail(fmt::format("expected three numbers after 'v', but found only {}", i));
      if (!ParseWord(word, p[i])) {
        Fail(fmt::format("expected three numbers after 'v', but found '{}'{}", word, DescribeForeignNumber(word)));
      }
    }
    file_.mesh.points.push_back(p);
  }

  /// Indices count from 1, or backwards from the last point if negative.
  void ReadFace(std::string_view line) {
    TriangleMesh& mesh = file_.mesh;
    Words words(line);
    words.Next();  // the keyword
    corners_.clear();
    for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
      const std::string_view point = word.substr(0, word.find('/'));
      const auto count = static_cast<std::int64_t>(mesh.points.size());
      std::int64_t index = 0;
      if (!ParseWord(point, index)) Fail(fmt::format("expected point numbers after 'f', but found '{}'", word));
      if (index < 0) index += count + 1;
      if (index < 1 || index > count) {
        Fail(fmt::format("a face uses point {}, but the number of points defined before it is {}; they count from 1",
                         point, count));
      }
      corners_.push_back(static_cast<std::uint32_t>(index - 1));
      CheckTriangles(mesh.triangles.size() + corners_.size(), path_);
    }
    if (corners_.size() < 3) Fail("a face needs at least three points");
    AddFace(corners_, path_, mesh);
  }

  [[noreturn]] void Fail(const std::string& what) const { throw Error(fmt::format("{}:{}: {}", path_, number_, what)); }

  Lines lines_;
  const std::string& path_;
  MeshFile file_;
  std::size_t number_ = 0;       // of the line, or of the first of several that are continued
  std::size_t next_number_ = 0;  // of the last line that was taken
  std::string joined_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

MeshFile ReadObj(std::string_view bytes, const std::string& path) {
  return ObjReader(bytes, path).Read();
}

}  // namespace kerf
