#include "catch.h"
#include "layout_checks.h"
#include "odometry.h"

#include <opencv2/videoio.hpp>

#include <fmt/format.h>
#include <tuple>

namespace
{

using namespace fresco;
using namespace fresco::testing;

/// Six pictures of 64x48 a thirtieth of a second apart, each of one gray, and depth of 16x12.
struct Capture
{
    TemporaryFolder folder;
    fs::path path = folder.path() / "capture";
    RawImages images;

    explicit Capture(int pictures = 6)
    {
        for (const char* name : {"depth", "confidence"})
            fs::create_directories(path / name);
        cv::VideoWriter video((path / "rgb.mp4").string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 30,
                              {64, 48});
        std::string odometry =
            "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy, distortion_center_x, distortion_center_y\n";
        for (int i = 0; i < 6; ++i)
        {
            if (i < pictures)
                video.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(gray(i))));
            const auto name = numbered("", static_cast<std::size_t>(i), ".png");
            Raster16 depth(16, 12);
            std::ranges::fill(depth.values, static_cast<std::uint16_t>(1000 + i));
            write_file(path / "depth" / name, images.encode_png(depth));
            Raster8 confidence(16, 12, 3);
            std::ranges::fill(confidence.values, std::uint8_t{2});
            for (int c = 0; c < 3; ++c)
                confidence.at(3, 0, c) = 1;
            write_file(path / "confidence" / name, images.encode_png(confidence));
            odometry += fmt::format("{:.6f}, {}, {}, 2, 3, 0.6, 0, 0, 0.8{}\n", 1000 + i / 30.0, name.substr(0, 6), i,
                                    i % 2 == 0 ? ", 60, 61, 32, 24, , " : ", , , , , , ");
        }
        write_file(path / "odometry.csv", odometry);
        write_file(path / "camera_matrix.csv", std::string("50, 0, 33\n0, 51, 25\n0, 0, 1"));
    }
    static int gray(int i) { return 30 + 40 * i; }

    recordings::ReadRecording read(TestRun& run, int every = 1, const Value& options = Value::Map{}) const
    {
        TestFactory none;
        const auto layout = make_from_plugin<recordings::Layout>(FRESCO_PLUGIN_FILE, "layout.stray_scanner");
        layout->configure(options, none);
        const auto out = folder.path() / "frames";
        fs::create_directories(out);
        return recordings::read_recording(*layout, {.path = path, .every = every}, images, out, run);
    }
    std::string error() const
    {
        return error_of(
            [&]
            {
                TestRun run;
                read(run);
            });
    }
    void edit(const fs::path& file, const std::string& from, const std::string& to) const
    {
        auto text = read_text_file(path / file);
        const auto at = text.find(from);
        REQUIRE(at != std::string::npos);
        write_file(path / file, text.replace(at, from.size(), to));
    }
};

}  // namespace

TEST_CASE("each picture of the video goes with its row", "[layout.stray_scanner]")
{
    const Capture capture;
    for (const int every : {1, 2})
    {
        TestRun run(2);
        const auto frames = capture.read(run, every).frames.frames;
        REQUIRE(frames.size() == 6U / static_cast<unsigned>(every));
        for (std::size_t i = 0; i < frames.size(); ++i)
        {
            const auto& frame = frames[i];
            const int row = static_cast<int>(i) * every;
            const auto color = load_color(frame, &capture.images);
            CHECK((color.width == 64 && color.height == 48));
            CHECK(color.at(20, 20, 0) == Approx(Capture::gray(row)).margin(4));
            CHECK(frame.color.intrinsics ==
                  (row % 2 == 0 ? Intrinsics{64, 48, 60, 61, 32, 24} : Intrinsics{64, 48, 50, 51, 33, 25}));
            // 0.6 i + 0.8 is a rotation about x by 73.7°.
            CHECK(length(frame.color.world_from_camera.point({0, 1, 0}) - Vec3d{double(row), 2.28, 3.96}) < 1e-9);
            const auto depth = load_depth_steps(frame, &capture.images);
            CHECK((depth.at(0, 0) == 1000 + row && depth.at(3, 0) == 0));
            CHECK(frame.depth.intrinsics.width == 16);
        }
    }
    TestRun run;
    const auto all = capture.read(run, 1, Value::Map{{"min_confidence", 1}}).frames.frames;
    CHECK(load_depth_steps(all[0], &capture.images).at(3, 0) == 1000);
}

TEST_CASE("without its first picture the video begins at the second row", "[layout.stray_scanner]")
{
    const Capture capture(5);
    fs::remove(capture.path / "depth/000003.png");
    TestRun run;
    const auto frames = capture.read(run).frames.frames;
    REQUIRE(frames.size() == 5);
    CHECK(frames[0].name == "000001");
    CHECK(load_color(frames[0], &capture.images).at(20, 20, 0) == Approx(Capture::gray(0)).margin(4));
    CHECK(frames[2].depth_picture.empty());
    CHECK(load_depth_steps(frames[4], &capture.images).at(0, 0) == 1005);
}

TEST_CASE("a row without a finite pose is left out", "[layout.stray_scanner]")
{
    const Capture capture;
    capture.edit("odometry.csv", "000001, 1, 2", "000001, nan, 2");
    TestRun run;
    CHECK(capture.read(run).frames.frames.size() == 5);
    CHECK(run.reported.at("poses_not_tracked").as_int() == 1);
}

TEST_CASE("a capture of Stray Scanner that cannot be used is refused by name", "[layout.stray_scanner]")
{
    CHECK_THAT(Capture(4).error(), Contains("rgb.mp4: 4 pictures, and odometry.csv has 6 rows"));
    const std::vector<std::tuple<const char*, const char*, const char*, const char*>> flaws{
        {"odometry.csv", "timestamp, ", "", "odometry.csv:1: there is no column \"timestamp\""},
        {"odometry.csv", ", 2, 3, 0.6", ", 3, 0.6", "odometry.csv:2: 14 values; expected 15"},
        {"odometry.csv", "0.6, 0, 0, 0.8", "0.6, 0, 0, 0.1", "odometry.csv:2"},
        {"odometry.csv", "1000.033333", "1000.000000", "odometry.csv:3: the time is not later"},
        {"camera_matrix.csv", "50, 0, 33", "50, 33", "camera_matrix.csv:1"},
        {"camera_matrix.csv", "0, 33", "0, 933", "the principal point"}};
    for (const auto& [file, from, to, said] : flaws)
    {
        const Capture capture;
        capture.edit(file, from, to);
        INFO(said);
        CHECK_THAT(capture.error(), Contains(said));
    }
    const Capture capture;
    fs::remove_all(capture.path / "depth");
    CHECK_THAT(capture.error(), Contains("6 files are missing") && Contains("depth/000002.png"));
    write_file(capture.path / "rgb.mp4", std::string("no video"));
    CHECK_THAT(capture.error(), Contains("rgb.mp4: OpenCV's FFmpeg cannot read this video"));
}
