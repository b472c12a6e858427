#include "catch.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/testing.h>

namespace
{

/// "Encodes" a picture as its width and height, so that the test needs no other plugin.
struct SizeCodec final : fresco::ImageIo
{
    fresco::ImageHeader header(const std::filesystem::path& file) const override
    {
        const auto bytes = fresco::read_file(file);
        return {std::to_integer<int>(bytes.at(0)), std::to_integer<int>(bytes.at(1))};
    }
    std::vector<std::byte> encode_png(const fresco::Raster8& image) const override
    {
        return {static_cast<std::byte>(image.width), static_cast<std::byte>(image.height)};
    }
    std::vector<std::byte> encode_png(const fresco::Raster16&) const override { throw fresco::Error("not used"); }
    std::vector<std::byte> encode_jpeg(const fresco::Raster8&, int) const override { throw fresco::Error("not used"); }
    fresco::Raster8 read_rgb(const std::filesystem::path&) const override { throw fresco::Error("not used"); }
    fresco::Raster16 read_depth(const std::filesystem::path&) const override { throw fresco::Error("not used"); }
};

}  // namespace

TEST_CASE("the picture lies at the path that was asked for")
{
    const auto codec = std::make_shared<SizeCodec>();
    const fresco::testing::TemporaryFolder folder;
    fresco::testing::TestRun run;
    fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "example.save_picture", fresco::Value::Map{{"path", "views/a.png"}},
                               {{"image", std::make_shared<fresco::Image>(fresco::Raster8(5, 3, 3))}}, folder.path(), run,
                               {{"image_io", codec}});
    const auto written = fresco::Files::load({folder.path() / "files", folder.path()});
    REQUIRE(written->names == std::vector<std::string>{"views/a.png"});
    const auto header = codec->header(written->loaded_from / "views/a.png");
    CHECK(header.width == 5);
    CHECK(header.height == 3);
    CHECK(run.reported.at("bytes").as_int() == 2);
}
