// Pieces of the bone that was cut through: picked, moved, hidden, measured, in the window.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/menu.h"
#include "app/window/theatre.h"
#include "bone/pieces/piece_set.h"
#include "session/export/take_away.h"

namespace kerf {

class PiecesMode {
 public:
  explicit PiecesMode(Theatre& theatre) : theatre_(theatre) {}

  /// The bone as it is falls into its pieces; where nothing was cut since the last time they stand as they were left.
  void Enter();
  void Leave();
  bool Take(const WindowEvent& event);
  void Update();
  void Fill(HudState& hud);
  static std::vector<HudKeyGroup> help();
  void Describe(nlohmann::json& state) const;

  /// Null before they are there.
  const std::shared_ptr<PieceSet>& pieces() const { return pieces_; }
  std::vector<TakenMeasure> measures() const;
  /// The bone has not changed since they were split.
  bool is_up_to_date() const;

 private:
  enum class Asking { kNothing, kDistance, kAngle };
  bool TakeKey(const WindowEvent& event);
  bool TakeMouse(const WindowEvent& event);
  void TakePoint(const ScreenPoint& at);
  void Drag(const WindowEvent& event);
  void Select(int piece);
  void SelectNext(int by);
  void Changed();  // a step is done: contacts anew
  void MakeShapes();
  void Show();
  std::optional<Vec3> axis() const;
  void ShowCheckpoints();

  struct Contacts {
    int piece = -1;
    std::vector<PieceContact> with;
  };
  struct Measure {
    std::vector<Vec3> points_W;
    double value = 0;  // mm of two points, degrees of three
    std::string label;
  };

  Theatre& theatre_;
  bool entered_ = false;
  std::future<std::shared_ptr<PieceSet>> splitting_;
  std::shared_ptr<PieceSet> pieces_;
  std::vector<std::shared_ptr<const TriangleMesh>> shapes_;  // as they are drawn
  int session_ = 0;                                          // in which they were split,
  std::uint64_t changes_ = 0;                                // after so many changes of the bone
  int selected_ = -1;
  int axis_ = -1;  // 0 to 2: what moves goes along this axis of the patient; -1: freely
  int gesture_ = 1;
  bool dragging_ = false;
  bool dragged_ = false;
  double last_x_ = 0;
  double last_y_ = 0;
  Asking asking_ = Asking::kNothing;
  std::vector<Vec3> points_W_;
  std::vector<Measure> measures_;
  std::future<Contacts> finding_;
  std::optional<Contacts> contacts_;
  bool stale_ = false;  // contacts are to be found again
  std::optional<Menu> menu_;
};

}  // namespace kerf
