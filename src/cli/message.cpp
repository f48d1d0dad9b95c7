#include "cli/message.h"

#include <fmt/format.h>

#include <cstdio>

namespace kerf::cli {

std::string FormatMessage(std::string_view message) {
  std::string text;
  bool line_begins = true;
  for (const char c : message) {
    if (line_begins && c != ' ' && c != '\n') text += "kerf: ";
    line_begins = c == '\n';
    const auto byte = static_cast<unsigned char>(c);
    text += (byte < 0x20 && c != '\n') || byte == 0x7f ? '?' : c;
  }
  return text;
}

void PrintMessage(std::string_view message) {
  // A closed or full stderr is no reason to end: what it should have shown is lost, the exit code stays.
  std::fputs((FormatMessage(message) + '\n').c_str(), stderr);
}

}  // namespace kerf::cli
