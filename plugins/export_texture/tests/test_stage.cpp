#include "catch.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

using namespace fresco;
using Catch::Contains;

namespace
{

TexturedMesh square()
{
    TexturedMesh textured;
    textured.mesh = testing::wall(0.5F);
    textured.image = Image(Raster8(8, 8, 3, 77));
    textured.image.pixels.at(2, 1, 0) = 200;
    return textured;
}

/// Writes no real JPEG: its own header, the size and nothing else.
struct SizeCodec final : stored_png::Codec
{
    int cut = 0;  ///< Added to the width that check() finds.

    ImageHeader header(const std::filesystem::path& file) const override
    {
        const auto bytes = read_file(file);
        return {std::to_integer<int>(bytes.at(0)) + cut, std::to_integer<int>(bytes.at(1)), 8, false};
    }
    std::vector<std::byte> encode_jpeg(const Raster8& image, int quality) const override
    {
        return {static_cast<std::byte>(image.width), static_cast<std::byte>(image.height), static_cast<std::byte>(quality)};
    }
};

std::filesystem::path export_to(const std::filesystem::path& folder, const Value& options, std::shared_ptr<ImageIo> codec,
                                testing::TestRun& run)
{
    testing::run_stage(FRESCO_PLUGIN_FILE, "export.texture", options, {{"mesh", std::make_shared<TexturedMesh>(square())}},
                       folder, run, {{"image_io", codec}});
    return folder / "files" / Files::load({folder / "files", folder})->names.at(0);
}

}  // namespace

TEST_CASE("the ending decides: PNG and NPY hold every texel, JPEG has the quality asked for")
{
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    const auto png = export_to(folder.path(), Value::Map{}, std::make_shared<stored_png::Codec>(), run);
    CHECK(png.filename() == "room.png");
    CHECK(stored_png::Codec().read_rgb(png) == square().image.pixels);
    CHECK_THAT(run.messages.at(0), Catch::StartsWith("room.png: ") && Catch::EndsWith("8 x 8 texels, valid"));

    const auto npy = export_to(folder.path(), Value::Map{{"path", "a/b.npy"}}, std::make_shared<stored_png::Codec>(), run);
    const NpyArray array = read_npy(npy);
    CHECK(array.shape == std::vector<std::size_t>{8, 8, 3});
    CHECK(array.as<std::uint8_t>()[(8 + 2) * 3] == 200);

    const Value jpeg = Value::Map{{"path", "c.jpg"}, {"jpeg_quality", 40}, {"max_texture_px", 4}};
    const auto jpg = export_to(folder.path(), jpeg, std::make_shared<SizeCodec>(), run);
    CHECK(read_file(jpg) == std::vector<std::byte>{std::byte{4}, std::byte{4}, std::byte{40}});
    CHECK(run.reported.at("texture_px").as_int() == 4);
}

TEST_CASE("other endings are refused, and so is a file that the written picture differs")
{
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    const auto codec = std::make_shared<SizeCodec>();
    codec->cut = 1;
    CHECK_THROWS_WITH(export_to(folder.path(), Value::Map{{"path", "c.tiff"}}, codec, run), Contains("ending in .png, .jpg"));
    CHECK_THROWS_WITH(export_to(folder.path(), Value::Map{{"path", "c.jpg"}}, codec, run),
                      Contains("the written picture differs"));
}
