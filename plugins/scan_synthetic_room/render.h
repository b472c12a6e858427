#pragma once

#include "light.h"

#include <fresco/camera.h>
#include <fresco/raster.h>

#include <cstdint>

namespace room
{

/// The color picture (RGB) of a camera, 2x2 samples per pixel, with a little sensor noise. One thread.
fresco::Raster<std::uint8_t> render_color(const Caster& caster, const LightMap& light, const fresco::Camera& camera,
                                          std::uint32_t seed);

/// Exact depth along the optical axis at pixel centers, meters; 0 = nothing met.
fresco::Raster<float> render_depth(const Caster& caster, const fresco::Camera& camera);

/// What a sensor makes of exact depth: noise that grows with the square of the distance, gaps beside silhouettes, none nearer
/// than 0.3 m or beyond 10 m; millimeters, 0 = none. `noise_m` is the noise at about 2 m.
fresco::Raster<std::uint16_t> sense_depth(const fresco::Raster<float>& exact, float noise_m, std::uint32_t seed);

}  // namespace room
