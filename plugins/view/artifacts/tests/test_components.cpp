#include "catch.h"
#include "plugin_under_test.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/viewer.h>

using namespace fresco;

namespace
{

/// Encodes JPEG as PNG; a test looks at sizes and colors.
class Codec final : public stored_png::Codec
{
  public:
    std::vector<std::byte> encode_jpeg(const Raster8& image, int) const override { return encode_png(image); }
};

/// Adds what the artifact's viewer shows.
template <class T>
void show(const T& artifact, PageEntry& entry)
{
    const auto viewer = testing::make_from_plugin<Viewer>(FRESCO_PLUGIN_FILE, "view." + std::string(T::artifact_name));
    testing::TestFactory factory;
    factory.add("codec", [] { return std::make_shared<Codec>(); });
    viewer->configure(Value::Map{{"image_io", Value::Map{{"type", "codec"}}}}, factory);
    CHECK(viewer->type().name == T::artifact_name);
    viewer->show(artifact, entry);
}

template <class T>
PageEntry shown(const T& artifact, PageEntry entry = {})
{
    show(artifact, entry);
    return entry;
}

std::vector<std::string> names_of(const PageEntry& entry)
{
    std::vector<std::string> names;
    if (const Value* pictures = entry.value.find("pictures"))
        for (const Value& picture : pictures->as_list())
            names.push_back(picture.at("name").as_string());
    return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "frames show what the cameras saw where others made pictures, files the pictures asked for")
{
    const auto write = [&](const std::string& name) { write_file(folder.path() / name, Codec().encode_png(Raster8(4, 2, 3))); };
    Frames frames;
    for (const char* name : {"a", "b", "c"})
    {
        write(std::string(name) + ".png");
        frames.frames.emplace_back().sequence = "s";
        frames.frames.back().name = name;
        frames.frames.back().color.intrinsics = {4, 2, 1, 1, 0, 0};
        frames.frames.back().color_picture.path = folder.path() / (std::string(name) + ".png");
    }
    const PageEntry seen = shown(frames, {.names = {"views/s_b.png", "other/s_b.jpg", "views/x.png"}, .last = false});
    CHECK(names_of(seen) == Names{"s_b"});
    CHECK(seen.value.at("pictures").as_list()[0].at("pose").at("forward") == parse_json("[0.0, 0.0, 1.0]"));
    CHECK(seen.value.find("cameras") != nullptr);
    // Earlier frames that nobody made pictures of show nothing.
    CHECK(shown(frames, {.last = false}).value == Value(Value::Map{}));

    Files files;
    files.loaded_from = folder.path();
    files.names = {"a.png", "b.png", "c.png", "note.txt"};
    CHECK(names_of(shown(files)) == Names{"a.png", "b.png", "c.png"});
    CHECK(names_of(shown(files, {.most_pictures = 1})) == Names{"b.png"});
    CHECK(names_of(shown(files, {.names = {"c.png"}})) == Names{"c.png"});
    auto compressed = Codec().encode_png(Raster8(4, 2, 3));
    compressed.at(43) = std::byte{2};
    write_file(folder.path() / "b.png", compressed);
    const PageEntry broken = shown(files);
    CHECK(names_of(broken) == Names{"a.png", "c.png"});
    CHECK(broken.value.at("notes").as_list().size() == 1);
}

TEST_CASE_METHOD(testing::StageTest, "a page holds videos up to a limit, and says which others there are")
{
    Files files;
    files.loaded_from = folder.path();
    files.names = {"a.mp4", "b.webm", "c.mp4", "d.mp4", "e.mp4"};
    for (const std::string& name : files.names)
        write_file(folder.path() / name, std::vector<std::byte>(name == "e.mp4" ? 9'000'000 : 7'000'000));
    const PageEntry page = shown(files);
    CHECK(names_of(page) == Names{"a.mp4", "b.webm", "c.mp4"});
    CHECK(page.value.at("pictures").as_list()[1].at("uri").as_string().starts_with("data:video/webm;base64,"));
    CHECK(page.value.at("notes") ==
          Value(Value::List{"d.mp4: a video of 7.0 MB is not put into the page, which takes 3.0 MB more; open the file",
                            "e.mp4: a video of 9.0 MB is not put into the page, which takes 8.0 MB at most; open the file"}));
}

TEST_CASE("the last textured mesh shows its atlas and its room, one without texcoords only the atlas")
{
    TexturedMesh room;
    room.image.pixels = Raster8(8, 8, 3);
    room.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    room.mesh.triangles = {{0, 1, 2}};
    PageEntry without;
    CHECK_THROWS_WITH(show(room, without), Catch::Contains("no texcoords"));
    CHECK(names_of(without) == Names{"8 × 8 texels"});
    room.mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}};
    const PageEntry page = shown(room);
    CHECK(page.scripts != nullptr);
    CHECK(page.value.at("room").at("triangles") == Value(1));
    CHECK(page.value.at("room").at("geometry").as_string().size() % 4 == 0);
    CHECK(page.value.at("room").at("texture").as_string().starts_with("data:image/jpeg;base64,"));
    CHECK(shown(room, {.last = false}).value == Value(Value::Map{}));
}
