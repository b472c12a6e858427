#include "catch.h"
#include "raw_images.h"

#include <fresco/command.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

/// A store with one input in it, and the folders that a worker would have.
struct Place
{
    Place()
    {
        for (const auto& each : {stored(), published(), scratch(), made_below()})
            fs::create_directories(each);
    }

    fs::path store() const { return folder.path(); }
    fs::path stored() const { return store() / "objects/0123/port"; }
    fs::path published() const { return store() / "tmp/made/port"; }
    fs::path scratch() const { return store() / "tmp/scratch/port"; }
    fs::path made_below() const { return store() / "tmp/scratch/made"; }

    testing::TemporaryFolder folder;
    testing::RawImages images;
    testing::TestRun run;
};

/// One input and one output that a pipeline declares.
class Ports : public Configurable
{
  public:
    Ports(const std::string& artifact, const std::string& as, Place& place) : place_(place)
    {
        Value port = Value::Map{{"artifact", artifact}};
        if (!as.empty())
            port.set("as", as);
        testing::TestFactory factory;
        configure(Value::Map{{"in", Value::Map{{"port", port}}}, {"out", Value::Map{{"port", port}}}}, factory);
        (*ins_).front()->load({place.stored(), place.store()});
        out().set_folder({place.published(), place.store()});
    }
    const DeclaredInput& in() const { return *(*ins_).front(); }
    DeclaredOutput& out() const { return *(*outs_).front(); }
    fs::path hand_over() const { return in().hand_over(place_.scratch(), &place_.images, place_.run); }
    void take_back() const { out().take_back(place_.made_below(), &place_.images, place_.run); }

  private:
    InputPorts ins_{this, "in", ""};
    OutputPorts outs_{this, "out", ""};
    Place& place_;
};

/// The program in between copies what it is given.
template <class T>
std::shared_ptr<T> through(Place& place, const std::string& as, const T& value)
{
    value.save({place.stored(), place.store()});
    const Ports ports(std::string(T::artifact_name), as, place);
    const fs::path given = ports.hand_over();
    fs::copy(given, ports.out().place(place.made_below()), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    ports.take_back();
    return T::load({place.published(), place.store()});
}

Image picture()
{
    return Image(testing::noise_picture(2, 2, 1));
}

Frame frame(const fs::path& color)
{
    Frame made = testing::frame("frame-000000", testing::camera(2, 2, 2));
    made.color_picture.path = color;
    return made;
}

}  // namespace

TEST_CASE("what a program hands on unchanged comes back bit by bit, in every form", "[exchange]")
{
    Place place;
    SECTION("a mesh, as a PLY file")
    {
        CHECK(to_ply(*through(place, "", testing::wall())) == to_ply(testing::wall()));
        CHECK(fs::exists(place.scratch() / "mesh.ply"));
    }
    SECTION("a picture, also one with alpha")
    {
        const std::string as = GENERATE("npy", "png");
        const Image made = GENERATE(picture(), Image(Raster8(2, 2, 4, 100)));
        CHECK(through(place, as, made)->pixels == made.pixels);
        CHECK(fs::exists(place.scratch() / ("image." + as)));
    }
    SECTION("a textured mesh, also one whose mesh is another result's")
    {
        const std::string as = GENERATE("npy", "png");
        TexturedMesh textured;
        textured.mesh = testing::wall();
        textured.image = picture();
        if (GENERATE(false, true))
        {
            textured.mesh.save({place.store(), {}});
            textured.mesh.saved_in = place.store();
        }
        const auto back = through(place, as, textured);
        CHECK(to_ply(back->mesh) == to_ply(testing::wall()));
        CHECK(back->image.pixels == picture().pixels);
        CHECK(fs::exists(place.scratch() / ("image." + as)));
        CHECK(fs::exists(place.published() / "mesh.ply"));
    }
    SECTION("files, where they lie")
    {
        Files files;
        fs::create_directories(place.stored() / "deep");
        write_file(place.stored() / "deep/a.txt", std::string_view("a"));
        files.names = {"deep/a.txt"};
        files.save({place.stored(), {}});
        const Ports ports("files", "", place);
        CHECK(ports.hand_over() == place.stored());
        fs::copy(place.stored() / "deep", place.published() / "deep");
        ports.take_back();
        CHECK(Files::load({place.published(), {}})->names == files.names);
    }
}

