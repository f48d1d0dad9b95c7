#include <cmath>
#include <vector>

#include "session/link/igtl_bone.h"
#include "session/link/igtl_message.h"
#include "session/link/plan_request.h"
#include "target.h"

namespace kerf::fuzz {

/// As it is, and with the length and the checksum of what follows the header.
KERF_FUZZ_TARGET(igtl_message) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  if (bytes.size() < IgtlHeader::kBytes) return;
  Accepts([&] {
    IgtlHeader header = ReadIgtlHeader(std::span<const std::uint8_t, IgtlHeader::kBytes>(data, IgtlHeader::kBytes));
    const std::span<const std::uint8_t> body(data + IgtlHeader::kBytes, bytes.size() - IgtlHeader::kBytes);
    header.body_bytes = body.size();
    header.crc = CalcIgtlCrc(body);
    const std::span<const std::uint8_t> content = CheckIgtlBody(header, body);
    if (header.type == "IMAGE") {
      const Volume volume = ReadIgtlLabelMap(content);
      if (volume.hu.size() != volume.count()) Finding("a label map without its voxels");
      CheckLattice(volume, "fuzz");
      return;
    }
    if (header.type == "POLYDATA") {
      const TriangleMesh mesh = ReadIgtlSurface(content);
      for (const auto& triangle : mesh.triangles) {
        for (const std::uint32_t corner : triangle) {
          if (corner >= mesh.points.size()) Finding("a corner that is no point");
        }
      }
      return;
    }
    if (header.type == "POINT") {
      constexpr Box3 kBone_W{Vec3(-50), Vec3(50)};
      const PlanRequest request = ReadPlanRequest(header, content, kBone_W);
      for (const Vec3& p_W : request.points_W) {
        if (!(glm::length(p_W) < 1200)) Finding("a point that is not near the bone");
      }
      Plan plan;
      std::vector<Mark> marks;
      Apply(request, plan, marks);
      CheckPlan(plan);
      CheckMarks(marks);
      return;
    }
    const Pose X = ReadIgtlTransform(content);
    if (!IsValid(X)) Finding("a pose that is not valid");
    // What was read is what is sent again, to the accuracy of float.
    const std::string again = MakeIgtlTransform({header.device, header.time_s}, X);
    const auto* sent = reinterpret_cast<const std::uint8_t*>(again.data()) + IgtlHeader::kBytes;
    const Pose X_again = ReadIgtlTransform({sent, again.size() - IgtlHeader::kBytes});
    const double size_mm = 1 + glm::length(X.p_AB);
    if (!(glm::length(X_again.p_AB - X.p_AB) <= 1e-6 * size_mm)) Finding("a pose that changes when it is sent");
  });
  Accepts([&] {
    const IgtlHeader header =
        ReadIgtlHeader(std::span<const std::uint8_t, IgtlHeader::kBytes>(data, IgtlHeader::kBytes));
    CheckIgtlBody(header, {data + IgtlHeader::kBytes, bytes.size() - IgtlHeader::kBytes});
  });
}

}  // namespace kerf::fuzz
