#include "experiment/study/settings.h"

#include <fmt/format.h>

#include <charconv>

#include "kerf/error.h"

namespace kerf {
namespace {

template <typename Number>
bool ReadWhole(const std::string& text, Number& number) {
  Number read{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), read);
  if (error != std::errc() || end != text.data() + text.size()) return false;
  number = read;
  return true;
}

struct Shower {
  std::string wanted;  // empty: all
  std::string text;

  void Add(const std::string& key, const std::string& value) {
    if (wanted.empty()) {
      text += fmt::format("{}{}={}", text.empty() ? "" : " ", key, value);
    } else if (key == wanted) {
      text = value;
    }
  }
  void operator()(const char* key, double& value, Range, const char*) { Add(key, ShowNumber(value)); }
  void operator()(const char* key, int& value, Range, const char*) { Add(key, fmt::format("{}", value)); }
  void operator()(const char* key, std::string& value, const Choices&, const char*) { Add(key, value); }
};

struct Setter {
  const std::string& knob;
  const std::string& text;
  bool good = false;

  void operator()(const char* key, double& value, Range, const char*) {
    if (key == knob) good = ReadWhole(text, value);
  }
  void operator()(const char* key, int& value, Range, const char*) {
    if (key == knob) good = ReadWhole(text, value);
  }
  void operator()(const char* key, std::string& value, const Choices&, const char*) {
    if (key != knob) return;
    value = text;
    good = true;
  }
};

}  // namespace

std::string ShowNumber(double number) {
  return fmt::format("{}", number);
}

std::string ValueOf(const StudySettings& settings, const std::string& knob) {
  FindKnob(knob);
  StudySettings copy = settings;
  Shower shower{knob, ""};
  Describe(copy, shower);
  return shower.text;
}

void SetValue(StudySettings& settings, const std::string& knob, const std::string& value) {
  FindKnob(knob);
  Setter setter{knob, value};
  Describe(settings, setter);
  if (!setter.good) throw Error(fmt::format("\"{}\" is not a value of {}", value, knob));
}

std::string ShowSettings(const StudySettings& settings) {
  StudySettings copy = settings;
  Shower shower;
  Describe(copy, shower);
  return shower.text;
}

std::uint64_t HashText(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

std::string ShowHash(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

}  // namespace kerf
