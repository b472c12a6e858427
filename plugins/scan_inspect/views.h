#pragma once

#include "diagnosis.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>

namespace fresco::inspect
{

/// The camera at another height of its picture; the width follows.
Camera at_height(const Camera& camera, int height);

/// What `diagnose` looks at of a frame: depths on a grid of 40 columns, edges at a height of 120 px, at which a tenth of a focal
/// length moves them by four pixels and a color camera that is not synchronized by one or two. Throws as check_camera,
/// load_color and load_depth do. Thread-safe.
View view_of(const Frame& frame, const ImageIo& images);

}  // namespace fresco::inspect
