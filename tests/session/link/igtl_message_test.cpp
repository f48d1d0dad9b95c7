// Messages of OpenIGTLink against the protocol's own library, which packs and unpacks them independently.
#include "session/link/igtl_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <igtlNDArrayMessage.h>
#include <igtlPolyDataMessage.h>
#include <igtlSensorMessage.h>
#include <igtlStatusMessage.h>
#include <igtlStringMessage.h>
#include <igtlTransformMessage.h>
#include <igtlUnit.h>
#include <igtl_util.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <utility>

#include "support/message_of.h"

namespace kerf {
namespace {

using test::MessageOf;
using testing::HasSubstr;

std::span<const std::uint8_t> BytesOf(const std::string& text, std::size_t from = 0) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()) + from, text.size() - from};
}

IgtlHeader HeaderOf(const std::string& message) {
  return ReadIgtlHeader(BytesOf(message).first<IgtlHeader::kBytes>());
}

/// Unpacks a message with the library, which checks its checksum.
template <typename Message>
typename Message::Pointer Unpack(const std::string& bytes) {
  igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
  header->InitPack();
  std::memcpy(header->GetPackPointer(), bytes.data(), IgtlHeader::kBytes);
  EXPECT_TRUE((header->Unpack() & igtl::MessageHeader::UNPACK_HEADER) != 0);
  EXPECT_EQ(header->GetBodySizeToRead(), bytes.size() - IgtlHeader::kBytes);
  typename Message::Pointer message = Message::New();
  message->SetMessageHeader(header);
  message->AllocatePack();
  std::memcpy(message->GetPackBodyPointer(), bytes.data() + IgtlHeader::kBytes, bytes.size() - IgtlHeader::kBytes);
  EXPECT_TRUE((message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) != 0);
  return message;
}

template <typename Message>
std::string Pack(Message& message) {
  message.Pack();
  return {static_cast<const char*>(message.GetPackPointer()), static_cast<std::size_t>(message.GetPackSize())};
}

const Pose kPose{glm::angleAxis(0.7, glm::normalize(Vec3(1, -2, 3))), {12.5, -3.25, 80}};

TEST(IgtlMessages, TransformsAreThoseOfTheLibraryInRas) {
  const std::string bytes = MakeIgtlTransform({"kerf_tool", 1.5}, kPose);
  const igtl::TransformMessage::Pointer message = Unpack<igtl::TransformMessage>(bytes);
  EXPECT_STREQ(message->GetDeviceName(), "kerf_tool");
  unsigned int s = 0, fraction = 0;
  message->GetTimeStamp(&s, &fraction);
  EXPECT_EQ(s, 1U);
  EXPECT_EQ(fraction, 0x80000000U);  // of 2^32
  igtl::Matrix4x4 m;
  message->GetMatrix(m);
  // A point of the tool and its place, both with x and y negated; 12 float numbers of up to 100 mm round to 4e-6 mm.
  const Vec3 p_T(3, 4, 5), p_W = kPose.Point(p_T);
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;
    const std::array<double, 4> r{m[row][0], m[row][1], m[row][2], m[row][3]};
    EXPECT_NEAR(-r[0] * p_T.x - r[1] * p_T.y + r[2] * p_T.z + r[3], sign * p_W[row], 5e-5);
  }

  const IgtlHeader header = HeaderOf(bytes);
  EXPECT_EQ(header.type, "TRANSFORM");
  EXPECT_EQ(header.device, "kerf_tool");
  EXPECT_DOUBLE_EQ(header.time_s, 1.5);
  const Pose read = ReadIgtlTransform(CheckIgtlBody(header, BytesOf(bytes, IgtlHeader::kBytes)));
  EXPECT_LT(glm::length(read.Point(p_T) - p_W), 5e-5);
}

TEST(IgtlMessages, TimesOutsideTheStampAreItsLimits) {
  for (const auto& [time_s, expected_s] : {std::pair{0x1p32, 0xFFFFFFFFU}, {1e300, 0xFFFFFFFFU}, {-1.0, 0U}}) {
    const std::string bytes = MakeIgtlTransform({"kerf_tool", time_s}, kPose);
    unsigned int s = 1, fraction = 0;
    Unpack<igtl::TransformMessage>(bytes)->GetTimeStamp(&s, &fraction);
    EXPECT_EQ(s, expected_s);
    EXPECT_EQ(fraction, expected_s) << "of 2^32";
  }
}

/// Appends a number in network order.
void Append(std::uint64_t value, int bytes, std::string& text) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) text += static_cast<char>(value >> shift);
}

/// Returns a message of protocol 1 as one of header version 2, as 3D Slicer sends it, with metadata.
std::string ToVersion2(const std::string& message, std::uint32_t metadata_bytes) {
  const std::string metadata_head("\0\1\0\4\0\3\0\0\0\6", 10), metadata = "froma test";
  std::string body;
  Append(12, 2, body);
  Append(metadata_head.size(), 2, body);
  Append(metadata_bytes, 4, body);
  Append(77, 4, body);  // number of the message
  body += message.substr(IgtlHeader::kBytes) + metadata_head + metadata;
  std::string changed = message.substr(0, 42);
  changed[1] = 2;
  Append(body.size(), 8, changed);
  Append(crc64(reinterpret_cast<unsigned char*>(body.data()), body.size(), 0), 8, changed);
  return changed + body;
}

