// Messages of OpenIGTLink (protocol 1 and 2, http://openigtlink.org): their bytes, without sockets.
//
// Lengths are mm. The protocol's frame, and that of 3D Slicer, is right-anterior-superior (RAS); kerf's is
// left-posterior-superior (LPS). All functions take and return kerf's frame and convert.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

struct IgtlHeader {
  static constexpr std::size_t kBytes = 58;
  int version = 1;
  std::string type;    // "TRANSFORM", at most 12 characters
  std::string device;  // name of what the message is about, at most 20 characters
  double time_s = 0;   // since 1970, UTC; 0: none
  std::uint64_t body_bytes = 0;
  std::uint64_t crc = 0;  // of the body
};

/// Names and times of a message to be sent. A longer name is cut off.
struct IgtlStamp {
  std::string device;
  double time_s = 0;
};

// ---- to be sent: whole messages, with their headers

/// A pose of the frame B in the world, X_WB. In the message, the axes of B are turned as those of the world.
std::string MakeIgtlTransform(const IgtlStamp& stamp, const Pose& X_WB);
/// The components of a force in N, at most 255 values.
std::string MakeIgtlForce(const IgtlStamp& stamp, const Vec3& f_W_N);
/// A row of numbers of any meaning, at most 65535.
std::string MakeIgtlNumbers(const IgtlStamp& stamp, std::span<const double> values);
/// A text in UTF-8; at most 65535 bytes are sent.
std::string MakeIgtlText(const IgtlStamp& stamp, const std::string& text);
/// A state in words. `failed`: it is the reason of a failure.
std::string MakeIgtlStatus(const IgtlStamp& stamp, bool failed, const std::string& sentence);
/// A closed surface in the world.
std::string MakeIgtlSurface(const IgtlStamp& stamp, const TriangleMesh& mesh_W);

/// Returns the checksum of a body.
std::uint64_t CalcIgtlCrc(std::span<const std::uint8_t> body);

// ---- received. These throw kerf::Error with one sentence for bytes that are no such message.

IgtlHeader ReadIgtlHeader(std::span<const std::uint8_t, IgtlHeader::kBytes> bytes);
/// Checks the body's checksum and returns the content: without the additional header and the metadata of protocol 2.
std::span<const std::uint8_t> CheckIgtlBody(const IgtlHeader& header, std::span<const std::uint8_t> body);
/// Reads the content of a TRANSFORM. The axes must be orthogonal, of unit length and right-handed to within 1e-3; they
/// are made so exactly.
Pose ReadIgtlTransform(std::span<const std::uint8_t> content);
/// Reads the places of the points of a POINT message; their names, colours and owners are skipped.
std::vector<Vec3> ReadIgtlPoints(std::span<const std::uint8_t> content);

}  // namespace kerf
