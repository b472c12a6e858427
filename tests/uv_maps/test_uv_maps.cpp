#include "catch.h"
#include "furnish.h"
#include "recording.h"
#include "scan_mesh.h"
#include "shared_data.h"

#include <fresco/mesh.h>
#include <fresco/raycast/scene.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <utility>

using namespace fresco;

namespace
{
constexpr double texels = 4096;

void add_texcoords(Mesh& mesh)
{
    const auto wrapped = [](float meters) { return std::abs(std::fmod(meters, 1.0F)); };
    testing::set_texcoords(mesh, [&](Vec3f p) { return Vec2f{wrapped(p.x), wrapped(p.z)}; });
}

/// Comparison of both in all pixels of all views.
struct Agreement
{
    std::size_t pixels = 0;
    std::size_t other_face = 0;
    std::size_t other_validity = 0;
    double texels_apart = 0;  ///< Distance where the face is the same.
    double depth_apart = 0;   ///< Relative depth difference, likewise.
    PixelCounts seen;
    PixelCounts cast;  ///< By the hits: those behind cracks are valid.

    /// Pixel by pixel against the scene's own hits, which know nothing of the maps' way of computing.
    void add(const Mesh& mesh, const raycast::Scene& scene, const Camera& camera, const FaceMap& drawn, const UvMap& map,
             const PixelCounts& counts)
    {
        std::vector<raycast::Hit> hits(drawn.values.size());
        scene.cast_rows(camera, 0, drawn.height, hits);
        seen += counts;
        pixels += hits.size();
        for (std::size_t i = 0; i < hits.size(); ++i)
        {
            cast.valid += raycast::sight(hits[i]) == Sight::surface ? 1 : 0;
            cast.back_face += raycast::sight(hits[i]) == Sight::back_face ? 1 : 0;
            if (hits[i].triangle != drawn.values[i])
            {
                ++other_face;
                continue;
            }
            if (map.valid.values[i] == 0)
                continue;
            other_validity += raycast::sight(hits[i]) == Sight::surface ? 0 : 1;
            const Vec2d uv = raycast::texcoord(mesh, hits[i]);
            texels_apart = std::max({texels_apart, texels * std::abs(map.uv.values[2 * i] - uv.x),
                                     texels * std::abs(map.uv.values[2 * i + 1] - uv.y)});
            depth_apart = std::max(depth_apart, std::abs(map.depth.values[i] / hits[i].distance - 1));
        }
    }
};

void check_agreement(const Mesh& mesh, const std::vector<Camera>& cameras, const std::vector<int>& heights)
{
    const raycast::Scene scene(mesh);
    rendering::RasterFinder raster(mesh);
    UvMapper drawn(mesh, std::make_unique<rendering::RasterFinder>(mesh));
    Agreement all;
    for (const Camera& camera : cameras)
    {
        const auto& maps = drawn.make(camera, heights, Progress{});
        for (std::size_t i = 0; i < heights.size(); ++i)
        {
            Camera sized = camera;
            sized.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width_at(heights[i]), heights[i]);
            std::vector<FaceMap> faces(1, FaceMap(sized.intrinsics.width, heights[i]));
            raster.find(std::span(&sized, 1), Progress{}, faces);
            all.add(mesh, scene, sized, faces.front(), maps[i].map, maps[i].counts);
        }
    }
    const auto share = [&](auto count) { return static_cast<double>(count) / static_cast<double>(all.pixels); };
    CHECK(share(all.seen.valid) > 0.8);
    CHECK(share(all.other_face) < 1e-4);
    CHECK(all.other_validity == 0);
    CHECK(all.texels_apart < 0.01);
    CHECK(all.depth_apart < 1e-5);
    CHECK(share(std::abs(all.seen.valid + all.seen.crack - all.cast.valid)) < 1e-4);
    CHECK(share(std::abs(all.seen.back_face - all.cast.back_face)) < 1e-4);
}

