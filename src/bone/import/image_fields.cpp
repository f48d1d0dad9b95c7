#include "bone/import/image_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>

#include "base/files/files.h"
#include "bone/import/limits.h"
#include "bone/import/unpack.h"
#include "kerf/error.h"

namespace kerf {

namespace {

std::string Trim(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string FieldName(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), ' '), text.end());
  return Lower(Trim(text));
}

bool IsList(const std::string& data_file) {
  return Lower(data_file.substr(0, data_file.find_first_of(" \t"))) == "list";
}

}  // namespace

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::vector<double> ParseNumbers(const std::string& text) {
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double v = 0; in >> v;) numbers.push_back(v);
  return numbers;
}

std::string ImageFields::Get(const std::string& name) const {
  const auto found = values.find(name);
  return found == values.end() ? "" : found->second;
}

std::string ReadHead(const std::string& path) {
  std::ifstream in = OpenImageFile(path);
  if (!in) throw Error(fmt::format("{}: the file can't be opened", path));
  std::string head(kMaxImageHeaderBytes, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  CheckReadable(in, path);
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

ImageFields ParseNrrdFields(const std::string& head) {
  ImageFields fields;
  while (fields.end < head.size() && !fields.complete) {
    std::size_t end = head.find('\n', fields.end);
    if (end == std::string::npos && IsList(fields.Get("datafile"))) end = head.size();
    if (end == std::string::npos) break;
    const std::string line = Trim(head.substr(fields.end, end - fields.end));
    fields.end = end + 1;
    fields.complete = line.empty();
    const std::size_t colon = line.find(": ");
    if (line.empty() || line[0] == '#') continue;
    if (IsList(fields.Get("datafile"))) {
      fields.files.push_back(line);
      continue;
    }
    if (const std::size_t assign = line.find(":="); assign < colon) {
      fields.keys[line.substr(0, assign)] = line.substr(assign + 2);
      continue;
    }
    if (colon == std::string::npos) continue;
    fields.values[FieldName(line.substr(0, colon))] = Trim(line.substr(colon + 2));
  }
  return fields;
}

ImageFields ParseMetaFields(const std::string& head) {
  ImageFields fields;
  while (fields.end < head.size() && !fields.complete) {
    const std::size_t end = std::min(head.find('\n', fields.end), head.size());
    const std::string line = Trim(head.substr(fields.end, end - fields.end));
    fields.end = end + 1;
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string name = FieldName(line.substr(0, equals));
    const std::string value = Trim(line.substr(equals + 1));
    fields.values[name] = value;
    fields.complete = name == "elementdatafile" && !value.empty();
  }
  if (IsList(fields.Get("elementdatafile"))) {
    std::istringstream rest(head.substr(std::min(fields.end, head.size())));
    for (std::string line; std::getline(rest, line);) {
      if (line = Trim(line); !line.empty()) fields.files.push_back(line);
    }
  }
  return fields;
}

}  // namespace kerf
