#include "session/run/fragments_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/core/number_text.h"
#include "kerf/surface.h"
#include "session/run/summary_json.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;

/// Colours of the pieces, distinguishable with red-green colour blindness (after Okabe and Ito, 2008); the largest
/// piece is pale, like bone.
constexpr Rgb8 kColours[] = {{232, 220, 196}, {230, 120, 30}, {0, 114, 178},  {0, 158, 115},
                             {204, 121, 167}, {240, 200, 60}, {86, 180, 233}, {130, 90, 60}};
constexpr std::size_t kMaxInLegend = 10;

double Since_ms(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

std::string Volume(double mm3) {
  return mm3 < 1000 ? fmt::format("{:.3g} mm³", mm3) : fmt::format("{:.2f} cm³", mm3 / 1000);
}

/// Returns the found piece that matches `bone` best by its final bounding box, or null if there is none.
const FoundPiece* FindPiece(const FragmentsReport& fragments, const Bone& bone) {
  const Box3 box = bone.CalcBounds();
  const FoundPiece* best = nullptr;
  double smallest = 1e300;
  for (const FoundPiece& piece : fragments.found.pieces) {
    const double difference =
        glm::length(piece.bounds_W.lower - box.lower) + glm::length(piece.bounds_W.upper - box.upper);
    if (difference < smallest) best = &piece;
    smallest = std::min(smallest, difference);
  }
  return best;
}

/// Describes the pieces that were taken out.
std::string DescribeTakenOut(const FragmentsReport& f) {
  std::size_t pieces = 0, crumbs = 0, kept = 0;
  for (const PieceOut& piece : f.out) {
    pieces += piece.id == kAllDust ? 0 : 1;
    crumbs += piece.crumbs;
  }
  for (std::size_t i = 1; f.params.pieces != PieceFate::kHeld && i < f.found.pieces.size(); ++i) {
    kept += f.found.pieces[i].from != 0 ? 1 : 0;
  }
  std::string text = "taken out of the bone: ";
  if (pieces > 0) {
    text += fmt::format("{} piece{} {}, {}", pieces, pieces == 1 ? "" : "s", ToString(f.params.pieces),
                        FormatVolume(f.CalcSetAside_mm3() + f.CalcDeleted_mm3()));
  }
  if (crumbs > 0) {
    text += fmt::format("{}{} crumb{}, {:.3g} mm3", pieces > 0 ? ", " : "", crumbs, crumbs == 1 ? "" : "s",
                        f.CalcDustOut_mm3());
  }
  if (f.out.empty()) text += "nothing";
  if (kept > 0) text += fmt::format("; {} kept because the tool was not clear of {}", kept, kept == 1 ? "it" : "them");
  return text;
}

Vec3 Middle(const TriangleMesh& mesh) {
  Vec3 sum(0);
  for (const Vec3& p : mesh.points) sum += p;
  return mesh.points.empty() ? sum : sum / static_cast<double>(mesh.points.size());
}

/// Adds the pieces that were taken out to the legend, and draws those that were set aside. `apart`: set to the
/// direction in which the first of these was moved, unless it is set already.
void AddTakenOut(const FragmentsReport& fragments, std::size_t drawn, PictureSpec& spec, Vec3& apart) {
  constexpr Rgb8 kNotDrawn{150, 150, 150};
  for (const PieceOut& piece : fragments.out) {
    Rgb8 colour = kNotDrawn;
    if (piece.fate == PieceFate::kMoved) {
      Shape shape;
      shape.mesh_W = MakeSurfaceOut(piece);
      colour = shape.colour = kColours[1 + (std::max<std::size_t>(drawn, 1) - 1) % (std::size(kColours) - 1)];
      spec.shapes.push_back(std::move(shape));
      ++drawn;
      if (apart == Vec3(0) && piece.move_mm != Vec3(0)) apart = glm::normalize(piece.move_mm);
    }
    if (spec.legend.size() >= kMaxInLegend) continue;
    const std::string what =
        piece.id == kAllDust ? fmt::format("dust ({})", piece.crumbs) : fmt::format("piece {}", piece.id);
    spec.legend.push_back({fmt::format("{}: {}, {} at {:.2f} s", what, Volume(piece.volume_mm3),
                                       piece.id == kAllDust ? "taken out" : ToString(piece.fate), piece.time_s),
                           colour});
  }
}

}  // namespace

FragmentsDriver::FragmentsDriver(EffectPlan& effects)
    : effect_(dynamic_cast<FragmentsEffect*>(effects.Find("fragments"))) {}

void FragmentsDriver::Change(const std::array<int, 3>& index, std::span<const float, 512> values) {
  if (effect_ == nullptr) return;
  const Clock::time_point begin = Clock::now();
  effect_->watch().Change(index, values);
  changes_ms_ += Since_ms(begin);
}

void FragmentsDriver::Search(double time_s) {
  Search(time_s, {});
}

