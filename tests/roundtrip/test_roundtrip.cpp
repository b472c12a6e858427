#include "catch.h"
#include "plain_viewer.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <cmath>
#include <memory>
#include <string>

using namespace fresco;

namespace
{

/// A room of 4 x 3 x 2.5 m with a block in it, seen from inside; every side is a rectangular chart of its own, 8.5 texels per
/// meter in a picture of box_room_texture_px.
Mesh box_room()
{
    testing::ChartedMesh room(4, 4, 0.075F);
    room.rectangle({0, 0, 0}, {4, 0, 0}, {0, 3, 0});      // floor
    room.rectangle({0, 3, 2.5F}, {4, 0, 0}, {0, -3, 0});  // ceiling
    room.rectangle({0, 3, 0}, {4, 0, 0}, {0, 0, 2.5F});   // walls
    room.rectangle({4, 0, 0}, {-4, 0, 0}, {0, 0, 2.5F});
    room.rectangle({0, 0, 0}, {0, 3, 0}, {0, 0, 2.5F});
    room.rectangle({4, 3, 0}, {0, -3, 0}, {0, 0, 2.5F});
    room.rectangle({1.4F, 1.2F, 0.7F}, {1.2F, 0, 0}, {0, 0.8F, 0});  // the block's top and sides
    room.rectangle({1.4F, 1.2F, 0}, {1.2F, 0, 0}, {0, 0, 0.7F});
    room.rectangle({2.6F, 2.0F, 0}, {-1.2F, 0, 0}, {0, 0, 0.7F});
    room.rectangle({1.4F, 2.0F, 0}, {0, -0.8F, 0}, {0, 0, 0.7F});
    room.rectangle({2.6F, 1.2F, 0}, {0, 0.8F, 0}, {0, 0, 0.7F});
    return room.mesh;
}
constexpr int box_room_texture_px = 160;

/// Eight views whose color and depth cameras differ in size, intrinsics and pose.
Frames box_room_frames()
{
    const Vec3d eyes[] = {{0.4, 0.4, 1.6}, {3.6, 0.5, 1.5}, {3.5, 2.6, 1.7}, {0.5, 2.5, 1.4},
                          {2.0, 0.3, 2.2}, {2.2, 2.7, 1.0}, {0.3, 1.5, 1.2}, {3.7, 1.5, 0.9}};
    const Vec3d targets[] = {{2.2, 1.7, 0.5}, {1.5, 2.0, 0.8}, {1.2, 0.8, 0.9}, {3.0, 0.9, 1.1},
                             {2.1, 2.0, 0.2}, {1.8, 0.2, 1.9}, {3.9, 1.2, 1.9}, {0.1, 1.9, 1.6}};
    Frames frames;
    for (std::size_t i = 0; i < std::size(eyes); ++i)
    {
        const Camera color{{160, 120, 118, 121, 77.2, 62.9}, testing::looking_at(eyes[i], targets[i])};
        Frame frame = testing::frame("frame-" + std::to_string(i), color, static_cast<long>(i));
        // Beside the color camera and turned a little outwards.
        const Vec3d right = frame.color.world_from_camera.direction({1, 0, 0});
        frame.depth.intrinsics = {128, 96, 88, 90, 65.5, 46.1};
        frame.depth.world_from_camera = testing::looking_at(eyes[i] + right * 0.08, targets[i] + right * 0.2);
        frames.frames.push_back(frame);
    }
    return frames;
}

/// The color (RGB in [0,1]) that the whole room is painted with: smooth, different along every axis.
std::array<double, 3> paint_at(double x, double y, double z)
{
    return {0.5 + 0.4 * std::sin(1.9 * x + 0.7 * y), 0.5 + 0.4 * std::sin(1.6 * y + 1.1 * z + 1),
            0.5 + 0.4 * std::sin(1.8 * z - 0.9 * x + 2)};
}

constexpr double limit = 2;  // of 255, mean over pixels and channels

void run(const char* library, const char* type, const Value& options, const testing::Inputs& inputs,
         const std::filesystem::path& folder)
{
    testing::TestRun test_run;
    testing::run_stage(library, type, options, inputs, folder, test_run, {{"image_io", std::make_shared<stored_png::Codec>()}});
}

plain::View plain_view(const Camera& camera)
{
    const auto& r = camera.world_from_camera.rotation.m;
    const Vec3d t = camera.world_from_camera.translation;
    const Intrinsics& i = camera.intrinsics;
    return {i.width, i.height, i.fx, i.fy, i.cx, i.cy, {r[0], r[1], r[2], t.x, r[3], r[4], r[5], t.y, r[6], r[7], r[8], t.z}};
}

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

using Picture = std::vector<plain::Pixel>;

/// The painted room as a camera sees it in truth.
Picture painted(const Camera& camera)
{
    Picture pixels = plain::render(true_room(), {1, 1, {0, 0, 0}}, plain_view(camera), {});
    for (plain::Pixel& pixel : pixels)
        for (std::size_t c = 0; c < 3; ++c)
            pixel.rgb[c] = 255 * paint_at(pixel.position[0], pixel.position[1], pixel.position[2])[c];
    return pixels;
}

/// The stages from pictures of the room to its GLB.
class Chain
{
  public:
    Chain() : room_(std::make_shared<Mesh>(box_room())), frames_(std::make_shared<Frames>(box_room_frames()))
    {
        for (Frame& frame : frames_->frames)
        {
            frame.color_picture.path = folder_.path() / (frame.name + ".png");
            const Picture seen = painted(frame.color);
            const int width = frame.color.intrinsics.width;
            const auto color = [&](int x, int y, int c) { return seen[static_cast<std::size_t>(y * width + x)].rgb[c]; };
            write_file(frame.color_picture.path,
                       stored_png::Codec().encode_png(testing::picture(width, frame.color.intrinsics.height, color)));
        }
        run(UVMAPS_RASTER_FILE, "uvmaps.raster", Value::Map{{"heights_px", Value::List{120}}},
            {{"mesh", room_}, {"frames", frames_}}, folder_.path());
        run(TEXTURE_FROM_FRAMES_FILE, "texture.from_frames", Value::Map{{"size_px", box_room_texture_px}},
            {{"uvmaps", UvMaps::load({folder_.path() / "uvmaps", folder_.path()})}, {"frames", frames_}}, folder_.path());
        run(TEXTURE_BAKE_FILE, "texture.bake", Value::Map{},
            {{"texture", Texture::load({folder_.path() / "texture", folder_.path()})}, {"mesh", room_}}, folder_.path());
        baked_ = TexturedMesh::load({folder_.path() / "textured_mesh", folder_.path()});
        run(EXPORT_GLTF_FILE, "export.gltf", Value::Map{{"up", "keep"}}, {{"textured_mesh", baked_}}, folder_.path());
    }
    std::filesystem::path glb() const { return folder_.path() / "files" / "room.glb"; }
    /// The pictures of render.views, where a pixel is covered.
    std::vector<Picture> rendered_views() const
    {
        run(RENDER_VIEWS_FILE, "render.views", Value::Map{}, {{"mesh", baked_}, {"frames", frames_}}, folder_.path());
        std::vector<Picture> pictures;
        const auto files = Files::load({folder_.path() / "views", folder_.path()});
        for (const std::string& name : files->names)
        {
            const Raster8 view = stored_png::Codec().read_rgb(folder_.path() / "views" / name);
            Picture& pixels = pictures.emplace_back(view.values.size() / 4);
            for (std::size_t i = 0; i < view.values.size(); ++i)
                if (i % 4 < 3)
                    pixels[i / 4].rgb[i % 4] = view.values[i];
                else
                    pixels[i / 4].found = view.values[i] == 255;
        }
        return pictures;
    }
    const Frames& frames() const { return *frames_; }

