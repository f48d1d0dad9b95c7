// Checks that a text is well-formed XML, as far as kerf's own output needs: matching tags, quoted attributes, entities.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace kerf::test {

/// Returns "" if the text is well-formed, otherwise a description of the fault.
inline std::string FindXmlFault(std::string_view text) {
  const auto text_fault = [](std::string_view part) -> std::string {
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i] == '<') return "a '<' that begins no tag";
      if (static_cast<unsigned char>(part[i]) < 0x20 && part[i] != '\n') return "a control character";
      if (part[i] != '&') continue;
      const auto rest = part.substr(i);
      const bool known = rest.starts_with("&amp;") || rest.starts_with("&lt;") || rest.starts_with("&gt;") ||
                         rest.starts_with("&quot;");
      if (!known) return "an unknown entity";
    }
    return "";
  };
  std::vector<std::string> open;
  std::size_t i = 0;
  bool had_root = false;
  if (text.starts_with("<?xml")) i = text.find("?>") + 2;
  while (i < text.size()) {
    const std::size_t begin = std::min(text.find('<', i), text.size());
    const std::string_view between = text.substr(i, begin - i);
    if (std::string fault = text_fault(between); !fault.empty()) return fault;
    if (open.empty() && !std::all_of(between.begin(), between.end(), [](char c) { return c == '\n'; }))
      return "text outside the root";
    if (begin == text.size()) break;
    // Finds the '>' outside quotes.
    std::size_t end = begin + 1;
    bool quoted = false;
    while (end < text.size() && (quoted || text[end] != '>')) {
      if (text[end] == '"') quoted = !quoted;
      ++end;
    }
    if (end == text.size()) return "a tag that does not end";
    std::string_view tag = text.substr(begin + 1, end - begin - 1);
    i = end + 1;
    if (tag.starts_with("/")) {
      if (open.empty() || open.back() != tag.substr(1)) return "an end tag without a start tag: " + std::string(tag);
      open.pop_back();
      continue;
    }
    const bool closed = tag.ends_with("/");
    if (closed) tag.remove_suffix(1);
    const std::size_t name_end = std::min(tag.find(' '), tag.size());
    if (open.empty() && had_root) return "two roots";
    had_root = true;
    std::vector<std::string> names;
    std::size_t at = name_end;
    while (at < tag.size()) {
      if (tag[at] == ' ') {
        ++at;
        continue;
      }
      const std::size_t equals = tag.find("=\"", at);
      if (equals == std::string_view::npos) return "an attribute without a value: " + std::string(tag);
      const std::size_t close = tag.find('"', equals + 2);
      if (close == std::string_view::npos) return "an attribute that does not end";
      const std::string name(tag.substr(at, equals - at));
      if (std::find(names.begin(), names.end(), name) != names.end()) return "a repeated attribute: " + name;
      names.push_back(name);
      if (std::string fault = text_fault(tag.substr(equals + 2, close - equals - 2)); !fault.empty()) return fault;
      at = close + 1;
    }
    if (!closed) open.emplace_back(tag.substr(0, name_end));
  }
  if (!open.empty()) return "a tag that is not closed: " + open.back();
  return had_root ? "" : "no root";
}

}  // namespace kerf::test
