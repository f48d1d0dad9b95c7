// The kinds of tools, one line each.
#pragma once

#include "cut/tool/ball_burr.h"
#include "cut/tool/disc_saw.h"
#include "cut/tool/fissure_bur.h"
#include "cut/tool/oscillating_blade.h"
#include "cut/tool/piezo_insert.h"
#include "cut/tool/reciprocating_blade.h"
#include "cut/tool/twist_drill.h"
