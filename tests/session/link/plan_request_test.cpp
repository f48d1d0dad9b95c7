// Changes of a plan that a peer asks for, as messages that the protocol's own library packs.
#include "session/link/plan_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <igtlPointMessage.h>
#include <igtlTransformMessage.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "support/message_of.h"

namespace kerf {
namespace {

using test::MessageOf;
using testing::HasSubstr;

const Box3 kBone_W{{-40, -30, -20}, {40, 30, 20}};

/// Header and content of a message, as the server passes them on.
struct Message {
  IgtlHeader header;
  std::vector<std::uint8_t> content;

  PlanRequest Read() const { return ReadPlanRequest(header, content, kBone_W); }
};

template <typename Packed>
Message PackToRead(Packed& message) {
  message.Pack();
  const auto* bytes = static_cast<const std::uint8_t*>(message.GetPackPointer());
  return {ReadIgtlHeader(std::span<const std::uint8_t, IgtlHeader::kBytes>(bytes, IgtlHeader::kBytes)),
          {bytes + IgtlHeader::kBytes, bytes + message.GetPackSize()}};
}

/// A plane as 3D Slicer shows it: centre, x axis and normal in RAS.
Message MakePlane(const std::string& name, const Vec3& p_R, const Vec3& x_R, const Vec3& n_R) {
  const Vec3 y_R = glm::cross(n_R, x_R);
  igtl::Matrix4x4 m = {};
  for (int row = 0; row < 3; ++row) {
    m[row][0] = static_cast<float>(x_R[row]);
    m[row][1] = static_cast<float>(y_R[row]);
    m[row][2] = static_cast<float>(n_R[row]);
    m[row][3] = static_cast<float>(p_R[row]);
  }
  m[3][3] = 1;
  const igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
  message->SetDeviceName(name.c_str());
  message->SetMatrix(m);
  return PackToRead(*message);
}

Message MakePoints(const std::string& name, const std::vector<Vec3>& points_R) {
  const igtl::PointMessage::Pointer message = igtl::PointMessage::New();
  message->SetDeviceName(name.c_str());
  for (const Vec3& p : points_R) {
    igtl::PointElement::Pointer element = igtl::PointElement::New();
    element->SetName("a point");
    element->SetPosition(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
    message->AddPointElement(element);
  }
  return PackToRead(*message);
}

struct Content {
  Plan plan{.planes = {{.name = "left", .plane = {{1, 2, 3}, {0, 0, 1}}, .width_mm = 31},
                       {.name = "a name of more than twenty characters", .plane = {{4, 5, 6}, {1, 0, 0}}}},
            .stops = {}};
  std::vector<Mark> marks;

  void Take(const Message& message) { Apply(message.Read(), plan, marks); }
};

void ExpectNear(const Vec3& v, const Vec3& expected) {
  EXPECT_LT(glm::length(v - expected), 1e-5) << v.x << " " << v.y << " " << v.z;
}

TEST(PlanRequest, APoseInRasMovesThePlaneOfItsName) {
  Content content;
  const Vec3 n_R = glm::normalize(Vec3(1, 2, -2)), x_R = glm::normalize(glm::cross(n_R, Vec3(0, 0, 1)));
  content.Take(MakePlane("left", {10, -20, 30}, x_R, n_R));
  const PlannedPlane& plane = content.plan.planes[0];
  ExpectNear(plane.plane.p_W, {-10, 20, 30});
  ExpectNear(plane.plane.normal_W, Vec3(-1, -2, -2) / 3.0);
  const Vec3 y_R = glm::cross(n_R, x_R);
  ExpectNear(plane.up_W, {-y_R.x, -y_R.y, y_R.z});
  EXPECT_EQ(plane.width_mm, 31);  // what the message does not say stays
  EXPECT_EQ(content.plan.planes.size(), 2U);
}

TEST(PlanRequest, OnlyThePrefixAddsAPlaneAndANameThatWasCutOffIsFound) {
  Content content;
  const auto at = [](const std::string& name) { return MakePlane(name, {0, 0, 7}, {1, 0, 0}, {0, 0, 1}); };
  EXPECT_THAT(MessageOf([&] { content.Take(at("tracker")); }), HasSubstr("the plan has no plane 'tracker'"));
  content.Take(at("kerf_plan/left"));
  ASSERT_EQ(content.plan.planes.size(), 2U);
  ExpectNear(content.plan.planes[0].plane.p_W, {0, 0, 7});
  content.Take(at("kerf_plan/right"));
  ASSERT_EQ(content.plan.planes.size(), 3U);
  EXPECT_EQ(content.plan.planes[2].name, "right");
  content.Take(at("a name of more than twenty characters"));  // the library cuts it off
  ExpectNear(content.plan.planes[1].plane.p_W, {0, 0, 7});
  EXPECT_EQ(content.plan.planes.size(), 3U);
  EXPECT_THAT(MessageOf([&] { content.Take(at("kerf_plan/")); }), HasSubstr("does not name a plane"));
}

TEST(PlanRequest, PointsGiveThePlaneThroughThemOrTheNerve) {
  Content content;
  // The plane x = 5 in RAS, clockwise and then counter-clockwise as seen from its new normal.
  content.Take(MakePoints("left", {{5, 0, 0}, {5, 0, 9}, {5, 9, 0}}));
  ExpectNear(content.plan.planes[0].plane.p_W, {-5, -3, 3});
  const Vec3 normal_W = content.plan.planes[0].plane.normal_W;
  EXPECT_NEAR(std::abs(normal_W.x), 1, 1e-9);
  content.Take(MakePoints("left", {{5, 0, 0}, {5, 9, 0}, {5, 0, 9}}));
  ExpectNear(content.plan.planes[0].plane.normal_W, normal_W);  // on the same side as before
  const std::vector<Vec3> nerve_R{{1, 2, 3}, {4, 5, 6}};
  content.Take(MakePoints("nerve", nerve_R));
  ASSERT_EQ(content.marks.size(), 1U);
  EXPECT_EQ(content.marks[0].kind, MarkKind::kNerve);
  ExpectNear(content.marks[0].points_W[1], {-4, -5, 6});
  content.marks[0].radius_mm = 2;
  content.Take(MakePoints("nerve", {{7, 8, 9}, {7, 8, 9}, {7, 8, 11}}));
  ASSERT_EQ(content.marks.size(), 1U);
  EXPECT_EQ(content.marks[0].points_W.size(), 3U);
  EXPECT_EQ(content.marks[0].radius_mm, 2);
  content.marks[0].kind = MarkKind::kLesion;
  content.Take(MakePoints("nerve", {{7, 8, 9}}));  // a ball
  EXPECT_EQ(content.marks[0].points_W.size(), 1U);
}

TEST(PlanRequest, RefusesWhatIsNotPossibleAndChangesNothing) {
  Content content;
  const auto refusal = [&content](const Message& message) { return MessageOf([&] { content.Take(message); }); };
  EXPECT_THAT(refusal(MakePoints("left", {{1, 1, 1}, {2, 2, 2}})), HasSubstr("a plane needs three"));
  EXPECT_THAT(refusal(MakePoints("left", {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}})), HasSubstr("lie on a line"));
  EXPECT_THAT(refusal(MakePlane("left", {-1041, 0, 0}, {1, 0, 0}, {0, 0, 1})), HasSubstr("1001 mm away from the bone"));
  EXPECT_THAT(refusal(MakePoints("nerve", {{0, 0, -1030}})), HasSubstr("1010 mm away"));
  EXPECT_THAT(refusal(MakePoints("nerve", std::vector<Vec3>(kMaxMarkPoints + 1))), HasSubstr("the limit is 1000"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(MakePlane("left", {nan, 0, 0}, {1, 0, 0}, {0, 0, 1})), HasSubstr("not finite"));
  EXPECT_THAT(refusal(MakePoints("nerve", {{0, nan, 0}})), HasSubstr("not finite"));
  EXPECT_THAT(refusal(MakePlane("left", {0, 0, 0}, {2, 0, 0}, {0, 0, 1})), HasSubstr("no rotation"));
  Message cut_off = MakePoints("nerve", {{0, 0, 0}});
  cut_off.content.pop_back();
  EXPECT_THAT(refusal(cut_off), HasSubstr("has 135 bytes"));
  EXPECT_EQ(refusal(MakePoints("nerve", {})), "a POINT message contains no points");
  for (const std::size_t count : {1U, 5U}) {
    EXPECT_EQ(refusal(MakePoints("nerve", std::vector<Vec3>(count, Vec3(1, 2, 3)))),
              "the nerve 'nerve' needs at least two points at different places");
  }
  EXPECT_THAT(refusal(MakePlane("kerf_plan/a\xff", {0, 0, 0}, {1, 0, 0}, {0, 0, 1})), HasSubstr("'a?' is no text"));
  EXPECT_EQ(content.plan.planes.size(), 2U);
  EXPECT_EQ(content.plan.planes[0].plane.p_W, Vec3(1, 2, 3));
  EXPECT_TRUE(content.marks.empty());
}

TEST(PlanInbox, KeepsTheNewestOfEachNameWithinItsLimit) {
  PlanInbox inbox;
  const auto send = [&inbox](const Message& message) { inbox.Take(message.header, message.content); };
  const auto at = [](const std::string& name, double z_mm) {
    return MakePlane(name, {0, 0, z_mm}, {1, 0, 0}, {0, 0, 1});
  };
  EXPECT_THAT(MessageOf([&] { send(at("left", 1)); }), HasSubstr("cannot be changed"));
  inbox.Open(kBone_W);
  for (int i = 0; i < 1000; ++i) send(at("left", i));
  send(MakePoints("left", {{0, 0, 0}}));
  const std::vector<PlanRequest> waiting = inbox.Fetch();
  ASSERT_EQ(waiting.size(), 2U);
  EXPECT_EQ(waiting[0].X_WP->p_AB.z, 999);
  EXPECT_TRUE(inbox.Fetch().empty());
  for (std::size_t i = 0; i < kMaxPlanned; ++i) send(at(std::to_string(i), 0));
  send(at("7", 1));  // keeps its place
  EXPECT_THAT(MessageOf([&] { send(at("one more", 1)); }), HasSubstr("more than 100 changes"));
  const std::vector<PlanRequest> in_order = inbox.Fetch();
  ASSERT_EQ(in_order.size(), kMaxPlanned);
  for (std::size_t i = 0; i < kMaxPlanned; ++i) EXPECT_EQ(in_order[i].name, std::to_string(i));
  send(at("left", 1));
  inbox.Close();
  EXPECT_TRUE(inbox.Fetch().empty());
  EXPECT_THAT(MessageOf([&] { send(at("left", 1)); }), HasSubstr("cannot be changed"));
}

}  // namespace
}  // namespace kerf
