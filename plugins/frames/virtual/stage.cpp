#include "stage.h"

#include <fresco/raycast/scene.h>

using namespace fresco;
using fresco::virtual_views::FramesVirtual;

FRESCO_STAGE("frames.virtual", FramesVirtual, "Adds cameras, planned from the mesh, that see the surface nobody recorded")
FRESCO_LIBRARY("Embree", raycast::embree_version())
