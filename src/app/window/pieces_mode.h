// Mode of the window in which pieces of a cut bone are selected, moved, hidden and measured.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/menu.h"
#include "app/window/viewer_app.h"
#include "bone/pieces/piece_measure.h"
#include "view/live/piece_mesh.h"

namespace kerf {

class PiecesMode {
 public:
  explicit PiecesMode(ViewerApp& viewer) : viewer_(viewer) {}

  /// Splits the current bone into its pieces. If nothing was cut since the last time, they keep their positions.
  /// `shown`: returns false while something else is shown in front of the pieces.
  void AddActions(ActionList& actions, const std::function<bool()>& shown);
  /// Sets positions of pieces from a project, and the measurements between them. They are used when the pieces are
  /// first made.
  void set_earlier(std::string json, std::vector<MeasuredPoints> measurements) {
    earlier_json_ = std::move(json);
    earlier_measurements_ = std::move(measurements);
  }
  void Enter();
  void Leave();
  /// Shows the pieces instead of the bone, and the other way round, as Enter() and Leave() do.
  /// `with_selection`: frames the piece that is selected.
  void ShowInPicture(bool with_selection = true);
  void HideInPicture();
  /// Moves marks that are shown with the pieces in which they lie. What lies in no piece is hidden once a piece has
  /// moved.
  void MoveMarks(std::vector<MarkOverlay> marks);
  void Undo();
  void Redo();
  void AskCheckpoint();
  void ShowCheckpoints();
  void PickMenuRow(int row);
  void PickPieceRow(int row);
  bool Take(const WindowEvent& event);
  /// Forgets the pieces, before another bone is opened. Waits for work on them.
  void Reset();
  void Update();
  void Fill(HudState& hud);
  static std::vector<HudKeyGroup> help();
  void Describe(nlohmann::json& state) const;

  /// Returns the pieces; null until they are ready.
  const std::shared_ptr<PieceSet>& pieces() const { return pieces_; }
  /// Returns the positions of the pieces (PieceSet::FormatJson()) for files, and the measurements between them. They
  /// are those that Enter() would show, if the bone still falls apart into the same pieces. Empty: nothing was moved
  /// yet.
  std::string FormatArrangement() const;
  const std::vector<MeasuredPoints>& measurements() const;
  /// Returns true if the bone has not changed since it was split.
  bool is_up_to_date() const;
  bool is_ready() const;
  bool is_unsaved() const { return unsaved_; }
  void set_unsaved(bool unsaved) { unsaved_ = unsaved; }

 private:
  enum class Asking { kNothing, kDistance, kAngle };
  /// Changes the pieces and shows the result, or the error message.
  void Do(const std::function<void()>& change);
  bool TakeKey(const WindowEvent& event);
  bool TakeMouse(const WindowEvent& event);
  void TakePoint(const ScreenPoint& at);
  static std::string MakeLabel(const PieceMeasure& measure);
  void ShowMeasures();
  void EndMeasuring();
  /// Returns the latest measurement as it is now, as a sentence.
  std::string DescribeLast() const;
  bool uses_earlier() const;
  void TakeSplit();
  void Drag(const WindowEvent& event);
  void Select(int piece);
  void SelectNext(int by);
  void Changed();  // called after each step, because the contacts must be recomputed
  /// Returns volume, motion and contacts of a piece as a sentence for the user.
  std::string DescribePiece(int i) const;
  /// Returns how far a piece was moved and turned; empty: it was not.
  std::string DescribeMotion(int i) const;
  /// Returns its largest overlap with another piece, mm3.
  double CalcOverlap(int i) const;
  /// Returns how a piece lies to its nearest neighbour, for a row of the list; empty: there is only one piece.
  std::string DescribeNearest(int i) const;
  void Show(bool with_selection = true);
  std::optional<Vec3> axis() const;

  /// Contacts of each piece with the others, by piece, and the states of the pieces for which they were computed.
  struct Contacts {
    std::vector<std::vector<PieceContact>> with;
    std::vector<PieceState> at;
  };
  /// `before`: latest contacts, whose pairs are used again if neither piece has moved since.
  static Contacts CalcAllContacts(const PieceSet& pieces, const Contacts& before);
  struct Split {
    std::shared_ptr<PieceSet> pieces;
    std::vector<std::shared_ptr<const PieceMesh>> meshes;  // as drawn, by piece
    std::string not_restored;  // positions that belong to other pieces than these; empty: none
  };

  ViewerApp& viewer_;
  bool entered_ = false;
  bool unsaved_ = false;      // pieces or measurements were changed since they were last saved
  std::string earlier_json_;  // positions of pieces that the bone does not fall apart into, or not yet
  std::future<Split> splitting_;
  std::shared_ptr<PieceSet> pieces_;
  std::vector<std::shared_ptr<const PieceMesh>> meshes_;
  int session_ = 0;            // session in which the pieces were split
  std::uint64_t changes_ = 0;  // number of changes to the bone at that time
  int selected_ = -1;
  int axis_ = -1;  // 0 to 2: axis of the patient along which pieces move; -1: free motion
  int gesture_ = 1;
  bool dragging_ = false;
  bool dragged_ = false;
  double last_x_ = 0;
  double last_y_ = 0;
  Asking asking_ = Asking::kNothing;
  MeasuredPoints points_;  // clicked for the next measurement
  std::string measured_;   // result that is shown until the next action or Escape; empty: none
  std::vector<MeasuredPoints> measurements_;
  std::vector<MeasuredPoints> earlier_measurements_;  // between the pieces of earlier_json_
  std::future<Contacts> finding_;
  std::optional<Contacts> contacts_;
  Contacts latest_contacts_;  // may belong to earlier states
  bool stale_ = false;        // contacts must be recomputed
  bool describes_ = false;    // the user has picked or moved the selected piece: a message describes it once
  std::optional<Menu> menu_;
  bool marks_left_out_ = false;  // parts of marks are hidden
};

}  // namespace kerf
