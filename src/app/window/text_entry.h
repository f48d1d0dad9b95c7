// A line that is being typed.
#pragma once

#include <string>

#include "app/window/event.h"

namespace kerf {

class TextEntry {
 public:
  TextEntry(std::string question, std::string preset) : question_(std::move(question)), text_(std::move(preset)) {}

  enum class State { kOpen, kDone, kLeft };
  /// Letters, backspace, Enter, Escape; everything else is taken and does nothing. At most 60 characters; control
  /// characters are not taken.
  State Take(const WindowEvent& event);
  const std::string& question() const { return question_; }
  const std::string& text() const { return text_; }  // UTF-8

 private:
  std::string question_;
  std::string text_;
};

}  // namespace kerf
