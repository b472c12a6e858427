#include "views.h"

namespace fresco::inspect
{
namespace
{

constexpr int edge_height = 120;
constexpr int depth_columns = 40;

}  // namespace

Camera at_height(const Camera& camera, int height)
{
    return {camera.intrinsics.scaled_to(camera.intrinsics.width_at(height), height), camera.world_from_camera};
}

View view_of(const Frame& frame, const ImageIo& images)
{
    check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
    check_camera(frame.depth, "the depth camera of " + frame.sequence + "/" + frame.name);
    View view{{frame.depth, {}}, {at_height(frame.color, edge_height), {}, {}}};
    if (!frame.depth_picture.empty())
        view.depth.samples = sample_depth(load_depth(frame, &images), depth_columns);
    const Intrinsics& size = view.color.camera.intrinsics;
    if (!frame.color_picture.empty())
        view.color.edges = edge_strength(resized(load_color(frame, &images), size.width, size.height));
    return view;
}

}  // namespace fresco::inspect
