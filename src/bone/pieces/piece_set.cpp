#include "bone/pieces/piece_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>

#include "bone/pieces/measure.h"
#include "bone/pieces/piece_history.h"
#include "kerf/error.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

Pose ComposeUnit(const Pose& X_AB, const Pose& X_BC) {
  return {glm::normalize(X_AB.R_AB * X_BC.R_AB), X_AB.Point(X_BC.p_AB)};
}

Vec3 UnitAxis(const Vec3& axis_W) {
  const std::optional<Vec3> axis = CalcDirection(axis_W);
  if (!axis) throw Error("an axis has no direction: its length is 0");
  return *axis;
}

/// Returns the rotation about p_W.
Pose MakeRotation(const Vec3& p_W, const Quat& by_W) {
  const Quat q = glm::normalize(by_W);
  return {q, p_W - q * p_W};
}

/// Returns the centroid of the volume that a closed surface encloses; the origin if the surface is empty.
Vec3 CalcCentroidOf(const TriangleMesh& mesh) {
  if (mesh.points.empty()) return Vec3(0);
  const Vec3 origin = mesh.points.front();  // nearby, so that no precision is lost far from the world's origin
  Vec3 sum(0);
  double six = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.points[t[0]] - origin;
    const Vec3 b = mesh.points[t[1]] - origin;
    const Vec3 c = mesh.points[t[2]] - origin;
    const double part = glm::dot(a, glm::cross(b, c));
    six += part;
    sum += part / 4 * (a + b + c);
  }
  return std::abs(six) > 0 ? origin + sum / six : origin;
}

}  // namespace

struct PieceSet::State {
  struct Part {
    Piece piece;
    mutable std::unique_ptr<SurfaceTree> tree;  // built on first use
  };
  std::vector<Part> parts;
  PieceHistory history;
  int numbers = 0;  // last number used in a name

  const SurfaceTree& TreeOf(int i) const {
    const Part& part = parts[static_cast<std::size_t>(i)];
    if (!part.tree) part.tree = std::make_unique<SurfaceTree>(part.piece.mesh);
    return *part.tree;
  }
  SurfaceWithTree WithTree(int i) const { return {&parts[static_cast<std::size_t>(i)].piece.mesh, &TreeOf(i)}; }
  const PieceState& At(int i) const { return history.now()[static_cast<std::size_t>(i)]; }

  void CheckNumber(int i) const {
    if (i < 0 || i >= static_cast<int>(parts.size())) {
      throw Error(fmt::format("there is no piece {}; there are {}", i, parts.size()));
    }
  }
  void Check(int i) const {
    CheckNumber(i);
    if (At(i).deleted) {
      throw Error(fmt::format("{} is deleted; undo that first", parts[static_cast<std::size_t>(i)].piece.name));
    }
  }
  void Do(int i, const char* what, const PieceState& next, int gesture) {
    if (!IsValid(next.X_WP) || !IsInWorld(next.X_WP.p_AB)) {
      throw Error(fmt::format("{} can't be moved there", parts[static_cast<std::size_t>(i)].piece.name));
    }
    const PieceState& now = At(i);
    if (next == now) return;
    PieceAction action{.what = what,
                       .piece = parts[static_cast<std::size_t>(i)].piece.name,
                       .X_WW = ComposeUnit(next.X_WP, now.X_WP.Inverse()),
                       .name = {}};
    std::vector<PieceState> states = history.now();
    states[static_cast<std::size_t>(i)] = next;
    history.Do(std::move(action), std::move(states), gesture);
  }
  void DoMotion(int i, const char* what, const Pose& X_WW, int gesture) {
    Check(i);
    PieceState next = At(i);
    next.X_WP = ComposeUnit(X_WW, next.X_WP);
    Do(i, what, next, gesture);
  }
  void Fill(Piece& piece, Bone bone) const {
    piece.bone = std::move(bone);
    piece.mesh = ExtractSurface(piece.bone);
    piece.volume_mm3 = piece.bone.CalcVolume();
    piece.bounds_P = Box3{};
    for (const Vec3& p : piece.mesh.points) piece.bounds_P.Include(p);
    piece.centroid_P = CalcCentroidOf(piece.mesh);
  }
  int Add(Bone bone, const std::string& name) {
    Part part;
    part.piece.name = name;
    // Uses the next number that is not taken.
    while (part.piece.name.empty() || Find(part.piece.name) >= 0) {
      part.piece.name = fmt::format("piece {}", ++numbers);
    }
    Fill(part.piece, std::move(bone));
    parts.push_back(std::move(part));
    return static_cast<int>(parts.size()) - 1;
  }
  int Find(const std::string& name) const {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].piece.name == name) return static_cast<int>(i);
    }
    return -1;
  }
};

