#include "view/ui/ui.h"

#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <set>
#include <utility>

#include "base/core/hash.h"
#include "base/files/installed.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/ui_prop.h"

namespace kerf {
namespace {

constexpr char kFontFolder[] = "/fonts/truetype/dejavu/";
constexpr float kDoubleClick_s = 0.3f;  // between the clicks of a double click
constexpr float kAnyTime_s = 1e6f;
constexpr double kNormal = 15;  // size of text, points
constexpr double kSmall = 13;
constexpr double kTitle = 20;

// Latin with its extensions, Greek, Cyrillic, punctuation, super- and subscripts, arrows, mathematical signs, shapes.
constexpr ImWchar kLetters[] = {0x0020, 0x024f, 0x0370, 0x03ff, 0x0400, 0x04ff, 0x1e00, 0x1eff, 0x2010,
                                0x205e, 0x2070, 0x209f, 0x20a0, 0x20bf, 0x2100, 0x214f, 0x2190, 0x21ff,
                                0x2200, 0x22ff, 0x25a0, 0x25ff, 0x2600, 0x26ff, 0x2713, 0x2718, 0};
constexpr ImWchar kFewLetters[] = {0x0020, 0x017f, 0x0370, 0x03ff, 0x0400, 0x045f, 0x2010, 0x2027, 0x2070, 0x209f, 0};

ImGuiKey ToImGuiKey(Key key) {
  switch (key) {
    case Key::kTab:
      return ImGuiKey_Tab;
    case Key::kLeft:
      return ImGuiKey_LeftArrow;
    case Key::kRight:
      return ImGuiKey_RightArrow;
    case Key::kUp:
      return ImGuiKey_UpArrow;
    case Key::kDown:
      return ImGuiKey_DownArrow;
    case Key::kPageUp:
      return ImGuiKey_PageUp;
    case Key::kPageDown:
      return ImGuiKey_PageDown;
    case Key::kHome:
      return ImGuiKey_Home;
    case Key::kEnd:
      return ImGuiKey_End;
    case Key::kDelete:
      return ImGuiKey_Delete;
    case Key::kBackspace:
      return ImGuiKey_Backspace;
    case Key::kEnter:
      return ImGuiKey_Enter;
    case Key::kEscape:
      return ImGuiKey_Escape;
    case Key::kSpace:
      return ImGuiKey_Space;
    case Key::kA:
      return ImGuiKey_A;
    case Key::kC:
      return ImGuiKey_C;
    case Key::kV:
      return ImGuiKey_V;
    case Key::kX:
      return ImGuiKey_X;
    case Key::kY:
      return ImGuiKey_Y;
    case Key::kZ:
      return ImGuiKey_Z;
    default:
      return ImGuiKey_COUNT;
  }
}

// Dear ImGui 1.86 (Debian 12) has arrays of keys. 1.87 replaced them by events; these names are those of 1.89.
#if IMGUI_VERSION_NUM >= 18900
void PrepareKeys(ImGuiIO& io) {
  io.ConfigInputTrickleEventQueue = false;  // Ui::BeginFrame() decides which events a frame takes
}
void SetKey(ImGuiIO& io, ImGuiKey key, bool down) {
  io.AddKeyEvent(key, down);
}
void SetModifiers(ImGuiIO& io, const WindowEvent& event) {
  io.AddKeyEvent(ImGuiMod_Ctrl, event.control);
  io.AddKeyEvent(ImGuiMod_Shift, event.shift);
  io.AddKeyEvent(ImGuiMod_Alt, event.alt);
}
void ReleaseKeys(ImGuiIO& io) {
  for (int key = ImGuiKey_NamedKey_BEGIN; key < ImGuiKey_GamepadStart; ++key)
    io.AddKeyEvent(static_cast<ImGuiKey>(key), false);
}
#else
void PrepareKeys(ImGuiIO& io) {
  for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
}
void SetKey(ImGuiIO& io, ImGuiKey key, bool down) {
  io.KeysDown[key] = down;
}
void SetModifiers(ImGuiIO& io, const WindowEvent& event) {
  io.KeyCtrl = event.control;
  io.KeyShift = event.shift;
  io.KeyAlt = event.alt;
}
void ReleaseKeys(ImGuiIO& io) {
  std::fill(std::begin(io.KeysDown), std::end(io.KeysDown), false);
}
#endif

UiBox ToBox(const ImGuiWindow& window) {
  return {window.Pos.x, window.Pos.y, window.Size.x, window.Size.y};
}

}  // namespace

bool Overlap(const UiBox& a, const UiBox& b) {
  return a.left < b.right() && b.left < a.right() && a.top < b.bottom() && b.top < a.bottom();
}

const UiColours& ColoursOf(Theme theme) {
  static constexpr UiColours kLightColours{.ground = {236, 239, 243},
                                           .panel = {250, 251, 252},
                                           .text = {26, 29, 36},
                                           .faint = {82, 90, 102},
                                           .edge = {176, 183, 192},
                                           .accent = {0, 92, 158},
                                           .selected = {204, 224, 246},
                                           .button = {222, 227, 233}};
  static constexpr UiColours kDarkColours{.ground = {30, 33, 38},
                                          .panel = {38, 42, 48},
                                          .text = {232, 235, 239},
                                          .faint = {168, 176, 186},
                                          .edge = {84, 91, 101},
                                          .accent = {120, 190, 240},
                                          .selected = {44, 74, 104},
                                          .button = {58, 64, 73}};
  return theme == Theme::kLight ? kLightColours : kDarkColours;
}

struct Ui::State {
  vtkSmartPointer<UiProp> prop;
  std::set<Key> changed_keys;
};

Ui::Ui() : state_(std::make_unique<State>()) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.ConfigInputTextCursorBlink = false;  // the same picture at any time
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  PrepareKeys(io);
  state_->prop = vtkSmartPointer<UiProp>::New();
  ApplyTheme();
}

