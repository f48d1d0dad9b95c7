#include "session/link/igtl_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <string_view>

#include "kerf/error.h"
#include "session/link/igtl_bytes.h"

namespace kerf {
namespace {

constexpr std::size_t kTypeBytes = 12;
constexpr std::size_t kDeviceBytes = 20;
constexpr std::uint8_t kDouble = 11;               // type of the values of an array
constexpr std::uint16_t kUtf8 = 106;               // number of the encoding in the list of the IANA
constexpr std::uint64_t kNewton = 0x0B1ULL << 50;  // a unit: no prefix, newton to the power of 1
constexpr std::uint16_t kStatusOk = 1, kStatusUnknownError = 2;
constexpr double kAxisTolerance = 1e-3;

/// Appends values in network order.
class Writer {
 public:
  template <std::unsigned_integral T>
  void Add(T value) {
    for (int shift = 8 * (static_cast<int>(sizeof(T)) - 1); shift >= 0; shift -= 8) {
      bytes_ += static_cast<char>(static_cast<unsigned char>(value >> shift));
    }
  }
  void AddFloat(double value) { Add(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void AddDouble(double value) { Add(std::bit_cast<std::uint64_t>(value)); }
  void AddPoint(const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) AddFloat(p[axis]);
  }
  /// Adds a text of a fixed length, with zeros at its end.
  void AddText(std::string_view text, std::size_t length) {
    bytes_ += text.substr(0, length);
    bytes_.append(length - std::min(length, text.size()), '\0');
  }
  void AddBytes(std::string_view bytes) { bytes_ += bytes; }
  void Reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::span<const std::uint8_t> AsBytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string ReadText(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t length) {
  const auto* begin = reinterpret_cast<const char*>(bytes.data()) + at;
  return {begin, std::find(begin, begin + length, '\0')};
}

std::string MakeMessage(const char* type, const IgtlStamp& stamp, const Writer& body) {
  Writer message;
  message.Reserve(IgtlHeader::kBytes + body.bytes().size());
  message.Add(std::uint16_t{1});
  message.AddText(type, kTypeBytes);
  message.AddText(stamp.device, kDeviceBytes);
  // Seconds and their binary fraction; 2^32 s, to which a double rounds the largest stamps, becomes the largest stamp.
  constexpr double kLargest = std::numeric_limits<std::uint32_t>::max();
  const double whole_s = std::clamp(std::floor(stamp.time_s), 0.0, kLargest);
  message.Add(static_cast<std::uint32_t>(whole_s));
  message.Add(static_cast<std::uint32_t>(std::clamp((stamp.time_s - whole_s) * 0x1p32, 0.0, kLargest)));
  message.Add(static_cast<std::uint64_t>(body.bytes().size()));
  message.Add(CalcIgtlCrc(AsBytes(body.bytes())));
  message.AddBytes(body.bytes());
  return message.bytes();
}

}  // namespace

std::string MakeIgtlTransform(const IgtlStamp& stamp, const Pose& X_WB) {
  const glm::dmat3 R = glm::mat3_cast(X_WB.R_AB);
  Writer body;
  for (int axis = 0; axis < 3; ++axis) body.AddPoint((axis < 2 ? -1.0 : 1.0) * TurnRas(R[axis]));
  body.AddPoint(TurnRas(X_WB.p_AB));
  return MakeMessage("TRANSFORM", stamp, body);
}

std::string MakeIgtlForce(const IgtlStamp& stamp, const Vec3& f_W_N) {
  Writer body;
  body.Add(std::uint8_t{3});
  body.Add(std::uint8_t{0});
  body.Add(kNewton);
  const Vec3 f_N = TurnRas(f_W_N);
  for (int axis = 0; axis < 3; ++axis) body.AddDouble(f_N[axis]);
  return MakeMessage("SENSOR", stamp, body);
}

std::string MakeIgtlNumbers(const IgtlStamp& stamp, std::span<const double> values) {
  const std::size_t count = std::min<std::size_t>(values.size(), std::numeric_limits<std::uint16_t>::max());
  Writer body;
  body.Add(kDouble);
  body.Add(std::uint8_t{1});
  body.Add(static_cast<std::uint16_t>(count));
  for (const double value : values.first(count)) body.AddDouble(value);
  return MakeMessage("NDARRAY", stamp, body);
}

std::string MakeIgtlText(const IgtlStamp& stamp, const std::string& text) {
  const std::size_t length = std::min<std::size_t>(text.size(), std::numeric_limits<std::uint16_t>::max());
  Writer body;
  body.Add(kUtf8);
  body.Add(static_cast<std::uint16_t>(length));
  body.AddText(text, length);
  return MakeMessage("STRING", stamp, body);
}

std::string MakeIgtlStatus(const IgtlStamp& stamp, bool failed, const std::string& sentence) {
  Writer body;
  body.Add(failed ? kStatusUnknownError : kStatusOk);
  body.Add(std::uint64_t{0});
  body.AddText(failed ? "failed" : "", kDeviceBytes);
  body.AddText(sentence, sentence.size() + 1);
  return MakeMessage("STATUS", stamp, body);
}

std::string MakeIgtlSurface(const IgtlStamp& stamp, const TriangleMesh& mesh_W) {
  constexpr std::uint32_t kTriangleBytes = 4 * 4;
  const auto points = static_cast<std::uint32_t>(mesh_W.points.size());
  const auto triangles = static_cast<std::uint32_t>(mesh_W.triangles.size());
  Writer body;
  body.Reserve(40 + 12 * std::size_t{points} + kTriangleBytes * std::size_t{triangles});
  // Points, then number and bytes of: vertices, lines, polygons, strips; attributes.
  for (const std::uint32_t number : {points, 0u, 0u, 0u, 0u, triangles, kTriangleBytes * triangles, 0u, 0u, 0u}) {
    body.Add(number);
  }
  for (const Vec3& p : mesh_W.points) body.AddPoint(TurnRas(p));
  for (const auto& triangle : mesh_W.triangles) {
    body.Add(std::uint32_t{3});
    for (const std::uint32_t corner : triangle) body.Add(corner);
  }
  return MakeMessage("POLYDATA", stamp, body);
}

// CRC-64 of ECMA-182, from 0, without reflection.
std::uint64_t CalcIgtlCrc(std::span<const std::uint8_t> body) {
  static const std::array<std::uint64_t, 256> table = [] {
    constexpr std::uint64_t kPolynomial = 0x42F0E1EBA9EA3693;
    std::array<std::uint64_t, 256> made{};
    for (std::size_t i = 0; i < made.size(); ++i) {
      std::uint64_t crc = static_cast<std::uint64_t>(i) << 56;
      for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ ((crc >> 63) != 0 ? kPolynomial : 0);
      made[i] = crc;
    }
    return made;
  }();
  std::uint64_t crc = 0;
  for (const std::uint8_t byte : body) crc = table[(crc >> 56) ^ byte] ^ (crc << 8);
  return crc;
}

IgtlHeader ReadIgtlHeader(std::span<const std::uint8_t, IgtlHeader::kBytes> bytes) {
  IgtlHeader header;
  header.version = ReadBig<std::uint16_t>(bytes, 0);
  if (header.version < 1 || header.version > 3) {
    throw Error(fmt::format("a message has the protocol version {}, not 1 to 3", header.version));
  }
  header.type = ReadText(bytes, 2, kTypeBytes);
  header.device = ReadText(bytes, 2 + kTypeBytes, kDeviceBytes);
  const auto is_plain = [](char c) { return c >= ' ' && c <= '~'; };
  if (header.type.empty() || !std::all_of(header.type.begin(), header.type.end(), is_plain)) {
    throw Error("a message has no readable type");
  }
  header.time_s = ReadBig<std::uint32_t>(bytes, 34) + 0x1p-32 * ReadBig<std::uint32_t>(bytes, 38);
  header.body_bytes = ReadBig<std::uint64_t>(bytes, 42);
  header.crc = ReadBig<std::uint64_t>(bytes, 50);
  return header;
}

std::span<const std::uint8_t> CheckIgtlBody(const IgtlHeader& header, std::span<const std::uint8_t> body) {
  if (body.size() != header.body_bytes || CalcIgtlCrc(body) != header.crc) {
    throw Error(fmt::format("the checksum of a message of type {} is wrong", header.type));
  }
  if (header.version == 1) return body;
  // Protocol 2: bytes of this header, of the metadata's header and of the metadata; number of the message.
  constexpr std::size_t kLeast = 12;
  const std::size_t first = body.size() < kLeast ? 0 : ReadBig<std::uint16_t>(body, 0);
  const std::uint64_t last =
      body.size() < kLeast ? 0 : std::uint64_t{ReadBig<std::uint16_t>(body, 2)} + ReadBig<std::uint32_t>(body, 4);
  if (first < kLeast || first > body.size() || last > body.size() - first) {
    throw Error(fmt::format("the additional header of a message of type {} is invalid", header.type));
  }
  return body.subspan(first, body.size() - first - static_cast<std::size_t>(last));
}

Pose ReadIgtlTransform(std::span<const std::uint8_t> content) {
  constexpr std::size_t kBytes = 48;
  if (content.size() != kBytes) {
    throw Error(fmt::format("a TRANSFORM message has {} bytes, not {}", content.size(), kBytes));
  }
  glm::dmat3 R(1);
  Vec3 p(0);
  for (int column = 0; column < 4; ++column) {
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis) {
      v[axis] = ReadBigFloat(content, 4 * static_cast<std::size_t>(3 * column + axis));
      if (!std::isfinite(v[axis])) throw Error("a TRANSFORM message has a number that is not finite");
    }
    if (column < 3) {
      R[column] = (column < 2 ? -1.0 : 1.0) * TurnRas(v);
    } else {
      p = TurnRas(v);
    }
  }
  const glm::dmat3 RtR = glm::transpose(R) * R;
  double error = std::abs(glm::determinant(R) - 1);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) error = std::max(error, std::abs(RtR[i][j] - (i == j ? 1 : 0)));
  }
  if (!(error <= kAxisTolerance)) throw Error("the axes of a TRANSFORM message are no rotation");
  return {glm::normalize(glm::quat_cast(R)), p};
}

std::vector<Vec3> ReadIgtlPoints(std::span<const std::uint8_t> content) {
  constexpr std::size_t kPointBytes = 136;
  constexpr std::size_t kPlace = 100;  // after name, group and colour
  if (content.empty()) throw Error("a POINT message contains no points");
  if (content.size() % kPointBytes != 0) {
    throw Error(fmt::format("a POINT message has {} bytes, not a multiple of {}", content.size(), kPointBytes));
  }
  std::vector<Vec3> points;
  points.reserve(content.size() / kPointBytes);
  for (std::size_t at = kPlace; at < content.size(); at += kPointBytes) {
    const Vec3 p(ReadBigFloat(content, at), ReadBigFloat(content, at + 4), ReadBigFloat(content, at + 8));
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw Error("a POINT message has a number that is not finite");
    }
    points.push_back(TurnRas(p));
  }
  return points;
}

}  // namespace kerf
