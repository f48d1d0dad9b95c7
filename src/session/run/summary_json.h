// Common parts of the summaries of voxel mode and slab mode. Include only in their .cpp files.
#pragma once

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "base/table/table_json.h"
#include "session/run/effect_record.h"
#include "session/run/run_scene.h"

namespace kerf {

inline nlohmann::ordered_json BoxJson(const Box3& box) {
  return {{"lower_mm", {box.lower.x, box.lower.y, box.lower.z}}, {"upper_mm", {box.upper.x, box.upper.y, box.upper.z}}};
}

inline nlohmann::ordered_json PieceJson(const PieceSummary& piece) {
  nlohmann::ordered_json row = {{"volume_mm3", piece.volume_mm3}, {"bounds", BoxJson(piece.bounds_W)}};
  if (piece.place != PieceFate::kHeld) row["place"] = ToString(piece.place);
  if (piece.place == PieceFate::kMoved) row["move_mm"] = {piece.move_mm.x, piece.move_mm.y, piece.move_mm.z};
  if (!piece.file.empty()) {
    row["file"] = piece.file;
    row["triangles"] = piece.triangles;
  }
  return row;
}

inline nlohmann::ordered_json DustJson(const PieceCounts& counts) {
  nlohmann::ordered_json json = {{"count", counts.dust_count}, {"volume_mm3", counts.dust_mm3}};
  if (counts.old_dust_count) {
    json["before_cut"] = {{"count", *counts.old_dust_count}, {"volume_mm3", counts.old_dust_mm3}};
  }
  return json;
}

/// Returns true if any of the pieces or parts was written as a surface.
template <typename Pieces>
bool HaveFiles(const Pieces& pieces) {
  return std::any_of(pieces.begin(), pieces.end(), [](const auto& piece) { return !piece.file.empty(); });
}

inline nlohmann::ordered_json ForceJson(const std::string& law, const ForceSummary& force) {
  return {{"law", law},
          {"peak_N", force.peak_N},
          {"peak_time_s", force.peak_time_s},
          {"mean_while_cutting_N", force.mean_N},
          {"impulse_Ns", force.impulse_Ns},
          {"work_J", force.work_Nmm / 1000},
          {"engaged_teeth_peak", force.engaged_teeth_peak},
          {"cutting_time_s", force.cutting_time_s}};
}

/// Returns the values of the channels, grouped by enabled effect.
inline nlohmann::ordered_json EffectsJson(const EffectRecord& record) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const std::string& effect : record.on) json[effect] = nlohmann::ordered_json::object();
  for (const EffectFigure& f : record.figures) {
    json[f.effect][f.name] = {
        {"last", NumberJson(f.last)}, {"smallest", NumberJson(f.smallest)}, {"largest", NumberJson(f.largest)}};
  }
  return json;
}

inline nlohmann::ordered_json CostsJson(const StageCosts& costs) {
  const auto json_of = [](const PartTimes& part) {
    return nlohmann::ordered_json{{"ticks", part.count},   {"mean_us", part.mean_us}, {"p50_us", part.p50_us},
                                  {"p99_us", part.p99_us}, {"p999_us", part.p999_us}, {"max_us", part.max_us}};
  };
  const auto list_of = [&](const std::vector<PartTimes>& parts) {
    nlohmann::ordered_json list = nlohmann::ordered_json::object();
    for (const PartTimes& part : parts) list[part.name] = json_of(part);
    return list;
  };
  return {{"budget_us", costs.budget_us},
          {"over_budget", costs.over},
          {"tick", json_of(costs.tick)},
          {"stages", list_of(costs.stages)},
          {"effects", list_of(costs.effects)}};
}

/// `Summary`: RunSummary or SlabSummary.
template <typename Summary>
nlohmann::ordered_json TicksJson(const Summary& s) {
  return {{"count", s.ticks},
          {"with_status", s.ticks_with_status},
          {"simulated_s", s.simulated_s},
          {"wall_s", s.ticks_wall_s},
          {"per_second", s.ticks_wall_s > 0 ? static_cast<double>(s.ticks) / s.ticks_wall_s : 0},
          {"p50_us", s.times.p50_us},
          {"p99_us", s.times.p99_us},
          {"p999_us", s.times.p999_us},
          {"max_us", s.times.max_us}};
}

}  // namespace kerf
