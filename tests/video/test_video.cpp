#include "catch.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
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
        return testing::picture(stored.width, stored.height, [&](int x, int y, int c) { return stored.at(x, y, c); });
    }
};

/// The paint that all pictures share: waves of 60 cm on every surface.
double room_paint(const Vec3d& p, int channel)
{
    const double wave = channel == 0 ? 10 * p.x + 4 * p.z : channel == 1 ? 10 * p.y - 3 * p.x : 10 * p.z + 5 * p.y;
    return 255 * (0.5 + 0.2 * std::sin(wave));
}

/// A walk along the middle of the room.
Frames walk()
{
    Frames frames;
    for (int i = 0; i < frame_count; ++i)
    {
        Camera camera = testing::camera(160, 120, 90);
        const Vec3d eye{1, 1.2 + 0.05 * i, 1.2 + 0.02 * (i % 4)};
        camera.world_from_camera = testing::looking_at(eye, eye + Vec3d{1, 0, -0.1});
        frames.frames.push_back(testing::frame("frame-" + std::to_string(i), camera, i));
    }
    return frames;
}

/// The room's paint, and in every picture stripes and a brightness of its own, as a style transfer picture by picture leaves.
Raster8 stylized(const Raster8& seen, int number)
{
    const double angle = 2.4 * number;
    const double gain = 1 + 0.1 * std::sin(1.7 * number);
    return testing::picture(seen.width, seen.height,
                            [&](int x, int y, int c)
                            {
                                const double along = x * std::cos(angle) + y * std::sin(angle);
                                return gain * seen.at(x, y, c) + 255 * 0.12 * std::sin(0.5 * along + number);
                            });
}

class Chain
{
  public:
    Chain() : room_(std::make_shared<Mesh>(testing::room({4, 3, 2.5F}))), frames_(std::make_shared<Frames>(walk()))
    {
        fs::create_directories(styled());
        for (const Frame& frame : frames_->frames)
            write_file(styled() / (frame.sequence + "_" + frame.name + ".png"),
                       Codec().encode_png(stylized(seen_by(frame.color), static_cast<int>(frame.number))));
        run("uvmaps.raster", Value::Map{{"heights_px", Value::List{120}}}, {{"mesh", room_}, {"frames", frames_}});
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
    Raster8 seen_by(const Camera& camera) const { return testing::picture_of(*room_, camera, room_paint); }

    /// The figures of frames `gap` apart.
    Value judged(const fs::path& pictures, int gap)
    {
        run("evaluate.reprojection", Value::Map{{"folder", pictures.string()}, {"gaps", Value::List{gap, 10}}},
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
                           {{"image_io", std::make_shared<Codec>()}});
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
        const Raster8 view = Codec().read_rgb(chain.rendered() / (frame.sequence + "_" + frame.name + ".png"));
        const Raster8 truth = chain.seen_by(frame.color);
        REQUIRE(view.values.size() == truth.values.size());
        for (std::size_t i = 0; i < view.values.size(); ++i, ++count)
            error += std::abs(view.values[i] - truth.values[i]) / 255.0;
    }
    CHECK(error / static_cast<double>(count) < 0.05);
}
