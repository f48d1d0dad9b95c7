// What a person does with keyboard, mouse and window, as the rest of the program sees it.
#pragma once

#include <cstdint>

namespace kerf {

/// Keys by what is printed on them on a keyboard laid out as in the US; letters and digits are their characters.
enum class Key : std::uint16_t {
  kNone = 0,
  kSpace = ' ',
  kMinus = '-',
  kEqual = '=',
  kLeftBracket = '[',
  kRightBracket = ']',
  // 'A' to 'Z', '0' to '9': Letter(), Digit()
  kEscape = 256,
  kEnter,
  kTab,
  kBackspace,
  kDelete,
  kLeft,
  kRight,
  kUp,
  kDown,
  kPageUp,
  kPageDown,
  kHome,
  kEnd,
  kF1,  // to kF12, in a row
  kF12 = kF1 + 11,
};
constexpr Key Letter(char c) {
  return static_cast<Key>(c);
}
constexpr Key Digit(int n) {
  return static_cast<Key>('0' + n);
}
constexpr Key Function(int n) {
  return static_cast<Key>(static_cast<int>(Key::kF1) + n - 1);
}

enum class MouseButton : std::uint8_t { kLeft, kRight, kMiddle };

struct WindowEvent {
  enum class Kind : std::uint8_t {
    kKeyDown,  // key, repeat
    kKeyUp,    // key
    kText,     // character
    kMouseDown,
    kMouseUp,    // button, x, y
    kMouseMove,  // x, y
    kScroll,     // amount: notches, away from the hand positive
    kResize,     // the size is asked of the window
    kFocus,      // on
    kMinimise,   // on
    kClose,
  };
  Kind kind = Kind::kClose;
  Key key = Key::kNone;
  bool repeat = false;
  char32_t character = 0;
  MouseButton button = MouseButton::kLeft;
  double x = 0;  // pixels of the picture from its left edge
  double y = 0;  // from its top
  double amount = 0;
  bool on = false;
  bool shift = false;
  bool control = false;
  bool alt = false;
};

}  // namespace kerf
