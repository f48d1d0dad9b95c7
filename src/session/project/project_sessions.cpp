#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/core/printable.h"
#include "base/files/json_text.h"
#include "kerf/error.h"
#include "session/project/members.h"
#include "session/project/project.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr Range kSessionNumberRange{0, 1e9};  // of seconds, newtons and cubic millimetres

bool IsSessionNumber(const Json& value) {
  return value.is_number() && kSessionNumberRange.Contains(value.get<double>());
}

/// Returns the number of a key, and nothing if the session does not have it.
std::optional<double> NumberOf(const Json& session, const char* key, const std::string& path) {
  const auto found = session.find(key);
  if (found == session.end()) return std::nullopt;
  if (!IsSessionNumber(*found)) throw Error(fmt::format("{}: '{}' of a session is not a valid number", path, key));
  return found->get<double>();
}

/// Returns the place of a key, mm, and nothing if the session does not have it.
std::optional<Vec3> PlaceOf(const Json& session, const char* key, const std::string& path) {
  constexpr Range kPlace_mm{-1e5, 1e5};
  const auto found = session.find(key);
  if (found == session.end()) return std::nullopt;
  Vec3 p_W{0};
  bool valid = found->is_array() && found->size() == 3;
  for (int i = 0; valid && i < 3; ++i) {
    const Json& part = (*found)[static_cast<std::size_t>(i)];
    valid = part.is_number() && kPlace_mm.Contains(part.get<double>());
    if (valid) p_W[i] = part.get<double>();
  }
  if (!valid) throw Error(fmt::format("{}: '{}' of a session is not a valid place", path, key));
  return p_W;
}

std::vector<std::pair<double, double>> ForcesOf(const Json& session, const std::string& path) {
  std::vector<std::pair<double, double>> forces_sN;
  const Json list = session.value("forces_s_N", Json::array());
  bool valid = list.is_array();
  for (std::size_t i = 0; valid && i < list.size(); ++i) {
    const Json& point = list[i];
    valid = point.is_array() && point.size() == 2 && IsSessionNumber(point[0]) && IsSessionNumber(point[1]);
    if (valid) forces_sN.emplace_back(point[0].get<double>(), point[1].get<double>());
  }
  const auto is_later = [](const auto& a, const auto& b) { return a.first > b.first; };
  if (!valid || std::adjacent_find(forces_sN.begin(), forces_sN.end(), is_later) != forces_sN.end()) {
    throw Error(fmt::format("{}: 'forces_s_N' of a session is not a list of times, in order, and forces", path));
  }
  return forces_sN;
}

}  // namespace

std::string FormatSessions(const std::vector<ProjectSession>& sessions) {
  OrderedJson json = OrderedJson::array();
  for (const ProjectSession& session : sessions) {
    OrderedJson entry{{"saw", session.saw}};
    if (session.duration_s) entry["duration_s"] = *session.duration_s;
    if (session.removed_mm3) entry["removed_mm3"] = *session.removed_mm3;
    if (session.largest_force_N) entry["largest_force_N"] = *session.largest_force_N;
    if (session.turning_force_N) entry["turning_force_N"] = *session.turning_force_N;
    if (session.stopped_force_N) entry["stopped_force_N"] = *session.stopped_force_N;
    if (session.in_bone_s) entry["in_bone_s"] = *session.in_bone_s;
    const auto add_place = [&entry](const char* key, const std::optional<Vec3>& p_W) {
      if (p_W) entry[key] = {p_W->x, p_W->y, p_W->z};
    };
    add_place("hub_in_bone_mm", session.hub_in_bone_W);
    add_place("handpiece_in_bone_mm", session.handpiece_in_bone_W);
    if (!session.recorded) entry["recorded"] = false;
    if (!session.forces_sN.empty()) entry["forces_s_N"] = session.forces_sN;
    json.push_back(std::move(entry));
  }
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::vector<ProjectSession> ParseSessions(const std::string& text, const std::string& path) {
  const Json json = ParseJson(text, path);
  if (!json.is_array() || json.size() > project_detail::kMaxSessions) {
    throw Error(
        fmt::format("{}: the sessions are not a list of at most {} sessions", path, project_detail::kMaxSessions));
  }
  std::vector<ProjectSession> sessions;
  std::size_t points = 0;
  for (const Json& entry : json) {
    const Json saw = entry.is_object() ? entry.value("saw", Json()) : Json();
    if (!saw.is_string()) throw Error(fmt::format("{}: a session does not name its saw", path));
    const Json recorded = entry.value("recorded", Json(true));
    if (!recorded.is_boolean()) throw Error(fmt::format("{}: 'recorded' of a session is not true or false", path));
    sessions.push_back({.saw = Printable(saw.get<std::string>().substr(0, 1000)),
                        .duration_s = NumberOf(entry, "duration_s", path),
                        .removed_mm3 = NumberOf(entry, "removed_mm3", path),
                        .largest_force_N = NumberOf(entry, "largest_force_N", path),
                        .forces_sN = ForcesOf(entry, path),
                        .recorded = recorded.get<bool>(),
                        .turning_force_N = NumberOf(entry, "turning_force_N", path),
                        .stopped_force_N = NumberOf(entry, "stopped_force_N", path),
                        .in_bone_s = NumberOf(entry, "in_bone_s", path),
                        .hub_in_bone_W = PlaceOf(entry, "hub_in_bone_mm", path),
                        .handpiece_in_bone_W = PlaceOf(entry, "handpiece_in_bone_mm", path)});
    points += sessions.back().forces_sN.size();
    if (points > project_detail::kMaxForces) {
      throw Error(fmt::format("{}: the sessions have more than {} forces", path, project_detail::kMaxForces));
    }
  }
  return sessions;
}

}  // namespace kerf