void FragmentsDriver::Search(double time_s, const std::function<double()>& now) {
  if (effect_ == nullptr) return;
  const bool changed = effect_->watch().finder().changed();
  const Clock::time_point begin = Clock::now();
  const std::size_t separated = effect_->Look(time_s);
  if (changed) times_ms_.push_back(changes_ms_ + Since_ms(begin));
  if (changed) changes_ms_ = 0;
  // The delay is at most the time since the last search, when the piece had not separated yet.
  if (separated > 0 && now) max_delay_ms_ = std::max(max_delay_ms_.value_or(0), 1e3 * (now() - searched_s_));
  searched_s_ = time_s;
}

std::optional<PieceJob> FragmentsDriver::Prepare(const Bone& bone,
                                                 const std::function<bool(const Box3&)>& is_clear) const {
  if (!takes_out()) return {};
  return PreparePiece(effect_->watch(), bone, taken_out_, is_clear);
}

void FragmentsDriver::Finish(PieceJob&& job, double time_s) {
  if (job.id != kAllDust) taken_out_.insert(job.id);
  out_.push_back(FinishPiece(std::move(job), effect_->watch().params(), time_s));
}

double FragmentsReport::CalcSetAside_mm3() const {
  double sum = 0;
  for (const PieceOut& piece : out) sum += piece.fate != PieceFate::kDeleted ? piece.volume_mm3 : 0;
  return sum;
}
double FragmentsReport::CalcDeleted_mm3() const {
  double sum = 0;
  for (const PieceOut& piece : out)
    sum += piece.fate == PieceFate::kDeleted && piece.id != kAllDust ? piece.volume_mm3 : 0;
  return sum;
}
double FragmentsReport::CalcDustOut_mm3() const {
  double sum = 0;
  for (const PieceOut& piece : out) sum += piece.id == kAllDust ? piece.volume_mm3 : 0;
  return sum;
}

std::optional<FragmentsReport> FragmentsDriver::MakeReport(const MaterialTable& materials) const {
  if (effect_ == nullptr) return {};
  const FragmentWatch& watch = effect_->watch();
  FragmentsReport report;
  report.params = watch.params();
  report.events = watch.events();
  report.event_count = watch.event_count();
  for (const FragmentEvent& event : report.events) {
    report.regions.push_back(materials.Contains(event.region) ? materials.At(event.region).name : "");
  }
  report.found = watch.finder().found();
  report.out = out_;
  std::vector<double> times = times_ms_;
  std::sort(times.begin(), times.end());
  report.searches = times.size();
  if (!times.empty()) {
    report.p50_ms = times[(times.size() - 1) / 2];
    report.max_ms = times.back();
  }
  report.max_delay_ms = max_delay_ms_;
  report.memory_MB = 1e-6 * static_cast<double>(effect_->CalcMemoryBytes());
  return report;
}

std::string DescribeFragments(const FragmentsReport& f) {
  std::string text = f.event_count == 0   ? std::string("nothing separated")
                     : f.event_count == 1 ? std::string("one piece separated")
                                          : fmt::format("{} pieces separated", f.event_count);
  constexpr std::size_t kMaxReported = 4;
  for (std::size_t i = 0; i < std::min(f.events.size(), kMaxReported); ++i) {
    const FragmentEvent& e = f.events[i];
    text += fmt::format("{}{} at {:.2f} s{}", i == 0 ? ": " : ", ", FormatVolume(e.piece.volume_mm3), e.time_s,
                        f.regions[i].empty() ? "" : fmt::format(" (mostly {})", f.regions[i]));
  }
  if (f.event_count > kMaxReported) text += ", ...";
  if (f.found.dust_count > 0) {
    text += fmt::format("; {} crumb{} below {:g} mm3, {:.3g} mm3 in total", f.found.dust_count,
                        f.found.dust_count == 1 ? "" : "s", f.params.dust_mm3, f.found.dust_mm3);
  }
  if (f.params.TakesOut()) text += "; " + DescribeTakenOut(f);
  if (f.searches > 0) {
    text += fmt::format("; searched every {:g} ms, which took p50 {:.1f}, max {:.1f} ms outside the tick",
                        f.params.every_ms, f.p50_ms, f.max_ms);
  }
  if (f.max_delay_ms) text += fmt::format("; found at most {:.0f} ms after separating", *f.max_delay_ms);
  return text;
}

