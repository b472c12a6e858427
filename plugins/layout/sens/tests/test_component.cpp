#include "layout_test.h"
#include "sens_file.h"

#include <limits>
#include <zlib.h>

namespace
{

// Offsets in the sample, whose sensor's name has 8 letters.
constexpr std::size_t at_matrices = 4 + 8 + 8;
constexpr std::size_t at_forms = at_matrices + 4 * 64;
constexpr std::size_t at_sizes = at_forms + 8;
constexpr std::size_t at_shift = at_sizes + 16;
constexpr std::size_t at_count = at_shift + 4;
constexpr std::size_t at_frames = at_count + 8;
constexpr std::size_t at_color_bytes = at_frames + 64 + 16;

const LayoutUnderTest layout{.type = "layout.sens",
                             .write = write_sens,
                             .pose_source = "frame-000001",
                             // Cut within the count of motion data, which is not read, nothing is lost.
                             .damaged = {""},
                             .has_depth_camera = true,
                             .third = "scene frame-000002 2"};

template <class T>
void set(const WrittenRecording& recording, std::size_t offset, T value)
{
    const std::string_view bytes(reinterpret_cast<const char*>(&value), sizeof value);
    recording.write("", recording.text("").replace(offset, sizeof value, bytes));
}

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("the unit of depth is that of the file's head", "[layout.sens]")
{
    const WrittenRecording recording(layout);
    set(recording, at_shift, 5000.0F);
    const auto frames = recording.read().frames->frames;
    CHECK(frames[0].depth_unit_m == Approx(0.0002));
    CHECK(read_file(frames[1].color_picture.path) == read_file(recording.frames.frames[1].color_picture.path));
}

TEST_CASE("frames that the recorder had lost are left out", "[layout.sens]")
{
    constexpr double lost = -std::numeric_limits<double>::infinity();
    const WrittenRecording recording(layout,
                                     [](Frames& frames) { frames.frames[1].depth.world_from_camera.translation.x = lost; });
    TestRun run(1);
    const auto frames = recording.read(run).frames->frames;
    REQUIRE(frames.size() == 2);
    CHECK(frames[1].number == 2);
    CHECK(run.reported.at("poses_not_tracked").as_int() == 1);
    CHECK(run.reported.at("recorded").as_int() == 3);
    set(recording, at_count, std::uint64_t{1});
    set(recording, at_frames, static_cast<float>(lost));
    CHECK_THAT(recording.error(), Contains("none of the 1 poses is finite"));
}

TEST_CASE("depth that zlib compressed is unpacked, and nothing beyond the picture", "[layout.sens]")
{
    Raster16 depth(40, 30);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        depth.values[i] = static_cast<std::uint16_t>(i * i % 5000);
    const auto pack = [](const Raster16& picture)
    {
        uLongf size = compressBound(picture.values.size() * 2);
        std::vector<std::byte> packed(size);
        compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(picture.values.data()),
                 picture.values.size() * 2);
        packed.resize(size);
        return packed;
    };
    const auto packed = pack(depth);
    CHECK(sens::unpack_depth(packed, 40, 30, "x") == depth);
    CHECK_THROWS_WITH(sens::unpack_depth(packed, 40, 29, "f: byte 3"),
                      Contains("f: byte 3: more; expected a zlib-compressed depth picture of 2320"));
    CHECK_THROWS_WITH(sens::unpack_depth(packed, 40, 31, "x"), Contains("x: 2400 bytes; expected"));
    CHECK_THROWS_WITH(sens::unpack_depth(std::span(packed).first(packed.size() - 5), 40, 30, "x"), Contains("x: "));
    CHECK_THROWS_AS(sens::unpack_depth({}, 40, 30, "x"), Error);
    // A thousand times its size if it were let.
    CHECK_THROWS_WITH(sens::unpack_depth(pack(Raster16(2000, 2000)), 2, 2, "x"), Contains("x: more; expected"));
}

TEST_CASE("a file that cannot be used is refused by byte", "[layout.sens]")
{
    using Recording = const WrittenRecording&;
    constexpr auto most = std::numeric_limits<std::uint64_t>::max();
    const auto with = [](std::size_t offset, auto value) { return [=](Recording it) { set(it, offset, value); }; };
    check_flaws(layout, {{with(0, std::uint32_t{5}), {"scene0000_00.sens: byte 0: version 5"}},
                         {with(4, std::uint64_t{1} << 60U), {"byte 4: the sensor's name has 1152921504606846976 bytes"}},
                         {with(at_forms, std::int32_t{-1}), {"compression -1 of the color pictures; expected 0 (raw), 1 (PNG)"}},
                         {with(at_forms + 4, std::int32_t{2}), {"compression 2 of the depth pictures", "not occi"}},
                         {with(at_sizes, std::uint64_t{65536} << 32U | 65536U), {"color pictures of 65536x65536"}},
                         {with(at_sizes, std::uint32_t{33}), {"frame-000000: a picture in it", "is 32x24", "pictures of 33x24"}},
                         {with(at_shift, 0.0F), {"the depth shift"}},
                         {with(at_count, most), {"18446744073709551615 frames do not fit into the"}},
                         {with(at_color_bytes, most - 8),
                          {"the color picture of frame 0 has a declared length of 18446744073709551607 bytes"}},
                         {with(at_matrices + 8, 640.0F), {"the color camera: the principal point (640.5, 12.5) is outside"}},
                         {with(at_color_bytes + 16, 0.0F),
                          {"byte " + std::to_string(at_color_bytes + 16) + ", frame-000000: a picture in it cannot be used"}}});
    CHECK_THROWS_AS(sens::SensFile("/none.sens"), MissingInput);
    CHECK_THROWS_AS(sens::SensFile("/"), MissingInput);
}

TEST_CASE("pictures may be raw", "[layout.sens]")
{
    // One frame by hand: 32x24 RGB and 16x12 of 16 bits behind the head of the sample.
    const WrittenRecording recording(layout);
    auto bytes = recording.text("").substr(0, at_color_bytes);
    const auto color = load_color(recording.frames.frames[0], &recording.images);
    const auto depth = load_depth_steps(recording.frames.frames[0], &recording.images);
    const std::uint64_t sizes[] = {color.values.size(), depth.values.size() * 2};
    bytes.append(reinterpret_cast<const char*>(sizes), sizeof sizes);
    bytes.append(reinterpret_cast<const char*>(color.values.data()), sizes[0]);
    bytes.append(reinterpret_cast<const char*>(depth.values.data()), sizes[1]);
    recording.write("", bytes);
    set(recording, at_forms, std::uint64_t{0});
    set(recording, at_count, std::uint64_t{1});
    const auto result = recording.read();
    const auto& frames = *result.frames;
    REQUIRE(frames.frames.size() == 1);
    CHECK(load_color(frames.frames[0], &recording.images) == color);
    CHECK(load_depth_steps(frames.frames[0], &recording.images) == depth);
    set(recording, at_sizes + 4, std::uint32_t{25});
    CHECK_THAT(recording.error(), Contains("2304 bytes; expected a raw picture of 2400"));
}
