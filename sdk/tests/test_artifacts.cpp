#include "catch.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/npy.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cstring>
#include <span>

using namespace fresco;
using Catch::Contains;

TEST_CASE("Frames keep their references when the store moves")
{
    const testing::TemporaryFolder place;
    const auto store = place.path() / "store";
    const ArtifactFolder own{store / "objects" / "b" / "frames", store};
    std::filesystem::create_directories(own.path);
    Frames frames;
    Frame frame;
    frame.sequence = "seq-01";
    frame.name = "frame-000008";
    frame.number = 8;
    frame.color = {{2, 2, 2, 2, 1, 1}, {}};
    frame.depth = {{3, 3, 2, 2, 1, 1}, {}};
    frame.color_picture = {own.path / "c.npy", ""};
    frame.depth_picture = {store / "objects" / "a" / "d.png", ""};
    frame.mask = {own.path / "m.npy", ""};
    frames.frames.push_back(frame);
    frame.color_picture = {place.path() / "user.npy", "abc"};
    frame.name = "frame-000009";
    frame.mask = {};
    frames.frames.push_back(frame);
    std::set<std::string> references;
    frames.save({own.path, store, &references});
    CHECK(references == std::set<std::string>{"a"});
    frames.frames[0].depth_picture.path = store / "tmp" / "run.abc" / "d.png";
    CHECK_THROWS_WITH(frames.save(own), Contains("tmp/run.abc/d.png: will be gone when the stage is done"));

    const auto moved = place.path() / "moved";
    std::filesystem::rename(store, moved);
    const auto loaded = Frames::load({moved / "objects" / "b" / "frames", moved});
    REQUIRE(loaded->frames.size() == 2);
    CHECK(loaded->frames[0].color_picture.path == moved / "objects" / "b" / "frames" / "c.npy");
    CHECK(loaded->frames[0].depth_picture.path == moved / "objects" / "a" / "d.png");
    CHECK(loaded->frames[1].color_picture.path == place.path() / "user.npy");
    CHECK(loaded->frames[0].mask.path == moved / "objects" / "b" / "frames" / "m.npy");
    CHECK(loaded->frames[1].mask.empty());
    CHECK(loaded->frames[0].color == frame.color);
    CHECK(loaded->frames[0].depth == frame.depth);
    CHECK(loaded->frames[0].number == 8);
}

