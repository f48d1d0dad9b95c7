#include "app/window/text_entry.h"

#include <algorithm>
#include <cstddef>

namespace kerf {
namespace {

constexpr std::ptrdiff_t kLongest = 60;

bool BeginsCharacter(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
}

void AppendUtf8(std::string& text, char32_t c) {
  const auto add = [&](char32_t bits) { text.push_back(static_cast<char>(bits)); };
  if (c < 0x80) {
    add(c);
  } else if (c < 0x800) {
    add(0xc0 | c >> 6);
    add(0x80 | (c & 0x3f));
  } else if (c < 0x10000) {
    add(0xe0 | c >> 12);
    add(0x80 | (c >> 6 & 0x3f));
    add(0x80 | (c & 0x3f));
  } else {
    add(0xf0 | c >> 18);
    add(0x80 | (c >> 12 & 0x3f));
    add(0x80 | (c >> 6 & 0x3f));
    add(0x80 | (c & 0x3f));
  }
}

}  // namespace

TextEntry::State TextEntry::Take(const WindowEvent& event) {
  if (event.kind == WindowEvent::Kind::kText) {
    const char32_t c = event.character;
    const bool prints = c >= 0x20 && !(c >= 0x7f && c < 0xa0) && c < 0x110000;
    if (prints && std::count_if(text_.begin(), text_.end(), BeginsCharacter) < kLongest) AppendUtf8(text_, c);
    return State::kOpen;
  }
  if (event.kind != WindowEvent::Kind::kKeyDown) return State::kOpen;
  if (event.key == Key::kEscape) return State::kCancelled;
  if (event.key == Key::kEnter) return State::kDone;
  if (event.key == Key::kBackspace && !text_.empty()) {
    while (!text_.empty() && !BeginsCharacter(text_.back())) text_.pop_back();
    if (!text_.empty()) text_.pop_back();
  }
  return State::kOpen;
}

}  // namespace kerf
