#pragma once

#include "circles.h"

/// The picture with its circles drawn on it: green where they have a radius in meters, else blue, with their axes.
fresco::Raster8 overlay(const fresco::Raster8& rgb, const std::vector<Circle>& circles);
