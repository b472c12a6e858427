#pragma once

#include "scene.h"

namespace room
{

/// Display color (sRGB, 0..1) of a face at `at` meters along it.
/// \param extent     the face's size in meters
/// \param footprint  meters covered by one sample; finer detail fades
Vec3f texture(const Material& material, Vec2f at, Vec2f extent, float footprint);

}  // namespace room
