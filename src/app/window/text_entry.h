// Input of a line of text.
#pragma once

#include <string>

#include "app/window/event.h"

namespace kerf {

class TextEntry {
 public:
  TextEntry(std::string question, std::string text) : question_(std::move(question)), text_(std::move(text)) {}

  enum class State { kOpen, kDone, kCancelled };
  /// Accepts text, Backspace, Enter and Escape; consumes every other event without effect. At most 60 characters;
  /// control characters are ignored.
  State Take(const WindowEvent& event);
  const std::string& question() const { return question_; }
  const std::string& text() const { return text_; }  // UTF-8

 private:
  std::string question_;
  std::string text_;
};

}  // namespace kerf
