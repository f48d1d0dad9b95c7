#include "bone/import/patient_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>

#include "kerf/error.h"

namespace kerf {

namespace {

constexpr std::string_view kPositive = "LPS";
constexpr std::string_view kNegative = "RAI";

}  // namespace

glm::dmat3 LpsFromFrame(const std::string& frame) {
  glm::dmat3 turn(0);
  for (std::size_t n = 0; n < 3 && frame.size() == 3; ++n) {
    const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(frame[n])));
    const int column = static_cast<int>(n);
    if (const std::size_t row = kPositive.find(letter); row != kPositive.npos) turn[column][static_cast<int>(row)] = 1;
    if (const std::size_t row = kNegative.find(letter); row != kNegative.npos) turn[column][static_cast<int>(row)] = -1;
  }
  if (std::abs(glm::determinant(turn)) != 1) {
    throw Error(fmt::format(
        "the frame '{}' is unknown; give three letters for where x, y and z of the file point: L or R, A or P, "
        "S or I, such as LPS (left, posterior, superior) or RAS",
        frame));
  }
  return turn;
}

std::string FrameName(const glm::dmat3& lps_from_frame) {
  std::string name;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      const double v = lps_from_frame[column][row];
      if (v != 0) name += v > 0 ? kPositive[static_cast<std::size_t>(row)] : kNegative[static_cast<std::size_t>(row)];
    }
  }
  return name;
}

void PlaceLattice(const Vec3& origin, const glm::dmat3& steps, double unit_mm, Volume& volume) {
  const glm::dmat3 turn = LpsFromFrame(volume.frame);
  volume.origin_W = turn * (origin * unit_mm) + 0.0;  // + 0.0 removes the sign of a zero, so that hashes agree
  for (int a = 0; a < 3; ++a) {
    const double length = std::sqrt(glm::dot(steps[a], steps[a]));
    volume.spacing_mm[a] = length * unit_mm;
    volume.axes_W[a] = turn * (steps[a] * (1 / length)) + 0.0;
  }
}

void DropFrameWarnings(std::vector<std::string>& warnings) {
  std::erase_if(warnings, [](const std::string& warning) { return warning.ends_with("with --frame"); });
}

void ReinterpretFrame(const std::string& frame, Volume& volume) {
  const glm::dmat3 turn = LpsFromFrame(frame);
  volume.frame = frame;
  volume.origin_W = turn * volume.origin_W;
  volume.axes_W = turn * volume.axes_W;
  for (SliceGap& gap : volume.gaps) gap.normal_W = turn * gap.normal_W;
}

Volume StoreAlongPatient(Volume volume) {
  // The order of axes that maximises the sum of their components along x, y and z.
  std::array<int, 3> order = {0, 1, 2};
  std::array<int, 3> best = order;
  double best_sum = -1;
  do {
    double sum = 0;
    for (int a = 0; a < 3; ++a) sum += std::abs(volume.axes_W[order[a]][a]);
    if (sum > best_sum + 1e-9) {
      best_sum = sum;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));

  Volume stored;
  stored.frame = volume.frame;
  stored.warnings = volume.warnings;
  stored.gaps = volume.gaps;
  stored.origin_W = volume.origin_W;
  const std::array<std::ptrdiff_t, 3> stride = {1, volume.size[0],
                                                static_cast<std::ptrdiff_t>(volume.size[0]) * volume.size[1]};
  std::array<std::ptrdiff_t, 3> step{};
  std::ptrdiff_t first = 0;
  for (int a = 0; a < 3; ++a) {
    const int from = best[a];
    const bool backwards = volume.axes_W[from][a] < 0;
    stored.size[a] = volume.size[from];
    stored.spacing_mm[a] = volume.spacing_mm[from];
    stored.axes_W[a] = backwards ? -volume.axes_W[from] + 0.0 : volume.axes_W[from];
    step[a] = backwards ? -stride[from] : stride[from];
    if (!backwards) continue;
    first += stride[from] * (volume.size[from] - 1);
    stored.origin_W += volume.axes_W[from] * (volume.spacing_mm[from] * (volume.size[from] - 1));
  }
  if (first == 0 && best == std::array<int, 3>{0, 1, 2}) return volume;
  const auto store = [&](const auto& from, auto& to) {
    to.reserve(from.size());
    for (int k = 0; k < stored.size[2]; ++k) {
      for (int j = 0; j < stored.size[1]; ++j) {
        const std::ptrdiff_t start = first + k * step[2] + j * step[1];
        for (int i = 0; i < stored.size[0]; ++i) to.push_back(from[static_cast<std::size_t>(start + i * step[0])]);
      }
    }
  };
  store(volume.hu, stored.hu);
  if (!volume.padding.empty()) store(volume.padding, stored.padding);
  return stored;
}

}  // namespace kerf
