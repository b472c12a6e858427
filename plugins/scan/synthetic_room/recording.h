#pragma once

#include "light.h"
#include "scene.h"

#include <fresco/camera.h>
#include <fresco/image.h>

#include <cstdint>
#include <vector>

/// \file The recorder: where its two cameras stand, and the pictures that they take of a lit scene. The stage writes these as
/// frames.

namespace room
{

/// The two cameras of the recorder. They differ in size and focal length, and stand 2.5 cm apart with a slight turn.
struct Recorder
{
    fresco::Intrinsics color;
    fresco::Intrinsics depth;
    fresco::RigidTransform color_from_depth;
};

Recorder make_recorder(int color_width, int color_height, int depth_width, int depth_height);

/// world_from_depth of `count` views: first a round along the walls, looking across the room and down beside the walls, then a
/// narrower one, looking outward, up and down. Positions keep clear of the furniture.
std::vector<fresco::RigidTransform> camera_path(const Scene& scene, int count, std::uint32_t seed);

/// The color picture (RGB) of a camera, two samples per pixel and four at edges, with a little sensor noise. Single-threaded.
fresco::Raster<std::uint8_t> render_color(const Caster& caster, const LightMap& light, const fresco::Camera& camera,
                                          std::uint32_t seed);

/// Exact depth along the optical axis at pixel centers, meters; 0 = no hit.
fresco::Raster<float> render_depth(const Caster& caster, const fresco::Camera& camera);

/// Depth as a sensor measures it: with noise that grows with the square of the distance, gaps beside silhouettes, and none nearer
/// than 0.3 m or beyond 10 m; millimeters, 0 = none. `noise_m` is the noise at about 2 m.
fresco::Raster<std::uint16_t> sense_depth(const fresco::Raster<float>& exact, float noise_m, std::uint32_t seed);

}  // namespace room
