#include "bone/segmentation/segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include "base/core/number_text.h"
#include "base/core/printable.h"
#include "bone/import/image_file.h"
#include "bone/import/image_header.h"
#include "bone/import/label_image.h"
#include "bone/segmentation/label_table.h"
#include "bone/segmentation/roles.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr int kMaxLabel = 32767;

std::optional<int> ParseWhole(const std::string& text) {
  int value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  while (true) {
    const std::size_t end = text.find(separator, from);
    parts.push_back(text.substr(from, end - from));
    if (end == std::string::npos) return parts;
    from = end + 1;
  }
}

// Returns the code of "scheme^code^meaning" if the scheme is SNOMED CT; otherwise empty.
std::string FindCode(const std::string& entry) {
  const std::vector<std::string> parts = Split(entry, '^');
  return parts.size() >= 2 && parts[0] == "SCT" ? parts[1] : "";
}

// Takes the terminology of "TerminologyEntry:list~category~type~modifier~list~region~modifier|other tag:value|...".
void ParseTags(const std::string& text, Segment& segment) {
  const std::string kTag = "TerminologyEntry:";
  for (const std::string& tag : Split(text, '|')) {
    if (tag.compare(0, kTag.size(), kTag) != 0) continue;
    const std::vector<std::string> entries = Split(tag.substr(kTag.size()), '~');
    const auto code = [&entries](std::size_t n) { return n < entries.size() ? FindCode(entries[n]) : std::string(); };
    segment.category = code(1);
    for (const std::size_t n : {2, 5}) {
      if (!code(n).empty()) segment.codes.push_back(code(n));
    }
    for (const std::size_t n : {3, 6}) {
      if (!code(n).empty()) segment.modifiers.push_back(code(n));
    }
  }
}

// The fields of one segment in a header.
struct SegmentFields {
  std::string name, label, layer, tags, id;
};

// Counts the voxels of all segments. Returns the labels that no segment has, without 0.
std::set<int> CountVoxels(Segmentation& segmentation) {
  std::set<int> unnamed;
  for (std::size_t n = 0; n < segmentation.layers.size(); ++n) {
    std::vector<std::size_t> counts(kMaxLabel + 1, 0);
    for (const std::int16_t label : segmentation.layers[n]) ++counts[static_cast<std::size_t>(label)];
    for (Segment& segment : segmentation.segments) {
      if (segment.layer != static_cast<int>(n)) continue;
      std::size_t& count = counts[static_cast<std::size_t>(segment.label)];
      segment.voxels = count;
      segment.volume_mm3 = static_cast<double>(count) * segmentation.lattice.CalcVoxelVolume();
      count = 0;
    }
    for (int label = 1; label <= kMaxLabel; ++label) {
      if (counts[static_cast<std::size_t>(label)] > 0) unnamed.insert(label);
    }
  }
  return unnamed;
}

void AddUnnamed(const std::vector<std::int16_t>& labels, std::vector<Segment>& segments) {
  std::vector<bool> found(kMaxLabel + 1, false);
  for (const std::int16_t label : labels) found[static_cast<std::size_t>(label)] = true;
  for (int label = 1; label <= kMaxLabel; ++label) {
    if (!found[static_cast<std::size_t>(label)]) continue;
    Segment segment;
    segment.label = label;
    segments.push_back(segment);
  }
}

// Returns the labels of each layer.
std::vector<std::set<int>> ListLabels(const Segmentation& segmentation) {
  std::vector<std::set<int>> labels;
  for (const std::vector<std::int16_t>& layer : segmentation.layers) {
    std::vector<bool> found(kMaxLabel + 1, false);
    for (const std::int16_t label : layer) found[static_cast<std::size_t>(label)] = true;
    labels.emplace_back();
    for (int label = 1; label <= kMaxLabel; ++label) {
      if (found[static_cast<std::size_t>(label)]) labels.back().insert(label);
    }
  }
  return labels;
}

// Gives segments whose label the header does not give, or gives wrong, those labels of the voxels that are left.
void MatchLabels(Segmentation& segmentation) {
  std::vector<std::set<int>> left = ListLabels(segmentation);
  for (const Segment& segment : segmentation.segments)
    left[static_cast<std::size_t>(segment.layer)].erase(segment.label);
  for (std::size_t layer = 0; layer < left.size(); ++layer) {
    std::vector<Segment*> all, unknown;
    for (Segment& segment : segmentation.segments) {
      if (segment.layer != static_cast<int>(layer)) continue;
      all.push_back(&segment);
      if (segment.label == 0) unknown.push_back(&segment);
    }
    const std::set<int>& labels = left[layer];
    if (unknown.empty()) {
      // A layer of one segment has it, whatever its value.
      const bool is_wrong = all.size() == 1 && labels.size() == 1 &&
                            std::ranges::find(segmentation.layers[layer], static_cast<std::int16_t>(all[0]->label)) ==
                                segmentation.layers[layer].end();
      if (!is_wrong) continue;
      segmentation.warnings.push_back(
          fmt::format("the header gives the segment '{}' the label {}, but its voxels have only {}, which was taken",
                      all[0]->name, all[0]->label, *labels.begin()));
      all[0]->label = *labels.begin();
      continue;
    }
    if (unknown.size() != labels.size()) {
      throw Error(fmt::format(
          "{}: the header does not give the label of the segment '{}', and the voxels have {} for {} without one",
          segmentation.path, unknown[0]->name, FormatCount(labels.size(), "label", "labels"),
          FormatCount(unknown.size(), "segment", "segments")));
    }
    std::string taken;
    auto label = labels.begin();
    for (Segment* segment : unknown) {
      segment->label = *label++;
      taken += fmt::format("{}{} for '{}'", taken.empty() ? "" : ", ", segment->label, segment->name);
    }
    segmentation.warnings.push_back(fmt::format(
        "the header does not give the labels of segments; those of the voxels were taken in order: {}", taken));
  }
}

