#include "catch.h"
#include "stored_png.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/reader.h>
#include <fresco/testing.h>

using namespace fresco;
using Catch::Contains;

namespace
{

/// Gives one pixel for any file and remembers which one it was asked for.
class OnePixel final : public stored_png::Codec
{
  public:
    Raster8 read_rgb(const std::filesystem::path& file) const override
    {
        asked = file;
        return {1, 1, 3, 9};
    }
    /// Transparent.
    Raster8 read_with_alpha(const std::filesystem::path& file) const override
    {
        return file.stem() == "clear" ? Raster8(1, 1, 4, 7) : read_rgb(file);
    }

    mutable std::filesystem::path asked;
};

struct Reader
{
    Reader() : made(testing::make_from_plugin(FRESCO_PLUGIN_FILE, "read.image")), reader(dynamic_cast<FileReader*>(made.get()))
    {
        factory.add("test.codec", [this] { return codec; });
        made->configure(parse_json(R"({"image_io": {"type": "test.codec"}})"), factory);
    }
    Raster8 read(const std::filesystem::path& file) const { return dynamic_cast<const Image&>(*reader->read(file)).pixels; }

    std::shared_ptr<OnePixel> codec = std::make_shared<OnePixel>();
    testing::TestFactory factory;
    std::unique_ptr<Configurable> made;
    FileReader* reader;
    testing::TemporaryFolder folder;
};

}  // namespace

TEST_CASE("read.image: all but NPY go to the codec")
{
    Reader reader;
    for (const char* name : {"a.png", "a.JPG", "b.jpeg", "c.webp", "d.heic"})
    {
        CHECK(reader.read(reader.folder.path() / name) == Raster8(1, 1, 3, 9));
        CHECK(reader.codec->asked.filename() == name);
    }
    CHECK(reader.read(reader.folder.path() / "clear.png") == Raster8(1, 1, 4, 7));
}

TEST_CASE("read.image: NPY pictures of one, three and four channels")
{
    Reader reader;
    const auto file = reader.folder.path() / "a.npy";
    const std::vector<std::uint8_t> values{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    const auto read = [&](std::vector<std::size_t> shape)
    {
        write_file(file, to_npy(NpyType::uint8, shape, std::as_bytes(std::span(values))));
        return reader.read(file);
    };
    const auto rgb = read({2, 2, 3});
    CHECK(rgb.width == 2);
    CHECK(rgb.height == 2);
    CHECK(rgb.values == values);
    CHECK(rgb.at(1, 0, 2) == 6);
    CHECK(read({1, 3, 4}).channels == 4);
    CHECK(read({3, 4, 1}).width == 4);
    CHECK(read({3, 4}).channels == 1);
    CHECK(reader.codec->asked.empty());
}

TEST_CASE("read.image: an NPY file that is not a picture is refused")
{
    const Reader reader;
    const auto file = reader.folder.path() / "a.npy";
    const auto refused = [&](const std::vector<std::size_t>& shape, const auto& values, const char* reason)
    {
        const NpyType type = sizeof values[0] == 1 ? NpyType::uint8 : NpyType::float32;
        write_file(file, to_npy(type, shape, std::as_bytes(std::span(values))));
        CHECK_THROWS_WITH(reader.read(file), Contains("a.npy") && Contains(reason));
    };
    const std::vector<std::uint8_t> bytes(12);
    refused({12}, bytes, "expected a picture");
    refused({2, 3, 2}, bytes, "expected a picture");
    refused({1, 2, 2, 3}, bytes, "expected a picture");
    refused({2, 2, 3}, std::vector<float>(12), "2 x 2 x 3 of a different type");
    refused({0, 5, 3}, std::vector<std::uint8_t>(), "0 x 5 x 3; expected 1 to 300 million pixels");
    CHECK_THROWS_AS(reader.read(reader.folder.path() / "none.npy"), MissingInput);
}
