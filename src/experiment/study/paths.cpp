#include "experiment/study/paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <mutex>
#include <numbers>
#include <utility>

#include "base/core/nearest_name.h"
#include "bone/material/region_table.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::uint64_t kMaxKept_bytes = std::uint64_t{150} << 20;

}  // namespace

Pose CalcUprightPose(const UprightMotion& motion, const DiscSaw& saw, double t_s) {
  const Quat upright = glm::angleAxis(-0.5 * std::numbers::pi, Vec3(1, 0, 0));
  return {glm::normalize(glm::angleAxis(motion.tilt_rad(t_s), Vec3(1, 0, 0)) * upright),
          {motion.x_mm(t_s), motion.y_mm(t_s), saw.radius_mm() - motion.depth_mm(t_s)}};
}

std::function<Bone(double, int)> RememberLast(std::function<Bone(double, int)> make) {
  struct Memory {
    std::mutex mutex;
    std::pair<double, int> what{0, 0};
    std::shared_ptr<const Bone> bone;
  };
  auto memory = std::make_shared<Memory>();
  return [memory, make = std::move(make)](double voxel_mm, int band_voxels) {
    const std::pair<double, int> what(voxel_mm, band_voxels);
    {
      std::shared_ptr<const Bone> last;
      {
        const std::lock_guard<std::mutex> lock(memory->mutex);
        if (memory->what == what) last = memory->bone;
      }
      if (last) return Bone(*last);
    }
    Bone bone = make(voxel_mm, band_voxels);
    const bool keep = bone.CalcMemoryBytes() <= kMaxKept_bytes;
    auto kept = keep ? std::make_shared<const Bone>(bone) : nullptr;
    const std::lock_guard<std::mutex> lock(memory->mutex);
    memory->what = what;
    memory->bone = std::move(kept);
    return bone;
  };
}

ExactSolid MakeSolid(std::function<double(const Vec3&)> distance_mm, std::function<int(const Vec3&)> region,
                     const MaterialTable& materials) {
  ExactSolid solid;
  solid.distance_mm = std::move(distance_mm);
  solid.material = [region = std::move(region), materials](const Vec3& p_W) {
    ExactSolid::Material material;
    material.region = region(p_W);
    if (material.region == 0) return material;
    const Region& found = materials.At(material.region);
    material.E_MPa = found.E_MPa;
    material.nu = found.nu;
    material.tissue = found.tissue;
    return material;
  };
  return solid;
}

StudyPath MakePlainPath(const std::string& name, const std::string& title) {
  StudyPath path;
  path.name = name;
  path.title = title;
  path.materials = DefaultMandibleTable();
  path.holdings = {Holding::kHand, Holding::kPath};
  return path;
}

std::vector<std::string> NamesOfStudyPaths() {
  return {"idle",      "entry",      "slot",    "plunge", "graze", "border",   "breakthrough", "tilt", "reentry",
          "free_form", "thin_plate", "lamella", "wedge",  "skim",  "crossing", "mandible",     "ct",   "worst"};
}

StudyPathList MakeStudyPaths(const std::vector<std::string>& names, const std::string& data_folder,
                             const std::string& cache_folder) {
  StudyPathList list;
  const std::vector<std::string> known = NamesOfStudyPaths();
  for (const std::string& name : names.empty() ? known : names) {
    if (name == "mandible") {
      list.paths.push_back(MakeMandiblePath());
    } else if (name == "ct") {
      try {
        list.paths.push_back(MakeCtPath(data_folder, cache_folder));
      } catch (const Error& error) {
        list.left_out.emplace_back(name, error.what());
      }
    } else if (std::optional<StudyPath> path = MakeBlockPath(name)) {
      list.paths.push_back(*std::move(path));
    } else {
      const std::string nearest = FindNearestName(name, known);
      throw Error(fmt::format("there is no path \"{}\"{}", name,
                              nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
    }
  }
  return list;
}

}  // namespace kerf