/// A view as ViewRenderer draws it, by the ray of every sample and the double precision of its hit. Where all samples of a pixel
/// see one face, they are looked up once, unless lamps or a bilinear filter ask for each.
Raster8 cast_view(const TexturedMesh& textured, const rendering::RenderOptions& options, const Camera& camera)
{
    const Mesh& mesh = textured.mesh;
    const int side = options.samples_per_side;
    const raycast::Scene scene(mesh);
    const rendering::MipMaps texture(textured.image.pixels, options.filter);
    const rendering::Lighting lighting(mesh, options.lights);
    Camera dense = camera;
    dense.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width * side, camera.intrinsics.height * side);
    std::vector<raycast::Hit> hits(static_cast<std::size_t>(dense.intrinsics.width) * dense.intrinsics.height);
    scene.cast_rows(dense, 0, dense.intrinsics.height, hits);
    std::vector<raycast::Hit> middles(static_cast<std::size_t>(camera.intrinsics.width) * camera.intrinsics.height);
    scene.cast_rows(camera, 0, camera.intrinsics.height, middles);
    const bool is_joined = options.lights.diffuse == 0 && options.filter != rendering::TextureFilter::bilinear;
    const auto color_at = [&](const raycast::Hit& hit, double dense_x, double dense_y, double size)
    {
        const Vec2d uv = raycast::texcoord(mesh, hit);
        const double texels =
            size * raycast::texels_per_pixel(mesh, hit.triangle, uv, dense, dense_x, dense_y, texture.width(), texture.height());
        return texture.sample(uv, texels > 1 ? std::log2(texels) : 0) * lighting.at(hit.triangle, hit.weights);
    };
    Raster8 image(camera.intrinsics.width, camera.intrinsics.height, 4);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
        {
            Vec3d sum;
            int found = 0;
            bool is_one_face = true;
            for (int sample = 0; sample < side * side; ++sample)
            {
                const int sx = x * side + sample % side;
                const int sy = y * side + sample / side;
                const raycast::Hit& hit = hits[static_cast<std::size_t>(sy) * dense.intrinsics.width + sx];
                is_one_face =
                    is_one_face &&
                    hit.triangle == hits[static_cast<std::size_t>(y) * side * dense.intrinsics.width + x * side].triangle;
                if (raycast::sight(hit) != Sight::surface)
                    continue;
                const Vec3d color = color_at(hit, sx + 0.5, sy + 0.5, 1);
                sum += Vec3d{std::min(color.x, 255.0), std::min(color.y, 255.0), std::min(color.z, 255.0)};
                ++found;
            }
            if (const raycast::Hit& middle = middles[static_cast<std::size_t>(y) * image.width + x];
                is_joined && is_one_face && found == side * side)
                sum = color_at(middle, (x + 0.5) * side, (y + 0.5) * side, side * std::sqrt(0.6)) * found;
            if (found == 0)
                continue;
            std::uint8_t* rgba = &image.at(x, y);
            for (const auto& [c, value] : {std::pair{0, sum.x}, {1, sum.y}, {2, sum.z}})
                rgba[c] = static_cast<std::uint8_t>(value / found + 0.5);
            rgba[3] = static_cast<std::uint8_t>(255.0 * found / (side * side) + 0.5);
        }
    return image;
}

void check_views(const TexturedMesh& textured, const rendering::RenderOptions& options, const std::vector<Camera>& cameras)
{
    const rendering::ViewRenderer renderer(textured, options);
    for (const Camera& camera : cameras)
    {
        const Raster8 drawn = renderer.render(camera, Progress{});
        const Raster8 cast = cast_view(textured, options, camera);
        std::size_t apart = 0;
        std::size_t seen = 0;
        for (std::size_t i = 0; i < drawn.values.size(); i += 4)
        {
            seen += cast.values[i + 3] > 0 ? 1 : 0;
            bool same = drawn.values[i + 3] == cast.values[i + 3];
            for (std::size_t c = 0; c < 3; ++c)
                same = same && std::abs(drawn.values[i + c] - cast.values[i + c]) <= 1;
            apart += same ? 0 : 1;
        }
        CHECK(static_cast<double>(seen) > 0.8 * static_cast<double>(drawn.values.size() / 4));
        // For a sample on an edge, within rounding, the two may see different faces.
        CHECK(static_cast<double>(apart) < 3e-4 * static_cast<double>(seen));
    }
}

void check_views(const Mesh& mesh, const std::vector<Camera>& cameras)
{
    TexturedMesh textured;
    textured.mesh = mesh;
    textured.image.pixels = testing::noise_picture(512, 512, 3);
    for (const auto& [filter, shading] :
         {std::pair{rendering::TextureFilter::trilinear, "scannet"}, std::pair{rendering::TextureFilter::trilinear, "none"},
          std::pair{rendering::TextureFilter::bilinear, "none"}})
    {
        const rendering::RenderOptions options{.samples_per_side = 2, .filter = filter, .lights = rendering::lights_of(shading)};
        check_views(textured, options, cameras);
    }
}

}  // namespace

TEST_CASE("drawn and cast uv maps and views of the synthetic room agree")
{
    constexpr float edge_m = 0.05F;
    const Progress progress;
    Progress watched;
    const auto scene = room::furnish({4.5F, 3.6F, 2.6F}, 1);
    const room::Caster caster(scene);
    const room::LightMap light(caster, watched);
    const auto net = room::surface_net(scene, edge_m, watched);
    Mesh mesh = room::noisy_mesh(net, scene, light, edge_m, 0.003F, 1, watched);
    add_texcoords(mesh);
    const auto recorder = room::make_recorder(640, 480, 320, 240);
    std::vector<Camera> cameras;
    for (const auto& pose : room::camera_path(scene, 3, 1))
        cameras.push_back({recorder.color, pose * recorder.color_from_depth.inverse()});
    check_agreement(mesh, cameras, {256, 432});
    check_views(mesh, cameras);
}

TEST_CASE("drawn and cast uv maps and views of a real scan agree")
{
    const auto file = shared_data("kitchen/mesh.ply", "uv maps of a real scan");
    if (file.empty())
        return;
    Mesh mesh = read_mesh(file);
    add_texcoords(mesh);
    std::vector<Camera> cameras;
    for (const char* frame : {"frame-000000", "frame-000400"})
    {
        std::ifstream text(file.parent_path() / "seq-01" / (std::string(frame) + ".pose.txt"));
        std::array<double, 12> m{};
        for (double& value : m)
            text >> value;
        REQUIRE(text.good());
        const RigidTransform pose{{{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}}, {m[3], m[7], m[11]}};
        cameras.push_back({{640, 480, 525, 525, 320, 240}, pose});
    }
    check_agreement(mesh, cameras, {256, 784});
    check_views(mesh, cameras);
}