PieceSet::PieceSet() : state_(std::make_unique<State>()) {}

PieceSet::PieceSet(const Bone& bone, double min_mm3) : PieceSet() {
  for (Bone& part : SplitPieces(bone, min_mm3).pieces) Add(std::move(part));
}

PieceSet::~PieceSet() = default;
PieceSet::PieceSet(PieceSet&&) noexcept = default;
PieceSet& PieceSet::operator=(PieceSet&&) noexcept = default;

int PieceSet::Add(Bone bone, const std::string& name) {
  const int i = state_->Add(std::move(bone), name);
  state_->history.AddPiece(-1);
  return i;
}

std::vector<int> PieceSet::Recut(int i, const Bone& now, double min_mm3) {
  State& s = *state_;
  s.CheckNumber(i);
  std::vector<Bone> parts = SplitPieces(now, min_mm3).pieces;
  std::vector<int> indices{i};
  State::Part& first = s.parts[static_cast<std::size_t>(i)];
  Bone rest = parts.empty() ? now : Bone(std::move(parts.front()));
  s.Fill(first.piece, std::move(rest));
  first.tree.reset();
  for (std::size_t k = 1; k < parts.size(); ++k) {
    indices.push_back(s.Add(std::move(parts[k]), ""));
    s.history.AddPiece(i);
  }
  return indices;
}

int PieceSet::size() const {
  return static_cast<int>(state_->parts.size());
}

const Piece& PieceSet::piece(int i) const {
  state_->CheckNumber(i);
  return state_->parts[static_cast<std::size_t>(i)].piece;
}

const PieceState& PieceSet::state(int i) const {
  state_->CheckNumber(i);
  return state_->At(i);
}

int PieceSet::Find(const std::string& name) const {
  return state_->Find(name);
}

Vec3 PieceSet::CalcCentroid(int i) const {
  return state(i).X_WP.Point(piece(i).centroid_P);
}

void PieceSet::SetHidden(int i, bool hidden) {
  state_->Check(i);
  PieceState next = state_->At(i);
  next.hidden = hidden;
  state_->Do(i, hidden ? "hide" : "show", next, 0);
}

void PieceSet::Delete(int i) {
  state_->Check(i);
  PieceState next = state_->At(i);
  next.deleted = true;
  state_->Do(i, "delete", next, 0);
}

void PieceSet::Move(int i, const Vec3& by_W_mm, int gesture) {
  state_->DoMotion(i, "move", {Quat{1, 0, 0, 0}, by_W_mm}, gesture);
}

void PieceSet::Rotate(int i, const Vec3& p_W, const Quat& by_W, int gesture) {
  state_->DoMotion(i, "rotate", MakeRotation(p_W, by_W), gesture);
}

void PieceSet::MoveAlong(int i, const Vec3& axis_W, double by_mm, int gesture) {
  state_->DoMotion(i, "move along", {Quat{1, 0, 0, 0}, by_mm * UnitAxis(axis_W)}, gesture);
}

void PieceSet::RotateAbout(int i, const Vec3& p_W, const Vec3& axis_W, double by_deg, int gesture) {
  state_->DoMotion(i, "rotate about", MakeRotation(p_W, glm::angleAxis(by_deg / kDegreesPerRad, UnitAxis(axis_W))),
                   gesture);
}

void PieceSet::Place(int i, const Pose& X_WP, int gesture) {
  state_->Check(i);
  PieceState next = state_->At(i);
  next.X_WP = X_WP;
  state_->Do(i, "place", next, gesture);
}

void PieceSet::Reset(int i) {
  state_->Check(i);
  PieceState next = state_->At(i);
  next.X_WP = Pose{};
  state_->Do(i, "reset", next, 0);
}

void PieceSet::ResetAll() {
  std::vector<PieceState> states(state_->parts.size());
  if (states == state_->history.now()) return;
  state_->history.Do({.what = "reset all", .piece = {}, .X_WW = {}, .name = {}}, std::move(states), 0);
}