TEST_CASE("frames are handed over with plain paths, and taken back with pictures of any place by any path", "[exchange]")
{
    Place place;
    const fs::path stored = place.store() / "objects/4567/a.npy";
    const fs::path passing = place.scratch() / "b.npy";
    const fs::path outside = place.store().parent_path() / (place.store().filename().string() + "-own.npy");
    const fs::path own = place.published() / "new.npy";
    fs::create_directories(stored.parent_path());
    for (const auto& file : {stored, passing, outside, own})
        write_npy(file, picture().pixels);
    Frames frames;
    const auto add = [&](const fs::path& color)
    {
        frames.frames.push_back(frame(color));
        frames.frames.back().name = "frame-" + std::to_string(frames.frames.size());
    };
    add(stored);
    add(outside);
    frames.save({place.stored(), place.store()});
    const Ports ports("frames", "", place);
    const fs::path given = ports.hand_over();
    const Value handed = parse_json(read_text_file(given / "frames.json"));
    CHECK(handed.at("frames").as_list().at(0).at("color_picture").at("ref").as_string() == "file:" + stored.string());

    // The program keeps both and adds a picture of its own. The store may be reached through a link.
    CHECK(ports.out().place(place.made_below()) == place.published());
    const fs::path link = place.store() / "link";
    fs::create_directory_symlink(place.store(), link);
    if (GENERATE(false, true))
        ports.out().set_folder({link / "tmp/made/port", link});
    add(own);
    frames.save({place.published(), {}});
    ports.take_back();
    const auto kept = parse_json(read_text_file(place.published() / "frames.json")).at("frames").as_list();
    const auto picture_of = [&](std::size_t i) { return kept.at(i).at("color_picture"); };
    CHECK(picture_of(0).at("ref").as_string() == "store:objects/4567/a.npy");
    CHECK(picture_of(1).at("ref").as_string() == "file:" + outside.string());
    CHECK(picture_of(1).at("hash").as_string().size() == 32);
    CHECK(picture_of(2).at("ref").as_string() == "own:new.npy");
    CHECK(place.run.files_read == std::vector<fs::path>{outside});

    fs::remove(outside);
    CHECK_THROWS_WITH(ports.take_back(), Contains("seq-01/frame-2: no such picture: " + outside.string()));
    frames.frames = {frame(passing)};
    frames.save({place.published(), {}});
    CHECK_THROWS_WITH(ports.take_back(),
                      Contains("seq-01/frame-000000: the picture " + passing.string() +
                               " will be gone when the program has ended: write it into the folder of this output"));
}

TEST_CASE("what a program did not write, or wrote wrong, is named", "[exchange]")
{
    Place place;
    const auto taken = [&](const char* artifact, const char* as = "") { Ports(artifact, as, place).take_back(); };
    for (const ArtifactType* type : artifact_types())
    {
        INFO(type->name);
        CHECK_THROWS_WITH(taken(type->name.c_str()), Contains(place.store().string()));
    }
    write_file(place.made_below() / "mesh.ply", std::string_view("ply\nformat ascii 1.0\n"));
    CHECK_THROWS_WITH(taken("mesh"), Contains("mesh.ply"));
    Mesh bare = testing::wall();
    bare.texcoords.clear();
    write_file(place.made_below() / "mesh.ply", to_ply(bare));
    write_npy(place.made_below() / "image.npy", picture().pixels);
    CHECK_THROWS_WITH(taken("textured_mesh", "npy"), Contains("a textured mesh needs texcoords"));
    write_npy(place.made_below() / "image.npy", RasterF(2, 2, 3));
    CHECK_THROWS_WITH(taken("image", "npy"), Contains("image.npy"));
    write_file(place.made_below() / "table.json", std::string_view("{\"columns\": [\"a\"], \"rows\": [[1, 2]]}"));
    CHECK_THROWS_WITH(taken("table"), Contains("table.json: rows[0]: "));
    write_file(place.published() / "files.json", std::string_view("{}"));
    CHECK_THROWS_WITH(taken("files"), Contains("this name is taken"));
    UvMaps maps;
    maps.heights_px = {3};
    maps.views = {{"seq-01", "frame-000000", testing::camera(4, 3, 2), {0}}};
    maps.save({place.published(), place.store()});
    CHECK_THROWS_WITH(taken("uv_maps"), Contains("000000_3.uvmap"));
    UvMaps::write_map({place.published(), {}}, 0, 3, {{4, 3, 2}, {4, 3}, {4, 3}, {4, 3}});
    CHECK_NOTHROW(taken("uv_maps"));
    const Ports png("image", "png", place);
    picture().save({place.stored(), {}});
    CHECK_THROWS_WITH(png.in().hand_over(place.scratch(), nullptr, place.run), Contains("no picture codec"));
}

TEST_CASE("names in braces are found and filled in, doubled braces are braces", "[command_line]")
{
    CHECK(names_in("--out={result}") == std::vector<std::string>{"result"});
    CHECK(names_in("{a}:{b.py}") == std::vector<std::string>{"a", "b.py"});
    CHECK(names_in("{{\"a\": 1}}").empty());
    CHECK(filled_in("{{{a}}}", {{"a", "/x y"}}) == "{/x y}");
    CHECK(filled_in("plain", {}) == "plain");
    for (const char* word : {"{", "}", "{a", "a}", "{a{b}}", "{{a}"})
    {
        INFO(word);
        CHECK_THROWS_WITH(names_in(word), Contains("without its other"));
    }
    CHECK_THROWS_WITH(filled_in("{b}", {{"a", ""}}), Contains("unknown name {b}"));
}
