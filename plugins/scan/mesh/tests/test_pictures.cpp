#include "catch.h"
#include "file_model.h"

#include "model_samples.h"

#include <fresco/stage.h>
#include <fresco/testing.h>

using namespace fresco;
using Catch::Contains;
using scan_mesh::without_profile;

namespace
{

using Bytes = std::vector<std::byte>;

Bytes bytes_of(const std::string& text)
{
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

}  // namespace

TEST_CASE("glTF pictures lose their color profiles, and nothing else", "[scan.mesh]")
{
    const auto numbers = stored_png::encode(Raster8(2, 2, 3, 5));
    std::vector<std::uint8_t> profile;
    stored_png::put_chunk(profile, "iCCP", std::vector<std::uint8_t>(70'000, 7));
    auto with = numbers;
    with.insert(with.begin() + 33, profile.begin(), profile.end());
    const auto bytes = [](const auto& values)
    {
        const auto all = std::as_bytes(std::span(values));
        return Bytes(all.begin(), all.end());
    };
    CHECK(without_profile(bytes(with)) == bytes(numbers));
    CHECK(without_profile(bytes(numbers)) == bytes(numbers));
    using namespace std::string_literals;
    const std::string icc = "\xFF\xE2\0\x12ICC_PROFILE\0\1\1xx"s;
    const std::string begin = "\xFF\xD8\xFF\xE0\0\4ab"s;
    const std::string end = "\xFF\xE2\0\6MPF\0\xFF\xDA\0\2ICC_PROFILE\0\xFF\xD9"s;
    std::string other = icc;
    other[1] = '\xEF';
    CHECK(without_profile(bytes_of(begin + icc + icc + end)) == bytes_of(begin + other + other + end));
    const auto webp = [](const char* name)
    { return "RIFF\x24\0\0\0WEBPVP8X\x0A\0\0\0\x20\0\0\0\1\0\0\1\0\0"s + name + "\2\0\0\0iiVP8L"s; };
    CHECK(without_profile(bytes_of(webp("ICCP"))) == bytes_of(webp("iCCP")));
    for (const Bytes& whole : {bytes(with), bytes_of(begin + icc + end), bytes_of(webp("ICCP"))})
        for (std::size_t size = 0; size < std::min<std::size_t>(whole.size(), 200); ++size)
            CHECK(without_profile(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))).size() <= size);
}

TEST_CASE("pictures that EXIF turns are taken in glTF, and refused elsewhere", "[scan.mesh]")
{
    struct Turned final : stored_png::Codec
    {
        ImageHeader check(const std::filesystem::path& file) const override
        {
            ImageHeader header = stored_png::Codec::check(file);
            header.orientation = 6;
            return header;
        }
    };
    const testing::TemporaryFolder folder;
    const auto run_on = [&](const std::filesystem::path& file)
    {
        testing::TestRun run;
        std::filesystem::remove_all(folder.path() / "out");
        testing::run_stage(FRESCO_PLUGIN_FILE, "scan.mesh", Value::Map{{"path", file.string()}}, {}, folder.path() / "out", run,
                           {{"image_io", std::make_shared<Turned>()}});
        return Model::load({folder.path() / "out/model", folder.path()});
    };
    CHECK(run_on(model_samples::write_glb_box(folder.path()))->pictures.size() == 6);
    const auto obj = model_samples::write_obj_box(folder.path());
    CHECK_THROWS_WITH(run_on(obj), Contains("side 0.png: its EXIF data rotates it"));
}
