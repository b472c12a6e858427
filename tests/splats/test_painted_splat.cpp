#include "catch.h"
#include "raw_images.h"
#include "splat_samples.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/splats/painted_splats.h>
#include <fresco/splats/render_splats.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace fresco;

namespace
{

constexpr double edge_m = 0.04;
constexpr double stroke_m = 0.12;

/// Opaque Gaussians on the faces: the square of `side` in each, 0.7 / side edges apart.
splats::Splats covering(const Mesh& mesh, int side)
{
    splats::Splats splats;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const auto corner = [&](std::size_t k) { return vec_cast<double>(mesh.positions[mesh.triangles[f][k]]); };
        const Vec3d first = corner(0), right = (corner(1) - first) * (1.0 / side), up = (corner(2) - first) * (1.0 / side);
        const Vec3d area = geometry::area_vector(mesh, f) * 0.5;
        const auto add = [&](double x, double y)
        {
            splats::samples::add_flat(splats, first + right * x + up * y, normalized(area), 0.7 * std::sqrt(length(area)) / side,
                                      0.001, 0.999, {});
        };
        for (int x = 0; x < side && length(area) > 1e-8; ++x)
            for (int y = 0; x + y < side; ++y)
            {
                add(x + 1 / 3.0, y + 1 / 3.0);
                if (x + y + 1 < side)
                    add(x + 2 / 3.0, y + 2 / 3.0);
            }
    }
    return splats;
}

/// The standard deviation of the visible Gaussians in a picture, in pixels: the median, of each the mean over all directions.
double median_footprint(const splats::Splats& splats, const Camera& camera, const RasterF& depth)
{
    const RigidTransform camera_from_world = camera.world_from_camera.inverse();
    const Intrinsics& lens = camera.intrinsics;
    std::vector<double> sizes;
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        const Vec3d at = camera_from_world.point(vec_cast<double>(splats.centers[i]));
        const double x = lens.fx * at.x / at.z + lens.cx, y = lens.fy * at.y / at.z + lens.cy;
        if (!(at.z > 0 && x >= 0 && y >= 0 && x < lens.width && y < lens.height) ||
            std::abs(depth.at(static_cast<int>(x), static_cast<int>(y)) - at.z) > 0.03)
            continue;
        const Vec3d normal = camera_from_world.rotation * splats::axes_of(splats, i)[2];
        const double size = double{splats.scales[i].x} * lens.fx / at.z;
        constexpr double pixel_variance = 0.3;  // The renderer's own filter.
        sizes.push_back(std::sqrt(size * size * std::abs(dot(normal, normalized(at))) + pixel_variance));
    }
    return numerics::median(std::move(sizes));
}

RasterF blurred(const RasterF& picture, double sigma)
{
    const int reach = static_cast<int>(3 * sigma) + 1;
    const auto along = [&](const RasterF& from, int step_x, int step_y)
    {
        RasterF to(from.width, from.height, from.channels);
        for (int y = 0; y < from.height; ++y)
            for (int x = 0; x < from.width; ++x)
                for (int c = 0; c < from.channels; ++c)
                {
                    double sum = 0, weights = 0;
                    for (int k = -reach; k <= reach; ++k)
                    {
                        const double weight = std::exp(-k * k / (2 * sigma * sigma));
                        sum += weight * double{from.at(std::clamp(x + k * step_x, 0, from.width - 1),
                                                       std::clamp(y + k * step_y, 0, from.height - 1), c)};
                        weights += weight;
                    }
                    to.at(x, y, c) = static_cast<float>(sum / weights);
                }
        return to;
    };
    return along(along(picture, 1, 0), 0, 1);
}

}  // namespace

