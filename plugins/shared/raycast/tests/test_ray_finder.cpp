#include "finder_cases.h"

#include <fresco/raycast/scene.h>

std::unique_ptr<fresco::FaceFinder> make_finder(const fresco::Mesh& mesh)
{
    return std::make_unique<fresco::raycast::RayFinder>(mesh);
}
