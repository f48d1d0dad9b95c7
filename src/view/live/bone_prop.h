// VTK prop that draws the bone's chunks. Each chunk has its own ranges of buffers on the graphics card, so that a cut
// uploads only the chunks that it changes.
#pragma once

#include <vtkProp.h>

#include <array>
#include <memory>
#include <vector>

#include "view/live/bone_chunks.h"
#include "view/picture/colours.h"

namespace kerf {

class BoneProp : public vtkProp {
 public:
  static BoneProp* New();
  vtkTypeMacro(BoneProp, vtkProp) BoneProp(const BoneProp&) = delete;
  BoneProp& operator=(const BoneProp&) = delete;

  /// Removes all chunks. `reach_mm`: no vertex is farther from the origin along any axis. Positions are rounded to
  /// 1/32767 of it.
  void Begin(const Vec3& origin_W, double reach_mm);
  void SetChunk(const ChunkMesh& mesh);
  /// Sets the colours, indexed by region; entries from 256 on are for cut faces. Alpha is 255 for tissue drawn with
  /// pores.
  void SetPalette(const std::array<std::array<std::uint8_t, 4>, 512>& palette);
  void SetTranslucent(bool translucent);
  void SetHidden(bool hidden);
  /// `pixel_mm`: size of a pixel of the window at the camera's target; `scale`: pixels per point.
  void SetPixel(double pixel_mm, double scale, double voxel_mm);
  /// Resolution at which uncut bone is drawn.
  struct Fineness {
    double cell_points = 1.5;           // minimum cell size, points
    double coarsest_cell_points = 3;    // maximum cell size, points
    std::size_t triangles = 6'000'000;  // maximum total number of triangles; decides between these sizes
  };
  void SetFineness(const Fineness& fineness);

  /// All are of the last picture, except `chunks`.
  struct Counts {
    std::size_t chunks = 0, drawn = 0, triangles = 0, bytes = 0;
    int step = 1;
  };
  const Counts& counts() const;
  /// Returns the corners of the bounding boxes of the chunks' surfaces.
  std::vector<Vec3> ListCorners() const;

  int RenderOpaqueGeometry(vtkViewport* viewport) override;
  double* GetBounds() override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  BoneProp();
  ~BoneProp() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
