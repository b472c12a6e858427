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

TEST_CASE("Frames keep their references when the store moves")
{
    const testing::TemporaryFolder place;
    const auto store = place.path() / "store";
    const ArtifactFolder own{store / "objects" / "b" / "frames", store};
    std::filesystem::create_directories(own.path);
    Frames frames;
    Frame frame = testing::frame("frame-000008", testing::camera(2, 2, 2), 8);
    frame.depth = testing::camera(3, 3, 2);
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
    const auto& first = loaded->frames[0];
    CHECK(first.color_picture.path == moved / "objects" / "b" / "frames" / "c.npy");
    CHECK(first.depth_picture.path == moved / "objects" / "a" / "d.png");
    CHECK(first.mask.path == moved / "objects" / "b" / "frames" / "m.npy");
    CHECK((first.color == frame.color && first.depth == frame.depth && first.number == 8));
    CHECK(loaded->frames[1].color_picture.path == place.path() / "user.npy");
    CHECK(loaded->frames[1].mask.empty());

    // The file of a user, by its path; other text is refused.
    CHECK(reference_to("/mnt/scans/a.png", own) == "file:/mnt/scans/a.png");
    CHECK(referred_file("file:/mnt/scans/a.png", own) == "/mnt/scans/a.png");
    CHECK_THROWS_WITH(referred_file("/mnt/scans/a.png", own), Contains("does not begin with own:, store: or file:"));
}

TEST_CASE("Frames keep their offset, and fit only meshes that have the same one")
{
    const testing::TemporaryFolder folder;
    Frames frames;
    frames.save({folder.path(), {}});
    CHECK(read_text_file(folder.path() / "frames.json").find("offset") == std::string::npos);
    frames.offset_m = {448'000, 5'411'000, -0.5};
    frames.save({folder.path(), {}});
    CHECK(Frames::load({folder.path(), {}})->offset_m == frames.offset_m);
    Mesh mesh;
    CHECK_THROWS_WITH(check_offset(frames, mesh), Contains("less (448000, 5411000, -0.5) m, those of the mesh less (0, 0, 0) m"));
    mesh.offset_m = frames.offset_m;
    CHECK_NOTHROW(check_offset(frames, mesh));
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

TEST_CASE("A frame's pictures must be those that were listed, of their cameras' sizes; NPY needs no codec")
{
    const testing::TemporaryFolder folder;
    Frame frame = testing::frame("f", testing::camera(3, 2, 2));
    const auto refused = [&](const std::string& reason)
    {
        CHECK_THROWS_WITH(load_color(frame, nullptr), Contains(reason));
        CHECK_THROWS_WITH(load_depth(frame, nullptr), Contains(reason));
    };
    CHECK_THROWS_WITH(load_color(frame, nullptr), Contains("seq-01/f: has no color picture"));
    CHECK_THROWS_WITH(load_depth(frame, nullptr), Contains("seq-01/f: has no depth picture"));
    testing::set_color_picture(frame, folder.path(), Raster8(3, 2, 3, 77));
    frame.depth_picture.path = folder.path() / "f.depth.npy";
    frame.depth_unit_m = 0.5;
    Raster16 steps(3, 2);
    steps.values = {0, 1, 2, 3, 65534, 65535};
    write_npy(frame.depth_picture.path, steps);
    for (PictureFile* picture : {&frame.color_picture, &frame.depth_picture})
        picture->hash = file_hash(picture->path);
    CHECK(load_color(frame, nullptr).at(2, 1, 2) == 77);
    CHECK(load_depth_steps(frame, nullptr) == steps);
    CHECK(load_depth(frame, nullptr).values == std::vector<float>{0, 0.5F, 1, 1.5F, 32767, 0});
    write_npy(frame.color_picture.path, Raster8(2, 3, 3, 78));
    write_npy(frame.depth_picture.path, Raster16(2, 3));
    refused("npy: changed since the scan was read");
    frame.color_picture.hash.clear();
    frame.depth_picture.hash.clear();
    refused("npy: is 2x3 pixels; its intrinsics say 3x2");
    frame.color_picture.path = frame.depth_picture.path = folder.path() / "image.png";
    refused("image.png: no picture codec");
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

    const auto file = folder.path() / "uvmaps.json";
    const std::string text = read_text_file(file);
    const auto refused = [&](const std::string& old, const std::string& other, const std::string& reason)
    {
        std::string changed = text;
        write_file(file, changed.replace(changed.find(old), old.size(), other));
        CHECK_THROWS_WITH(UvMaps::load(own), Contains("uvmaps.json: " + reason));
    };
    // 2^32 more is the same number in 32 bits.
    refused("  16", "  4294967312", "heights_px[0]: expected an integer from 1 to 65536, got 4294967312");
    refused("  16", "  -16", "heights_px[0]: ");
    refused("\"width\": 64", "\"width\": 4294967360", "views[0].camera.width: expected");
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
    const ArtifactFolder own{place.path() / "textured", place.path()};
    TexturedMesh textured;
    textured.mesh = testing::wall();
    textured.image = Image(Raster8(4, 4, 3, 77));
    textured.mesh.saved_in = place.path() / "atlas";
    for (const auto& folder : {own.path, textured.mesh.saved_in})
        std::filesystem::create_directories(folder);
    write_file(textured.mesh.saved_in / "mesh.ply", to_ply(textured.mesh));
    textured.save(own);
    CHECK(std::filesystem::equivalent(textured.mesh.saved_in / "mesh.ply", own.path / "mesh.ply"));
    std::filesystem::remove_all(textured.mesh.saved_in);
    CHECK(TexturedMesh::load(own)->mesh.positions == textured.mesh.positions);
    CHECK(TexturedMesh::load(own)->mesh.saved_in.empty());
    // Without a file to link, the mesh is written.
    std::filesystem::remove(own.path / "mesh.ply");
    textured.save(own);
    CHECK(TexturedMesh::load(own)->mesh.texcoords == textured.mesh.texcoords);
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
    map.shifts = testing::noise_picture(37, 37, 7);
    texture.layers = {RasterF(37, 37, 3)};
    texture.seen = Raster8(37, 37, 1, 1);
    for (float& value : texture.layers[0].values)
        value = static_cast<float>(2000 * random.uniform() - 1000);
    texture.layers[0].at(3, 4) = -0.0F;
    map.save(own);
    texture.save(own);
    CHECK((SourceMap::load(own)->places == map.places && SourceMap::load(own)->shifts == map.shifts));
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
    CHECK_THROWS_WITH(Texture::load(own), Contains("layer_1.packed: is 5x5; expected 4 texels a side"));

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