Ui::~Ui() {
  ImGui::DestroyContext();
}

vtkProp& Ui::prop() {
  return *state_->prop;
}

void Ui::SetSize(int width_px, int height_px, double scale) {
  if (width_px < 1 || height_px < 1) return;
  width_px_ = width_px;
  height_px_ = height_px;
  if (scale != scale_) fonts_stale_ = true;
  scale_ = scale;
}

void Ui::set_theme(Theme theme) {
  theme_ = theme;
  ApplyTheme();
}

void Ui::set_text_size(double text_size) {
  text_size = kTextSizeRange.Clamp(text_size);
  if (text_size != text_size_) fonts_stale_ = true;
  text_size_ = text_size;
}

void Ui::ApplyTheme() {
  ImGuiStyle style;
  const UiColours& c = colours();
  if (theme_ == Theme::kLight) {
    ImGui::StyleColorsLight(&style);
  } else {
    ImGui::StyleColorsDark(&style);
  }
  const auto set = [&](ImGuiCol_ index, const Rgb8& colour, double alpha = 1) {
    style.Colors[index] = ToImVec4(colour, alpha);
  };
  set(ImGuiCol_Text, c.text);
  set(ImGuiCol_TextDisabled, c.faint);
  set(ImGuiCol_WindowBg, c.panel);
  set(ImGuiCol_PopupBg, c.panel);
  set(ImGuiCol_MenuBarBg, c.ground);
  set(ImGuiCol_Border, c.edge);
  set(ImGuiCol_FrameBg, c.ground);
  set(ImGuiCol_FrameBgHovered, c.selected);
  set(ImGuiCol_FrameBgActive, c.selected);
  set(ImGuiCol_Button, c.button);
  set(ImGuiCol_ButtonHovered, c.selected);
  set(ImGuiCol_ButtonActive, c.selected);
  set(ImGuiCol_Header, c.selected);
  set(ImGuiCol_HeaderHovered, c.selected);
  set(ImGuiCol_HeaderActive, c.selected);
  set(ImGuiCol_TitleBg, c.ground);
  set(ImGuiCol_TitleBgActive, c.ground);
  set(ImGuiCol_Separator, c.edge);
  set(ImGuiCol_CheckMark, c.accent);
  set(ImGuiCol_SliderGrab, c.accent);
  set(ImGuiCol_SliderGrabActive, c.accent);
  set(ImGuiCol_PlotHistogram, c.accent);
  set(ImGuiCol_ScrollbarBg, c.ground);
  set(ImGuiCol_TextSelectedBg, c.accent, 0.35);
  set(ImGuiCol_TableBorderLight, c.edge);
  set(ImGuiCol_TableHeaderBg, c.ground);
  set(ImGuiCol_ModalWindowDimBg, c.ground, 0.55);
  set(ImGuiCol_NavHighlight, c.accent);
  style.WindowRounding = 0;
  style.PopupRounding = 4;
  style.FrameRounding = 3;
  style.WindowPadding = {10, 8};
  style.FramePadding = {8, 4};
  style.ItemSpacing = {8, 5};
  style.ItemInnerSpacing = {6, 4};
  style.ScrollbarSize = 12;
  style.WindowBorderSize = 1;
  style.FrameBorderSize = 0;
  style.ScaleAllSizes(scale());
  style.WindowBorderSize = 1;
  style.AntiAliasedLinesUseTex = false;
  ImGui::GetStyle() = style;
}

