#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>

#include "base/core/foreign_format.h"
#include "bone/mesh/read.h"
#include "bone/mesh/words.h"
#include "kerf/error.h"

namespace kerf {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat, kDouble };

std::optional<Type> TypeFromName(std::string_view name) {
  if (name == "char" || name == "int8") return Type::kInt8;
  if (name == "uchar" || name == "uint8") return Type::kUint8;
  if (name == "short" || name == "int16") return Type::kInt16;
  if (name == "ushort" || name == "uint16") return Type::kUint16;
  if (name == "int" || name == "int32") return Type::kInt32;
  if (name == "uint" || name == "uint32") return Type::kUint32;
  if (name == "int64") return Type::kInt64;
  if (name == "uint64") return Type::kUint64;
  if (name == "float" || name == "float32") return Type::kFloat;
  if (name == "double" || name == "float64") return Type::kDouble;
  return std::nullopt;
}

std::size_t SizeOf(Type type) {
  switch (type) {
    case Type::kInt8:
    case Type::kUint8:
      return 1;
    case Type::kInt16:
    case Type::kUint16:
      return 2;
    case Type::kInt32:
    case Type::kUint32:
    case Type::kFloat:
      return 4;
    case Type::kInt64:
    case Type::kUint64:
    case Type::kDouble:
      return 8;
  }
  return 0;
}

struct Property {
  std::string name;
  Type type;                  // of the value, or of each value of the list
  std::optional<Type> count;  // type of a list's length
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Format { kText, kLittleEndian, kBigEndian };

struct Header {
  Format format = Format::kText;
  std::vector<Element> elements;
};

// Reads the values after the header one by one.
class Body {
 public:
  Body(std::string_view bytes, Format format, const std::string& path) : rest_(bytes), format_(format), path_(path) {}

  double Next(Type type) { return format_ == Format::kText ? NextWord() : NextBinary(type); }
  std::size_t size() const { return rest_.size(); }
  // Returns the minimum number of bytes of one row of `element`.
  std::uint64_t SmallestRow(const Element& element) const {
    std::uint64_t sum = 0;
    for (const Property& p : element.properties) sum += format_ == Format::kText ? 2 : SizeOf(p.count.value_or(p.type));
    return sum;
  }

 private:
  [[noreturn]] void FailShort() const {
    throw Error(fmt::format("{}: the PLY is shorter than its header states", path_));
  }

  double NextWord() {
    constexpr std::string_view kBlank = " \t\r\n";
    const std::size_t begin = rest_.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) FailShort();
    const std::size_t end = std::min(rest_.find_first_of(kBlank, begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || stop != word.data() + word.size()) {
      throw Error(fmt::format("{}: expected a number in the PLY, but found '{}'{}", path_, word.substr(0, 40),
                              DescribeForeignNumber(word)));
    }
    return value;
  }

