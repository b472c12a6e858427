#include "parsers.h"

#include <fresco/splats/splats.h>

#include <algorithm>
#include <cmath>

namespace fresco::fuzz
{
namespace
{

void read_splats(Bytes bytes)
{
    const auto file = splats::parse_splats(bytes, std::string(source));
    const splats::Splats& splats = file.splats;
    require(splats.size() > 0, "Gaussians");
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        double norm = 0;
        for (const float each : splats.rotations[i])
            norm += double{each} * double{each};
        require(std::abs(norm - 1) < 1e-4, "unit quaternions");
        const Vec3f scale = splats.scales[i];
        require(std::min({scale.x, scale.y, scale.z}) > 0 && std::isfinite(scale.x + scale.y + scale.z), "scales above 0");
        require(splats.opacities[i] >= 0 && splats.opacities[i] <= 1, "opacities from 0 to 1");
        require(std::isfinite(length(splats.centers[i])) && std::isfinite(length(splats.colors[i])), "finite numbers");
    }
}

const Registered registered{{"splats", "plugins/shared/splats/src/.*\\.cpp", read_splats}};

}  // namespace
}  // namespace fresco::fuzz