// Returns whether the values up to `upper` change from voxel to voxel, as in a soft map, and do not form regions.
bool IsGraded(const std::vector<std::int16_t>& layer, int upper) {
  std::size_t between = 0, equal = 0;
  for (std::size_t v = 0; v + 1 < layer.size(); ++v) {
    if (layer[v] < 0 || layer[v] > upper) return false;
    if (layer[v] == 0 || layer[v] == upper) continue;
    ++between;
    equal += layer[v + 1] == layer[v] ? 1 : 0;
  }
  return 2 * equal < between && std::ranges::find(layer, upper) != layer.end();
}

// Makes labels of the values of a soft map: from 0 to 1 and not whole, or from 0 to 100 or 255. Leaves another map as
// it is.
void TakeSoft(const std::string& path, const std::string& frame, double threshold, LayeredImage& image) {
  constexpr int kSteps = 1000;
  const auto is_within = [](const LayeredImage& of, int upper) {
    return std::ranges::all_of(of.layers, [upper](const std::vector<std::int16_t>& layer) {
      return std::ranges::all_of(layer, [upper](std::int16_t value) { return value >= 0 && value <= upper; });
    });
  };
  int steps = 0, upper = 1;
  for (const int graded : {100, 255}) {
    if (image.layers.size() == 1 && IsGraded(image.layers.front(), graded)) steps = upper = graded;
  }
  if (!image.lattice.exact && is_within(image, 1)) {
    LayeredImage fine = ReadLayeredImage(path, frame, kSteps);
    if (!is_within(fine, kSteps)) return;
    image = std::move(fine);
    steps = kSteps;
  }
  if (steps == 0) return;
  for (std::vector<std::int16_t>& layer : image.layers) {
    for (std::int16_t& value : layer) value = value > 0 && value >= threshold * steps ? 1 : 0;
  }
  image.lattice.exact = true;
  image.lattice.warnings.push_back(fmt::format(
      "the values of the map are not labels, but from 0 to {}: voxels from {:g} on were taken as the label 1; "
      "to change this, use --mask-threshold",
      upper, threshold * upper));
}

// Names the segments of a label map, and adds those of the jaw that have a name, but no voxel.
void TakeNames(const std::map<int, std::string>& names, std::vector<Segment>& segments) {
  for (Segment& segment : segments) {
    if (const auto name = names.find(segment.label); name != names.end()) segment.name = name->second;
  }
  for (const auto& [label, name] : names) {
    if (segments.size() >= kMaxSegments) return;
    const std::optional<SegmentMeaning> meaning = FindMeaning(name);
    const bool in_jaw = meaning && (meaning->role == SegmentRole::kMandible || meaning->role == SegmentRole::kCanal);
    if (!in_jaw || std::ranges::find(segments, label, &Segment::label) != segments.end()) continue;
    Segment segment;
    segment.name = name;
    segment.label = label;
    segments.push_back(std::move(segment));
  }
}

// The fields that say where a segment's voxels are.
void PlaceSegment(const SegmentFields& fields, std::size_t layers, std::size_t segments, bool has_layers,
                  const std::string& path, Segment& segment, bool& flattened) {
  // Files of 3D Slicer before version 4.11 have one layer with the value 1 for each segment.
  const bool one_each = !has_layers && layers == segments && layers > 1;
  std::optional<int> label = ParseWhole(fields.label);
  if (fields.label.empty()) label = layers == segments || (layers > 1 && has_layers) ? 1 : 0;
  if (!label || *label < 0 || *label > kMaxLabel || (*label == 0 && !fields.label.empty())) {
    throw Error(fmt::format("{}: the label of the segment '{}' is '{}'; it must be a whole number from 1 to {}", path,
                            segment.name, fields.label, kMaxLabel));
  }
  std::optional<int> layer = fields.layer.empty() ? std::optional(0) : ParseWhole(fields.layer);
  if (!one_each && layer && *layer > 0 && layers == 1) {
    flattened = true;
    layer = 0;
  }
  if (!layer || *layer < 0 || *layer >= static_cast<int>(layers)) {
    throw Error(fmt::format("{}: the layer of the segment '{}' is '{}', but the file has {}", path, segment.name,
                            fields.layer, FormatCount(layers, "layer", "layers")));
  }
  segment.label = *label;
  if (!one_each) segment.layer = *layer;
}

}  // namespace

