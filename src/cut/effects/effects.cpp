#include "cut/effects/effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <utility>

#include "base/core/new_name.h"
#include "kerf/describe.h"
#include "kerf/error.h"

namespace kerf {
namespace {

const char* NameKind(const EffectValue& value) {
  return std::array{"a number", "true or false", "three numbers", "a string"}[value.index()];
}

std::vector<const EffectInfo*>& AllEffects() {
#define KERF_LIST_EFFECT(function) &function(),
  static std::vector<const EffectInfo*> effects{KERF_EFFECTS(KERF_LIST_EFFECT)};
#undef KERF_LIST_EFFECT
  return effects;
}

}  // namespace

const std::vector<const EffectInfo*>& Effects() {
  return AllEffects();
}

void RegisterEffect(EffectInfo info) {
  CheckNewName("effect", info.name, [](std::string_view name) { return FindEffect(name) != nullptr; });
  if (info.make_own == nullptr) throw Error(fmt::format("the effect {} has no make_own", info.name));
  if ((info.hooks & ~unsigned{kEffectBegin | kEffectSolved | kEffectEnd | kEffectPush}) != 0) {
    throw Error(fmt::format("the effect {} lists a hook that is only for kerf's own effects", info.name));
  }
  static std::deque<EffectInfo> registered;
  AllEffects().push_back(&registered.emplace_back(std::move(info)));
}

const EffectInfo* FindEffect(std::string_view name) {
  for (const EffectInfo* info : Effects()) {
    if (info->name == name) return info;
  }
  return nullptr;
}

std::size_t EffectInfo::FindParameter(std::string_view key) const {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].key == key) return i;
  }
  std::vector<std::string_view> keys;
  for (const EffectParameter& p : parameters) keys.emplace_back(p.key);
  throw Error(fmt::format("the effect {} has no parameter '{}'; {}", name, key,
                          keys.empty() ? "it has none" : fmt::format("it has {}", fmt::join(keys, ", "))));
}

EffectChoice::EffectChoice(std::string_view name) : info_(FindEffect(name)) {
  if (info_ == nullptr) {
    std::vector<std::string_view> names;
    for (const EffectInfo* info : Effects()) names.emplace_back(info->name);
    throw Error(fmt::format("there is no effect '{}'; available: {}", name, fmt::join(names, ", ")));
  }
  for (const EffectParameter& parameter : info_->parameters) values_.push_back(parameter.default_value);
  files_.resize(values_.size());
}

double EffectChoice::GetNumber(std::string_view key) const {
  const double* number = std::get_if<double>(&values_[info_->FindParameter(key)]);
  if (number == nullptr) throw Error(fmt::format("{} of the effect {} is not a number", key, name()));
  return *number;
}

EffectChoice& EffectChoice::Set(std::string_view key, EffectValue value) {
  const std::size_t i = info_->FindParameter(key);
  if (value.index() != values_[i].index()) {
    throw Error(fmt::format("{} of the effect {} is {}, not {}", key, name(), NameKind(values_[i]), NameKind(value)));
  }
  values_[i] = std::move(value);
  return *this;
}

const EffectChoice* FindChoice(const EffectChoices& choices, std::string_view name) {
  const auto at = std::find_if(choices.begin(), choices.end(), [&](const EffectChoice& c) { return c.name() == name; });
  return at == choices.end() ? nullptr : &*at;
}

EffectChoice& EffectChoice::SetFile(std::string_view key, EffectFile file) {
  const std::size_t i = info_->FindParameter(key);
  if (info_->parameters[i].file == EffectFileKind::kNone) {
    throw Error(fmt::format("{} of the effect {} does not name a file", key, name()));
  }
  values_[i] = file.name;
  files_[i] = std::make_shared<const EffectFile>(std::move(file));
  return *this;
}

void SetEffect(EffectChoices& choices, std::string_view name, std::string_view key, EffectValue value) {
  auto at = std::find_if(choices.begin(), choices.end(), [&](const EffectChoice& c) { return c.name() == name; });
  if (at == choices.end()) at = choices.insert(at, EffectChoice(name));
  at->Set(key, std::move(value));
}

void SetEffect(EffectChoices& choices, std::string_view name, std::string_view key, double value) {
  SetEffect(choices, name, key, EffectValue(value));
}

void RemoveEffect(EffectChoices& choices, std::string_view name) {
  std::erase_if(choices, [&](const EffectChoice& c) { return c.name() == name; });
}

void CheckEffects(const EffectChoices& choices) {
  std::vector<std::string> faults;
  for (const EffectChoice& choice : choices) {
    const EffectInfo& info = choice.info();
    if (FindChoice(choices, info.name) != &choice)
      faults.push_back(fmt::format("the effect {} is listed twice", info.name));
    for (const char* needed : info.needs) {
      if (FindChoice(choices, needed) == nullptr) {
        faults.push_back(fmt::format("the effect {} needs the effect {}", info.name, needed));
      }
    }
    if (info.find_fault != nullptr) {
      const std::string fault = info.find_fault(choice.values());
      if (!fault.empty()) faults.push_back(fmt::format("the effect {}: {}", info.name, fault));
    }
    for (std::size_t i = 0; i < info.parameters.size(); ++i) {
      const EffectParameter& parameter = info.parameters[i];
      const auto check = [&](double x) {
        const std::string fault = FindRangeFault(x, {parameter.lower, parameter.upper}, UnitOfKey(parameter.key));
        if (!fault.empty()) {
          faults.push_back(fmt::format("the effect {}: {} = {} {}", info.name, parameter.key, x, fault));
        } else if (parameter.whole && x != std::round(x)) {
          faults.push_back(fmt::format("the effect {}: {} = {} is not a whole number", info.name, parameter.key, x));
        }
      };
      if (const auto* number = std::get_if<double>(&choice.values()[i])) check(*number);
      if (const auto* vector = std::get_if<Vec3>(&choice.values()[i])) {
        for (int axis = 0; axis < 3; ++axis) check((*vector)[axis]);
      }
      const auto* text = std::get_if<std::string>(&choice.values()[i]);
      if (text != nullptr && !parameter.words.empty() &&
          std::find(parameter.words.begin(), parameter.words.end(), *text) == parameter.words.end()) {
        faults.push_back(fmt::format("{} = \"{}\" of the effect {} must be one of: {}", parameter.key, *text, info.name,
                                     fmt::join(parameter.words, ", ")));
      }
    }
  }
  if (!faults.empty()) throw Error(fmt::format("{}", fmt::join(faults, "\n")));
}

}  // namespace kerf
