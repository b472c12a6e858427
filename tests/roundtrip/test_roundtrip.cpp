#include "box_room.h"
#include "catch.h"
#include "plain_viewer.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <cmath>
#include <memory>
#include <string>

using namespace fresco;

namespace
{

/// The color (RGB in [0,1]) that the whole room is painted with: smooth, different along every axis.
std::array<double, 3> paint_at(double x, double y, double z)
{
    return {0.5 + 0.4 * std::sin(1.9 * x + 0.7 * y), 0.5 + 0.4 * std::sin(1.6 * y + 1.1 * z + 1),
            0.5 + 0.4 * std::sin(1.8 * z - 0.9 * x + 2)};
}

/// Conventions that a stage could have got wrong; applied on purpose.
enum class Mistake
{
    none,
    flipped_v,
    half_texel,
    mirrored_axis,
    depth_camera
};

constexpr int rounds = 30;

struct Sample
{
    Vec2f uv;
    std::array<double, 3> color;
};

std::vector<Sample> samples_of(const UvMaps& maps, const std::vector<Camera>& cameras, int size_px, Mistake mistake)
{
    std::vector<Sample> samples;
    for (std::size_t view = 0; view < maps.views.size(); ++view)
    {
        const UvMap map = maps.load_map(view, 0);
        Camera camera = cameras[view];
        camera.intrinsics = camera.intrinsics.scaled_to(map.uv.width, map.uv.height);
        for (int y = 0; y < map.uv.height; ++y)
            for (int x = 0; x < map.uv.width; ++x)
            {
                if (!map.valid.at(x, y))
                    continue;
                const double px = mistake == Mistake::mirrored_axis ? map.uv.width - (x + 0.5) : x + 0.5;
                const Vec3d point = camera.world_from_camera.translation + camera.ray(px, y + 0.5) * double{map.depth.at(x, y)};
                Vec2f uv{map.uv.at(x, y, 0), map.uv.at(x, y, 1)};
                if (mistake == Mistake::flipped_v)
                    uv.y = 1 - uv.y;
                if (mistake == Mistake::half_texel)
                    uv = uv + Vec2f{0.5F, 0.5F} * (1.0F / static_cast<float>(size_px));
                samples.push_back({uv, paint_at(point.x, point.y, point.z)});
            }
    }
    return samples;
}

/// The four texels and shares of a bilinear lookup.
struct Taps
{
    std::array<std::size_t, 4> texel;
    std::array<float, 4> share;
};

Taps taps_of(Vec2f uv, int size)
{
    const float x = std::clamp(uv.x * static_cast<float>(size) - 0.5F, 0.0F, static_cast<float>(size - 1));
    const float y = std::clamp((1 - uv.y) * static_cast<float>(size) - 0.5F, 0.0F, static_cast<float>(size - 1));
    const auto x0 = static_cast<std::size_t>(x);
    const auto y0 = static_cast<std::size_t>(y);
    const auto s = static_cast<std::size_t>(size);
    const std::size_t x1 = std::min(x0 + 1, s - 1);
    const std::size_t y1 = std::min(y0 + 1, s - 1);
    const float fx = x - static_cast<float>(x0);
    const float fy = y - static_cast<float>(y0);
    return {{y0 * s + x0, y0 * s + x1, y1 * s + x0, y1 * s + x1}, {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}
/// Makes a texture of two layers whose lookups at the maps' uv give paint_at of the surface points at the maps' depth, by a few
/// rounds of spreading the differences over the texels looked up. `cameras`: the one of each view, depth cameras for that
/// mistake.
Texture painted(const UvMaps& maps, const std::vector<Camera>& cameras, int size_px, Mistake mistake)
{
    Texture texture;
    texture.layers = {RasterF(size_px, size_px, 3, 0.5F), RasterF(size_px / 2, size_px / 2, 3)};
    for (std::size_t i = 0; i < texture.layers[1].values.size(); ++i)
        texture.layers[1].values[i] = 0.05F * std::sin(static_cast<float>(i) * 0.01F);
    texture.seen = Raster8(size_px, size_px);

    const std::vector<Sample> samples = samples_of(maps, cameras, size_px, mistake);
    RasterF& fine = texture.layers[0];
    std::vector<float> difference(fine.values.size());
    std::vector<float> weight(texture.seen.values.size());
    for (int round = 0; round < rounds; ++round)
    {
        std::fill(difference.begin(), difference.end(), 0.0F);
        std::fill(weight.begin(), weight.end(), 0.0F);
        for (const Sample& sample : samples)
        {
            std::array<float, 3> low{};
            std::array<float, 3> high{};
            sample_bilinear(texture.layers[0], sample.uv.x, sample.uv.y, low.data());
            sample_bilinear(texture.layers[1], sample.uv.x, sample.uv.y, high.data());
            const Taps taps = taps_of(sample.uv, size_px);
            for (std::size_t t = 0; t < 4; ++t)
            {
                weight[taps.texel[t]] += taps.share[t];
                for (std::size_t c = 0; c < 3; ++c)
                    difference[3 * taps.texel[t] + c] += taps.share[t] * (static_cast<float>(sample.color[c]) - low[c] - high[c]);
            }
        }
        for (std::size_t texel = 0; texel < weight.size(); ++texel)
            if (weight[texel] > 0)
            {
                texture.seen.values[texel] = 1;
                for (std::size_t c = 0; c < 3; ++c)
                    fine.values[3 * texel + c] += difference[3 * texel + c] / weight[texel];
            }
    }
    return texture;
}

constexpr double limit = 2;  // of 255, mean over pixels and channels

void run(const char* library, const char* type, const Value& options, const testing::Inputs& inputs,
         const std::filesystem::path& folder)
{
    testing::TestRun test_run;
    testing::run_stage(library, type, options, inputs, folder, test_run, {{"images", std::make_shared<stored_png::Codec>()}});
}

/// The stages from the room to its GLB, run once per mistake of the painter.
class Chain
{
  public:
    Chain() : room_(std::make_shared<Mesh>(box_room())), frames_(std::make_shared<Frames>(box_room_frames()))
    {
        run(UVMAPS_RAYCAST_FILE, "uvmaps.raycast", Value::Map{{"heights_px", Value::List{120}}},
            {{"mesh", room_}, {"frames", frames_}}, folder_.path());
        maps_ = UvMaps::load({folder_.path() / "uvmaps", folder_.path()});
    }

    std::filesystem::path glb(Mistake mistake)
    {
        std::vector<Camera> cameras;
        for (const Frame& frame : frames_->frames)
            cameras.push_back(mistake == Mistake::depth_camera ? frame.depth : frame.color);
        const auto texture = std::make_shared<Texture>(painted(*maps_, cameras, box_room_texture_px, mistake));
        // A painter who paints beside the charts leaves nothing to fill from.
        const char* unseen = mistake == Mistake::none ? "fill" : "keep";
        run(TEXTURE_BAKE_FILE, "texture.bake", Value::Map{{"unseen", unseen}}, {{"texture", texture}, {"mesh", room_}},
            folder_.path());
        baked_ = TexturedMesh::load({folder_.path() / "textured_mesh", folder_.path()});
        run(EXPORT_GLTF_FILE, "export.gltf", Value::Map{{"up", "keep"}}, {{"textured_mesh", baked_}}, folder_.path());
        return folder_.path() / "files" / "room.glb";
    }

    /// The pictures of render.views of what glb() baked last.
    std::vector<Raster8> rendered_views()
    {
        run(RENDER_VIEWS_FILE, "render.views", Value::Map{}, {{"mesh", baked_}, {"frames", frames_}}, folder_.path());
        std::vector<Raster8> pictures;
        const auto files = Files::load({folder_.path() / "views", folder_.path()});
        for (const std::string& name : files->names)
            pictures.push_back(stored_png::Codec().read_rgb(folder_.path() / "views" / name));
        return pictures;
    }

    const Frames& frames() const { return *frames_; }

  private:
    testing::TemporaryFolder folder_;
    std::shared_ptr<const Mesh> room_;
    std::shared_ptr<const Frames> frames_;
    std::shared_ptr<const UvMaps> maps_;
    std::shared_ptr<const TexturedMesh> baked_;
};

plain::View plain_view(const Camera& camera)
{
    const auto& r = camera.world_from_camera.rotation.m;
    const Vec3d t = camera.world_from_camera.translation;
    const Intrinsics& i = camera.intrinsics;
    return {i.width, i.height, i.fx, i.fy, i.cx, i.cy, {r[0], r[1], r[2], t.x, r[3], r[4], r[5], t.y, r[6], r[7], r[8], t.z}};
}

/// A GLB as the independent code reads it.
struct Loaded
{
    plain::Model model;
    plain::Picture picture;

    explicit Loaded(const std::filesystem::path& file) : model(plain::read_glb(file))
    {
        const Raster8 decoded = stored_png::decode(model.picture);
        picture = {decoded.width, decoded.height, decoded.values};
    }
};

/// The room's own geometry for the renderer, to know which point each pixel truly sees.
plain::Model true_room()
{
    const Mesh mesh = box_room();
    plain::Model model;
    for (const Triangle& t : mesh.triangles)
    {
        auto& triangle = model.triangles.emplace_back();
        for (std::size_t i = 0; i < 3; ++i)
            triangle[i].position = {double{mesh.positions[t[i]].x}, double{mesh.positions[t[i]].y},
                                    double{mesh.positions[t[i]].z}};
    }
    return model;
}

/// Mean difference (of 255) between what the GLB shows from every pose and the paint at the points that the color camera truly
/// sees; a pixel that shows nothing counts 255.
double difference_to_paint(const Loaded& loaded, const Frames& frames, const plain::Wrong& wrong,
                           bool through_depth_camera = false)
{
    const plain::Model room = true_room();
    const plain::Picture nothing{1, 1, {0, 0, 0}};
    double sum = 0;
    std::size_t count = 0;
    for (const Frame& frame : frames.frames)
    {
        const plain::View view = plain_view(frame.color);
        plain::View shown_view = view;
        if (through_depth_camera)
        {
            Camera depth = frame.depth;
            depth.intrinsics = depth.intrinsics.scaled_to(view.width, view.height);
            shown_view = plain_view(depth);
        }
        const auto truth = plain::render(room, nothing, view, {});
        const auto shown = plain::render(loaded.model, loaded.picture, shown_view, wrong);
        for (std::size_t i = 0; i < truth.size(); ++i)
        {
            const auto& p = truth[i].position;
            const auto paint = paint_at(p[0], p[1], p[2]);
            for (std::size_t c = 0; c < 3; ++c)
                sum += truth[i].found && shown[i].found ? std::abs(shown[i].rgb[c] - 255 * paint[c]) : 255;
            count += 3;
        }
    }
    return sum / static_cast<double>(count);
}

double difference_to_views(const Loaded& loaded, const Frames& frames, const std::vector<Raster8>& views,
                           const plain::Wrong& wrong)
{
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t f = 0; f < views.size(); ++f)
    {
        const auto shown = plain::render(loaded.model, loaded.picture, plain_view(frames.frames[f].color), wrong);
        for (std::size_t i = 0; i < shown.size(); ++i)
        {
            const bool both = shown[i].found && views[f].values[4 * i + 3] == 255;
            for (std::size_t c = 0; c < 3; ++c)
                sum += both ? std::abs(shown[i].rgb[c] - views[f].values[4 * i + c]) : 255;
            count += 3;
        }
    }
    return sum / static_cast<double>(count);
}

constexpr plain::Wrong right_viewer{};
constexpr plain::Wrong flipped_v{.flipped_v = true};
constexpr plain::Wrong half_texel{.half_texel = true};
constexpr plain::Wrong mirrored_axis{.mirrored_axis = true};
}  // namespace

TEST_CASE("what is painted through the uv maps is what a viewer of the GLB sees")
{
    Chain chain;
    const Loaded loaded(chain.glb(Mistake::none));
    const std::vector<Raster8> views = chain.rendered_views();
    REQUIRE(loaded.model.triangles.size() == box_room().triangles.size());
    REQUIRE(views.size() == chain.frames().frames.size());

    CHECK(difference_to_paint(loaded, chain.frames(), right_viewer) <= limit);
    CHECK(difference_to_views(loaded, chain.frames(), views, right_viewer) <= limit);

    SECTION("a viewer of any other convention is detected")
    {
        for (const plain::Wrong& wrong : {flipped_v, half_texel, mirrored_axis})
        {
            CHECK(difference_to_paint(loaded, chain.frames(), wrong) > limit);
            CHECK(difference_to_views(loaded, chain.frames(), views, wrong) > limit);
        }
        CHECK(difference_to_paint(loaded, chain.frames(), right_viewer, true) > limit);
    }
    SECTION("so is a painter of any other convention")
    {
        for (const Mistake mistake : {Mistake::flipped_v, Mistake::half_texel, Mistake::mirrored_axis, Mistake::depth_camera})
        {
            CAPTURE(static_cast<int>(mistake));
            CHECK(difference_to_paint(Loaded(chain.glb(mistake)), chain.frames(), right_viewer) > limit);
        }
    }
}
