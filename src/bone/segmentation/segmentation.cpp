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

}  // namespace

std::vector<Segment> ParseSegments(const std::map<std::string, std::string>& keys, std::size_t layers,
                                   const std::string& path) {
  const std::string kPrefix = "Segment";
  std::map<int, SegmentFields> all;
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
  }
  if (all.size() > kMaxSegments)
    throw Error(fmt::format("{}: the header has {} segments; kerf reads up to {}", path, all.size(), kMaxSegments));
  std::vector<Segment> segments;
  std::set<std::pair<int, int>> places;
  for (const auto& [number, fields] : all) {
    Segment segment;
    segment.name = Printable(FirstCharacters(fields.name.empty() ? fields.id : fields.name, kMaxSegmentName));
    if (segment.name.empty()) segment.name = fmt::format("Segment {}", number);
    // Files of 3D Slicer before version 4.11 have one layer with the value 1 for each segment.
    const bool is_old = fields.label.empty() && fields.layer.empty();
    if (is_old && layers != all.size())
      throw Error(fmt::format("{}: the header does not give the label of the segment '{}'", path, segment.name));
    const std::optional<int> label = fields.label.empty() ? std::optional(1) : ParseWhole(fields.label);
    if (!label || *label < 1 || *label > kMaxLabel) {
      throw Error(fmt::format("{}: the label of the segment '{}' is '{}'; it must be a whole number from 1 to {}", path,
                              segment.name, fields.label, kMaxLabel));
    }
    const std::optional<int> layer = is_old                 ? std::optional(static_cast<int>(segments.size()))
                                     : fields.layer.empty() ? std::optional(0)
                                                            : ParseWhole(fields.layer);
    if (!layer || *layer < 0 || *layer >= static_cast<int>(layers)) {
      throw Error(fmt::format("{}: the layer of the segment '{}' is '{}', but the file has {}", path, segment.name,
                              fields.layer, FormatCount(layers, "layer", "layers")));
    }
    segment.label = *label;
    segment.layer = *layer;
    if (!places.insert({segment.layer, segment.label}).second) {
      throw Error(fmt::format("{}: two segments have the label {} in layer {}", path, segment.label, segment.layer));
    }
    ParseTags(fields.tags, segment);
    segments.push_back(std::move(segment));
  }
  return segments;
}

std::string Describe(const Segment& segment) {
  if (segment.name.empty()) return fmt::format("label {} ({})", segment.label, FormatVolume(segment.volume_mm3));
  return fmt::format("'{}' (label {}{}, {})", segment.name, segment.label,
                     segment.layer > 0 ? fmt::format(" in layer {}", segment.layer) : "",
                     FormatVolume(segment.volume_mm3));
}

Segmentation ReadSegmentation(const std::string& path, const std::string& frame) {
  if (!HasImageExtension(path)) {
    throw Error(
        fmt::format("{}: unknown file type; a segmentation is a DICOM segmentation, a .seg.nrrd, or a label map "
                    "{}",
                    path, ListImageExtensions()));
  }
  LayeredImage image = ReadLayeredImage(path, frame);
  Segmentation segmentation;
  segmentation.path = path;
  segmentation.layers = std::move(image.layers);
  segmentation.segments = ParseSegments(image.keys, segmentation.layers.size(), path);
  segmentation.named = !segmentation.segments.empty();
  for (const std::vector<std::int16_t>& layer : segmentation.layers) {
    const std::string objection = FindLabelObjection(layer, image.lattice.exact, kMaxSegments + 1);
    if (!objection.empty()) {
      throw Error(fmt::format("{}: the file is not a segmentation: {}; export the segmentation as a label map", path,
                              objection));
    }
  }
  segmentation.lattice = std::move(image.lattice);
  segmentation.warnings = segmentation.lattice.warnings;
  if (!segmentation.named) {
    if (segmentation.layers.size() > 1) {
      throw Error(
          fmt::format("{}: the file has {} layers but does not name its segments", path, segmentation.layers.size()));
    }
    AddUnnamed(segmentation.layers.front(), segmentation.segments);
    if (segmentation.segments.empty()) throw Error(fmt::format("{}: the label map is empty", path));
  }
  if (const std::set<int> unnamed = CountVoxels(segmentation); !unnamed.empty()) {
    segmentation.warnings.push_back(fmt::format("the segmentation has voxels with {} that no segment has, such as {}",
                                                FormatCount(unnamed.size(), "label", "labels"), *unnamed.begin()));
  }
  return segmentation;
}

}  // namespace kerf