TEST_CASE("A mask at another size ignores what it covers in part")
{
    Raster8 mask(6, 4, 1, 1);
    mask.at(2, 1) = 0;
    const auto half = mask_at(mask, 3, 2);
    CHECK(half.values == std::vector<std::uint8_t>{255, 0, 255, 255, 255, 255});
    // Columns of 1.5 pixels: the second covers half of pixel 1, and pixel 2.
    const auto narrow = mask_at(mask, 4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            CHECK(narrow.at(x, y) == (y == 1 && x == 1 ? 0 : 255));
    const auto large = mask_at(mask, 12, 8);
    CHECK(std::ranges::count(large.values, 0) == 4);
    CHECK(large.at(5, 3) == 0);
    CHECK(mask_at({}, 3, 2).empty());
}

TEST_CASE("A frame's picture must be the one that was listed, of its camera's size")
{
    const testing::TemporaryFolder folder;
    write_npy(folder.path() / "image.npy", Raster8(4, 3, 3, 77));
    Frame frame;
    frame.color = {{4, 3, 2, 2, 1, 1}, {}};
    frame.color_picture = {folder.path() / "image.npy", file_hash(folder.path() / "image.npy")};
    CHECK(load_color(frame, nullptr).at(3, 2, 2) == 77);
    CHECK_THROWS_WITH(load_depth(frame, nullptr), Contains("no depth"));
    frame.color.intrinsics.width = 5;
    CHECK_THROWS_WITH(load_color(frame, nullptr), Contains("image.npy") && Contains("5x3"));
    frame.color.intrinsics.width = 4;
    write_npy(folder.path() / "image.npy", Raster8(4, 3, 3, 78));
    CHECK_THROWS_WITH(load_color(frame, nullptr), Contains("changed"));
    frame.color_picture.path = folder.path() / "image.png";
    write_file(frame.color_picture.path, "x");
    frame.color_picture.hash.clear();
    CHECK_THROWS_WITH(load_color(frame, nullptr), Contains("codec"));
}

TEST_CASE("A depth picture may be NPY, and needs no codec then")
{
    const testing::TemporaryFolder folder;
    Frame frame;
    frame.sequence = "seq";
    frame.name = "f";
    CHECK_THROWS_WITH(load_color(frame, nullptr), Contains("seq/f: has no color picture"));
    frame.depth.intrinsics = {3, 2, 1, 1, 1, 1};
    frame.depth_unit_m = 0.5;
    frame.depth_picture.path = folder.path() / "depth.npy";
    Raster16 steps(3, 2);
    steps.values = {0, 1, 2, 3, 65534, 65535};
    write_npy(frame.depth_picture.path, steps);
    CHECK(load_depth_steps(frame, nullptr) == steps);
    CHECK(load_depth(frame, nullptr).values == std::vector<float>{0, 0.5F, 1, 1.5F, 32767, 0});
    std::swap(steps.width, steps.height);
    write_npy(frame.depth_picture.path, steps);
    CHECK_THROWS_WITH(load_depth(frame, nullptr), Contains("depth.npy") && Contains("2x3"));
    frame.depth_picture.path = folder.path() / "depth.png";
    CHECK_THROWS_WITH(load_depth(frame, nullptr), Contains("codec"));
}

TEST_CASE("uv maps stream to disk and back")
{
    const testing::TemporaryFolder folder;
    const ArtifactFolder own{folder.path(), {}};
    UvMaps maps;
    maps.heights_px = {16, 32};
    maps.texture_px = 8192;
    maps.uv_bits = 18;
    maps.views.push_back({"s", "f", {{64, 48, 50, 50, 32, 24}, {}}, {5, 6}});
    UvMap map{{21, 16, 2, 0.2F}, {21, 16, 1, 1.5F}, {21, 16, 1, 0.6F}, {21, 16, 1, 1}};
    UvMaps::write_map(own, 0, 16, map);
    maps.save(own);
    const auto loaded = UvMaps::load(own);
    CHECK(loaded->views[0].valid_pixels == std::vector<std::int64_t>{5, 6});
    CHECK(loaded->texture_px == 8192);
    CHECK(loaded->uv_bits == 18);
    CHECK_NOTHROW(check_uv_bits(*loaded, 16384, "the maps"));
    CHECK_THROWS_WITH(check_uv_bits(*loaded, 16385, "the maps"),
                      Contains("the maps hold texcoords of 18 bits, for textures up to 16384 texels a side, not 16385"));
    // A fifth is a whole number of steps of 1/65535 and of 1/255.
    const UvMap back = loaded->load_map(0, 0);
    CHECK((back.uv == map.uv && back.depth == map.depth && back.cosine == map.cosine && back.valid == map.valid));
    CHECK_THROWS_AS(loaded->load_map(0, 1), MissingInput);
    map.uv.at(3, 2, 1) = 1.0F / 262143;
    UvMaps::write_map(own, 0, 16, map, 18);
    CHECK(loaded->load_map(0, 0).uv.at(3, 2, 1) == 1.0F / 262143);
    UvMaps::write_map(own, 0, 16, {{20, 16, 2}, {20, 16}, {20, 16}, {20, 16}});
    CHECK_THROWS_WITH(loaded->load_map(0, 0), Contains("000000_16.uvmap") && Contains("is 20x16; the index says 21x16"));
}

TEST_CASE("Sizes in an index of uv maps that no picture has are refused")
{
    const testing::TemporaryFolder folder;
    const ArtifactFolder own{folder.path(), {}};
    UvMaps maps;
    maps.heights_px = {16};
    maps.views.push_back({"s", "f", {{64, 48, 50, 50, 32, 24}, {}}, {5}});
    maps.save(own);
    const auto file = folder.path() / "uvmaps.json";
    const std::string text = read_text_file(file);
    const auto with = [&](const std::string& old, const std::string& other)
    {
        std::string changed = text;
        write_file(file, changed.replace(changed.find(old), old.size(), other));
        UvMaps::load(own);
    };
    // 2^32 more is the same number in 32 bits.
    CHECK_THROWS_WITH(with("  16", "  4294967312"),
                      Contains("heights_px[0]: expected an integer from 1 to 65536, got 4294967312"));
    CHECK_THROWS_WITH(with("  16", "  -16"), Contains("heights_px[0]: "));
    CHECK_THROWS_WITH(with("\"width\": 64", "\"width\": 4294967360"), Contains("uvmaps.json: views[0].camera.width: expected"));
    CHECK_NOTHROW(with("  16", "  16"));
}

TEST_CASE("The size to paint at is the atlas's, or the one asked for, with a warning")
{
    testing::TestRun run;
    CHECK(painted_size_px(0, 2048, "the mesh", run) == 2048);
    CHECK(painted_size_px(2048, 2048, "the mesh", run) == 2048);
    CHECK(painted_size_px(512, 0, "the mesh", run) == 512);
    CHECK(run.messages.empty());
    CHECK(painted_size_px(4096, 2048, "the mesh", run) == 4096);
    REQUIRE(run.messages.size() == 1);
    CHECK_THAT(run.messages[0],
               Contains("size_px is 4096, but the mesh came from an atlas for 2048") && Contains("2 times as wide"));
    CHECK_THROWS_WITH(painted_size_px(0, 0, "the mesh", run), Contains("the texture size is unknown: the mesh came without"));
    CHECK_THROWS_WITH(painted_size_px(4, 0, "the mesh", run), Contains("expected 16 to 16384: set size_px"));
    CHECK_THROWS_WITH(painted_size_px(0, 20000, "the mesh", run), Contains("set size_px of the atlas.* stage"));
}

TEST_CASE("A mesh that is in the store already is linked, not written again")
{
    const testing::TemporaryFolder place;
    const auto atlas = place.path() / "atlas";
    const auto textured_folder = place.path() / "textured";
    for (const auto& folder : {atlas, textured_folder})
        std::filesystem::create_directories(folder);
    TexturedMesh textured;
    textured.mesh = testing::wall();
    textured.image = Image(Raster8(4, 4, 3, 77));
    textured.mesh.save({atlas, place.path()});
    textured.mesh.saved_in = atlas;
    textured.save({textured_folder, place.path()});
    CHECK(std::filesystem::equivalent(atlas / "mesh.ply", textured_folder / "mesh.ply"));
    std::filesystem::remove_all(atlas);
    const auto loaded = TexturedMesh::load({textured_folder, place.path()});
    CHECK(loaded->mesh.positions == textured.mesh.positions);
    CHECK(loaded->mesh.saved_in.empty());

    // Without a file to link, the mesh is written.
    std::filesystem::remove(textured_folder / "mesh.ply");
    textured.save({textured_folder, place.path()});
    CHECK(TexturedMesh::load({textured_folder, place.path()})->mesh.texcoords == textured.mesh.texcoords);
}

TEST_CASE("Packed rasters come back bit by bit, and are refused where they are damaged or of another type")
{
    const testing::TemporaryFolder folder;
    const ArtifactFolder own{folder.path(), {}};
    SourceMap map;
    map.picture_width = map.picture_height = 100;
    map.clear(37);
    Texture texture;
    Random random(7);
    for (std::uint16_t& value : map.places.values)
        value = static_cast<std::uint16_t>(random.below(65536));
    for (std::uint8_t& value : map.shifts.values)
        value = static_cast<std::uint8_t>(random.below(256));
    texture.layers = {RasterF(37, 37, 3)};
    texture.seen = Raster8(37, 37, 1, 1);
    for (float& value : texture.layers[0].values)
        value = static_cast<float>(2000 * random.uniform() - 1000);
    texture.layers[0].at(3, 4) = -0.0F;
    map.save(own);
    texture.save(own);
    CHECK(SourceMap::load(own)->places == map.places);
    CHECK(SourceMap::load(own)->shifts == map.shifts);
    const auto bits = [](const RasterF& raster) { return std::as_bytes(std::span(raster.values)); };
    CHECK(std::ranges::equal(bits(Texture::load(own)->layers[0]), bits(texture.layers[0])));

    const auto file = folder.path() / "layer_0.packed";
    const auto bytes_of_floats = std::filesystem::file_size(file);
    for (std::size_t i = 0; i < texture.layers[0].values.size(); ++i)
        texture.layers[0].values[i] = static_cast<float>(i % 256) / 255;
    texture.save(own);
    CHECK(Texture::load(own)->layers[0] == texture.layers[0]);
    CHECK(4 * std::filesystem::file_size(file) < bytes_of_floats);  // A byte for each of its values.

    const auto whole = read_file(file);
    for (std::size_t at = 0; at < whole.size(); at += 7)
    {
        auto damaged = whole;
        damaged[at] ^= std::byte{1};
        write_file(file, damaged);
        INFO(at);
        CHECK_THROWS_WITH(Texture::load(own), Contains("layer_0"));
        damaged.resize(at);
        write_file(file, damaged);
        CHECK_THROWS_WITH(Texture::load(own), Contains("layer_0.packed: offset"));
    }
    std::filesystem::copy_file(folder.path() / "places.packed", file, std::filesystem::copy_options::overwrite_existing);
    CHECK_THROWS_WITH(Texture::load(own), Contains("layer_0.packed: offset 8: expected values of type"));

    auto large = whole;
    const std::uint32_t sides[] = {1U << 20U, 1U << 9U};
    std::memcpy(large.data() + 12, sides, sizeof sides);
    write_file(file, large);
    CHECK_THROWS_WITH(Texture::load(own), Contains("layer_0.packed: offset 12: expected 1 to 268435456 pixels"));
    texture.seen.width = texture.seen.height = 1 << 15;
    CHECK_THROWS_WITH(texture.save(own), Contains("seen.packed: expected at most 268435456 pixels, got 32768x32768"));
}

TEST_CASE("Textures, tables and files read back; what is missing is named")
{
    const testing::TemporaryFolder folder;
    const ArtifactFolder own{folder.path(), {}};
    Texture texture;
    texture.layers = {RasterF(8, 8, 3, 0.5F), RasterF(4, 4, 3, 0.1F)};
    texture.seen = Raster8(8, 8, 1, 1);
    texture.save(own);
    CHECK(Texture::load(own)->layers == texture.layers);
    texture.layers[1] = RasterF(5, 5, 3);
    texture.save(own);
    CHECK_THROWS_WITH(Texture::load(own), Contains("layer_1.packed") && Contains("half"));

    Table table;
    table.columns = {"stage", "seconds"};
    table.rows = {{"scan", 1.5}, {"mesh", 2}};
    table.save(own);
    CHECK(Table::load(own)->rows == table.rows);
    table.rows.push_back({"short"});
    CHECK_THROWS_WITH(table.save(own), Contains("row of 1"));

    Files files;
    files.names = {"views/a.png"};
    CHECK_THROWS_WITH(files.save(own), Contains("a.png") && Contains("not written"));
    files.names = {"../up.png"};
    CHECK_THROWS_WITH(files.save(own), Contains("up.png"));
}

TEST_CASE("A reference leads to a user's file by its path; other text is refused")
{
    const ArtifactFolder folder{"/store/objects/1/frames", "/store"};
    CHECK(reference_to("/mnt/scans/a.png", folder) == "file:/mnt/scans/a.png");
    CHECK(referred_file("file:/mnt/scans/a.png", folder) == "/mnt/scans/a.png");
    CHECK_THROWS_WITH(referred_file("/mnt/scans/a.png", folder), Contains("does not begin with own:, store: or file:"));
}
