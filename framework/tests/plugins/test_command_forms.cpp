#include "raw_images.h"
#include "plugins/command_forms.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh_io.h>
#include <fresco/npy.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <array>

#include <catch2/catch.hpp>

using namespace fresco;
using namespace fresco::host;
namespace fs = std::filesystem;

namespace
{

/// A store with one input in it, and the folders that a worker would have.
struct Place
{
    Place()
    {
        for (const auto& each : {stored(), published(), scratch()})
            fs::create_directories(each);
    }

    fs::path store() const { return folder.path(); }
    fs::path stored() const { return store() / "objects/0123/port"; }
    fs::path published() const { return store() / "tmp/work/port"; }
    fs::path scratch() const { return store() / "tmp/scratch/port"; }

    /// The program in between copies what it is given.
    template <class T>
    std::shared_ptr<T> through(const CommandPort& port, const T& value)
    {
        value.save({stored(), store()});
        const fs::path given = hand_over(port, {stored(), store()}, nullptr, scratch(), &images);
        const fs::path made = place_for(port, store() / "made", published());
        fs::create_directories(made.extension().empty() ? made : made.parent_path());
        fs::copy(given, made, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
        take_back(port, made, {published(), store()}, &images, run);
        return T::load({published(), store()});
    }

    fresco::testing::TemporaryFolder folder;
    fresco::testing::RawImages images;
    fresco::testing::TestRun run;
};

Mesh triangle()
{
    Mesh mesh;
    mesh.positions = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
    mesh.triangles = {{0, 1, 2}};
    mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}};
    return mesh;
}

constexpr std::array<std::size_t, 3> picture_shape{2, 2, 3};

Image picture()
{
    Raster8 pixels(2, 2, 3);
    for (std::size_t i = 0; i < pixels.values.size(); ++i)
        pixels.values[i] = static_cast<std::uint8_t>(20 * i);
    return Image(std::move(pixels));
}

Frame frame(const fs::path& color)
{
    Frame made;
    made.sequence = "seq-01";
    made.name = "frame-000000";
    made.color.intrinsics = {2, 2, 2, 2, 1, 1};
    made.depth = made.color;
    made.color_picture.path = color;
    return made;
}

}  // namespace

TEST_CASE("what a program hands on unchanged comes back bit by bit", "[command]")
{
    Place place;
    SECTION("a mesh, as a PLY file")
    {
        const auto mesh = place.through({"mesh", ""}, triangle());
        CHECK(to_ply(*mesh) == to_ply(triangle()));
        CHECK(fs::exists(place.scratch() / "mesh.ply"));
    }
    SECTION("a picture, in both forms")
    {
        const std::string as = GENERATE("npy", "png");
        CHECK(place.through({"image", as}, picture())->pixels.values == picture().pixels.values);
        CHECK(fs::exists(place.scratch() / ("image." + as)));
    }
    SECTION("a textured mesh, in both forms")
    {
        const std::string as = GENERATE("npy", "png");
        TexturedMesh textured;
        textured.mesh = triangle();
        textured.image = picture();
        const auto back = place.through({"textured_mesh", as}, textured);
        CHECK(to_ply(back->mesh) == to_ply(triangle()));
        CHECK(back->image.pixels.values == picture().pixels.values);
        CHECK(fs::exists(place.scratch() / ("image." + as)));
    }
    SECTION("a table")
    {
        Table table;
        table.columns = {"a"};
        table.rows = {{Value(1)}, {Value("x")}};
        CHECK(place.through({"table", ""}, table)->rows == table.rows);
    }
    SECTION("a texture")
    {
        Texture texture;
        texture.layers = {RasterF(2, 2, 3)};
        texture.layers[0].values[5] = 0.25F;
        texture.seen = Raster8(2, 2, 1);
        CHECK(place.through({"texture", ""}, texture)->layers[0].values == texture.layers[0].values);
    }
    SECTION("files")
    {
        Files files;
        fs::create_directories(place.stored() / "deep");
        write_file(place.stored() / "deep/a.txt", std::string_view("a"));
        files.names = {"deep/a.txt"};
        files.save({place.stored(), {}});
        const fs::path given = hand_over({"files", ""}, {place.stored(), place.store()}, nullptr, place.scratch(), nullptr);
        fs::create_directories(place.published() / "deep");
        fs::copy(given / "deep/a.txt", place.published() / "deep/a.txt");
        take_back({"files", ""}, place.published(), {place.published(), place.store()}, nullptr, place.run);
        CHECK(Files::load({place.published(), {}})->names == files.names);
    }
}

TEST_CASE("frames are handed over with plain paths, and taken back with pictures of any place", "[command]")
{
    Place place;
    const fs::path stored = place.store() / "objects/4567/pictures/a.npy";
    const fs::path outside = place.store().parent_path() / (place.store().filename().string() + "-own.npy");
    fs::create_directories(stored.parent_path());
    for (const auto& file : {stored, outside})
        write_npy(file, picture_shape, std::span<const std::uint8_t>(picture().pixels.values));
    Frames frames;
    frames.frames = {frame(stored), frame(outside)};
    frames.frames[1].name = "frame-000001";
    frames.save({place.stored(), place.store()});
    const CommandPort port{"frames", ""};
    const fs::path given = hand_over(port, {place.stored(), place.store()}, nullptr, place.scratch(), nullptr);
    const Value handed = parse_json(read_text_file(given / "frames.json"));
    CHECK(handed.at("frames").as_list().at(0).at("color_picture").at("ref").as_string() == "file:" + stored.string());

    // The program keeps both and adds a picture of its own.
    CHECK(place_for(port, place.scratch(), place.published()) == place.published());
    auto made = Frames::load({given, {}});
    fs::copy(stored, place.published() / "new.npy");
    made->frames.push_back(frame(place.published() / "new.npy"));
    made->save({place.published(), {}});
    take_back(port, place.published(), {place.published(), place.store()}, nullptr, place.run);
    const auto kept = parse_json(read_text_file(place.published() / "frames.json")).at("frames").as_list();
    CHECK(kept.at(0).at("color_picture").at("ref").as_string() == "store:objects/4567/pictures/a.npy");
    CHECK(kept.at(1).at("color_picture").at("ref").as_string() == "file:" + outside.string());
    CHECK(kept.at(1).at("color_picture").at("hash").as_string().size() == 32);
    CHECK(kept.at(2).at("color_picture").at("ref").as_string() == "own:new.npy");
    CHECK(place.run.files_read == std::vector<fs::path>{outside});
    fs::remove(outside);
    CHECK_THROWS_WITH(take_back(port, place.published(), {place.published(), place.store()}, nullptr, place.run),
                      Catch::Contains("seq-01/frame-000001: no such picture: " + outside.string()));
}

