// Rates of the machine that bound the speed of a tick.
#pragma once

namespace kerf {

struct MachineRates {
  double memory_GB_per_s = 0;  // at which one core reads an array larger than its caches
  // Additions and multiplications that one core does in registers, with vectors as removal and contact use them.
  double float_Gop_per_s = 0;
  double double_Gop_per_s = 0;
};

/// Measures the rates of the calling thread's core with the vector instructions in use; takes about 0.2 s.
MachineRates MeasureMachineRates();

}  // namespace kerf
