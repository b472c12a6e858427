#include "sens_depth.h"
#include "sens_frames.h"

#include "reader_damage.h"

#include <fresco/error.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <limits>
#include <zlib.h>

namespace fs = std::filesystem;
using Catch::Contains;
using fresco::Value;
using fresco::testing::RawImages;
using fresco::testing::TestRun;

namespace
{

// Where things are in the sample, whose sensor's name has 8 letters.
constexpr std::size_t at_matrices = 4 + 8 + 8;
constexpr std::size_t at_forms = at_matrices + 4 * 64;
constexpr std::size_t at_sizes = at_forms + 8;
constexpr std::size_t at_shift = at_sizes + 16;
constexpr std::size_t at_count = at_shift + 4;
constexpr std::size_t at_frames = at_count + 8;
constexpr std::size_t at_color_bytes = at_frames + 64 + 16;

/// Color and depth camera apart.
struct TinyRecording
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;
    fresco::Frames frames;

    explicit TinyRecording(const std::function<void(std::size_t, std::vector<double>&)>& edit = {}, int count = 3)
        : frames(fresco::testing::tiny_recording(folder.path(), images, count))
    {
        fresco::RigidTransform color_from_depth;
        color_from_depth.translation = {0.03, 0.001, -0.002};
        for (auto& frame : frames.frames)
            frame.depth.world_from_camera = frame.color.world_from_camera * color_from_depth;
        fresco::testing::write_sens(frames, file(), images, edit);
    }
    fs::path file() const { return folder.path() / "scene0000_00.sens"; }
    std::string bytes() const { return fresco::read_text_file(file()); }
    template <class T>
    void set(std::size_t offset, T value) const
    {
        auto content = bytes();
        content.replace(offset, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
        fresco::write_file(file(), content);
    }
};

fresco::Frames read(const TinyRecording& recording, TestRun& run, const Value& options = Value::Map{})
{
    return *fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.sens", recording.file(), recording.images,
                                        recording.folder.path() / "out", run, options)
                .frames;
}

std::string error_of(const TinyRecording& recording)
{
    return fresco::testing::reading_error([&](TestRun& run) { read(recording, run); });
}

void lose(std::vector<double>& pose)
{
    pose.assign(16, -std::numeric_limits<double>::infinity());
}

}  // namespace

TEST_CASE("a recording is read back, both cameras", "[scan.sens]")
{
    const TinyRecording recording;
    TestRun run;
    const auto frames = read(recording, run);
    fresco::testing::check_same_recording(frames, recording.frames, recording.images);
    CHECK(frames.frames[1].name == "frame-000001");
    CHECK(frames.frames[1].sequence == "scene");
    CHECK(frames.frames[1].depth_unit_m == Approx(0.001));
    CHECK(fresco::read_file(frames.frames[1].color_picture.path) ==
          fresco::read_file(recording.frames.frames[1].color_picture.path));
    const auto second = read(recording, run, Value::Map{{"every", 2}});
    REQUIRE(second.frames.size() == 2);
    CHECK(second.frames[1].number == 2);
}

TEST_CASE("frames that the recorder had lost are left out", "[scan.sens]")
{
    const TinyRecording recording(
        [](std::size_t frame, std::vector<double>& pose)
        {
            if (frame == 1)
                lose(pose);
        });
    TestRun run(1);
    const auto frames = read(recording, run);
    REQUIRE(frames.frames.size() == 2);
    CHECK(frames.frames[1].number == 2);
    CHECK(run.reported.at("poses_not_tracked").as_int() == 1);
    CHECK(run.reported.at("recorded").as_int() == 3);
    const TinyRecording lost([](std::size_t, std::vector<double>& pose) { lose(pose); });
    CHECK_THAT(error_of(lost), Contains("none of the 3 frames has a finite pose"));
}

TEST_CASE("depth that zlib compressed is unpacked, and nothing beyond the picture", "[scan.sens]")
{
    fresco::Raster16 depth(40, 30);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        depth.values[i] = static_cast<std::uint16_t>(i * i % 5000);
    const auto pack = [](const fresco::Raster16& picture)
    {
        uLongf size = compressBound(picture.values.size() * 2);
        std::vector<std::byte> packed(size);
        REQUIRE(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(picture.values.data()),
                         picture.values.size() * 2) == Z_OK);
        packed.resize(size);
        return packed;
    };
    const auto packed = pack(depth);
    CHECK(packed.size() < depth.values.size() * 2);
    CHECK(sens::unpack_depth(packed, 40, 30, "x") == depth);
    CHECK_THROWS_WITH(sens::unpack_depth(packed, 40, 29, "f: byte 3"), Contains("f: byte 3: more where a depth picture of 2320"));
    CHECK_THROWS_WITH(sens::unpack_depth(packed, 40, 31, "x"), Contains("x: 2400 bytes where"));
    CHECK_THROWS_WITH(sens::unpack_depth(std::span(packed).first(packed.size() - 5), 40, 30, "x"), Contains("x: "));
    CHECK_THROWS_AS(sens::unpack_depth({}, 40, 30, "x"), fresco::Error);
    // A thousand times its size if it were let.
    CHECK_THROWS_WITH(sens::unpack_depth(pack(fresco::Raster16(2000, 2000)), 2, 2, "x"), Contains("x: more where"));
}

