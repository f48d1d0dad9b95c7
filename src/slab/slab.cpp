#include "kerf/slab.h"
