#include "catch.h"
#include "fly_path.h"
#include "plugin_under_test.h"
#include "stored_png.h"
#include "video_file.h"

#include <fresco/files.h>
#include <fresco/frames.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <opencv2/videoio.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <sys/resource.h>

using namespace fresco;

namespace
{

/// At `place`, turned to the right by `turn` (radians) from looking along z, y down.
RigidTransform standing(Vec3d place, double turn)
{
    return testing::camera(1, 1, 1, place, turn).world_from_camera;
}

/// A wall z = 2 over x, y in [-1,1] facing the origin, red on the left half and blue on the right.
std::shared_ptr<TexturedMesh> wall()
{
    auto textured = std::make_shared<TexturedMesh>();
    textured->mesh = testing::wall(1);
    textured->image = Image(testing::picture(8, 8, [](int x, int, int c) { return c == (x < 4 ? 0 : 2) ? 255 : 0; }));
    return textured;
}

std::shared_ptr<Frames> two_frames()
{
    auto frames = std::make_shared<Frames>();
    for (const double x : {-0.2, 0.2})
    {
        frames->frames.push_back(testing::frame(x < 0 ? "a" : "b", testing::camera(65, 49, 49, {x, 0, 0})));
        frames->frames.back().depth.world_from_camera = {};
    }
    return frames;
}

/// The names of the files in folder/video.
std::vector<std::string> fly(const std::filesystem::path& folder, Value options, std::shared_ptr<Frames> frames,
                             testing::TestRun& run)
{
    testing::run_stage(FRESCO_PLUGIN_FILE, "render.flythrough", options, {{"mesh", wall()}, {"frames", std::move(frames)}},
                       folder, run, {{"image_io", std::make_shared<stored_png::Codec>()}});
    return Files::load({folder / "video", folder})->names;
}

}  // namespace

TEST_CASE("the smooth way begins and ends with the recording and is walked at a steady speed")
{
    // Recorded in haste at first, then lingering: steps of 0.4 m, then of 0.05 m.
    std::vector<RigidTransform> recorded;
    double x = 0;
    for (int i = 0; i < 30; ++i)
    {
        recorded.push_back(standing({x, i % 2 == 0 ? 0.02 : -0.02, 0}, 0));
        x += i < 10 ? 0.4 : 0.05;
    }
    const auto path = recorded_path(recorded, 3, 101);
    REQUIRE(path.size() == 101);
    CHECK(length(path.front().translation - recorded.front().translation) < 1e-12);
    CHECK(length(path.back().translation - recorded.back().translation) < 1e-12);
    const double step = length(path[1].translation - path[0].translation);
    for (std::size_t i = 1; i < path.size(); ++i)
        CHECK(length(path[i].translation - path[i - 1].translation) == Approx(step).epsilon(0.03));
    // The trembling is gone where there are enough frames around.
    CHECK(std::abs(path[50].translation.y) < 0.004);
    for (const auto& pose : path)
        CHECK(pose.rotation_error() < 1e-9);
}

TEST_CASE("turning on the spot is steady too")
{
    std::vector<RigidTransform> recorded;
    for (const double turn : {0.0, 0.1, 0.2, 1.0, 1.2})
        recorded.push_back(standing({1, 2, 3}, turn));
    const auto path = recorded_path(recorded, 0.1, 25);
    for (std::size_t i = 0; i < path.size(); ++i)
    {
        const Vec3d forward = path[i].direction({0, 0, 1});
        CHECK(std::atan2(forward.x, forward.z) == Approx(1.2 * static_cast<double>(i) / 24).margin(0.03));
    }
    CHECK(recorded_path(std::span(recorded).first(1), 6, 3).size() == 3);
}

TEST_CASE_METHOD(testing::StageTest, "pictures show the wall, and gray beside it")
{
    REQUIRE(fly(folder.path(), Value::Map{{"format", "png"}, {"seconds", 0.1}, {"height_px", 49}}, two_frames(), run) ==
            std::vector<std::string>{"flythrough/000000.png", "flythrough/000001.png", "flythrough/000002.png"});
    const Raster8 picture = stored_png::Codec().read_rgb(folder.path() / "video/flythrough/000000.png");
    CHECK((picture.height == 48 && picture.width == 64));
    CHECK((picture.at(24, 24, 0) == 255 && picture.at(46, 24, 2) == 255 && picture.at(0, 0, 0) == 32));
    CHECK(run.reported.at("pictures").as_int() == 3);
}

TEST_CASE("a video can be played: size, pictures and colors")
{
    for (const char* format : {"mp4", "webm"})
    {
        const testing::TemporaryFolder folder;
        testing::TestRun run;
        fly(folder.path(), Value::Map{{"format", format}, {"seconds", 0.4}, {"height_px", 96}, {"name", "a/tour"}}, two_frames(),
            run);
        const auto file = folder.path() / "video" / ("a/tour." + std::string(format));
        cv::VideoCapture video(file.string());
        REQUIRE(video.isOpened());
        CHECK(video.get(cv::CAP_PROP_FRAME_WIDTH) == 128);
        CHECK(video.get(cv::CAP_PROP_FRAME_HEIGHT) == 96);
        CHECK(video.get(cv::CAP_PROP_FPS) == Approx(25));
        int count = 0;
        for (cv::Mat picture; video.read(picture); ++count)
        {
            const auto blue = picture.at<cv::Vec3b>(48, 90);
            const auto red = picture.at<cv::Vec3b>(48, 40);
            CHECK(blue[0] > blue[2] + 100);
            CHECK(red[2] > red[0] + 100);
        }
        CHECK(count == 10);
    }
}

TEST_CASE_METHOD(testing::StageTest, "a video that the disk did not hold to its end is refused")
{
    // As a full disk: beyond so many bytes nothing is written.
    struct rlimit before = {};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    for (const char* name : {"cut.mp4", "cut.webm"})
        for (const bool is_full : {false, true})
        {
            VideoFile video(folder.path() / name, 64, 48, 25);
            const struct rlimit limit = {20'000, before.rlim_max};
            REQUIRE(setrlimit(RLIMIT_FSIZE, is_full ? &limit : &before) == 0);
            for (std::uint64_t i = 0; i < 300; ++i)
                video.add(testing::noise_picture(64, 48, i));
            if (is_full)
                CHECK_THROWS_WITH(video.close(), Catch::Contains(name) && Catch::Contains("is the disk full?"));
            else
                CHECK_NOTHROW(video.close());
            REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
        }
    std::signal(SIGXFSZ, handler);
}

TEST_CASE_METHOD(testing::StageTest, "the flight refuses what it cannot show")
{
    CHECK_THROWS_WITH(fly(folder.path(), Value::Map{}, std::make_shared<Frames>(), run), Catch::Contains("no frames"));
    CHECK_THROWS_WITH(VideoFile(folder.path() / "none/there.mp4", 64, 48, 25), Catch::Contains("format: png"));
}
