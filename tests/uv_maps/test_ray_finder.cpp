#include "finder_cases.h"
#include "ray_finder.h"

std::unique_ptr<fresco::FaceFinder> make_finder(const fresco::Mesh& mesh)
{
    return std::make_unique<RayFinder>(mesh);
}
