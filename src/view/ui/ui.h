// Panels, menus and dialogs over the picture, with Dear ImGui: its context, fonts, colours and input.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/describe.h"
#include "view/picture/colours.h"
#include "view/picture/image.h"
#include "view/ui/event.h"

struct ImFont;
class vtkProp;

namespace kerf {

/// Size of text relative to the normal size.
inline constexpr Range kTextSizeRange{0.8, 2};

/// Rectangle in points from the top left of the window; a point is a pixel divided by the display scale.
struct UiBox {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
  bool empty() const { return !(width > 0 && height > 0); }
  bool Contains(double x, double y) const { return x >= left && x < right() && y >= top && y < bottom(); }
};
bool Overlap(const UiBox& a, const UiBox& b);

/// Colours of the panels; each pair of text and ground has a contrast of at least 4.5.
struct UiColours {
  Rgb8 ground, panel, text, faint, edge, accent, selected, button;
};
const UiColours& ColoursOf(Theme theme);

/// The only Dear ImGui context of the program. Between BeginFrame() and EndFrame(), panels are submitted with the
/// functions of Dear ImGui, in points multiplied by scale(). Used by one thread. Not copyable; only one may exist.
class Ui {
 public:
  Ui();
  ~Ui();
  Ui(const Ui&) = delete;
  Ui& operator=(const Ui&) = delete;

  /// Size of the window in pixels, and pixels per point.
  void SetSize(int width_px, int height_px, double scale);
  /// Pixels per point of text and lines, including the text size.
  float scale() const { return static_cast<float>(scale_ * text_size_); }
  double width() const { return width_px_; }
  double height() const { return height_px_; }
  void set_theme(Theme theme);
  Theme theme() const { return theme_; }
  const UiColours& colours() const { return ColoursOf(theme_); }
  void set_text_size(double text_size);
  double text_size() const { return text_size_; }

  /// Queues an event for the panels. A frame takes at most one change of each button and one key on which the panels
  /// act, so that a click or key within one frame is not lost, and any number of letters, so that a slow window writes
  /// as fast as one types.
  void Take(const WindowEvent& event);
  /// Returns true if events still wait for the next frame.
  bool has_waiting_events() const { return !queue_.empty(); }
  /// Announces a text field in the next frame: keys and letters wait until it has the input. `clicks_wait`: clicks
  /// wait too; one that comes in the frame in which the field takes the input would be lost.
  void ExpectText(bool clicks_wait) {
    expects_text_ = true;
    clicks_wait_ = clicks_wait;
  }
  /// Shows no tooltips, for example while a dialog is open.
  void set_tooltips(bool shown) { tooltips_ = shown; }
  bool tooltips() const { return tooltips_; }
  /// Takes the input away from a text field that is no longer shown.
  void DropText();
  /// Returns true if the pixel lies on a panel, or if a menu or dialog is open. As of the last frame.
  bool IsOnPanel(double x_px, double y_px) const;
  /// Returns true if a text field has the input, so that letters are not commands. As of the last frame.
  bool takes_text() const;
  /// Returns the item with the input: a text field, or a button that is held; 0: none. As of the last frame.
  unsigned int active_item() const;
  /// Returns true if a dialog or menu is open. As of the last frame.
  bool is_popup_open() const;
  /// Returns true in the frame in which ClosePopups() took the input away from a text field: what was typed into it is
  /// discarded.
  bool discards_text() const { return discards_text_; }
  /// Text field with the input, and its text as typed so far. For TextField().
  struct TypedText {
    unsigned int id = 0;
    std::string text;
  };
  TypedText& typed() { return typed_; }
  /// Closes menus, and takes the input away from a text field.
  void ClosePopups() { closes_popups_ = true; }

  /// Whether banners that would cover much of the picture are shown in full; otherwise they have one line. A click on
  /// one of them changes it.
  bool shows_long_banners() const { return shows_long_banners_; }
  void set_shows_long_banners(bool shows) { shows_long_banners_ = shows; }

  void BeginFrame(double dt_s);
  void EndFrame();
  /// Returns a hash of what the last frame draws, to find out whether it differs from another one.
  std::uint64_t CalcFrameHash() const;
  /// Draws the last frame; part of the picture's flat layer.
  vtkProp& prop();

  ImFont* normal() const { return normal_; }
  ImFont* bold() const { return bold_; }
  ImFont* small() const { return small_; }
  ImFont* title() const { return title_; }

  /// Makes a texture of the image, or updates it if `version` has changed; returns its ImTextureID. `slot`: name of the
  /// texture.
  void* Texture(const std::string& slot, const Image& image, std::uint64_t version);

  /// Notes the position of the last item under a name, for tests that control the window with the mouse.
  void Note(std::string_view name);
  /// Positions noted in the last frame: name -> box in pixels.
  const std::map<std::string, UiBox>& noted() const { return noted_; }
  /// Boxes in pixels of the panels of the last frame, without menus and dialogs.
  std::vector<UiBox> PanelBoxes() const;
  /// Texts drawn in the last frame whose end did not fit into their panel. For tests.
  const std::vector<std::string>& cut_texts() const { return cut_texts_; }
  void NoteCutText(const std::string& text) { cut_texts_.push_back(text); }

 private:
  struct State;
  void LoadFonts();
  void ApplyTheme();

  std::unique_ptr<State> state_;
  int width_px_ = 1280;
  int height_px_ = 720;
  double scale_ = 1;
  double text_size_ = 1;
  Theme theme_ = Theme::kLight;
  bool fonts_stale_ = true;
  bool tooltips_ = true;
  bool shows_long_banners_ = false;
  bool in_frame_ = false;
  bool expects_text_ = false;
  bool clicks_wait_ = false;  // for the text field too
  bool closes_popups_ = false;
  bool discards_text_ = false;
  TypedText typed_;
  int expected_frames_ = 0;  // since then
  ImFont* normal_ = nullptr;
  ImFont* bold_ = nullptr;
  ImFont* small_ = nullptr;
  ImFont* title_ = nullptr;
  std::deque<WindowEvent> queue_;
  std::int64_t frame_ = 0;           // number of the last frame
  std::int64_t press_frame_ = -2;    // before which the last press of the left button came
  std::deque<bool> presses_follow_;  // for each press in the queue: it came at most one frame after the one before
  std::map<std::string, UiBox> noted_;
  std::uint64_t textures_hash_ = 0;  // of the versions of this frame's textures
  std::vector<std::string> cut_texts_;
};

}  // namespace kerf
