#pragma once

#include <fresco/camera.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <array>
#include <vector>

/// The color (RGB in [0,1]) that the whole room is painted with: smooth, different along every axis.
std::array<double, 3> paint_at(double x, double y, double z);

/// Conventions that a stage could have got wrong; applied on purpose.
enum class Mistake
{
    none,
    flipped_v,
    half_texel,
    mirrored_axis,
    depth_camera
};

/// Makes a texture of two layers whose lookups at the maps' uv give paint_at of the surface points at the maps' depth, by a few
/// rounds of spreading the differences over the texels looked up. `cameras`: the one of each view, depth cameras for that
/// mistake.
fresco::Texture painted(const fresco::UvMaps& maps, const std::vector<fresco::Camera>& cameras, int size_px, Mistake mistake);