  template <typename T>
  double Take() {
    if (rest_.size() < sizeof(T)) FailShort();
    char raw[sizeof(T)];
    std::memcpy(raw, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    const bool file_is_little = format_ == Format::kLittleEndian;
    if (file_is_little != (std::endian::native == std::endian::little)) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return static_cast<double>(value);
  }

  double NextBinary(Type type) {
    switch (type) {
      case Type::kInt8:
        return Take<std::int8_t>();
      case Type::kUint8:
        return Take<std::uint8_t>();
      case Type::kInt16:
        return Take<std::int16_t>();
      case Type::kUint16:
        return Take<std::uint16_t>();
      case Type::kInt32:
        return Take<std::int32_t>();
      case Type::kUint32:
        return Take<std::uint32_t>();
      case Type::kInt64:
        return Take<std::int64_t>();
      case Type::kUint64:
        return Take<std::uint64_t>();
      case Type::kFloat:
        return Take<float>();
      case Type::kDouble:
        return Take<double>();
    }
    return 0;
  }

  std::string_view rest_;
  Format format_;
  const std::string& path_;
};

std::vector<std::string> SplitWords(std::string_view line) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  while ((begin = line.find_first_not_of(" \t\r", begin)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
    words.emplace_back(line.substr(begin, end - begin));
    begin = end;
  }
  return words;
}

// Parses the header and removes it from `bytes`. Its lines end in LF or CR LF, or all of them in CR.
Header TakeHeader(std::string_view& bytes, const std::string& path, MeshFile& file) {
  Header header;
  bool format_seen = false;
  const std::size_t first_end = bytes.find_first_of("\r\n");
  const char line_end =
      bytes.substr(std::min(first_end, bytes.size())).starts_with("\r") && !bytes.substr(first_end).starts_with("\r\n")
          ? '\r'
          : '\n';
  for (std::size_t number = 1;; ++number) {
    const std::size_t end = bytes.find(line_end);
    if (end == std::string_view::npos) throw Error(fmt::format("{}: the PLY header has no 'end_header'", path));
    const std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(end + 1);
    const std::vector<std::string> words = SplitWords(line);
    const auto fail = [&] {
      return Error(fmt::format("{}:{}: not a PLY header line: '{}'", path, number, line.substr(0, 60)));
    };
    if (number == 1) {
      if (words != std::vector<std::string>{"ply"}) throw Error(fmt::format("{}: not a PLY file", path));
      continue;
    }
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") {
      ReadComment(line, file);
      continue;
    }
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      if (words[1] == "ascii")
        header.format = Format::kText;
      else if (words[1] == "binary_little_endian")
        header.format = Format::kLittleEndian;
      else if (words[1] == "binary_big_endian")
        header.format = Format::kBigEndian;
      else
        throw fail();
      format_seen = true;
    } else if (words[0] == "element" && words.size() == 3) {
      Element element{words[1], 0, {}};
      const auto [stop, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
      if (error != std::errc() || *stop != '\0') throw fail();
      header.elements.push_back(std::move(element));
    } else if (words[0] == "property" && !header.elements.empty() && words.size() == 3 && TypeFromName(words[1])) {
      header.elements.back().properties.push_back({words[2], *TypeFromName(words[1]), std::nullopt});
    } else if (words[0] == "property" && !header.elements.empty() && words.size() == 5 && words[1] == "list" &&
               TypeFromName(words[2]) && TypeFromName(words[3])) {
      header.elements.back().properties.push_back({words[4], *TypeFromName(words[3]), TypeFromName(words[2])});
    } else {
      throw fail();
    }
  }
  if (!format_seen) throw Error(fmt::format("{}: the PLY header has no 'format'", path));
  return header;
}

// Reads the length of a list; throws if it has more values than the rest of the file has bytes.
std::uint64_t ReadLength(const Property& property, const Element& element, std::uint64_t row, Body& body,
                         const std::string& path) {
  const double length = body.Next(*property.count);
  if (!(length >= 0) || length > static_cast<double>(body.size())) {
    throw Error(fmt::format("{}: {} {} states a list of {} values, more than the file contains", path, element.name,
                            row + 1, length));
  }
  return static_cast<std::uint64_t>(length);
}

void ReadVertices(const Element& element, Body& body, const std::string& path, TriangleMesh& mesh) {
  mesh.points.reserve(element.count);
  for (std::uint64_t row = 0; row < element.count; ++row) {
    Vec3 p{0};
    for (const Property& property : element.properties) {
      if (property.count) {
        for (std::uint64_t n = ReadLength(property, element, row, body, path); n > 0; --n) body.Next(property.type);
        continue;
      }
      const double value = body.Next(property.type);
      if (property.name == "x") p.x = value;
      if (property.name == "y") p.y = value;
      if (property.name == "z") p.z = value;
    }
    mesh.points.push_back(p);
  }
}

// Adds the triangles of a strip, in which every other one is turned over; -1 ends a strip.
void AddStrip(const std::vector<std::int64_t>& strip, TriangleMesh& mesh) {
  std::size_t first = 0;
  for (std::size_t n = 0; n < strip.size(); ++n) {
    if (strip[n] < 0) first = n + 1;
    if (n < first + 2) continue;
    const auto at = [&strip](std::size_t i) { return static_cast<std::uint32_t>(strip[i]); };
    const bool is_turned = (n - first) % 2 == 1;
    mesh.triangles.push_back({at(n - (is_turned ? 1 : 2)), at(n - (is_turned ? 2 : 1)), at(n)});
  }
}

// Reads the rows of an element. Lists of point indices of an element 'face' are faces, those of 'tristrips' are strips
// of triangles; all else is ignored.
void ReadRows(const Element& element, Body& body, const std::string& path, TriangleMesh& mesh) {
  const bool is_strip = element.name == "tristrips";
  std::vector<std::int64_t> strip;
  std::vector<std::uint32_t> corners;
  for (std::uint64_t row = 0; row < element.count; ++row) {
    for (const Property& property : element.properties) {
      if (!property.count) {
        body.Next(property.type);
        continue;
      }
      const std::uint64_t length = ReadLength(property, element, row, body, path);
      const bool is_wanted = (is_strip || element.name == "face") &&
                             (property.name == "vertex_indices" || property.name == "vertex_index");
      if (is_wanted && !is_strip && length < 3) {
        throw Error(fmt::format("{}: face {} has {} points; at least three are required", path, row + 1, length));
      }
      if (is_wanted && length > 2) CheckTriangles(mesh.triangles.size() + static_cast<std::size_t>(length) - 2, path);
      strip.clear();
      for (std::uint64_t i = 0; i < length; ++i) {
        const double index = body.Next(property.type);
        if (!is_wanted) continue;
        const bool is_end = is_strip && index == -1;
        if (!is_end &&
            (!(index >= 0) || index >= static_cast<double>(mesh.points.size()) || index != std::floor(index))) {
          throw Error(fmt::format("{}: {} {} uses point {}, but {}", path, is_strip ? "strip" : "face", row + 1, index,
                                  mesh.points.empty() ? "no points are defined before it"
                                                      : fmt::format("the points are 0 to {}", mesh.points.size() - 1)));
        }
        strip.push_back(static_cast<std::int64_t>(index));
      }
      if (!is_wanted) continue;
      if (is_strip) {
        AddStrip(strip, mesh);
      } else {
        corners.assign(strip.begin(), strip.end());
        AddFace(corners, path, mesh);
      }
    }
  }
}

}  // namespace

MeshFile ReadPly(std::string_view bytes, const std::string& path) {
  bytes = SkipByteOrderMark(bytes);
  MeshFile file;
  const Header header = TakeHeader(bytes, path, file);
  Body body(bytes, header.format, path);
  for (const Element& element : header.elements) {
    // A count that needs more bytes than there are is refused before memory is allocated.
    const std::uint64_t row = body.SmallestRow(element);
    if (row == 0 ? element.count > 0 : element.count > (body.size() + 1) / row) {
      throw Error(fmt::format(
          "{}: the PLY states {} rows of element '{}', more than its {} bytes can hold; it is cut off or its header is "
          "wrong",
          path, WithSeparators(element.count), element.name, WithSeparators(bytes.size())));
    }
    const auto has = [&](const char* name) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& p) { return p.name == name && !p.count; });
    };
    if (element.name == "vertex") {
      if (!has("x") || !has("y") || !has("z")) throw Error(fmt::format("{}: the PLY's points lack x, y or z", path));
      ReadVertices(element, body, path, file.mesh);
    } else {
      ReadRows(element, body, path, file.mesh);
    }
  }
  return file;
}

}  // namespace kerf
