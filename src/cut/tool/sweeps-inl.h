// The sweeps of all kinds of tools, one line each. Has no include guard: each file it includes has its own.
#include "cut/tool/ball_burr_sweep-inl.h"
#include "cut/tool/disc_saw_sweep-inl.h"
#include "cut/tool/planar_sweep-inl.h"
#include "cut/tool/round_sweep-inl.h"
