// Messages other than results. They are printed on stderr, with "kerf: " before each sentence.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace kerf::cli {

/// Returns `message` with "kerf: " before each line that begins a sentence. A line that begins with a space continues
/// the previous one. Unprintable characters (core/printable.h) are replaced by '?', because messages quote files, and
/// no file may control the terminal.
std::string FormatMessage(std::string_view message);

/// Prints FormatMessage(message) and a newline on stderr. Of sentences that differ only in their numbers, only the
/// first ten are printed. May be called by any thread.
void PrintMessage(std::string_view message);
/// Prints, at the program's end, how many messages of each kind were left out.
void PrintLeftOutMessages();

/// Calls PrintMessage() with a text formatted as by fmt::format.
template <typename... Args>
void Say(fmt::format_string<Args...> format, Args&&... args) {
  PrintMessage(fmt::format(format, std::forward<Args>(args)...));
}
/// Does the same with the prefix "warning: ".
template <typename... Args>
void SayWarning(fmt::format_string<Args...> format, Args&&... args) {
  PrintMessage("warning: " + fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace kerf::cli