std::string DescribeUnnamed(const std::set<int>& labels) {
  return fmt::format("the segmentation has voxels with {} that no segment has, such as {}",
                     FormatCount(labels.size(), "label", "labels"), *labels.begin());
}

std::vector<Segment> ParseSegments(const std::map<std::string, std::string>& keys, std::size_t layers,
                                   const std::string& path, std::vector<std::string>& warnings) {
  const std::string kPrefix = "Segment";
  std::map<int, SegmentFields> all;
  bool has_layers = false, flattened = false;
  for (const auto& [key, value] : keys) {
    const std::size_t bar = key.find('_');
    if (key.compare(0, kPrefix.size(), kPrefix) != 0 || bar == std::string::npos) continue;
    const std::optional<int> number = ParseWhole(key.substr(kPrefix.size(), bar - kPrefix.size()));
    if (!number || *number < 0) continue;
    SegmentFields& fields = all[*number];
    const std::string field = key.substr(bar + 1);
    if (field == "Name") fields.name = value;
    if (field == "ID") fields.id = value;
    if (field == "LabelValue") fields.label = value;
    if (field == "Layer") fields.layer = value;
    if (field == "Tags") fields.tags = value;
    has_layers |= field == "Layer" && !value.empty();
  }
  if (all.size() > kMaxSegments)
    throw Error(fmt::format("{}: the header has {} segments; kerf reads up to {}", path, all.size(), kMaxSegments));
  std::vector<Segment> segments;
  std::set<std::pair<int, int>> places;
  for (const auto& [number, fields] : all) {
    Segment segment;
    segment.name = Printable(FirstCharacters(fields.name.empty() ? fields.id : fields.name, kMaxSegmentName));
    if (segment.name.empty()) segment.name = fmt::format("Segment {}", number);
    segment.layer = static_cast<int>(segments.size());
    PlaceSegment(fields, layers, all.size(), has_layers, path, segment, flattened);
    if (segment.label != 0 && !places.insert({segment.layer, segment.label}).second) {
      throw Error(fmt::format("{}: two segments have the label {} in layer {}{}", path, segment.label, segment.layer,
                              flattened ? "; the header names more layers, but the file has only this one" : ""));
    }
    ParseTags(fields.tags, segment);
    segments.push_back(std::move(segment));
  }
  if (flattened) {
    warnings.emplace_back(
        "the header names several layers, but the file has one: its segments were found by their labels, and where "
        "they overlapped, only one of them is left");
  }
  return segments;
}

std::string Describe(const Segment& segment) {
  if (segment.name.empty()) return fmt::format("label {} ({})", segment.label, FormatVolume(segment.volume_mm3));
  return fmt::format("'{}' (label {}{}, {})", segment.name, segment.label,
                     segment.layer > 0 ? fmt::format(" in layer {}", segment.layer) : "",
                     FormatVolume(segment.volume_mm3));
}

Segmentation ReadSegmentation(const std::string& path, const std::string& frame, double threshold) {
  if (!HasImageExtension(path)) {
    throw Error(
        fmt::format("{}: unknown file type; a segmentation is a DICOM segmentation, a .seg.nrrd, or a label map "
                    "{}",
                    path, ListImageExtensions()));
  }
  LayeredImage image = ReadLayeredImage(path, frame);
  TakeSoft(path, frame, threshold, image);
  Segmentation segmentation;
  segmentation.path = path;
  segmentation.layers = std::move(image.layers);
  for (const std::vector<std::int16_t>& layer : segmentation.layers) {
    const std::string objection = FindLabelObjection(layer, image.lattice.exact, kMaxSegments + 1);
    if (!objection.empty()) {
      throw Error(fmt::format("{}: the file is not a segmentation: {}; export the segmentation as a label map", path,
                              objection));
    }
  }
  segmentation.lattice = std::move(image.lattice);
  segmentation.warnings = segmentation.lattice.warnings;
  segmentation.segments = ParseSegments(image.keys, segmentation.layers.size(), path, segmentation.warnings);
  segmentation.named = !segmentation.segments.empty();
  if (segmentation.named) {
    MatchLabels(segmentation);
  } else {
    if (segmentation.layers.size() > 1) {
      throw Error(
          fmt::format("{}: the file has {} layers but does not name its segments", path, segmentation.layers.size()));
    }
    AddUnnamed(segmentation.layers.front(), segmentation.segments);
    if (segmentation.segments.empty()) throw Error(fmt::format("{}: the label map is empty", path));
    if (HasNiftiExtension(path)) {
      const std::map<int, std::string> names = ReadLabelTable(path);
      segmentation.named = !names.empty();
      TakeNames(names, segmentation.segments);
    }
  }
  if (const std::set<int> unnamed = CountVoxels(segmentation); !unnamed.empty()) {
    segmentation.warnings.push_back(DescribeUnnamed(unnamed));
  }
  return segmentation;
}

}  // namespace kerf
