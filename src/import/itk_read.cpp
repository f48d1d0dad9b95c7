#include "import/itk_read.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gdcmTrace.h>
#include <itkObject.h>
#include <nifti1_io.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <type_traits>

#include "kerf/error.h"

namespace kerf {

QuietItk::QuietItk()
    : cerr_(std::cerr.rdbuf(nullptr)),
      cout_(std::cout.rdbuf(nullptr)),
      warnings_(itk::Object::GetGlobalWarningDisplay()),
      stderr_copy_(dup(STDERR_FILENO)) {
  itk::Object::GlobalWarningDisplayOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  gdcm::Trace::DebugOff();
  nifti_set_debug_level(0);
  // libjpeg and its like write to the C stream.
  std::fflush(stderr);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere < 0) return;
  dup2(nowhere, STDERR_FILENO);
  close(nowhere);
}

QuietItk::~QuietItk() {
  std::cerr.rdbuf(cerr_);
  std::cout.rdbuf(cout_);
  // A stream without a buffer turns bad when something is written to it.
  std::cerr.clear();
  std::cout.clear();
  itk::Object::SetGlobalWarningDisplay(warnings_);
  if (stderr_copy_ < 0) return;
  std::fflush(stderr);
  dup2(stderr_copy_, STDERR_FILENO);
  close(stderr_copy_);
}

std::string OneLine(const itk::ExceptionObject& e) {
  std::string text = e.GetDescription();
  // "ITK ERROR: GDCMImageIO(0x55d0): what is wrong": the class and its address help nobody.
  const std::size_t end = text.find("): ");
  if (text.rfind("ITK ERROR: ", 0) == 0 && end != std::string::npos) text.erase(0, end + 3);
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text;
}

namespace {

template <typename T>
void AppendAs(const std::vector<char>& buffer, const std::string& name, std::vector<std::int16_t>& out) {
  const std::size_t n = buffer.size() / sizeof(T);
  const T* values = reinterpret_cast<const T*>(buffer.data());
  std::size_t not_numbers = 0;
  out.reserve(out.size() + n);
  for (std::size_t i = 0; i < n; ++i) {
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(values[i])) {
        ++not_numbers;
        continue;
      }
    }
    const double v = std::clamp(static_cast<double>(values[i]), -32768.0, 32767.0);
    out.push_back(static_cast<std::int16_t>(std::lround(v)));
  }
  if (not_numbers > 0) {
    throw Error(
        fmt::format("{}: {} of {} voxels are not finite numbers; replace them (by -1024 for air) and import again",
                    name, not_numbers, n));
  }
}

}  // namespace

void AppendPixels(itk::ImageIOBase& io, const std::string& name, std::vector<std::int16_t>& out,
                  const std::string& complaint) {
  using Io = itk::ImageIOBase;
  if (io.GetNumberOfComponents() != 1) {
    throw Error(
        fmt::format("{}: each voxel has {} components (a colour or vector image); kerf needs one HU value per voxel",
                    name, io.GetNumberOfComponents()));
  }
  std::size_t bytes = io.GetComponentSize();
  itk::ImageIORegion region(io.GetNumberOfDimensions());
  for (unsigned a = 0; a < io.GetNumberOfDimensions(); ++a) {
    region.SetSize(a, io.GetDimensions(a));
    region.SetIndex(a, 0);
    bytes *= io.GetDimensions(a);
  }
  io.SetIORegion(region);
  std::vector<char> buffer(bytes);
  try {
    io.Read(buffer.data());
  } catch (const itk::ExceptionObject& e) {
    throw Error(fmt::format("{}: {} ({})", name, complaint, OneLine(e)));
  }
  switch (io.GetComponentType()) {
    case Io::UCHAR:
      return AppendAs<unsigned char>(buffer, name, out);
    case Io::CHAR:
      return AppendAs<signed char>(buffer, name, out);
    case Io::USHORT:
      return AppendAs<unsigned short>(buffer, name, out);
    case Io::SHORT:
      return AppendAs<short>(buffer, name, out);
    case Io::UINT:
      return AppendAs<unsigned>(buffer, name, out);
    case Io::INT:
      return AppendAs<int>(buffer, name, out);
    case Io::ULONG:
      return AppendAs<unsigned long>(buffer, name, out);
    case Io::LONG:
      return AppendAs<long>(buffer, name, out);
    case Io::ULONGLONG:
      return AppendAs<unsigned long long>(buffer, name, out);
    case Io::LONGLONG:
      return AppendAs<long long>(buffer, name, out);
    case Io::FLOAT:
      return AppendAs<float>(buffer, name, out);
    case Io::DOUBLE:
      return AppendAs<double>(buffer, name, out);
    default:
      throw Error(fmt::format("{}: voxels of type '{}' are not read", name,
                              Io::GetComponentTypeAsString(io.GetComponentType())));
  }
}

}  // namespace kerf
