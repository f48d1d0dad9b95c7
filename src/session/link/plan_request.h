// Changes of a plan that a peer asks for: a plane that was moved in 3D Slicer moves in kerf.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kerf/geometry.h"
#include "session/link/igtl_message.h"
#include "session/marks/mark.h"
#include "session/plan/plan.h"

namespace kerf {

struct PlanRequest {
  std::string name;            // of a plane or mark, as in the message: cut off after 20 characters
  bool adds = false;           // a plane with this name is made if there is none
  std::optional<Pose> X_WP{};  // of a plane: origin in its centre, z normal, y up. None: the points count
  std::vector<Vec3> points_W{};
};

/// Begins the name of a message that may also add a plane: "kerf_plan/left".
inline constexpr std::string_view kPlanPrefix = "kerf_plan/";
/// A POINT message with this name sets the points of the nerve, which need not exist yet.
inline constexpr std::string_view kNerveName = "nerve";

/// Reads a TRANSFORM or a POINT message. Throws kerf::Error with one sentence if it is not valid, has more than
/// kMaxMarkPoints points, or a place that is more than 1 m outside of the box around the bone.
PlanRequest ReadPlanRequest(const IgtlHeader& header, std::span<const std::uint8_t> content, const Box3& bone_W);

/// Carries out a request. A pose moves the plane of that name. Points become those of the mark of that name; if there
/// is none, the plane of that name goes through them, with its normal on the same side as before. A nerve needs two
/// points at different places. Throws kerf::Error with one sentence, and changes nothing, if there is no such plane or
/// the result is not valid.
void Apply(const PlanRequest& request, Plan& plan, std::vector<Mark>& marks);

/// Requests that wait for the owner of the plan. All functions may be called in any thread.
class PlanInbox {
 public:
  /// From now on, requests are accepted for a plan on this bone.
  void Open(const Box3& bone_W);
  /// From now on, requests are refused. This is so at first.
  void Close();
  /// Keeps the request of a message; it replaces an earlier one of the same type and name that still waits. Throws
  /// kerf::Error as ReadPlanRequest() does, if it is closed, and if more than kMaxPlanned requests would wait.
  void Take(const IgtlHeader& header, std::span<const std::uint8_t> content);
  /// Returns what waits, in the order in which the first message of each type and name arrived.
  std::vector<PlanRequest> Fetch();

 private:
  std::mutex mutex_;
  std::optional<Box3> bone_W_;
  std::vector<std::pair<std::string, PlanRequest>> waiting_;  // type and name; in the order in which they arrived
};

}  // namespace kerf
