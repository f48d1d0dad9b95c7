#include "session/scene/schema.h"

#include <array>
#include <utility>

#include "device/devices/hand.h"

namespace kerf {

const std::vector<std::string_view>& BoneModelWords() {
  static const std::vector<std::string_view> kWords{"mandible", "block", "plate"};
  return kWords;
}

const std::vector<std::string_view>& ForceLawWords() {
  const auto list = [] {
    std::vector<std::string_view> words;
    for (const ForceLawInfo* law : ForceLaws()) words.emplace_back(law->name);
    return words;
  };
  static std::vector<std::string_view> words = list();
  if (words.size() != ForceLaws().size()) words = list();  // a program has added a law
  return words;
}

const std::vector<std::string_view>& HandWords() {
  static const std::vector<std::string_view> kWords = [] {
    std::vector<std::string_view> words;
    for (const HandModel& hand : HandModels()) words.emplace_back(hand.name);
    return words;
  }();
  return kWords;
}

BoneSource BoneSourceFromModel(std::string_view word) {
  if (word == "mandible") return BoneSource::kMandible;
  return word == "plate" ? BoneSource::kPlate : BoneSource::kBlock;
}

std::string_view ToString(BoneSource source) {
  switch (source) {
    case BoneSource::kFile:
      return "";
    case BoneSource::kMandible:
      return "mandible";
    case BoneSource::kBlock:
      return "block";
    case BoneSource::kPlate:
      return "plate";
  }
  return "";
}

}  // namespace kerf
