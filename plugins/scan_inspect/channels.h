#pragma once

#include "views.h"

#include <fresco/camera.h>
#include <fresco/raycast/scene.h>

#include <vector>

namespace fresco::inspect
{

/// Whether the pictures have red and blue exchanged against the colors of the mesh's vertices: where cameras see the mesh, green
/// goes along with its green, but red minus blue goes against its red minus blue, in most frames. White balance and exposure may
/// differ. False if the mesh has no colors. `cameras`: of the views' color pictures, at the size of View::color.
bool channels_exchanged(const raycast::Scene& scene, const std::vector<View>& views, const std::vector<Camera>& cameras);

}  // namespace fresco::inspect
