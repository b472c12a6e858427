#include "transforms.h"

#include <fresco/value.h>

#include <cstdio>

using namespace fresco;

namespace
{
std::string six_digits(std::size_t number)
{
    char text[24];
    std::snprintf(text, sizeof text, "%06zu", number);
    return text;
}

/// Four rows of world_from_camera for a camera whose y points up and whose z points backward.
Value opengl_pose(const RigidTransform& world_from_camera)
{
    const Mat3& r = world_from_camera.rotation;
    const Vec3d t = world_from_camera.translation;
    const double translation[] = {t.x, t.y, t.z};
    Value::List rows;
    for (int row = 0; row < 3; ++row)
        // 0 - x, not -x: no "-0.0" in the text.
        rows.emplace_back(Value::List{r(row, 0), 0 - r(row, 1), 0 - r(row, 2), translation[row]});
    rows.emplace_back(Value::List{0.0, 0.0, 0.0, 1.0});
    return rows;
}

Value frame_of(const dataset::Manifest& manifest, std::size_t view)
{
    const Camera& camera = manifest.views[view].color;
    const Intrinsics& k = camera.intrinsics;
    const std::string jpeg = image_name(view, ".jpg");
    return Value::Map{{"file_path", manifest.files.contains(jpeg) ? jpeg : image_name(view, ".png")},
                      {"depth_file_path", depth_image_name(view)},
                      {"w", k.width},
                      {"h", k.height},
                      {"fl_x", k.fx},
                      {"fl_y", k.fy},
                      {"cx", k.cx},
                      {"cy", k.cy},
                      {"transform_matrix", opengl_pose(camera.world_from_camera)}};
}
}  // namespace

std::string image_name(std::size_t view, const std::string& extension)
{
    return "images/" + six_digits(view) + extension;
}

std::string depth_image_name(std::size_t view)
{
    return "depth/" + six_digits(view) + ".png";
}

std::string transforms_text(const dataset::Manifest& manifest)
{
    Value::List frames;
    for (std::size_t view = 0; view < manifest.views.size(); ++view)
        frames.push_back(frame_of(manifest, view));
    const Value root = Value::Map{{"camera_model", "PINHOLE"}, {"depth_unit_scale_factor", 0.001}, {"frames", std::move(frames)}};
    return to_json(root, 1) + "\n";
}
