// Separation of the mandible from bone that it touches, by points that the user clicks in the slices of a CT.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/window/ct_preview.h"

namespace kerf {

class JawSeparation {
 public:
  enum class Answer { kNone, kSeparate, kCancel };

  /// `iso_hu`: voxels above this are bone.
  JawSeparation(std::shared_ptr<const Volume> ct, double iso_hu) : ct_(std::move(ct)), iso_hu_(iso_hu) {}

  /// Asks for points. `why`: why they, or more of them, are needed, in the language of the window.
  void Ask(const std::string& why);
  /// Returns true while points are asked for; false while the CT is imported with them.
  bool asks() const { return asks_; }
  /// Ends asking if there are points in both kinds of bone. Returns false otherwise.
  bool Separate();

  /// Adds a point to the list that is chosen. A point away from bone is refused, with a sentence in `refusal()`.
  void Take(const Vec3& p_W);
  /// Removes the point that was added last.
  void TakeBack();
  void Remove(bool keep, std::size_t i);
  /// Chooses the list that Take() adds to: points in the mandible, or in other bone.
  void set_keeps(bool keeps) { keeps_ = keeps; }
  bool can_separate() const { return !keep_W_.empty() && !drop_W_.empty(); }
  /// Points in the mandible and in other bone, mm.
  const std::vector<Vec3>& keep_W() const { return keep_W_; }
  const std::vector<Vec3>& drop_W() const { return drop_W_; }
  const std::string& refusal() const { return refusal_; }

  /// Draws what is asked over the scene, and the slices in it and in the column.
  Answer Draw(Ui& ui, const UiBox& scene, const UiBox& column, CtPreview& slices);
  void Describe(nlohmann::json& state) const;

 private:
  std::vector<CtMark> ListMarks() const;
  void DrawChoice(Ui& ui, bool keep);
  void DrawList(Ui& ui, bool keep, CtPreview& slices);

  std::shared_ptr<const Volume> ct_;
  double iso_hu_;
  bool asks_ = false;
  bool keeps_ = true;
  std::string why_;
  std::string refusal_;
  std::vector<Vec3> keep_W_, drop_W_;
  std::vector<bool> order_;  // of the points: true for each one in the mandible
};

}  // namespace kerf
