#include "catch.h"
#include "raw_images.h"
#include "splat_samples.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/geometry/topology.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/splats/painted_splats.h>
#include <fresco/splats/render_splats.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <cmath>

using namespace fresco;

namespace
{

constexpr double edge_m = 0.04;
/// The middles of faces are 0.7 edges apart, a quarter of a stroke at most.
constexpr double stroke_m = 0.12;

/// Opaque Gaussians on the faces.
splats::Splats covering(const Mesh& mesh)
{
    splats::Splats splats;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const auto& [a, b, c] = mesh.triangles[f];
        const Vec3d area = geometry::area_vector(mesh, f) * 0.5;
        const Vec3d middle = vec_cast<double>(mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (1 / 3.0);
        if (length(area) > 1e-8)
            splats::samples::add_flat(splats, middle, normalized(area), 0.7 * std::sqrt(length(area)), 0.001, 0.999, {});
    }
    return splats;
}

/// The mean of 5 x 5 pixels, which is wider than the median Gaussian.
double mean_at(const auto& picture, int x, int y, int channel)
{
    double sum = 0;
    for (int k = 0; k < 25; ++k)
        sum += static_cast<double>(picture.at(x + k % 5 - 2, y + k / 5 - 2, channel));
    return sum / 25;
}

}  // namespace

TEST_CASE("the painted splat of the generated room looks much as its painted mesh does", "[splats]")
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
        Mesh::load({stage(ATLAS_PROJECT_PLUGIN, "atlas.project", Value::Map{{"size_px", 512}}, {{"mesh", room}}) / "atlas", {}});
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
    const auto painting = Texture::load(
        {stage(TEXTURE_SYNTHESIZE_PLUGIN, "texture.synthesize", Value::Map{{"stroke_cm", 100 * stroke_m}, {"rounds_count", 2}},
               {{"mesh", atlas}, {"start", photo}, {"style", style}}, true) /
             "texture",
         {}});
    const auto baked = TexturedMesh::load(
        {stage(TEXTURE_BAKE_PLUGIN, "texture.bake", Value::Map{}, {{"texture", painting}, {"mesh", atlas}}) / "textured_mesh",
         {}});
    write_file(at("room.ply"), splats::bytes_of(covering(*room), splats::SplatFormat::ply));
    const auto written = stage(EXPORT_SPLATS_PLUGIN, "export.splats",
                               Value::Map{{"file", at("room.ply").string()}, {"path", "painted"}, {"stroke_cm", 100 * stroke_m}},
                               {{"textured_mesh", baked}});
    const auto painted = splats::read_splats(written / "files/painted.ply").splats;
    const rendering::ViewRenderer renderer(*baked, {.filter = rendering::TextureFilter::trilinear});
    double apart = 0, before = 0, through = 0, count = 0;
    for (const Frame& frame : frames->frames)
    {
        const Raster8 mesh = renderer.render(frame.color, run);
        const auto splat = render_splats(painted, frame.color, 0.05, run);
        for (int y = 2; y < mesh.height - 2; ++y)
            for (int x = 2; x < mesh.width - 2; ++x)
            {
                if (mean_at(mesh, x, y, 3) < 255)
                    continue;
                through += 255 * double{splat.transmittance.at(x, y)};
                for (int c = 0; c < 3; ++c)
                {
                    const double truth = mean_at(mesh, x, y, c);
                    apart += std::abs(255 * mean_at(splat.color, x, y, c) - truth) / 3;
                    before += std::abs(127.5 - truth) / 3;
                }
                ++count;
            }
    }
    INFO(apart / count << " of 255 apart; gray would be " << before / count << "; let through " << through / count);
    CHECK(count > 100'000);
    CHECK(through / count < 4);
    CHECK(apart / count < 7);
}
