#include <fresco/raycast/options.h>

#include <utility>

namespace fresco::raycast
{

Option<int> samples_option(Configurable* owner)
{
    return {owner, "samples", 2, range(1, 8), "Rays per pixel along each side, against aliasing at edges and far away"};
}

Option<std::string> shading_option(Configurable* owner, std::string help)
{
    return {owner, "shading", "none", one_of({"none", "scannet", "matterport3d"}), std::move(help)};
}

}  // namespace fresco::raycast
