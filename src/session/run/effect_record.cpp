#include "session/run/effect_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "cut/effects/plan.h"

namespace kerf {

EffectRecord::EffectRecord(const EffectPlan& plan) {
  for (const EffectPlan::Entry& entry : plan.entries()) {
    on.emplace_back(entry.info->name);
    for (const EffectChannel& channel : entry.info->channels) {
      figures.push_back({entry.info->name, channel.name});
    }
  }
  for (const EffectInfo* info : plan.left_out()) left_out.emplace_back(info->name);
}

void EffectRecord::Take(std::span<const double> channels) {
  for (std::size_t i = 0; i < figures.size(); ++i) {
    EffectFigure& figure = figures[i];
    figure.last = channels[i];
    figure.sum += channels[i];
    figure.smallest = ticks == 0 ? channels[i] : std::min(figure.smallest, channels[i]);
    figure.largest = ticks == 0 ? channels[i] : std::max(figure.largest, channels[i]);
  }
  ++ticks;
}

void EffectRecord::TakeRow(std::span<const double> channels) {
  Take(channels);
  rows.insert(rows.end(), channels.begin(), channels.begin() + static_cast<std::ptrdiff_t>(figures.size()));
}

EffectRecord EffectRecord::WithoutRows() const {
  EffectRecord record;
  record.on = on;
  record.left_out = left_out;
  record.figures = figures;
  record.ticks = ticks;
  return record;
}

std::string EffectRecord::Header() const {
  std::string text;
  for (const EffectFigure& figure : figures) text.append(",").append(figure.column());
  return text;
}

std::string EffectRecord::Row(std::size_t row) const {
  return FormatEffectRow(std::span(rows).subspan(row * figures.size(), figures.size()));
}

std::string FormatEffectRow(std::span<const double> channels) {
  std::string text;
  for (const double value : channels) fmt::format_to(std::back_inserter(text), ",{:.6g}", value);
  return text;
}

std::vector<std::string> DescribeEffects(const EffectRecord& record) {
  std::vector<std::string> phrases;
  for (const std::string& effect : record.on) {
    std::string text = effect;
    for (const EffectFigure& figure : record.figures) {
      if (figure.effect != effect) continue;
      text += fmt::format("{} {} {:.4g}", text == effect ? ":" : ",", figure.name, figure.last);
      if (figure.smallest != figure.largest)
        text += fmt::format(" ({:.4g} to {:.4g})", figure.smallest, figure.largest);
    }
    phrases.push_back(text);
  }
  for (const std::string& effect : record.left_out) {
    phrases.push_back(effect + ": omitted; it needs a coupled simulation ('kerf loop')");
  }
  return phrases;
}

}  // namespace kerf
