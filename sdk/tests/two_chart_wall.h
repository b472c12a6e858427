#pragma once

#include <fresco/testing_scenes.h>

using fresco::testing::blank_texture;
using fresco::testing::see;
using fresco::testing::two_chart_wall;
