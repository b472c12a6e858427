#include "box_room.h"
#include "catch.h"
#include "plain_viewer.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

constexpr int frame_count = 12;

/// Without the alpha channel of rendered views.
class Codec final : public stored_png::Codec
{
  public:
    Raster8 read_rgb(const fs::path& file) const override
    {
        const Raster8 stored = stored_png::Codec::read_rgb(file);
        Raster8 rgb(stored.width, stored.height, 3);
        for (int y = 0; y < rgb.height; ++y)
            for (int x = 0; x < rgb.width; ++x)
                for (int c = 0; c < 3; ++c)
                    rgb.at(x, y, c) = stored.at(x, y, c);
        return rgb;
    }
};

/// What all pictures agree on: waves of 60 cm on every surface.
std::array<double, 3> room_paint(const plain::Point& p)
{
    return {0.5 + 0.2 * std::sin(10 * p[0] + 4 * p[2]), 0.5 + 0.2 * std::sin(10 * p[1] - 3 * p[0]),
            0.5 + 0.2 * std::sin(10 * p[2] + 5 * p[1])};
}

/// A walk along the middle of the room.
Frames walk()
{
    Frames frames;
    const Camera like = box_room_frames().frames[6].color;
    for (int i = 0; i < frame_count; ++i)
    {
        Frame frame;
        frame.sequence = "walk";
        frame.name = "frame-" + std::to_string(i);
        frame.number = i;
        frame.color = like;
        frame.color.world_from_camera.translation += Vec3d{0, 0.05 * i - 0.3, 0.02 * (i % 4)};
        frame.depth = frame.color;
        frames.frames.push_back(frame);
    }
    return frames;
}

std::vector<plain::Pixel> true_points(const Camera& camera)
{
    plain::Model model;
    const Mesh mesh = box_room();
    for (const Triangle& t : mesh.triangles)
    {
        auto& triangle = model.triangles.emplace_back();
        for (std::size_t i = 0; i < 3; ++i)
            triangle[i].position = {double{mesh.positions[t[i]].x}, double{mesh.positions[t[i]].y},
                                    double{mesh.positions[t[i]].z}};
    }
    const auto& r = camera.world_from_camera.rotation.m;
    const Vec3d t = camera.world_from_camera.translation;
    const Intrinsics& k = camera.intrinsics;
    return plain::render(
        model, {1, 1, {0, 0, 0}},
        {k.width, k.height, k.fx, k.fy, k.cx, k.cy, {r[0], r[1], r[2], t.x, r[3], r[4], r[5], t.y, r[6], r[7], r[8], t.z}}, {});
}

/// The room's paint, and in every picture stripes and a brightness of its own, as a style transfer picture by picture leaves.
Raster8 stylized(const Camera& camera, int number)
{
    const auto points = true_points(camera);
    Raster8 picture(camera.intrinsics.width, camera.intrinsics.height, 3);
    const double angle = 2.4 * number;
    const double gain = 1 + 0.1 * std::sin(1.7 * number);
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
        {
            const auto paint = room_paint(points[static_cast<std::size_t>(y * picture.width + x)].position);
            const double stripe = 0.12 * std::sin(0.5 * (x * std::cos(angle) + y * std::sin(angle)) + number);
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = static_cast<std::uint8_t>(
                    std::lround(std::clamp(gain * paint[static_cast<std::size_t>(c)] + stripe, 0.0, 1.0) * 255));
        }
    return picture;
}

class Chain
{
  public:
    Chain() : room_(std::make_shared<Mesh>(box_room())), frames_(std::make_shared<Frames>(walk()))
    {
        fs::create_directories(styled());
        for (const Frame& frame : frames_->frames)
            write_file(styled() / ("walk_" + frame.name + ".png"),
                       Codec().encode_png(stylized(frame.color, static_cast<int>(frame.number))));
        run("uvmaps.raycast", Value::Map{{"heights_px", Value::List{120}}}, {{"mesh", room_}, {"frames", frames_}});
        const auto maps = UvMaps::load({folder_.path() / "uvmaps", folder_.path()});
        run("texture.from_frames", Value::Map{{"pictures", styled().string()}, {"size_px", 640}},
            {{"uvmaps", maps}, {"frames", frames_}});
        const auto texture = Texture::load({folder_.path() / "texture", folder_.path()});
        run("texture.bake", Value::Map{}, {{"texture", texture}, {"mesh", room_}});
        const auto baked = TexturedMesh::load({folder_.path() / "textured_mesh", folder_.path()});
        run("render.views", Value::Map{{"samples", 1}}, {{"mesh", baked}, {"frames", frames_}});
    }

    fs::path styled() const { return folder_.path() / "styled"; }
    fs::path rendered() const { return folder_.path() / "views" / "views"; }
    const Frames& frames() const { return *frames_; }

    /// The figures of frames `gap` apart.
    Value judged(const fs::path& pictures, int gap)
    {
        run("evaluate.reprojection", Value::Map{{"folder", pictures.string()}, {"short_gap", gap}, {"long_gap", 10}},
            {{"frames", frames_}, {"mesh", room_}});
        const auto files = Files::load({folder_.path() / "figures", folder_.path()});
        return parse_json(read_text_file(files->loaded_from / files->names.at(0))).at("short");
    }

  private:
    void run(const std::string& type, const Value& options, const testing::Inputs& inputs)
    {
        std::string library = type;
        std::ranges::replace(library, '.', '_');
        testing::TestRun test_run;
        testing::run_stage(fs::path(FRESCO_PLUGINS) / (library + ".so"), type, options, inputs, folder_.path(), test_run,
                           {{"images", std::make_shared<Codec>()}});
    }

    testing::TemporaryFolder folder_;
    std::shared_ptr<const Mesh> room_;
    std::shared_ptr<const Frames> frames_;
};

double of(const Value& figures, const char* name)
{
    return figures.at(name).at("value").as_double();
}

}  // namespace

TEST_CASE("the texture of pictures that were stylized one by one agrees with itself, and shows what they share")
{
    Chain chain;
    for (const int gap : {1, 4})
    {
        CAPTURE(gap);
        const Value pictures = chain.judged(chain.styled(), gap);
        const Value texture = chain.judged(chain.rendered(), gap);
        REQUIRE(pictures.at("pairs").as_int() == frame_count - gap);
        REQUIRE(texture.at("pairs").as_int() == frame_count - gap);
        CAPTURE(of(pictures, "value"), of(texture, "value"), of(pictures, "headline"), of(texture, "headline"));
        // Two stripes of 0.12 in independent phases differ by 0.1 in the mean.
        CHECK(of(pictures, "value") > 0.07);
        CHECK(of(texture, "value") < of(pictures, "value") / 5);
        CHECK(of(texture, "headline") < of(pictures, "headline") / 5);
    }
    // Neither gray nor one of the pictures: the paint, from which every single picture differs by 0.08 and more.
    double error = 0;
    std::size_t count = 0;
    for (const Frame& frame : chain.frames().frames)
    {
        const Raster8 view = Codec().read_rgb(chain.rendered() / ("walk_" + frame.name + ".png"));
        const auto points = true_points(frame.color);
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c, ++count)
                error += std::abs(view.values[3 * i + c] / 255.0 - room_paint(points[i].position)[c]);
    }
    CHECK(error / static_cast<double>(count) < 0.05);
}
