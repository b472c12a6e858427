#include "catch.h"
#include "painted_wall.h"
#include "plugin_under_test.h"
#include "raw_images.h"
#include "uv_map_samples.h"

#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/texture.h>

#include <filesystem>

using namespace painted_wall;
namespace fs = std::filesystem;

namespace
{

/// Uv maps of two heights, and frames with NPY pictures and raw depth pictures, below a folder.
struct Recording
{
    explicit Recording(const fs::path& folder, bool with_depth = false)
    {
        const auto cameras = five_cameras();
        for (std::size_t i = 0; i < cameras.size(); ++i)
        {
            Frame frame = testing::frame("frame-" + std::to_string(i), cameras[i]);
            testing::set_color_picture(frame, folder, picture_of(cameras[i], smooth_paint));
            if (with_depth)
                write_depth(folder, frame);
            frames->frames.push_back(frame);
        }
        maps = written_uv_maps(folder / "maps", *frames, {30, 60},
                               [&](std::size_t view, int, int height) { return map_of(cameras[view], height); });
    }

    /// The wall's depth; in the left half of the first frame something 1 m away.
    static void write_depth(const fs::path& folder, Frame& frame)
    {
        RasterF depth(frame.depth.intrinsics.width, frame.depth.intrinsics.height);
        for (int y = 0; y < depth.height; ++y)
            for (int x = 0; x < depth.width; ++x)
                depth.at(x, y) =
                    frame.name == "frame-0" && x < 80 ? 1 : static_cast<float>(point_at(frame.depth, x + 0.5, y + 0.5).depth);
        testing::set_depth_picture(frame, folder, depth);
    }

    std::shared_ptr<UvMaps> maps;
    std::shared_ptr<Frames> frames = std::make_shared<Frames>();
};

std::shared_ptr<const Texture> made(const Recording& recording, Value::Map options, testing::TestRun& run)
{
    return testing::output_of<Texture>("texture.from_frames", "texture", options,
                                       {{"uvmaps", recording.maps}, {"frames", recording.frames}}, run,
                                       {{"image_io", std::make_shared<testing::RawImages>()}});
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "the stage makes a texture that texture.bake takes, and reports")
{
    const Recording recording(folder.path());
    const auto texture = made(recording, {{"size_px", 64}}, run);
    REQUIRE(texture->size_px() == 64);
    const Vec3f truth = smooth_paint(20.5 / 64, 1 - 40.5 / 64);
    CHECK(texture->layers[0].at(20, 40, 0) == Approx(truth.x).margin(0.01));
    CHECK(texture->layers[0].at(20, 40, 2) == Approx(truth.z).margin(0.01));
    CHECK(run.reported.at("views").as_int() == 5);
    CHECK(run.reported.at("height_px").as_int() == 60);
    CHECK(run.reported.at("samples_per_texel").as_double() > 3);
    CHECK(run.reported.at("occluded_pixel_share").as_double() == 0);
    CHECK(run.reported.at("least_gain").as_double() == Approx(1).epsilon(0.01));
    CHECK_THROWS_WITH(made(recording, {}, run), Contains("the texture size is unknown") && Contains("'uvmaps'"));
    recording.maps->texture_px = 48;
    CHECK(made(recording, {}, run)->size_px() == 48);
    made(Recording(folder.path(), true), {{"size_px", 16}, {"height_px", 30}}, run);
    CHECK(run.reported.at("height_px").as_int() == 30);
    CHECK(run.reported.at("occluded_pixel_share").as_double() == Approx(0.1).margin(0.03));
    CHECK_THROWS_WITH(made(recording, {{"size_px", 16}, {"height_px", 45}}, run), Contains("45 px; found 30, 60"));
}

TEST_CASE_METHOD(testing::StageTest, "pictures of a folder take the place of the cameras'")
{
    const Recording recording(folder.path());
    const fs::path styled = folder.path() / "styled";
    fs::create_directories(styled);
    const auto write_all = [&](int width, int height)
    {
        for (const Frame& frame : recording.frames->frames)
        {
            const auto file = styled / ("seq-01_" + frame.name + ".npy");
            write_npy(file, testing::picture(width, height, [](int, int, int c) { return c == 0 ? 200 : 40; }));
        }
    };
    const Value::Map options{{"size_px", 32}, {"pictures", styled.string()}};
    write_all(213, 160);  // 4 : 3, to a pixel.
    const auto texture = made(recording, options, run);
    CHECK(texture->layers[0].at(16, 16, 0) == Approx(200 / 255.0).margin(1e-3));
    CHECK(texture->layers[0].at(16, 16, 1) == Approx(40 / 255.0).margin(1e-3));
    CHECK(run.files_read.size() == 5);
    CHECK(run.folders_read.size() == 4);

    write_all(200, 160);
    CHECK_THROWS_WITH(made(recording, options, run), Contains("seq-01_frame-") && Contains("160x120"));
    write_all(160, 120);
    fs::remove(styled / "seq-01_frame-3.npy");
    fs::remove(styled / "seq-01_frame-1.npy");
    CHECK_THROWS_AS(made(recording, options, run), MissingInput);
    CHECK_THROWS_WITH(made(recording, options, run), Contains("2 of 5 frames") && Contains("seq-01_frame-1, seq-01_frame-3;"));
    write_file(styled / "seq-01_frame-1.png", testing::RawImages().encode_png(Raster8(160, 120, 3, 9)));
    write_file(styled / "seq-01_frame-3.jpg", testing::RawImages().encode_jpeg(Raster8(160, 120, 3, 9), 90));
    CHECK(made(recording, options, run)->layers[0].at(16, 16, 0) > 0.1F);

    // A picture that is transparent everywhere shows nothing; the others are used.
    write_file(styled / "seq-01_frame-1.png", testing::RawImages().encode_png(Raster8(160, 120, 4, 0)));
    CHECK(made(recording, options, run)->layers[0].at(16, 16, 0) > 0.1F);

    // Texels that are transparent in all pictures are unseen: only the first picture is left, and its upper half is transparent.
    recording.maps->views.resize(1);
    const auto first = [&](std::uint8_t alpha_above)
    {
        Raster8 picture(160, 120, 4, 100);
        for (std::size_t i = 3; i < picture.values.size(); i += 4)
            picture.values[i] = i < picture.values.size() / 2 ? alpha_above : 255;
        fs::remove(styled / "seq-01_frame-0.npy");
        write_file(styled / "seq-01_frame-0.png", testing::RawImages().encode_png(picture));
        return made(recording, options, run);
    };
    const auto seen = [](const Texture& made) { return static_cast<double>(std::ranges::count(made.seen.values, 1)); };
    const auto whole = first(255);
    const auto half = first(0);
    CHECK(seen(*half) > 0);
    CHECK(seen(*half) < 0.7 * seen(*whole));
    for (std::size_t i = 0; i < half->seen.values.size(); ++i)
        if (half->seen.values[i] != 0)
            CHECK(half->layers[0].values[3 * i] == Approx(100 / 255.0).margin(1e-3));
    write_file(styled / "seq-01_frame-0.png", testing::RawImages().encode_png(Raster8(160, 120, 4, 0)));
    CHECK_THROWS_WITH(made(recording, options, run), Contains("no view shows a texel") && Contains("opaque"));
}