TEST_CASE("the finer the Gaussians of the generated room, the nearer is its painted splat to its painted mesh", "[splats]")
{
    const testing::TemporaryFolder folder;
    const auto images = std::make_shared<testing::RawImages>();
    testing::TestRun run;
    const auto at = [&](const char* name) { return folder.path() / name; };
    const auto stage =
        [&](const char* library, const char* type, Value options, const testing::Inputs& inputs, bool reads = false)
    {
        std::map<std::string, std::shared_ptr<Component>> components;
        if (reads)
            components.emplace("image_io", images);
        testing::run_stage(library, type, std::move(options), inputs, at(type), run, components);
        return at(type);
    };
    const auto scan = stage(SCAN_SYNTHETIC_ROOM_PLUGIN, "scan.synthetic_room",
                            Value::Map{{"frames_count", 12},
                                       {"color_width_px", 240},
                                       {"color_height_px", 180},
                                       {"size_m", Value::List{3.5, 3.0, 2.3}},
                                       {"noise_m", 0.0},
                                       {"edge_m", edge_m}},
                            {}, true);
    const auto room = Mesh::load({scan / "mesh", {}});
    const auto frames = Frames::load({scan / "frames", {}});
    const auto atlas =
        Mesh::load({stage(ATLAS_PROJECT_PLUGIN, "atlas.project", Value::Map{{"size_px", 1024}}, {{"mesh", room}}) / "atlas", {}});
    const auto uvmaps = UvMaps::load({stage(UVMAPS_RASTER_PLUGIN, "uvmaps.raster", Value::Map{{"heights_px", Value::List{180}}},
                                            {{"mesh", atlas}, {"frames", frames}}) /
                                          "uvmaps",
                                      {}});
    const auto photo = Texture::load(
        {stage(TEXTURE_FROM_FRAMES_PLUGIN, "texture.from_frames", Value::Map{}, {{"uvmaps", uvmaps}, {"frames", frames}}, true) /
             "texture",
         {}});
    const auto style =
        std::make_shared<Image>(images->read_rgb(std::filesystem::path(FRESCO_SOURCE_FOLDER) / "tests/picture.npy"));
    const auto painting = Texture::load({stage(TEXTURE_SYNTHESIZE_PLUGIN, "texture.synthesize",
                                               Value::Map{{"stroke_cm", 100 * stroke_m}, {"rounds_count", 2}, {"detail", 0.0}},
                                               {{"mesh", atlas}, {"start", photo}, {"style", style}}, true) /
                                             "texture",
                                         {}});
    const auto baked = TexturedMesh::load(
        {stage(TEXTURE_BAKE_PLUGIN, "texture.bake", Value::Map{}, {{"texture", painting}, {"mesh", atlas}}) / "textured_mesh",
         {}});
    const rendering::ViewRenderer renderer(*baked, {.filter = rendering::TextureFilter::trilinear});
    /// In 255ths.
    struct Difference
    {
        double pictures = 0, from_gray = 0, let_through = 0;
    };
    const auto difference = [&](int side)
    {
        write_file(at("room.ply"), splats::bytes_of(covering(*room, side), splats::SplatFormat::ply));
        std::filesystem::remove_all(at("export.splats"));
        const auto written =
            stage(EXPORT_SPLATS_PLUGIN, "export.splats",
                  Value::Map{{"file", at("room.ply").string()}, {"path", "painted"}, {"stroke_cm", 100 * stroke_m}},
                  {{"textured_mesh", baked}});
        const auto painted = splats::read_splats(written / "files/painted.ply").splats;
        Difference sum;
        double count = 0;
        for (std::size_t i = 0; i < frames->frames.size(); i += 2)
        {
            Camera camera = frames->frames[i].color;
            camera.intrinsics = camera.intrinsics.scaled_to(640, 480);
            const Raster8 rendered = renderer.render(camera, run);
            const auto splat = render_splats(painted, camera, 0.05, run);
            const double sigma = median_footprint(painted, camera, splat.depth);
            RasterF sharp(rendered.width, rendered.height, 4);
            std::ranges::copy(rendered.values, sharp.values.begin());
            const RasterF mesh = blurred(sharp, sigma), from_splat = blurred(splat.color, sigma);
            for (int y = 0; y < mesh.height; ++y)
                for (int x = 0; x < mesh.width; ++x)
                {
                    // Pixels beside the surface are black.
                    if (mesh.at(x, y, 3) < 254.9F)
                        continue;
                    sum.let_through += 255 * double{splat.transmittance.at(x, y)};
                    for (int c = 0; c < 3; ++c)
                    {
                        sum.pictures += double{std::abs(255 * from_splat.at(x, y, c) - mesh.at(x, y, c))} / 3;
                        sum.from_gray += double{std::abs(127.5F - mesh.at(x, y, c))} / 3;
                    }
                    ++count;
                }
        }
        CHECK(count > 500'000);
        return Difference{sum.pictures / count, sum.from_gray / count, sum.let_through / count};
    };
    const Difference coarse = difference(1), fine = difference(4);
    INFO("a quarter of a stroke: " << coarse.pictures << " of 255; a sixteenth: " << fine.pictures << "; gray: " << fine.from_gray
                                   << "; let through: " << coarse.let_through << ", " << fine.let_through);
    CHECK(fine.pictures <= 4);
    CHECK(coarse.pictures < 7);
    CHECK(fine.from_gray > 30);
    CHECK(fine.let_through < 4);
    CHECK(coarse.let_through < 4);
}