void Ui::LoadFonts() {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  const auto load = [&](const char* file, double points, const ImWchar* letters) -> ImFont* {
    std::string path = FindShareFolder() + kFontFolder + file;  // a portable installation has its own
    if (!std::filesystem::exists(path)) path = std::string("/usr/share") + kFontFolder + file;
    if (!std::filesystem::exists(path)) return nullptr;
    ImFontConfig config;
    config.OversampleH = 1;
    config.OversampleV = 1;
    config.PixelSnapH = true;
    return atlas.AddFontFromFileTTF(path.c_str(), static_cast<float>(std::round(points * scale_ * text_size_)), &config,
                                    letters);
  };
  normal_ = load("DejaVuSans.ttf", kNormal, kLetters);
  // Without the font, the built-in one has at least the letters of English.
  if (normal_ == nullptr) normal_ = atlas.AddFontDefault();
  const auto or_normal = [&](ImFont* font) { return font != nullptr ? font : normal_; };
  bold_ = or_normal(load("DejaVuSans-Bold.ttf", kNormal, kFewLetters));
  small_ = or_normal(load("DejaVuSans.ttf", kSmall, kFewLetters));
  title_ = or_normal(load("DejaVuSans-Bold.ttf", kTitle, kFewLetters));
  atlas.Build();
  state_->prop->RenewFonts();
  fonts_stale_ = false;
}

// ---- input

void Ui::Take(const WindowEvent& event) {
  if (event.kind == WindowEvent::Kind::kMouseDown && event.button == MouseButton::kLeft) {
    // Frames that go on without events are short, so that these presses are close in time, however slow the window is.
    presses_follow_.push_back(frame_ - press_frame_ <= 1);
    press_frame_ = frame_;
  }
  queue_.push_back(event);
}

namespace {

/// Returns whether the panels act on the key. The others only write, and their letters come as text.
bool Acts(const WindowEvent& event) {
  const bool letter = event.key >= Key::kA && event.key <= Key::kZ;
  return ToImGuiKey(event.key) != ImGuiKey_COUNT && (!letter || event.control);
}

/// Passes an event to Dear ImGui.
void Feed(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  ImGuiIO& io = ImGui::GetIO();
  SetModifiers(io, event);
  const auto at = [&] { io.MousePos = {static_cast<float>(event.x), static_cast<float>(event.y)}; };
  switch (event.kind) {
    case Kind::kKeyDown:
      if (Acts(event)) SetKey(io, ToImGuiKey(event.key), true);
      break;
    case Kind::kKeyUp:
      if (const ImGuiKey key = ToImGuiKey(event.key); key != ImGuiKey_COUNT) SetKey(io, key, false);
      break;
    case Kind::kText:
      io.AddInputCharacter(event.character);
      break;
    case Kind::kMouseDown:
    case Kind::kMouseUp:
      at();
      io.MouseDown[static_cast<int>(event.button)] = event.kind == Kind::kMouseDown;
      break;
    case Kind::kMouseMove:
      at();
      break;
    case Kind::kScroll:
      at();
      io.MouseWheel += static_cast<float>(event.amount);
      break;
    case Kind::kFocus:
      if (!event.on) {
        ReleaseKeys(io);
        std::fill(std::begin(io.MouseDown), std::end(io.MouseDown), false);
      }
      break;
    default:
      break;
  }
}

}  // namespace

void Ui::BeginFrame(double dt_s) {
  using Kind = WindowEvent::Kind;
  if (fonts_stale_) {
    LoadFonts();
    ApplyTheme();
  }
  ++frame_;
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(width_px_), static_cast<float>(height_px_)};
  const float last_s = std::exchange(io.DeltaTime, static_cast<float>(std::clamp(dt_s, 1e-4, 0.5)));
  // A slow window takes one press or release a frame, so that a double click lasts two of its frames. One long frame
  // after a short one is a window that had nothing to draw.
  io.MouseDoubleClickTime = std::max(kDoubleClick_s, 2.5f * std::min(io.DeltaTime, last_s));
  // A text field that never appears must not hold back the keys for ever.
  if (expects_text_ && (io.WantTextInput || ++expected_frames_ > 10)) {
    expects_text_ = false;
    expected_frames_ = 0;
  }
  const ImVec2 placed = io.MousePos;  // in the last frame, rounded
  std::set<int> changed;              // keys, and buttons as negative numbers
  bool pressed = false;
  bool acted = false;
  bool wrote = false;
  while (!queue_.empty()) {
    const WindowEvent& event = queue_.front();
    const bool key = event.kind == Kind::kKeyDown || event.kind == Kind::kKeyUp;
    const bool button = event.kind == Kind::kMouseDown || event.kind == Kind::kMouseUp;
    const bool text = event.kind == Kind::kText;
    // A release is of a key or button that acted before.
    if (expects_text_ && (event.kind == Kind::kKeyDown || text)) break;
    if (expects_text_ && clicks_wait_ && event.kind == Kind::kMouseDown) break;
    // After a press, the mouse stays in its place until the next frame.
    if (pressed && (button || event.kind == Kind::kMouseMove)) break;
    // Before a press, it has been there for a frame: Dear ImGui 1.90 takes no click on a row that was not hovered
    // before.
    if (event.kind == Kind::kMouseDown && !(std::abs(placed.x - static_cast<float>(event.x)) < 1 &&
                                            std::abs(placed.y - static_cast<float>(event.y)) < 1)) {
      io.MousePos = {static_cast<float>(event.x), static_cast<float>(event.y)};
      break;
    }
    // In a frame, Dear ImGui takes the mouse first, then the text, then one key.
    if ((wrote && button) || (acted && (key || text))) break;
    const bool acts = key && Acts(event) && !event.repeat;
    const int id = key ? static_cast<int>(event.key) : -1 - static_cast<int>(event.button);
    if ((acts || button) && !changed.insert(id).second) break;
    pressed = pressed || button;
    acted = acted || (acts && event.kind == Kind::kKeyDown);
    wrote = wrote || text;
    if (event.kind == Kind::kMouseDown && event.button == MouseButton::kLeft) {
      if (presses_follow_.front()) io.MouseDoubleClickTime = kAnyTime_s;
      presses_follow_.pop_front();
    }
    Feed(event);
    queue_.pop_front();
  }
  noted_.clear();
  textures_hash_ = 0;
  cut_texts_.clear();
  in_frame_ = true;
  ImGui::NewFrame();
  discards_text_ = std::exchange(closes_popups_, false);
  if (discards_text_) {
    if (is_popup_open()) ImGui::ClosePopupToLevel(0, false);
    ImGui::ClearActiveID();
  }
  ImGui::PushFont(normal_);
}

