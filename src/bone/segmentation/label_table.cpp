#include "bone/segmentation/label_table.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "base/core/printable.h"
#include "bone/import/limits.h"
#include "bone/import/unpack.h"
#include "bone/segmentation/segmentation.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

constexpr int kMaxTableLabel = 32767;

std::optional<int> ParseLabel(std::string_view text) {
  int value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc() || end != text.data() + text.size() || value < 1 || value > kMaxTableLabel) {
    return std::nullopt;
  }
  return value;
}

void AddName(std::optional<int> label, std::string_view name, std::map<int, std::string>& table) {
  const std::size_t first = name.find_first_not_of(" \t\r\n");
  if (!label || first == std::string_view::npos || table.size() >= std::size_t{kMaxTableLabel}) return;
  name = name.substr(first, name.find_last_not_of(" \t\r\n") - first + 1);
  table[*label] = Printable(FirstCharacters(name, kMaxSegmentName));
}

// Reads <Label Key="1" ...><![CDATA[mandible]]></Label>.
void ParseXml(std::string_view text, std::map<int, std::string>& table) {
  constexpr std::string_view kKey = " Key=\"", kOpen = "<![CDATA[", kClose = "]]>";
  for (std::size_t at = 0; (at = text.find("<Label ", at)) != std::string_view::npos;) {
    const std::size_t close = text.find('>', at);
    const std::size_t end = text.find("</Label>", at);
    if (close == std::string_view::npos || end == std::string_view::npos || close > end) return;
    const std::string_view attributes = text.substr(at, close - at);
    std::string_view name = text.substr(close + 1, end - close - 1);
    at = end;
    const std::size_t key = attributes.find(kKey);
    if (key == std::string_view::npos) continue;
    const std::string_view number = attributes.substr(key + kKey.size());
    if (const std::size_t open = name.find(kOpen); open != std::string_view::npos) {
      name = name.substr(open + kOpen.size());
      name = name.substr(0, name.find(kClose));
    }
    AddName(ParseLabel(number.substr(0, number.find('"'))), name, table);
  }
}

std::optional<int> ToLabel(const Json& value) {
  if (value.is_number_integer()) return ParseLabel(value.dump());
  return value.is_string() ? ParseLabel(value.get_ref<const std::string&>()) : std::nullopt;
}

// Reads {"1": "mandible"}, {"mandible": 1} and [{"label": 1, "name": "mandible"}], at any depth.
void ParseJson(const Json& json, std::map<int, std::string>& table) {
  if (json.is_object() && json.contains("name") && json["name"].is_string()) {
    for (const char* key : {"label", "value", "id", "index"}) {
      if (json.contains(key)) AddName(ToLabel(json[key]), json["name"].get_ref<const std::string&>(), table);
    }
  }
  for (const auto& [key, value] : json.items()) {
    if (value.is_structured()) {
      ParseJson(value, table);
    } else if (json.is_object() && value.is_string()) {
      AddName(ParseLabel(key), value.get_ref<const std::string&>(), table);
    } else if (json.is_object() && !json.contains("name")) {
      AddName(ToLabel(value), key, table);
    }
  }
}

// Returns a whole number in the file's byte order; 0 if the bytes end before it.
std::uint64_t ReadWhole(std::string_view bytes, std::size_t at, std::size_t count, bool big_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count && at + count <= bytes.size(); ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[at + (big_endian ? i : count - 1 - i)]);
  }
  return value;
}

}  // namespace

std::map<int, std::string> ParseLabelTable(std::string_view text) {
  constexpr std::size_t kMaxDepth = 64;  // the recursion below goes as deep
  std::map<int, std::string> table;
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return table;
  if (text[first] == '<') {
    ParseXml(text, table);
    return table;
  }
  const std::size_t last = text.find_last_of("]}");
  if ((text[first] != '{' && text[first] != '[') || last == std::string_view::npos) return table;
  bool deep = false;
  const auto watch = [&deep](int depth, Json::parse_event_t, Json&) {
    deep |= depth > static_cast<int>(kMaxDepth);
    return !deep;
  };
  const Json json = Json::parse(text.substr(first, last - first + 1), watch, false);
  if (!deep && !json.is_discarded()) ParseJson(json, table);
  return table;
}

std::map<int, std::string> ReadLabelTable(const std::string& path) {
  std::string bytes(kMaxImageHeaderBytes, '\0');
  if (IsGzip(path)) {
    std::vector<char> unpacked;
    Unpack(path, 0, static_cast<double>(bytes.size()), 0, &unpacked);
    bytes.assign(unpacked.begin(), unpacked.end());
  } else {
    std::ifstream in = OpenImageFile(path);
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(in.gcount()));
  }
  const bool big_endian = ReadWhole(bytes, 0, 4, false) > 1000;
  const std::uint64_t header = ReadWhole(bytes, 0, 4, big_endian);  // 348 of NIfTI-1, 540 of NIfTI-2
  if (header != 348 && header != 540) return {};
  const auto flag_at = static_cast<std::size_t>(header);
  if (bytes.size() < flag_at + 4 || bytes[flag_at] == '\0') return {};
  std::map<int, std::string> table;
  const double voxels_at =
      header == 540
          ? static_cast<double>(ReadWhole(bytes, 168, 8, big_endian))
          : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(ReadWhole(bytes, 108, 4, big_endian))));
  // The size of an extension counts its own 8 bytes of size and code.
  for (std::size_t at = flag_at + 4; at + 8 <= bytes.size();) {
    const std::uint64_t size = ReadWhole(bytes, at, 4, big_endian);
    if (size < 16 || size % 16 != 0 || size > bytes.size() - at) break;
    if (!(static_cast<double>(at + size) <= voxels_at)) break;
    std::string_view text = std::string_view(bytes).substr(at + 8, static_cast<std::size_t>(size) - 8);
    text = text.substr(0, text.find('\0'));
    for (const auto& [label, name] : ParseLabelTable(text)) table.emplace(label, name);
    at += static_cast<std::size_t>(size);
  }
  return table;
}

}  // namespace kerf
