#include "session/link/bone_inbox.h"

#include <fmt/format.h>

#include <utility>

#include "base/files/files.h"
#include "bone/mesh/meshfile.h"
#include "kerf/error.h"

namespace kerf {
namespace {

std::string FormatVector(const Vec3& v) {
  return fmt::format("({},{},{})", v.x, v.y, v.z);
}

/// Returns a .seg.nrrd in which the segment is called as the wanted bone is.
std::string FormatSegmentation(const Volume& labels) {
  std::string text = fmt::format(
      "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n"
      "space directions: {} {} {}\nkinds: domain domain domain\nencoding: raw\nspace origin: {}\n"
      "Segment0_ID:=kerf_bone\nSegment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Name:=mandible\n\n",
      labels.size[0], labels.size[1], labels.size[2], FormatVector(labels.axes_W[0] * labels.spacing_mm.x),
      FormatVector(labels.axes_W[1] * labels.spacing_mm.y), FormatVector(labels.axes_W[2] * labels.spacing_mm.z),
      FormatVector(labels.origin_W));
  text.reserve(text.size() + labels.hu.size());
  for (const std::int16_t label : labels.hu) text += static_cast<char>(label);
  return text;
}

}  // namespace

bool IsBoneMessage(const IgtlHeader& header) {
  return header.device == kBoneName && (header.type == "IMAGE" || header.type == "POLYDATA");
}

std::string WriteSentBone(const SentBone& bone, const std::string& path) {
  if (const auto* surface = std::get_if<TriangleMesh>(&bone)) {
    WriteMesh(*surface, path + ".ply");
    return path + ".ply";
  }
  WriteTextFile(path + ".seg.nrrd", FormatSegmentation(std::get<Volume>(bone)));
  return path + ".seg.nrrd";
}

void BoneInbox::Open() {
  const std::lock_guard lock(mutex_);
  open_ = true;
}

void BoneInbox::Close() {
  const std::lock_guard lock(mutex_);
  open_ = false;
  waiting_.reset();
}

void BoneInbox::Check() const {
  const std::lock_guard lock(mutex_);
  if (!open_) throw Error("the bone of this session is fixed; 'kerf rehearse' takes another one");
  if (Clock::now() < next_) {
    throw Error(fmt::format("a bone was sent less than {} s ago; send this one again", kBetween.count()));
  }
}

void BoneInbox::Take(const IgtlHeader& header, std::span<const std::uint8_t> content) {
  Check();
  SentBone bone = header.type == "IMAGE" ? SentBone(ReadIgtlLabelMap(content)) : SentBone(ReadIgtlSurface(content));
  const std::lock_guard lock(mutex_);
  if (!open_) return;
  waiting_ = std::move(bone);
  next_ = Clock::now() + kBetween;
}

std::optional<SentBone> BoneInbox::Fetch() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, std::nullopt);
}

}  // namespace kerf