TEST(IgtlMessages, TransformsOfTheLibraryAreReadInBothVersions) {
  igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
  message->SetDeviceName("plane");
  igtl::Matrix4x4 m;
  igtl::IdentityMatrix(m);
  m[0][3] = 10;  // to the right
  m[1][3] = 20;  // to the front
  m[2][3] = 30;
  message->SetMatrix(m);
  const std::string bytes = Pack(*message);
  const auto read = [](const std::string& text) {
    const IgtlHeader header = HeaderOf(text);
    return ReadIgtlTransform(CheckIgtlBody(header, BytesOf(text, IgtlHeader::kBytes)));
  };
  for (const std::string& version : {bytes, ToVersion2(bytes, 10)}) {
    const Pose X = read(version);
    EXPECT_EQ(X.p_AB, Vec3(-10, -20, 30));
    EXPECT_NEAR(std::abs(X.R_AB.w), 1, 1e-12);
  }
  EXPECT_THAT(MessageOf([&] { read(ToVersion2(bytes, 4'000'000'000)); }), HasSubstr("additional header"));
}

TEST(IgtlMessages, ForcesNumbersTextsAndStatusAreThoseOfTheLibrary) {
  const auto force = Unpack<igtl::SensorMessage>(MakeIgtlForce({"kerf_force", 0}, {1, 2, 3}));
  ASSERT_EQ(force->GetLength(), 3U);
  EXPECT_EQ(force->GetValue(0), -1);
  EXPECT_EQ(force->GetValue(1), -2);
  EXPECT_EQ(force->GetValue(2), 3);
  igtl::Unit::Pointer newton = igtl::Unit::New();
  newton->Append(igtl::Unit::SI_DERIVED_NEWTON, 1);
  EXPECT_EQ(force->GetUnit(), newton->Pack());

  const std::array<double, 3> values{0.25, -1e300, 7};
  const auto numbers = Unpack<igtl::NDArrayMessage>(MakeIgtlNumbers({"kerf_numbers", 0}, values));
  EXPECT_EQ(numbers->GetType(), igtl::NDArrayMessage::TYPE_FLOAT64);
  ASSERT_EQ(numbers->GetArray()->GetRawArraySize(), sizeof(values));
  std::array<double, 3> unpacked{};
  std::memcpy(unpacked.data(), numbers->GetArray()->GetRawArray(), sizeof(unpacked));
  EXPECT_EQ(unpacked, values);

  const auto text = Unpack<igtl::StringMessage>(MakeIgtlText({"kerf_names", 0}, "mm\u00b3"));
  EXPECT_STREQ(text->GetString(), "mm\u00b3");

  const auto status = Unpack<igtl::StatusMessage>(MakeIgtlStatus({"kerf", 0}, false, "cutting"));
  EXPECT_EQ(status->GetCode(), igtl::StatusMessage::STATUS_OK);
  EXPECT_STREQ(status->GetStatusString(), "cutting");
}

TEST(IgtlMessages, SurfacesAreThoseOfTheLibrary) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  const auto message = Unpack<igtl::PolyDataMessage>(MakeIgtlSurface({"kerf_bone", 0}, mesh));
  ASSERT_EQ(message->GetPoints()->GetNumberOfPoints(), 4);
  std::array<float, 3> p{};
  message->GetPoints()->GetPoint(2, p.data());
  EXPECT_EQ(p, (std::array<float, 3>{0, -2, 0}));
  ASSERT_EQ(message->GetPolygons()->GetNumberOfCells(), 4U);
  for (unsigned int i = 0; i < 4; ++i) {
    ASSERT_EQ(message->GetPolygons()->GetCellSize(i), 3U);
    std::array<std::uint32_t, 3> corners{};
    message->GetPolygons()->GetCell(i, corners.data());
    EXPECT_EQ(corners, mesh.triangles[i]);
  }
}

TEST(IgtlMessages, InvalidOnesAreRefusedWithOneSentence) {
  const std::string good = MakeIgtlTransform({"plane", 0}, kPose);
  const auto read = [](std::string bytes) {
    return MessageOf([&] {
      const IgtlHeader header = HeaderOf(bytes);
      ReadIgtlTransform(CheckIgtlBody(header, BytesOf(bytes, IgtlHeader::kBytes)));
    });
  };
  EXPECT_EQ(read(good), "");
  std::string bad = good;
  bad[1] = 9;
  EXPECT_THAT(read(bad), HasSubstr("protocol version 9"));
  bad = good;
  bad[2] = '\x01';
  EXPECT_THAT(read(bad), HasSubstr("no readable type"));
  for (std::size_t at = IgtlHeader::kBytes; at < good.size(); ++at) {  // each byte counts
    bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    ASSERT_THAT(read(bad), HasSubstr("checksum of a message of type TRANSFORM is wrong")) << at;
  }
  // A rotation that is none, with a right checksum.
  igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
  igtl::Matrix4x4 m;
  const auto with = [&](int row, int column, float value) {
    igtl::IdentityMatrix(m);
    m[row][column] = value;
    message->SetMatrix(m);
    return read(Pack(*message));
  };
  EXPECT_EQ(with(0, 3, 5), "");
  EXPECT_THAT(with(0, 0, 2), HasSubstr("no rotation"));
  EXPECT_THAT(with(0, 0, -1), HasSubstr("no rotation"));  // left-handed
  EXPECT_THAT(with(1, 3, std::numeric_limits<float>::quiet_NaN()), HasSubstr("not finite"));
  EXPECT_THAT(read(MakeIgtlText({"plane", 0}, "x")), HasSubstr("not 48"));
}

}  // namespace
}  // namespace kerf
