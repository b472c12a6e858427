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
#include <numbers>
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

const std::string no_common_up = "warning: the cameras have no common upward direction: the orbit turns about the world's z axis";

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

TEST_CASE("an orbit is level, turns to the right and closes")
{
    const std::vector<RigidTransform> recorded{standing({1, 5, 0}, 0.4), standing({3, 5, 0}, 2.0)};
    const auto path = orbit_path(recorded, 0.5, 30, 8);
    REQUIRE(path.size() == 8);
    for (std::size_t i = 0; i < 8; ++i)
    {
        CHECK(length(path[i].translation - Vec3d{2, 5, 0}) == Approx(0.5));
        CHECK(path[i].translation.y == Approx(5));
        const Vec3d forward = path[i].direction({0, 0, 1});
        CHECK(forward.y == Approx(0.5));  // y is down: sin 30°
        const double turn = 0.4 + 2 * std::numbers::pi * static_cast<double>(i) / 8;
        CHECK(forward.x == Approx(std::cos(std::numbers::pi / 6) * std::sin(turn)).margin(1e-12));
        CHECK(path[i].direction({1, 0, 0}).y == Approx(0).margin(1e-12));
    }
}

TEST_CASE("an orbit turns over the widest run of directions with something to see")
{
    using std::numbers::pi;
    CHECK(orbit_arc(std::vector<double>(8, 0.6)).around);
    CHECK(orbit_arc(std::vector<double>(8, 0.4)).around);
    // Two of them to the right; three across the one ahead.
    const OrbitArc arc = orbit_arc(std::vector<double>{0.9, 0.5, 0.49, 1, 1, 0, 0, 0.7});
    CHECK_FALSE(arc.around);
    CHECK(arc.first == Approx(2 * pi * 7 / 8));
    CHECK(arc.last == Approx(2 * pi * 9 / 8));

    const std::vector<RigidTransform> recorded{standing({1, 5, 0}, 0.4)};
    const auto path = orbit_path(recorded, 0.5, 0, 8, {-0.2, 0.6, false});
    const std::vector<double> turns{0.2, 0.2 + 0.4 * (1 - std::sqrt(0.5)), 0.6, 0.6 + 0.4 * std::sqrt(0.5), 1.0};
    for (std::size_t i = 0; i < 8; ++i)
    {
        const Vec3d forward = path[i].direction({0, 0, 1});
        CHECK(std::atan2(forward.x, forward.z) == Approx(turns[i <= 4 ? i : 8 - i]));
    }
}

TEST_CASE_METHOD(testing::StageTest, "an orbit before a single wall never turns away from it")
{
    auto frames = two_frames();
    frames->frames.resize(1);
    const auto names =
        fly(folder.path(), Value::Map{{"format", "png"}, {"seconds", 0.32}, {"height_px", 48}, {"path", "orbit"}}, frames, run);
    CHECK(std::ranges::count(run.messages, no_common_up) == 0);
    CHECK(run.reported.at("arc_deg").as_double() == Approx(50).margin(40));
    REQUIRE(names.size() == 8);
    for (const auto& name : names)
    {
        // The wall has no channel of this gray.
        const Raster8 picture = stored_png::Codec().read_rgb(folder.path() / "video" / name);
        CHECK(std::ranges::count(picture.values, 32) <= std::ssize(picture.values) * 11 / 20);
    }
}

TEST_CASE_METHOD(testing::StageTest, "an orbit says that its cameras have no common upward direction")
{
    auto frames = two_frames();
    frames->frames[1].sequence = frames->frames[0].sequence;
    frames->frames[1].color.world_from_camera.rotation.m = {-1, 0, 0, 0, -1, 0, 0, 0, 1};
    fly(folder.path(), Value::Map{{"format", "png"}, {"seconds", 0.1}, {"height_px", 16}, {"path", "orbit"}}, frames, run);
    CHECK(std::ranges::count(run.messages, no_common_up) == 1);
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
