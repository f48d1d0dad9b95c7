// Format of pieces.json.
#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/files/json_text.h"
#include "bone/pieces/piece_history.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "kerf pieces";
constexpr int kVersion = 1;
constexpr double kSameVolume = 0.01;
constexpr double kRigid = 1e-6;

Json FormatStates(const std::vector<PieceIdentity>& pieces, const std::vector<PieceState>& states) {
  Json list = Json::array();
  for (std::size_t i = 0; i < states.size(); ++i) {
    list.push_back({{"name", pieces[i].name},
                    {"volume_mm3", pieces[i].volume_mm3},
                    {"hidden", states[i].hidden},
                    {"deleted", states[i].deleted},
                    {"transform", MakeMatrix(states[i].X_WP)}});
  }
  return list;
}

[[noreturn]] void Refuse(const std::string& path, const std::string& what) {
  throw Error(fmt::format("{}: {}", path, what));
}

/// Reads a transform. Throws kerf::Error unless it is a rigid motion.
Pose ReadTransform(const nlohmann::json& entry, const std::string& path, const std::string& name) {
  const nlohmann::json list = entry.value("transform", nlohmann::json());
  std::array<double, 16> m{};
  bool good = list.is_array() && list.size() == 16;
  for (std::size_t i = 0; good && i < 16; ++i) {
    good = list[i].is_number();
    m[i] = good ? list[i].get<double>() : 0;
    good = good && std::isfinite(m[i]);
  }
  if (!good) Refuse(path, fmt::format("'transform' of {} is not a list of 16 numbers", name));
  const Vec3 x(m[0], m[4], m[8]);
  const Vec3 y(m[1], m[5], m[9]);
  const Vec3 z(m[2], m[6], m[10]);
  const auto unit = [](const Vec3& v) { return std::abs(glm::length(v) - 1) < kRigid; };
  const bool rigid = unit(x) && unit(y) && unit(z) && glm::length(glm::cross(x, y) - z) < kRigid && m[12] == 0 &&
                     m[13] == 0 && m[14] == 0 && m[15] == 1;
  if (!rigid) Refuse(path, fmt::format("'transform' of {} is not a rigid motion", name));
  const Pose X{glm::normalize(glm::quat_cast(glm::dmat3(x, y, z))), {m[3], m[7], m[11]}};
  if (!IsInWorld(X.p_AB)) Refuse(path, fmt::format("'transform' of {} moves it out of the world", name));
  return X;
}

std::vector<PieceState> ReadStates(const nlohmann::json& list, const std::string& path,
                                   const std::vector<PieceIdentity>& pieces, std::vector<PieceState> states) {
  if (!list.is_array()) Refuse(path, "has no list 'pieces'");
  for (const nlohmann::json& entry : list) {
    if (!entry.is_object() || !entry.value("name", nlohmann::json()).is_string()) {
      Refuse(path, "an entry of 'pieces' has no name");
    }
    const auto name = entry["name"].get<std::string>();
    std::optional<std::size_t> at;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (pieces[i].name == name) at = i;
    }
    if (!at) Refuse(path, fmt::format("there is no {} here; the file belongs to another bone or another cut", name));
    const nlohmann::json volume = entry.value("volume_mm3", nlohmann::json());
    const double own = pieces[*at].volume_mm3;
    if (!volume.is_number() || !(std::abs(volume.get<double>() - own) <= kSameVolume * own)) {
      Refuse(path,
             fmt::format("{} has a different volume here; the file belongs to another bone or another cut", name));
    }
    const auto flag = [&](const char* key) {
      const nlohmann::json value = entry.value(key, nlohmann::json(false));
      if (!value.is_boolean()) Refuse(path, fmt::format("'{}' of {} is neither true nor false", key, name));
      return value.get<bool>();
    };
    states[*at] = {.X_WP = ReadTransform(entry, path, name), .hidden = flag("hidden"), .deleted = flag("deleted")};
  }
  return states;
}

}  // namespace

std::string FormatPieces(const std::vector<PieceIdentity>& pieces, const PieceHistory& history) {
  Json json{{"format", kFormat}, {"version", kVersion}, {"frame", "LPS"}, {"units", "mm"}};
  json["pieces"] = FormatStates(pieces, history.now());
  json["checkpoints"] = Json::array();
  for (const auto& [name, states] : history.checkpoints()) {
    json["checkpoints"].push_back({{"name", name}, {"pieces", FormatStates(pieces, states)}});
  }
  json["actions"] = Json::array();
  for (const PieceAction& action : history.actions()) {
    Json entry{{"what", action.what}};
    if (!action.piece.empty()) entry["piece"] = action.piece;
    if (!action.name.empty()) entry["checkpoint"] = action.name;
    if (!action.piece.empty()) entry["transform"] = MakeMatrix(action.X_WW);
    json["actions"].push_back(entry);
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void RestorePieces(const std::string& text, const std::string& path, const std::vector<PieceIdentity>& pieces,
                   PieceHistory& history) {
  const nlohmann::json json = ParseJson(text, path);
  if (!json.is_object() || json.value("format", nlohmann::json()) != kFormat) {
    Refuse(path, "not a pieces file written by kerf");
  }
  if (json.value("version", nlohmann::json()) != kVersion) Refuse(path, "was written by a later version of kerf");
  const std::vector<PieceState> states =
      ReadStates(json.value("pieces", nlohmann::json()), path, pieces, history.now());
  const nlohmann::json checkpoints = json.value("checkpoints", nlohmann::json::array());
  if (!checkpoints.is_array()) Refuse(path, "'checkpoints' is not a list");
  std::vector<std::pair<std::string, std::vector<PieceState>>> read;
  for (const nlohmann::json& entry : checkpoints) {
    if (!entry.is_object() || !entry.value("name", nlohmann::json()).is_string()) {
      Refuse(path, "a checkpoint has no name");
    }
    read.emplace_back(entry["name"].get<std::string>(),
                      ReadStates(entry.value("pieces", nlohmann::json()), path, pieces, history.now()));
  }
  // Nothing is changed before this point, so an invalid file has no effect.
  for (auto& [name, kept] : read) history.set_checkpoint(name, std::move(kept));
  if (states != history.now()) {
    history.Do({.what = "restore", .piece = {}, .X_WW = {}, .name = path}, states, 0);
  }
}

}  // namespace kerf
