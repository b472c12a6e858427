#include "stage_cases.h"

const char* const stage_type = "uvmaps.raster";