TEST_CASE("a picture is found by each of its paths, and refused where it will not stay", "[command]")
{
    Place place;
    const fs::path link = place.store() / "link";
    fs::create_directory_symlink(place.store(), link);
    const ArtifactFolder published{link / "tmp/work/port", link};
    const fs::path stored = place.store() / "objects/4567/a.npy";
    const fs::path passing = place.scratch() / "b.npy";
    fs::create_directories(stored.parent_path());
    for (const auto& file : {stored, passing, place.published() / "c.npy"})
        write_npy(file, picture_shape, std::span<const std::uint8_t>(picture().pixels.values));
    Frames frames;
    frames.frames = {frame(stored), frame(place.published() / "c.npy")};
    frames.save({place.published(), {}});
    take_back({"frames", ""}, published.path, published, nullptr, place.run);
    const auto kept = parse_json(read_text_file(place.published() / "frames.json")).at("frames").as_list();
    CHECK(kept.at(0).at("color_picture").at("ref").as_string() == "store:objects/4567/a.npy");
    CHECK(kept.at(1).at("color_picture").at("ref").as_string() == "own:c.npy");
    CHECK(place.run.files_read.empty());

    frames.frames = {frame(passing)};
    frames.save({place.published(), {}});
    CHECK_THROWS_WITH(take_back({"frames", ""}, published.path, published, nullptr, place.run),
                      Catch::Contains("seq-01/frame-000000: the picture " + passing.string() +
                                      " will be gone when the program has ended: write it into the folder of this output"));
}

TEST_CASE("uv maps are read to the last when they are taken back", "[command]")
{
    Place place;
    UvMap map{RasterF(4, 3, 2), RasterF(4, 3), RasterF(4, 3), Raster8(4, 3)};
    UvMaps maps;
    maps.heights_px = {3};
    maps.views = {{"seq-01", "frame-000000", frame("").color, {0}}};
    maps.views[0].camera.intrinsics = {4, 3, 2, 2, 2, 1.5};
    const ArtifactFolder published{place.published(), place.store()};
    UvMaps::write_map(published, 0, 3, map);
    maps.save(published);
    CHECK_NOTHROW(take_back({"uv_maps", ""}, place.published(), published, nullptr, place.run));
    for (const auto& entry : fs::directory_iterator(place.published()))
        if (entry.path().extension() == ".uvmap")
            fs::resize_file(entry.path(), 60);
    CHECK_THROWS_WITH(take_back({"uv_maps", ""}, place.published(), published, nullptr, place.run), Catch::Contains(".uvmap"));
}

TEST_CASE("what a program did not write, or wrote wrong, is named", "[command]")
{
    Place place;
    const ArtifactFolder published{place.published(), place.store()};
    const auto taken = [&](const CommandPort& port)
    {
        const fs::path path = place_for(port, place.scratch(), place.published());
        take_back(port, path, published, &place.images, place.run);
    };
    for (const ExchangeForm& form : exchange_forms())
    {
        INFO(form.artifact);
        CHECK_THROWS_WITH(taken({std::string(form.artifact), ""}),
                          Catch::Contains("was not written") || Catch::Contains("no file was written into it"));
    }
    write_file(place.scratch() / "mesh.ply", std::string_view("ply\nformat ascii 1.0\n"));
    CHECK_THROWS_WITH(taken({"mesh", ""}), Catch::Contains("mesh.ply"));
    Mesh bare = triangle();
    bare.texcoords.clear();
    write_file(place.scratch() / "mesh.ply", to_ply(bare));
    write_npy(place.scratch() / "image.npy", picture_shape, std::span<const std::uint8_t>(picture().pixels.values));
    CHECK_THROWS_WITH(taken({"textured_mesh", "npy"}), Catch::Contains("a textured mesh needs texcoords"));
    const std::vector<float> floats(12);
    write_npy(place.scratch() / "image.npy", picture_shape, std::span<const float>(floats));
    CHECK_THROWS_WITH(taken({"image", "npy"}), Catch::Contains("image.npy"));
    write_file(place.scratch() / "table.json", std::string_view("{\"columns\": [\"a\"], \"rows\": [[1, 2]]}"));
    CHECK_THROWS_WITH(taken({"table", ""}), Catch::Contains("row 1 does not have one cell per column"));
    write_file(place.published() / "files.json", std::string_view("{}"));
    CHECK_THROWS_WITH(taken({"files", ""}), Catch::Contains("this name is taken"));
    CHECK_THROWS_WITH(hand_over({"image", "png"}, {}, std::make_unique<Image>(picture()).get(), place.scratch(), nullptr),
                      Catch::Contains("no picture codec"));
}
