#include "bone/import/itk_read.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gdcmTrace.h>
#include <itkCommand.h>
#include <itkObject.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>

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
  // libjpeg and similar libraries write to the C stream.
  std::fflush(stderr);
  const int null_device = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (null_device < 0) return;
  dup2(null_device, STDERR_FILENO);
  close(null_device);
}

QuietItk::~QuietItk() {
  std::cerr.rdbuf(cerr_);
  std::cout.rdbuf(cout_);
  // Writing to a stream without a buffer sets its badbit.
  std::cerr.clear();
  std::cout.clear();
  itk::Object::SetGlobalWarningDisplay(warnings_);
  if (stderr_copy_ < 0) return;
  std::fflush(stderr);
  dup2(stderr_copy_, STDERR_FILENO);
  close(stderr_copy_);
}

void ReportProgress(itk::ProcessObject& filter, const std::function<void(double)>& progress) {
  if (!progress) return;
  filter.AddObserver(itk::ProgressEvent(), [&filter, progress](const itk::EventObject&) {
    progress(static_cast<double>(filter.GetProgress()));
  });
}

std::string OneLine(const itk::ExceptionObject& e) {
  std::string text = e.GetDescription();
  // Removes the class and its address from messages such as "ITK ERROR: GDCMImageIO(0x55d0): what is wrong".
  const std::size_t end = text.find("): ");
  const bool names_class = text.rfind("ITK ERROR: ", 0) == 0 || text.rfind("itk::ERROR: ", 0) == 0;
  if (names_class && end != std::string::npos) text.erase(0, end + 3);
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text;
}

namespace {

VoxelType FindType(const itk::ImageIOBase& io, const std::string& name) {
  using Io = itk::ImageIOBase;
  static_assert(sizeof(long) == 8);
  switch (io.GetComponentType()) {
    case Io::UCHAR:
      return VoxelType::kUint8;
    case Io::CHAR:
      return VoxelType::kInt8;
    case Io::USHORT:
      return VoxelType::kUint16;
    case Io::SHORT:
      return VoxelType::kInt16;
    case Io::UINT:
      return VoxelType::kUint32;
    case Io::INT:
      return VoxelType::kInt32;
    case Io::ULONG:
    case Io::ULONGLONG:
      return VoxelType::kUint64;
    case Io::LONG:
    case Io::LONGLONG:
      return VoxelType::kInt64;
    case Io::FLOAT:
      return VoxelType::kFloat;
    case Io::DOUBLE:
      return VoxelType::kDouble;
    default:
      throw Error(fmt::format("{}: voxels of type '{}' are not supported", name,
                              Io::GetComponentTypeAsString(io.GetComponentType())));
  }
}

}  // namespace

Overflow AppendPixels(itk::ImageIOBase& io, const std::string& name, std::vector<std::int16_t>& out,
                      const std::string& complaint) {
  CheckOneComponent(io.GetNumberOfComponents(), name);
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
  } catch (const itk::ExceptionObject&) {
    throw Error(fmt::format("{}: {}", name, complaint));
  }
  return AppendHu(buffer, FindType(io, name), 1, 0, out);
}

}  // namespace kerf
