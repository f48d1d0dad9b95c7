// Random numbers that are the same with every standard library. (The standard distributions differ between libraries.)
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <random>

#include "kerf/geometry.h"

namespace kerf::test {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  std::uint64_t Bits() { return random_(); }
  /// Returns a number uniform in [0, 1).
  double Unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double Uniform(double lower, double upper) { return lower + (upper - lower) * Unit(); }
  /// Returns a number from `lower` to `upper`; each order of magnitude is equally likely.
  double LogUniform(double lower, double upper) { return lower * std::pow(upper / lower, Unit()); }
  /// Returns an integer from 0 to `count` - 1.
  int Below(int count) { return static_cast<int>(Unit() * count); }
  bool OneIn(int count) { return Below(count) == 0; }
  template <typename T>
  T One(std::initializer_list<T> of) {
    return of.begin()[Below(static_cast<int>(of.size()))];
  }
  /// Returns a point uniform in the cube from -1 to 1.
  Vec3 InCube() {
    const double x = Uniform(-1, 1);
    const double y = Uniform(-1, 1);
    return {x, y, Uniform(-1, 1)};
  }
  /// Returns a unit vector, uniform over all directions.
  Vec3 Direction() {
    for (;;) {
      const Vec3 v = InCube();
      const double length = glm::length(v);
      if (length > 0.1 && length <= 1) return v / length;
    }
  }
  Quat Rotation() {
    const Vec3 axis = Direction();
    return glm::angleAxis(Uniform(0, std::numbers::pi), axis);
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace kerf::test
