// Keyboard, mouse and window events, independent of the window library.
#pragma once

#include <cstdint>
#include <string>

namespace kerf {

/// Keys, named after their labels on a US keyboard; letters and digits have their character codes.
enum class Key : std::uint16_t {
  kNone = 0,
  kSpace = ' ',
  kMinus = '-',
  kEqual = '=',
  kLeftBracket = '[',
  kRightBracket = ']',
  k0 = '0',
  k1 = '1',
  k2 = '2',
  k3 = '3',
  k4 = '4',
  k5 = '5',
  k6 = '6',
  k7 = '7',
  k8 = '8',
  k9 = '9',
  kA = 'A',
  kB = 'B',
  kC = 'C',
  kD = 'D',
  kE = 'E',
  kF = 'F',
  kG = 'G',
  kH = 'H',
  kI = 'I',
  kJ = 'J',
  kK = 'K',
  kL = 'L',
  kM = 'M',
  kN = 'N',
  kO = 'O',
  kP = 'P',
  kQ = 'Q',
  kR = 'R',
  kS = 'S',
  kT = 'T',
  kU = 'U',
  kV = 'V',
  kW = 'W',
  kX = 'X',
  kY = 'Y',
  kZ = 'Z',
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
  kF1,
  kF2,
  kF3,
  kF4,
  kF5,
  kF6,
  kF7,
  kF8,
  kF9,
  kF10,
  kF11,
  kF12,
};
enum class MouseButton : std::uint8_t { kLeft, kRight, kMiddle };

struct WindowEvent {
  enum class Kind : std::uint8_t {
    kKeyDown,  // key, repeat
    kKeyUp,    // key
    kText,     // character
    kMouseDown,
    kMouseUp,    // button, x, y
    kMouseMove,  // x, y
    kScroll,     // amount: notches, positive away from the user
    kResize,     // query the size from the window
    kFocus,      // on
    kMinimise,   // on
    kRefresh,    // the content of the window was lost
    kDrop,       // path of a file or folder
    kClose,
  };
  Kind kind = Kind::kClose;
  Key key = Key::kNone;
  bool repeat = false;
  char32_t character = 0;
  MouseButton button = MouseButton::kLeft;
  double x = 0;  // pixels of the picture from its left edge
  double y = 0;  // pixels from its top
  double amount = 0;
  bool on = false;
  std::string path;
  bool shift = false;
  bool control = false;
  bool alt = false;
};

}  // namespace kerf
