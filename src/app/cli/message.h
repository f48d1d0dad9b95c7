// What the program says beside its results: on stderr, each sentence with "kerf: " before it.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace kerf::cli {

/// `message` with "kerf: " before each line that begins a sentence; a line that begins with a space continues the one
/// before. What is not printable (core/printable.h) becomes '?', since messages quote files and nothing in a file may
/// control the terminal.
std::string FormatMessage(std::string_view message);

/// Prints FormatMessage(message) and a line end on stderr; of sentences that differ in their numbers only, the first
/// ten. Any thread.
void PrintMessage(std::string_view message);
/// At the program's end: how many more there were of each kind.
void PrintLeftOutMessages();

/// PrintMessage of a text formatted as by fmt::format.
template <typename... Args>
void Say(fmt::format_string<Args...> format, Args&&... args) {
  PrintMessage(fmt::format(format, std::forward<Args>(args)...));
}
/// The same with "warning: " before it.
template <typename... Args>
void SayWarning(fmt::format_string<Args...> format, Args&&... args) {
  PrintMessage("warning: " + fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace kerf::cli
