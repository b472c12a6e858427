#include "my_plugin.h"

#include <algorithm>

namespace my_plugin
{

fresco::Mesh scaled(fresco::Mesh mesh, double factor)
{
    if (mesh.positions.empty())
        return mesh;
    fresco::Vec3f low = mesh.positions.front();
    fresco::Vec3f high = low;
    for (const auto& p : mesh.positions)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const fresco::Vec3f middle{(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2};
    const auto s = static_cast<float>(factor);
    for (auto& p : mesh.positions)
        p = {middle.x + s * (p.x - middle.x), middle.y + s * (p.y - middle.y), middle.z + s * (p.z - middle.z)};
    return mesh;
}

}  // namespace my_plugin
