// Differences of colours for any colour vision, and contrast of text. Computed, not judged by eye.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "view/picture/colours.h"

namespace kerf::test {

using Rgb = std::array<double, 3>;

inline Rgb ToLinear(const Rgb8& c) {
  Rgb linear{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double v = c[i] / 255.0;
    linear[i] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  return linear;
}

using Matrix = std::array<Rgb, 3>;
// From Machado, Oliveira and Fernandes 2009, severity 1, for linear RGB.
inline constexpr Matrix kNormal{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
inline constexpr Matrix kProtan{
    {{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}};
inline constexpr Matrix kDeutan{
    {{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}};
inline constexpr Matrix kTritan{
    {{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}};

// Returns the colour in CIE L*a*b*, D65.
inline Rgb ToLab(const Rgb8& colour, const Matrix& eye) {
  const Rgb c = ToLinear(colour);
  Rgb s{};
  for (std::size_t i = 0; i < 3; ++i) {
    s[i] = std::clamp(eye[i][0] * c[0] + eye[i][1] * c[1] + eye[i][2] * c[2], 0.0, 1.0);
  }
  const double x = (0.4124564 * s[0] + 0.3575761 * s[1] + 0.1804375 * s[2]) / 0.95047;
  const double y = 0.2126729 * s[0] + 0.7151522 * s[1] + 0.0721750 * s[2];
  const double z = (0.0193339 * s[0] + 0.1191920 * s[1] + 0.9503041 * s[2]) / 1.08883;
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  return {116 * f(y) - 16, 500 * (f(x) - f(y)), 200 * (f(y) - f(z))};
}

inline double Difference(const Rgb8& a, const Rgb8& b, const Matrix& eye) {
  const Rgb p = ToLab(a, eye);
  const Rgb q = ToLab(b, eye);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

inline void ExpectApart(const std::vector<Rgb8>& colours, double least, const std::string& what) {
  for (const Matrix& eye : {kNormal, kProtan, kDeutan, kTritan}) {
    for (std::size_t i = 0; i < colours.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_GT(Difference(colours[i], colours[j], eye), least) << what << " " << i << " " << j;
      }
    }
  }
}

/// Contrast of two colours as defined by WCAG 2, 1 to 21.
inline double CalcContrast(const Rgb8& a, const Rgb8& b) {
  const auto luminance = [](const Rgb8& c) {
    const Rgb l = ToLinear(c);
    return 0.2126 * l[0] + 0.7152 * l[1] + 0.0722 * l[2];
  };
  const double p = luminance(a) + 0.05;
  const double q = luminance(b) + 0.05;
  return std::max(p, q) / std::min(p, q);
}

}  // namespace kerf::test
