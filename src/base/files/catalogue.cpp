#include "base/files/catalogue.h"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <optional>

#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::uint32_t kMagic = 0x950412de;
/// Texts with fewer letters between their replacement fields would be found in texts that were not made of them.
constexpr std::size_t kMinLetters = 8;

/// Returns the texts between the fields, such as {} or {0:.2f}, of a format.
std::vector<std::string> SplitAtFields(std::string_view format) {
  std::vector<std::string> parts{""};
  for (std::size_t i = 0; i < format.size(); ++i) {
    const bool doubled = i + 1 < format.size() && format[i + 1] == format[i];
    if (format[i] == '{' && !doubled) {
      parts.emplace_back();
      i = std::min(format.find('}', i), format.size());
    } else {
      parts.back() += format[i];
      if ((format[i] == '{' || format[i] == '}') && doubled) ++i;
    }
  }
  return parts;
}

/// Removes the formats of the fields: {:.2f} becomes {}.
std::string WithoutFormats(std::string_view format) {
  std::string out;
  bool skips = false;
  int depth = 0;
  for (const char c : format) {
    if (c == '{') ++depth;
    if (c == '}') skips = false, --depth;
    if (c == ':' && depth == 1) skips = true;
    if (!skips) out += c;
  }
  return out;
}

/// Returns the values that were put between the parts; none if the text was not made of them.
std::optional<std::vector<std::string>> MatchParts(const std::string& text, const std::vector<std::string>& parts) {
  const std::string& last = parts.back();
  if (!text.starts_with(parts.front()) || text.size() < parts.front().size() + last.size() || !text.ends_with(last)) {
    return std::nullopt;
  }
  std::vector<std::string> values;
  std::size_t at = parts.front().size();
  const std::size_t end = text.size() - last.size();
  for (std::size_t i = 1; i + 1 < parts.size(); ++i) {
    const std::size_t next = text.find(parts[i], at);
    if (next == std::string::npos || next + parts[i].size() > end) return std::nullopt;
    values.push_back(text.substr(at, next - at));
    at = next + parts[i].size();
  }
  values.push_back(text.substr(at, end - at));
  return values;
}

/// Replaces the points between two digits, except in what has several, such as the UID of a series.
std::string WithPoint(std::string text, std::string_view point) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find_first_not_of("0123456789.", i), text.size());
    const std::size_t at = text.find('.', i), next = text.find('.', at + 1);
    const bool is_last = next >= end || next + 1 == end;  // a full stop may follow
    if (at > i && at < end && at + 1 < end && is_last) text.replace(at, 1, point);
    i = end + 1;
  }
  return text;
}

}  // namespace

Catalogue::Catalogue(const std::string& file) : bytes_(ReadTextFile(file)) {
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    if (at > bytes_.size() || bytes_.size() - at < sizeof(value)) {
      throw Error(fmt::format("{}: is not a catalogue of gettext, or is damaged", file));
    }
    std::memcpy(&value, bytes_.data() + at, sizeof(value));
    return static_cast<std::size_t>(value);
  };
  const auto text = [&](std::size_t at) {
    const std::size_t length = number(at), offset = number(at + 4);
    if (offset >= bytes_.size() || length >= bytes_.size() - offset || bytes_[offset + length] != '\0') {
      throw Error(fmt::format("{}: is not a catalogue of gettext, or is damaged", file));
    }
    return std::string_view(bytes_).substr(offset, length);
  };
  if (number(0) != kMagic) throw Error(fmt::format("{}: is not a catalogue of gettext, or is damaged", file));
  const std::size_t count = number(8), texts = number(12), translations = number(16);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view original = text(texts + 8 * i), translated = text(translations + 8 * i);
    if (original.empty() || translated.empty()) continue;  // the first one is the header
    texts_[original] = translated.data();
    Form form{.parts = SplitAtFields(original), .letters = 0, .translated = WithoutFormats(translated)};
    for (const std::string& part : form.parts) {
      form.letters += static_cast<std::size_t>(
          std::count_if(part.begin(), part.end(), [](unsigned char c) { return std::isalpha(c) != 0; }));
    }
    if (form.parts.size() > 1 && form.letters >= kMinLetters) forms_.push_back(std::move(form));
  }
  std::stable_sort(forms_.begin(), forms_.end(), [](const Form& a, const Form& b) { return a.letters > b.letters; });
}

const char* Catalogue::Find(std::string_view text) const {
  const auto found = texts_.find(text);
  return found == texts_.end() ? nullptr : found->second;
}

std::string_view Catalogue::point() const {
  const char* const found = Find("decimal separator");
  return found != nullptr && std::strlen(found) == 1 ? found : ".";
}

std::string Catalogue::Translate(const std::string& text) const {
  if (const char* const found = Find(text)) return found;
  for (const Form& form : forms_) {
    const std::optional<std::vector<std::string>> values = MatchParts(text, form.parts);
    if (!values) continue;
    fmt::dynamic_format_arg_store<fmt::format_context> arguments;
    for (const std::string& value : *values) {
      const char* const word = Find(value);
      arguments.push_back(word != nullptr ? std::string(word) : WithPoint(value, point()));
    }
    try {
      return fmt::vformat(form.translated, arguments);
    } catch (const fmt::format_error&) {
      return text;  // the translation has other fields
    }
  }
  return text;
}

}  // namespace kerf