  private:
    testing::TemporaryFolder folder_;
    std::shared_ptr<const Mesh> room_;
    std::shared_ptr<Frames> frames_;
    std::shared_ptr<const TexturedMesh> baked_;
};

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

/// Mean difference (of 255) between what the GLB shows and what is expected of each view; a pixel that shows nothing counts 255.
double difference(const Loaded& loaded, const std::vector<plain::View>& views, const std::vector<Picture>& expected,
                  const plain::Wrong& wrong)
{
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t f = 0; f < views.size(); ++f)
    {
        const Picture shown = plain::render(loaded.model, loaded.picture, views[f], wrong);
        for (std::size_t i = 0; i < shown.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c, ++count)
                sum += shown[i].found && expected[f][i].found ? std::abs(shown[i].rgb[c] - expected[f][i].rgb[c]) : 255;
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
    const Chain chain;
    const Loaded loaded(chain.glb());
    std::vector<plain::View> color_views, depth_views;
    std::vector<Picture> paint;
    for (const Frame& frame : chain.frames().frames)
    {
        color_views.push_back(plain_view(frame.color));
        Camera depth = frame.depth;
        depth.intrinsics = depth.intrinsics.scaled_to(color_views.back().width, color_views.back().height);
        depth_views.push_back(plain_view(depth));
        paint.push_back(painted(frame.color));
    }
    const std::vector<Picture> rendered = chain.rendered_views();
    REQUIRE(loaded.model.triangles.size() == box_room().triangles.size());
    REQUIRE(rendered.size() == paint.size());
    CHECK(difference(loaded, color_views, paint, right_viewer) <= limit);
    CHECK(difference(loaded, color_views, rendered, right_viewer) <= limit);
    // A viewer of any other convention is detected.
    for (const plain::Wrong& wrong : {flipped_v, half_texel, mirrored_axis})
        for (const auto& expected : {paint, rendered})
            CHECK(difference(loaded, color_views, expected, wrong) > limit);
    CHECK(difference(loaded, depth_views, paint, right_viewer) > limit);
}
