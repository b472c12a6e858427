#pragma once

#include "scene.h"

#include <fresco/parallel.h>

#include <vector>

/// \file Lights the scene and colors its faces, for the pictures and for the mesh's vertices.

namespace room
{

/// Light on every face, computed once and looked up: direct light of lamps and the window with soft shadows, and one bounce off
/// all other faces. Immutable after construction, so thread-safe.
class LightMap
{
  public:
    /// Deterministic for any thread count. Throws Canceled.
    LightMap(const Caster& caster, fresco::Progress& progress);

    /// Linear RGB irradiance at a face, scaled so that the room's mean is 1.
    Vec3f at(int solid, int face, Vec2f coordinates) const;

    /// The displayed color (sRGB, 0..1) of a face: its texture under this light, or a lamp's own glow.
    Vec3f shade(int solid, int face, Vec2f coordinates, float footprint) const;

  private:
    struct Patch
    {
        std::size_t first = 0;  ///< Into values_.
        int columns = 0;
        int rows = 0;
        Vec2f extent;
    };
    const Patch& patch(int solid, int face) const { return patches_[static_cast<std::size_t>(solid * 6 + face)]; }

    const Scene* scene_;
    std::vector<Patch> patches_;  ///< 6 per solid.
    std::vector<Vec3f> values_;
};

}  // namespace room