void Ui::EndFrame() {
  ImGui::PopFont();
  ImGui::Render();
  in_frame_ = false;
}

std::uint64_t Ui::CalcFrameHash() const {
  std::uint64_t hash = textures_hash_;
  const auto mix = [&hash](const void* from, std::size_t bytes) {
    const char* at = static_cast<const char*>(from);
    for (; bytes > 0; bytes -= std::min(bytes, sizeof(std::uint64_t)), at += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, at, std::min(bytes, sizeof word));
      hash = MixHash(hash ^ word);
    }
  };
  const ImDrawData* data = ImGui::GetDrawData();
  for (int i = 0; data != nullptr && i < data->CmdListsCount; ++i) {
    const ImDrawList& list = *data->CmdLists[i];
    mix(list.VtxBuffer.Data, static_cast<std::size_t>(list.VtxBuffer.size_in_bytes()));
    mix(list.IdxBuffer.Data, static_cast<std::size_t>(list.IdxBuffer.size_in_bytes()));
    for (const ImDrawCmd& command : list.CmdBuffer) {
      mix(&command.ClipRect, sizeof command.ClipRect);
      mix(&command.TextureId, sizeof command.TextureId);
    }
  }
  return hash;
}

void Ui::DropText() {
  ImGui::ClearActiveID();
  ImGui::GetIO().WantTextInput = false;
  ImGui::GetCurrentContext()->WantTextInputNextFrame = -1;
}

bool Ui::is_popup_open() const {
  return ImGui::GetCurrentContext()->OpenPopupStack.Size > 0;
}

bool Ui::takes_text() const {
  return ImGui::GetIO().WantTextInput;
}

unsigned int Ui::active_item() const {
  return ImGui::GetCurrentContext()->ActiveId;
}

bool Ui::IsOnPanel(double x_px, double y_px) const {
  if (is_popup_open()) return true;
  const std::vector<UiBox> boxes = PanelBoxes();
  return std::any_of(boxes.begin(), boxes.end(), [&](const UiBox& box) { return box.Contains(x_px, y_px); });
}

std::vector<UiBox> Ui::PanelBoxes() const {
  std::vector<UiBox> boxes;
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    // During a frame, the windows of the last one count.
    const bool active = in_frame_ ? window->WasActive : window->Active;
    const bool counts = active && !window->Hidden && window->ParentWindow == nullptr &&
                        (window->Flags & ImGuiWindowFlags_NoMouseInputs) == 0 &&
                        (window->Flags & ImGuiWindowFlags_Tooltip) == 0 && !window->IsFallbackWindow;
    if (counts) boxes.push_back(ToBox(*window));
  }
  return boxes;
}

void* Ui::Texture(const std::string& slot, const Image& image, std::uint64_t version) {
  textures_hash_ = MixHash(textures_hash_ ^ version);
  return state_->prop->Texture(slot, image, version);
}

void Ui::Note(std::string_view name) {
  const ImVec2 from = ImGui::GetItemRectMin();
  const ImVec2 to = ImGui::GetItemRectMax();
  noted_[std::string(name)] = {from.x, from.y, to.x - from.x, to.y - from.y};
}

}  // namespace kerf
