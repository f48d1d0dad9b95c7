// The bone's chunks as something that VTK draws: each on the graphics card by itself, so that a cut uploads what it
// changed.
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

  void Begin(const Vec3& origin_W);  // forgets all chunks
  void SetChunk(const ChunkMesh& mesh);
  /// Colours by region, and from 256 on where it was cut; `a` is 255 for what looks spongy.
  void SetPalette(const std::array<std::array<std::uint8_t, 4>, 512>& palette);
  void SetTranslucent(bool translucent);
  void SetHidden(bool hidden);
  /// Of the window's pixels at the camera's target; `scale`: pixels a point.
  void SetPixel(double pixel_mm, double scale, double voxel_mm);
  /// How fine bone that was not cut is drawn.
  struct Fineness {
    double cell_points = 1.5;           // no finer than this
    double coarsest_cell_points = 3;    // nor coarser
    std::size_t triangles = 6'000'000;  // in between as many triangles as this, all in all
  };
  void SetFineness(const Fineness& fineness);

  struct Counts {
    std::size_t chunks = 0, drawn = 0, triangles = 0, bytes = 0;
    int step = 1;
  };
  const Counts& counts() const;
  /// Corners of the boxes that hold the chunks' surfaces.
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