TEST_CASE("a file that cannot be used is refused by byte", "[scan.sens]")
{
    TinyRecording recording;
    SECTION("another version")
    {
        recording.set(0, std::uint32_t{5});
        CHECK_THAT(error_of(recording), Contains("scene0000_00.sens: byte 0: version 5"));
    }
    SECTION("a name that is none")
    {
        recording.set(4, std::uint64_t{1} << 60U);
        CHECK_THAT(error_of(recording), Contains("byte 4: a sensor's name of 1152921504606846976 bytes"));
    }
    SECTION("compressions")
    {
        recording.set(at_forms, std::int32_t{-1});
        CHECK_THAT(error_of(recording), Contains("compression -1 of the color pictures; 0 (raw), 1 (PNG)"));
        recording.set(at_forms, std::int32_t{2});
        recording.set(at_forms + 4, std::int32_t{2});
        CHECK_THAT(error_of(recording), Contains("compression 2 of the depth pictures") && Contains("not occi"));
    }
    SECTION("sizes")
    {
        recording.set(at_sizes, std::uint32_t{65536});
        recording.set(at_sizes + 4, std::uint32_t{65536});
        CHECK_THAT(error_of(recording), Contains("color pictures of 65536x65536"));
        recording.set(at_sizes, std::uint32_t{0});
        CHECK_THAT(error_of(recording), Contains("color pictures of 0x65536"));
    }
    SECTION("sizes that the pictures have not")
    {
        recording.set(at_sizes, std::uint32_t{33});
        CHECK_THAT(error_of(recording), Contains("frame-000000: the color picture is 32x24, the file's head says 33x24"));
    }
    SECTION("the shift")
    {
        recording.set(at_shift, 0.0F);
        CHECK_THAT(error_of(recording), Contains("the depth shift"));
    }
    SECTION("hostile counts")
    {
        recording.set(at_count, std::numeric_limits<std::uint64_t>::max());
        CHECK_THAT(error_of(recording), Contains("18446744073709551615 frames do not fit into the"));
    }
    SECTION("hostile pictures")
    {
        recording.set(at_color_bytes, std::numeric_limits<std::uint64_t>::max() - 8);
        CHECK_THAT(error_of(recording), Contains("the color picture of frame 0 is said to have 18446744073709551607 bytes"));
    }
    SECTION("intrinsics for another size")
    {
        recording.set(at_matrices + 8, 640.0F);
        CHECK_THAT(error_of(recording), Contains("the color camera: the center (640.5, 12.5) is outside"));
    }
    SECTION("a pose that is no rotation")
    {
        recording.set(at_frames, 3.0F);
        CHECK_THAT(error_of(recording), Contains("the pose of frame 0: the upper left 3x3 part is not a rotation"));
    }
    SECTION("a color picture that is cut")
    {
        recording.set(at_color_bytes, std::uint64_t{20});
        recording.set(at_color_bytes + 8, std::uint64_t{recording.bytes().size() - at_color_bytes - 16 - 20});
        recording.set(at_count, std::uint64_t{1});
        CHECK_THAT(error_of(recording),
                   Contains("byte " + std::to_string(at_color_bytes + 16) + ", frame-000000: the color picture cannot be used"));
    }
    SECTION("a color picture that EXIF turns")
    {
        recording.images.orientation = 3;
        CHECK_THAT(error_of(recording), Contains("frame-000000: the color picture's EXIF data says"));
    }
    SECTION("a pose beyond all rooms")
    {
        recording.set(at_frames + 12, 2e7F);
        CHECK_THAT(error_of(recording), Contains("the pose of frame 0: the camera is more than 1e7 m"));
    }
    SECTION("no file")
    {
        CHECK_THROWS_AS(sens::SensFile(recording.folder.path() / "none.sens"), fresco::MissingInput);
        CHECK_THROWS_AS(sens::SensFile(recording.folder.path()), fresco::MissingInput);
    }
    SECTION("stopped")
    {
        TestRun run;
        run.cancel_after(2);
        CHECK_THROWS_AS(read(recording, run), fresco::Canceled);
    }
}

TEST_CASE("pictures may be raw", "[scan.sens]")
{
    // One frame by hand: 32x24 RGB and 16x12 of 16 bits behind the head of the sample.
    const TinyRecording recording;
    auto bytes = recording.bytes().substr(0, at_color_bytes);
    const auto color = fresco::load_color(recording.frames.frames[0], &recording.images);
    const auto depth = fresco::load_depth_steps(recording.frames.frames[0], &recording.images);
    const std::uint64_t sizes[] = {color.values.size(), depth.values.size() * 2};
    bytes.append(reinterpret_cast<const char*>(sizes), sizeof sizes);
    bytes.append(reinterpret_cast<const char*>(color.values.data()), sizes[0]);
    bytes.append(reinterpret_cast<const char*>(depth.values.data()), sizes[1]);
    fresco::write_file(recording.file(), bytes);
    recording.set(at_forms, std::uint64_t{0});
    recording.set(at_count, std::uint64_t{1});
    TestRun run;
    const auto frames = read(recording, run);
    REQUIRE(frames.frames.size() == 1);
    CHECK(fresco::load_color(frames.frames[0], &recording.images) == color);
    CHECK(fresco::load_depth_steps(frames.frames[0], &recording.images) == depth);
    recording.set(at_sizes + 4, std::uint32_t{25});
    CHECK_THAT(error_of(recording), Contains("2304 bytes where a raw picture has 2400"));
}

TEST_CASE("damage to a recording gives an error or what can be used", "[scan.sens]")
{
    const TinyRecording recording({}, 1);
    // Cut within the count of motion data, which is not read, nothing is lost.
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.sens", recording.file(), recording.images,
                                  recording.folder.path() / "out", {{recording.file(), 199, 100}});
}
