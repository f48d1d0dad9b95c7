// Mathematical functions that return the same bits on every processor.
//
// The C library has several versions of sin, pow and similar functions, with and without fused multiply-add, and
// selects one according to the processor when a program starts. They differ in the last bit, so a replay on another
// machine would differ from its recording. This file replaces them with SLEEF's scalar functions without fused
// multiply-add (Shibata and Petrogalli, IEEE TPDS 31, 2020): a single version with an error of at most one unit in the
// last place. The replacement applies to every program that links this file and to the libraries that the program uses.
// sqrt, fmod, floor and other functions that are exact by definition need no replacement.
#include <sleef.h>

// Symbol that makes the linker include this file (src/base/CMakeLists.txt).
extern "C" int kerf_same_math;
int kerf_same_math = 0;

extern "C" {
double sin(double x) noexcept {
  return Sleef_cinz_sind1_u10purec(x);
}
double cos(double x) noexcept {
  return Sleef_cinz_cosd1_u10purec(x);
}
// The compiler combines sin and cos of the same argument into this call.
void sincos(double x, double* s, double* c) noexcept {
  *s = Sleef_cinz_sind1_u10purec(x);
  *c = Sleef_cinz_cosd1_u10purec(x);
}
double tan(double x) noexcept {
  return Sleef_cinz_tand1_u10purec(x);
}
double asin(double x) noexcept {
  return Sleef_cinz_asind1_u10purec(x);
}
double acos(double x) noexcept {
  return Sleef_cinz_acosd1_u10purec(x);
}
double atan(double x) noexcept {
  return Sleef_cinz_atand1_u10purec(x);
}
double atan2(double y, double x) noexcept {
  return Sleef_cinz_atan2d1_u10purec(y, x);
}
double exp(double x) noexcept {
  return Sleef_cinz_expd1_u10purec(x);
}
double expm1(double x) noexcept {
  return Sleef_cinz_expm1d1_u10purec(x);
}
double log(double x) noexcept {
  return Sleef_cinz_logd1_u10purec(x);
}
double log1p(double x) noexcept {
  return Sleef_cinz_log1pd1_u10purec(x);
}
double log10(double x) noexcept {
  return Sleef_cinz_log10d1_u10purec(x);
}
double pow(double x, double y) noexcept {
  return Sleef_cinz_powd1_u10purec(x, y);
}
double cbrt(double x) noexcept {
  return Sleef_cinz_cbrtd1_u10purec(x);
}
double hypot(double x, double y) noexcept {
  return Sleef_cinz_hypotd1_u05purec(x, y);
}
}