nlohmann::ordered_json FragmentsJson(const FragmentsReport& f, bool times) {
  using Json = nlohmann::ordered_json;
  Json events = Json::array();
  for (std::size_t i = 0; i < f.events.size(); ++i) {
    const FragmentEvent& e = f.events[i];
    events.push_back({{"time_s", e.time_s},
                      {"piece", e.piece.id},
                      {"from", e.piece.from},
                      {"volume_mm3", e.piece.volume_mm3},
                      {"bounds", BoxJson(e.piece.bounds_W)},
                      {"region", e.region},
                      {"region_name", f.regions[i]},
                      {"pieces", e.pieces}});
  }
  Json pieces = Json::array();
  for (const FoundPiece& piece : f.found.pieces) {
    pieces.push_back({{"piece", piece.id},
                      {"from", piece.from},
                      {"volume_mm3", piece.volume_mm3},
                      {"bounds", BoxJson(piece.bounds_W)}});
  }
  Json out = Json::array();
  for (const PieceOut& piece : f.out) {
    Json row = {{"piece", piece.id},
                {"place", ToString(piece.fate)},
                {"time_s", piece.time_s},
                {"volume_mm3", piece.volume_mm3}};
    if (piece.id == kAllDust) row["crumbs"] = piece.crumbs;
    if (piece.fate == PieceFate::kMoved) row["move_mm"] = {piece.move_mm.x, piece.move_mm.y, piece.move_mm.z};
    out.push_back(row);
  }
  Json json = {
      {"came_off", f.event_count},
      {"events", events},
      {"pieces", pieces},
      {"wanted", ToString(f.params.pieces)},
      {"taken_out", out},
      {"taken_out_mm3", f.CalcSetAside_mm3()},
      {"deleted_mm3", f.CalcDeleted_mm3()},
      {"dust_taken_out_mm3", f.CalcDustOut_mm3()},
      {"dust", {{"below_mm3", f.params.dust_mm3}, {"count", f.found.dust_count}, {"volume_mm3", f.found.dust_mm3}}},
      {"every_ms", f.params.every_ms},
      {"memory_MB", f.memory_MB}};
  if (times) {
    json["looking"] = {{"count", f.searches},
                       {"p50_ms", f.p50_ms},
                       {"max_ms", f.max_ms},
                       {"most_late_ms", f.max_delay_ms ? Json(*f.max_delay_ms) : Json()}};
  }
  return json;
}

bool WriteFragmentsPicture(const FragmentsReport& fragments, const std::vector<Bone>& pieces, bool patient,
                           const std::string& name, const std::string& path) {
  if (pieces.empty() || (pieces.size() < 2 && fragments.out.empty())) return false;
  PictureSpec spec;
  Vec3 from(0);
  Vec3 apart(0);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    Shape shape;
    shape.mesh_W = ExtractSurface(pieces[i]);
    shape.colour = i == 0 ? kColours[0] : kColours[1 + (i - 1) % (std::size(kColours) - 1)];
    const Vec3 middle = Middle(shape.mesh_W);
    if (i == 0) {
      from = middle;
    } else {
      const double length = glm::length(middle - from);
      const Vec3 direction = length > 0 ? (middle - from) / length : Vec3(0, 0, 1);
      for (Vec3& p : shape.mesh_W.points) p += fragments.params.apart_mm * direction;
      if (i == 1) apart = direction;
    }
    if (i < kMaxInLegend) {
      const FoundPiece* piece = FindPiece(fragments, pieces[i]);
      std::string text = fmt::format("{}: {}", piece ? fmt::format("piece {}", piece->id) : std::string("piece"),
                                     Volume(pieces[i].CalcVolume()));
      for (const FragmentEvent& event : fragments.events) {
        if (piece != nullptr && event.piece.id == piece->id) text += fmt::format(", at {:.2f} s", event.time_s);
      }
      spec.legend.push_back({text, shape.colour});
    }
    spec.shapes.push_back(std::move(shape));
  }
  AddTakenOut(fragments, pieces.size(), spec, apart);
  spec.title = name + ": the pieces";
  spec.caption = pieces.size() < 2
                     ? std::string("1 piece in place")
                     : fmt::format(
                           "{} pieces in place, with the time at which each came off; drawn {:g} mm away from "
                           "the largest,\nalong the line between their centres",
                           pieces.size(), fragments.params.apart_mm);
  if (!fragments.out.empty()) spec.caption += (pieces.size() < 2 ? "; " : "\n") + DescribeTakenOut(fragments);
  if (pieces.size() > kMaxInLegend) spec.caption += fmt::format("; the legend names the {} largest", kMaxInLegend);
  spec.orientation = patient ? Orientation::kPatient : Orientation::kAxes;
  // View across the direction in which the second piece was moved, so that the gap is visible, and slightly from above
  // and from the front.
  Vec3 eye = Vec3(0, -1, 0) - glm::dot(Vec3(0, -1, 0), apart) * apart;
  if (glm::length(eye) < 0.3) eye = Vec3(1, 0, 0) - glm::dot(Vec3(1, 0, 0), apart) * apart;
  eye = glm::normalize(eye) + 0.45 * apart + Vec3(0, 0, 0.45);
  spec.camera = {eye, std::abs(glm::normalize(eye).z) < 0.9 ? Vec3(0, 0, 1) : Vec3(0, -1, 0), {}, 0};
  WritePicture(spec, path);
  return true;
}

}  // namespace kerf
