// Import of marks from a file: curves of 3D Slicer, or a label map.
#pragma once

#include <chrono>
#include <future>
#include <string>
#include <vector>

#include "app/window/plan_document.h"

namespace kerf {

/// Returns whether the path has the extension of curves of 3D Slicer.
bool IsCurvesPath(const std::string& path);

class MarkImport {
 public:
  MarkImport(ViewerApp& viewer, PlanDocument& document) : viewer_(viewer), document_(document) {}

  /// Marks must lie near this box.
  void set_bone_W(const Box3& box_W) { bone_W_ = box_W; }
  void AskFile();
  /// Adds the marks of a file, as one step; of a label map, once it is read and the user has said what it contains. If
  /// that is not possible, a dialog says why. Call it only while a session runs.
  void Read(const std::string& path);
  bool is_reading() const { return reading_.valid(); }
  /// Discards what is being read.
  void Reset();
  /// Called once per frame while no dialog is open.
  void Update();
  /// Waits until no work is left, but not longer than `until`. Returns false if some is left.
  bool WaitUntil(std::chrono::steady_clock::time_point until) const;

 private:
  struct Labels {
    std::vector<Mark> marks;
    std::size_t left_out = 0;
    std::vector<std::string> warnings;
  };
  static Labels ReadLabels(const std::string& path, std::size_t max_marks);
  void AskKind(Labels labels);
  void CheckPlace(const std::vector<Mark>& marks) const;
  void Add(std::vector<Mark> marks);
  void Refuse(const std::string& why);

  ViewerApp& viewer_;
  PlanDocument& document_;
  Box3 bone_W_;
  std::string file_;  // name of the file that is read
  std::future<Labels> reading_;
  std::vector<std::future<Labels>> discarded_;  // end by themselves
};

}  // namespace kerf
