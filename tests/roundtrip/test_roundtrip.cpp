#include "catch.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

using namespace fresco;

namespace
{

/// A room of 4 x 3 x 2.5 m with a block in it, seen from inside; every side is a rectangular chart of its own, 8.5 texels per
/// meter in a picture of box_room_texture_px.
Mesh box_room()
{
    testing::ChartedMesh room(4, 4, 0.075F);
    room.box({}, {4, 3, 2.5F}, false);
    room.box({1.4F, 1.2F, 0}, {1.2F, 0.8F, 0.7F}, true);
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

// A viewer that shares no code and no convention with fresco's stages: numbers by the formulas of glTF and of pinhole cameras.

/// A GLB of one mesh. Its texcoords have their origin at the upper left.
struct GlbModel
{
    Mesh mesh;
    Raster8 picture;
};

template <class T>
T number(const std::string& bytes, std::size_t at)
{
    T value{};
    REQUIRE(bytes.copy(reinterpret_cast<char*>(&value), sizeof value, at) == sizeof value);
    return value;
}

GlbModel read_glb(const std::filesystem::path& file)
{
    using nlohmann::json;
    const std::string bytes = read_text_file(file);
    REQUIRE((bytes.starts_with("glTF") && number<std::uint32_t>(bytes, 4) == 2));
    const auto json_size = number<std::uint32_t>(bytes, 12);
    const json root = json::parse(bytes.substr(20, json_size));
    const std::string binary = bytes.substr(28 + json_size);
    const json& primitive = root.at("meshes").at(0).at("primitives").at(0);
    REQUIRE(primitive.value("mode", 4) == 4);
    const auto accessor = [&](const json& index) -> const json& { return root.at("accessors").at(index.get<std::size_t>()); };
    const auto view = [&](const json& of) -> const json&
    { return root.at("bufferViews").at(of.at("bufferView").get<std::size_t>()); };
    /// Offset of the elements of an accessor, which must be of this form.
    const auto begin_of = [&](const json& index, const char* type, int component)
    {
        const json& of = accessor(index);
        REQUIRE((of.at("type") == type && of.at("componentType") == component && !view(of).contains("byteStride")));
        return view(of).value("byteOffset", std::size_t{0}) + of.value("byteOffset", std::size_t{0});
    };
    constexpr int of_uint16 = 5123;
    constexpr int of_float = 5126;
    const std::size_t indices = begin_of(primitive.at("indices"), "SCALAR", of_uint16);
    const std::size_t positions = begin_of(primitive.at("attributes").at("POSITION"), "VEC3", of_float);
    const std::size_t texcoords = begin_of(primitive.at("attributes").at("TEXCOORD_0"), "VEC2", of_float);
    GlbModel model;
    for (std::uint32_t i = 0; i < accessor(primitive.at("indices")).at("count").get<std::uint32_t>(); ++i)
    {
        const std::size_t vertex = number<std::uint16_t>(binary, indices + 2 * i);
        model.mesh.positions.push_back(number<Vec3f>(binary, positions + 12 * vertex));
        model.mesh.texcoords.push_back(number<Vec2f>(binary, texcoords + 8 * vertex));
        if (i % 3 == 0)
            model.mesh.triangles.push_back({i, i + 1, i + 2});
    }
    const json& picture = view(root.at("images").at(0));
    const std::string png =
        binary.substr(picture.value("byteOffset", std::size_t{0}), picture.at("byteLength").get<std::size_t>());
    model.picture = stored_png::decode({png.begin(), png.end()});
    return model;
}

/// Mistakes of a viewer with another convention.
struct Wrong
{
    bool flipped_v = false;
    bool half_texel = false;     ///< Texel centers at whole numbers.
    bool mirrored_axis = false;  ///< Pixel columns from right to left.
};

/// A texture lookup as OpenGL defines it: linear, clamped to the edge.
std::array<double, 3> lookup(const Raster8& picture, Vec2d uv, const Wrong& wrong)
{
    const double shift = wrong.half_texel ? 0 : 0.5;
    const double x = uv.x * picture.width - shift;
    const double y = (wrong.flipped_v ? 1 - uv.y : uv.y) * picture.height - shift;
    const double left = std::floor(x);
    const double top = std::floor(y);
    std::array<double, 3> result{};
    for (const int dy : {0, 1})
        for (const int dx : {0, 1})
        {
            const int tx = std::clamp(static_cast<int>(left) + dx, 0, picture.width - 1);
            const int ty = std::clamp(static_cast<int>(top) + dy, 0, picture.height - 1);
            const double share = (dx != 0 ? x - left : 1 - x + left) * (dy != 0 ? y - top : 1 - y + top);
            for (int c = 0; c < 3; ++c)
                result[static_cast<std::size_t>(c)] += share * picture.at(tx, ty, c);
        }
    return result;
}

struct Pixel
{
    bool found = false;
    Vec3d position;
    std::array<double, 3> rgb{};  ///< 0..255
};
using Picture = std::vector<Pixel>;

/// The nearest face at every pixel center, row-major; a pixel that sees its back is not found.
Picture render(const GlbModel& model, const Camera& camera, const Wrong& wrong = {})
{
    const Intrinsics& i = camera.intrinsics;
    const auto& m = camera.world_from_camera.rotation.m;
    Picture pixels;
    for (int row = 0; row < i.height; ++row)
        for (int column = 0; column < i.width; ++column)
        {
            const double x = ((wrong.mirrored_axis ? i.width - column - 0.5 : column + 0.5) - i.cx) / i.fx;
            const double y = (row + 0.5 - i.cy) / i.fy;
            const Vec3d ray{m[0] * x + m[1] * y + m[2], m[3] * x + m[4] * y + m[5], m[6] * x + m[7] * y + m[8]};
            const Vec3d eye = camera.world_from_camera.translation;
            const testing::RayHit hit = testing::cast(model.mesh, eye, ray);
            Vec2d uv;
            for (std::size_t corner = 0; corner < 3 && hit.found(); ++corner)
            {
                const Vec2f at = model.mesh.texcoords[3 * hit.triangle + corner];
                uv = uv + Vec2d{double{at.x}, double{at.y}} * hit.weights[corner];
            }
            pixels.push_back({hit.front, eye + ray * hit.distance, lookup(model.picture, uv, wrong)});
        }
    return pixels;
}

/// The painted room as a camera sees it in truth.
Picture painted(const Camera& camera)
{
    Picture pixels = render({box_room(), Raster8(1, 1, 3)}, camera);
    for (Pixel& pixel : pixels)
        for (std::size_t c = 0; c < 3; ++c)
            pixel.rgb[c] = 255 * paint_at(pixel.position.x, pixel.position.y, pixel.position.z)[c];
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

/// Mean difference (of 255) between what is shown and what is expected; a pixel that shows nothing counts 255.
double difference(const std::vector<Picture>& shown, const std::vector<Picture>& expected)
{
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t f = 0; f < shown.size(); ++f)
        for (std::size_t i = 0; i < shown[f].size(); ++i)
            for (std::size_t c = 0; c < 3; ++c, ++count)
                sum += shown[f][i].found && expected[f][i].found ? std::abs(shown[f][i].rgb[c] - expected[f][i].rgb[c]) : 255;
    return sum / static_cast<double>(count);
}
}  // namespace

TEST_CASE("what is painted through the uv maps is what a viewer of the GLB sees")
{
    const Chain chain;
    const GlbModel model = read_glb(chain.glb());
    REQUIRE(model.mesh.triangles.size() == box_room().triangles.size());
    std::vector<Camera> color_cameras, depth_cameras;
    std::vector<Picture> paint;
    for (const Frame& frame : chain.frames().frames)
    {
        color_cameras.push_back(frame.color);
        depth_cameras.push_back(frame.depth);
        depth_cameras.back().intrinsics =
            frame.depth.intrinsics.scaled_to(frame.color.intrinsics.width, frame.color.intrinsics.height);
        paint.push_back(painted(frame.color));
    }
    const std::vector<Picture> rendered = chain.rendered_views();
    REQUIRE(rendered.size() == paint.size());
    const auto shown = [&](const std::vector<Camera>& cameras, const Wrong& wrong = {})
    {
        std::vector<Picture> pictures;
        for (const Camera& camera : cameras)
            pictures.push_back(render(model, camera, wrong));
        return pictures;
    };
    const std::vector<Picture> right = shown(color_cameras);
    CHECK(difference(right, paint) <= limit);
    CHECK(difference(right, rendered) <= limit);
    // A viewer of any other convention is detected.
    for (const Wrong& wrong : {Wrong{.flipped_v = true}, Wrong{.half_texel = true}, Wrong{.mirrored_axis = true}})
    {
        const std::vector<Picture> other = shown(color_cameras, wrong);
        CHECK(difference(other, paint) > limit);
        CHECK(difference(other, rendered) > limit);
    }
    CHECK(difference(shown(depth_cameras), paint) > limit);
}