bool PieceSet::Undo() {
  return state_->history.Undo();
}
bool PieceSet::Redo() {
  return state_->history.Redo();
}
std::vector<PieceAction> PieceSet::actions() const {
  return state_->history.actions();
}

void PieceSet::Checkpoint(const std::string& name) {
  state_->history.Checkpoint(name);
}
bool PieceSet::GoTo(const std::string& name) {
  return state_->history.GoTo(name);
}
std::vector<std::string> PieceSet::checkpoints() const {
  return state_->history.checkpoint_names();
}

void PieceSet::Prepare() const {
  for (int i = 0; i < size(); ++i) state_->TreeOf(i);
}

std::optional<PiecePick> PieceSet::Pick(const Vec3& origin_W, const Vec3& direction_W) const {
  const State& s = *state_;
  std::optional<PiecePick> best;
  for (int i = 0; i < size(); ++i) {
    const PieceState& at = s.At(i);
    if (at.hidden || at.deleted) continue;
    const auto hit = s.TreeOf(i).Intersect(at.X_WP.InversePoint(origin_W), at.X_WP.InverseVector(direction_W));
    if (hit && (!best || hit->distance_mm < best->distance_mm)) {
      best = PiecePick{.piece = i, .p_W_mm = at.X_WP.Point(hit->p), .distance_mm = hit->distance_mm};
    }
  }
  return best;
}

double PieceSet::CalcOverlapWith(int i, int other) const {
  state_->Check(i);
  state_->Check(other);
  const auto with_bounds = [](const Piece& p) { return BoneWithBounds{&p.bone, p.bounds_P}; };
  return CalcOverlap(with_bounds(piece(i)), state(i).X_WP, with_bounds(piece(other)), state(other).X_WP);
}

std::optional<Gap> PieceSet::CalcGapTo(int i, int other, double limit_mm) const {
  state_->Check(i);
  state_->Check(other);
  return CalcGap(state_->WithTree(i), state(i).X_WP, state_->WithTree(other), state(other).X_WP, limit_mm);
}

Facing PieceSet::CalcFacingTo(int i, int other, double reach_mm, double contact_mm) const {
  state_->Check(i);
  state_->Check(other);
  return CalcFacing(state_->WithTree(i), state(i).X_WP, state_->WithTree(other), state(other).X_WP, reach_mm,
                    contact_mm);
}

std::vector<PieceContact> PieceSet::CalcContacts(int i, double gap_limit_mm) const {
  state_->Check(i);
  std::vector<PieceContact> contacts;
  for (int other = 0; other < size(); ++other) {
    if (other != i && !state(other).deleted) contacts.push_back(CalcContact(i, other, gap_limit_mm));
  }
  return contacts;
}

PieceContact PieceSet::CalcContact(int i, int other, double gap_limit_mm) const {
  PieceContact contact{
      .other = other, .overlap_mm3 = CalcOverlapWith(i, other), .gap = CalcGapTo(i, other, gap_limit_mm)};
  if (contact.overlap_mm3 > 0 && contact.gap) contact.gap->gap_mm = 0;
  return contact;
}

std::string PieceSet::FormatJson() const {
  std::vector<PieceIdentity> identities;
  for (const State::Part& part : state_->parts) {
    identities.push_back({.name = part.piece.name, .volume_mm3 = part.piece.volume_mm3});
  }
  return FormatPieces(identities, state_->history);
}

void PieceSet::Restore(const std::string& text, const std::string& path) {
  std::vector<PieceIdentity> identities;
  for (const State::Part& part : state_->parts) {
    identities.push_back({.name = part.piece.name, .volume_mm3 = part.piece.volume_mm3});
  }
  RestorePieces(text, path, identities, state_->history);
}

Pose ConstrainToAxis(const Pose& X_WW, const Vec3& p_W, const Vec3& axis_W) {
  const Vec3 axis = UnitAxis(axis_W);
  // The component of the rotation about the axis (swing-twist decomposition).
  const Quat& q = X_WW.R_AB;
  const double along = glm::dot(Vec3(q.x, q.y, q.z), axis);
  const double length = std::hypot(q.w, along);
  const Quat twist = length > 1e-12 ? Quat(q.w / length, along / length * axis) : Quat(1, 0, 0, 0);
  const double shift_mm = glm::dot(axis, X_WW.Point(p_W) - p_W);
  return {twist, p_W - twist * p_W + shift_mm * axis};
}

}  // namespace kerf
