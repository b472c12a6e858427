#include "program.h"

#include "base/common.h"
#include "plugins/plugin_library.h"

#include <elf.h>
#include <sys/stat.h>

// Other proofs are about plugins, too: prove_hostile_plugins has stages that do harm, prove_never_stale changes libraries.

using namespace fresco::host;

namespace
{

const char* const one_source = "version: 1\nstages:\n  source: {type: test.source}\n";
const char* const no_library = "no library, but long enough for all headers of one";

fs::path description_of(const fs::path& library)
{
    return fs::path(library).replace_extension(".json");
}

/// The description of another plugin, changed, as that of this library.
void describe_as(
    const fs::path& library, const std::string& other, const std::function<void(fresco::Value&)>& change = [](auto&) {})
{
    fresco::Value description = fresco::parse_json(fresco::read_text_file(description_of(test_plugin(other))));
    description.set("build_id", fresco::build_id(library));
    change(description);
    fresco::write_file(description_of(library), to_json(description));
}

/// A workplace whose plugins are in a folder of its own.
struct OwnPlugins : RoomPlace
{
    explicit OwnPlugins(const std::string& text = one_source) : RoomPlace(text, {})
    {
        fs::create_directories(plugins);
        environment["FRESCO_PLUGIN_PATH"] = plugins;
    }

    void put_library(const std::string& plugin, const std::string& name) const
    {
        fs::copy_file(test_plugin(plugin), plugins / name);
    }
    void put(const std::string& plugin, const std::string& name) const
    {
        put_library(plugin, name);
        fs::copy_file(description_of(test_plugin(plugin)), description_of(plugins / name));
    }
    std::string listed() { return run({"stages", "--all"}).out; }
    Finished describe(const std::string& name) const
    {
        return Background({FRESCO_DESCRIBE, plugins / name}, environment, work(), root() / "out", root() / "err").wait();
    }

    const fs::path plugins = root() / "plugins";
};

}  // namespace

TEST_CASE("The handshake names what differs, with both values")
{
    using Info = fresco_plugin_info;
    const Info host = fresco::sdk_stamp();
    const auto problem = [&](const auto& change, const Info* torch = nullptr)
    {
        Info plugin = host;
        change(plugin);
        return fresco::handshake_problem(plugin, host, torch).value_or("none");
    };
    CHECK(problem([](Info&) {}) == "none");
    // Behind another ABI number nothing else is looked at.
    const std::string abi = problem(
        [](Info& plugin)
        {
            plugin.abi = 99;
            plugin.compiler = nullptr;
        });
    CHECK((contains(abi, "\"99\"") && contains(abi, "\"" + std::to_string(FRESCO_ABI) + "\"")));
    CHECK(contains(problem([](Info& plugin) { plugin.magic = 0x12345678; }), "0x12345678"));
    for (const auto field : {&Info::compiler, &Info::standard_library, &Info::containers})
    {
        const std::string differs = problem([&](Info& plugin) { plugin.*field = "another"; });
        CHECK((contains(differs, "\"another\"") && contains(differs, host.*field)));
    }

    Info torch = host;
    torch.torch = "1.13.1";
    const auto uses = [](Info& plugin) { plugin.torch = "2.1.0"; };
    CHECK(problem([](Info&) {}, &torch) == "none");  // Does not use it.
    CHECK((contains(problem(uses, &torch), "\"2.1.0\"") && contains(problem(uses, &torch), "\"1.13.1\"")));
    torch.torch = "2.1.0";
    CHECK(problem(uses, &torch) == "none");
    torch.cuda = "12.1";
    CHECK(contains(problem(uses, &torch), "CUDA"));
}

TEST_CASE("A build id is read from a library's notes, and a file without one is refused")
{
    const fs::path library = test_plugin("sided/sided.so");
    const std::string whole = fresco::read_text_file(library).substr(0, 4096);  // With all headers and notes.
    const std::string id = fresco::parse_json(fresco::read_text_file(description_of(library))).at("build_id").as_string();
    const fresco::testing::TemporaryFolder folder;
    const auto id_of = [&](const std::string& text)
    {
        fresco::write_file(folder.path() / "x.so", text);
        return fresco::build_id(folder.path() / "x.so");
    };
    CHECK(id_of(whole) == id);
    const auto changed = [&](std::size_t at, int byte)
    {
        std::string text = whole;
        text[at] = static_cast<char>(byte);
        return fresco::testing::error_of([&] { id_of(text); });
    };
    const std::size_t type =
        whole.find(std::string("\3\0\0\0GNU", 7));  // The type of the note follows the sizes of its name and id.
    REQUIRE(type < whole.size());
    for (std::size_t at = 0; at < type + 40; ++at)
    {
        CHECK(attempt([&] { return id_of(whole.substr(0, at)); }).value_or(id) == id);
        for (const int byte : {0, 1, 127, 255})  // Whatever the headers and notes hold, only an Error comes of it.
            changed(at, byte);
    }
    for (const std::size_t at : {offsetof(Elf64_Ehdr, e_type), std::size_t{EI_CLASS}})
        CHECK(contains(changed(at, 1), "is not a shared library"));
    CHECK(contains(changed(offsetof(Elf64_Ehdr, e_phentsize), 1), "its list of segments cannot be read"));
    for (const std::size_t before : {0, 1, 5})  // The type, and the highest bytes of the two sizes.
        CHECK(contains(changed(type - before, 255), "-Wl,--build-id"));
}

TEST_CASE("Bad plugins are refused by name, good ones beside them work")
{
    OwnPlugins place;
    fs::create_directories(place.plugins / "folder.so");
    REQUIRE(mkfifo((place.plugins / "fifo.so").c_str(), 0600) == 0);
    // A library that plugins link may lie beside them.
    for (const char* name : {"text.so", "libtext.so"})
        std::ofstream(place.plugins / name) << no_library;
    place.put_library("sided/libside.so", "side.so");
    place.put("good/test_stages.so", "damaged.so");
    fs::resize_file(place.plugins / "damaged.json", 1000);
    const auto put_described = [&](const std::string& name, const std::function<void(fresco::Value&)>& change)
    {
        place.put_library("sided/sided.so", name);
        describe_as(place.plugins / name, "sided/sided.so", change);
    };
    put_described("foreign.so", [](auto& description) { description.set("build_id", "00ff"); });
    put_described("odd.so", [](auto& description) { description.set("types", 7); });
    put_described("old.so", [](auto& description) { description.find("handshake")->set("abi", 99); });
    put_described("alone.so",
                  [](auto& description) { description.set("own_libraries", fresco::Value::List{"libfresco_side.so"}); });
    std::string& path = place.environment["FRESCO_PLUGIN_PATH"];
    path += ":" + test_plugin("good").string() + ":" + (place.root() / "nowhere").string();
    const std::string listed = place.listed();
    for (const char* text :
         {"side.so: was built without its description: build it with fresco_add_plugin", "damaged.json: not valid JSON at byte ",
          "foreign.json: that one describes the build 00ff, the library is the build ",
          "odd.json: types: ", "its SDK ABI number is \"99\"",
          "alone.so: needs libfresco_side.so, which is neither beside it nor in ", "folder.so: is not a shared library",
          "fifo.so: is not a shared library", "/text.so: is not a shared library", "test.source"})
        CHECK_THAT(listed, Contains(text));
    CHECK(listed.find("libtext.so") == std::string::npos);
    place.make();
    CHECK(place.run({"doctor"}).code == 4);
}

TEST_CASE("A run opens all its plugins before it begins, and names those that cannot be opened")
{
    OwnPlugins place;
    place.put("good/test_stages.so", "test_stages.so");
    const auto [bad, reason] = GENERATE(table<std::string, std::string>(
        {{"crashes", "crashed when it was opened: Segmentation fault"},
         {"undefined_symbol", "cannot be loaded: "},
         {"wrong_abi", "its SDK ABI number is \"99\", this fresco needs \"" + std::to_string(FRESCO_ABI) + "\""}}));
    const fs::path library = fs::canonical(place.plugins) / "bad.so";
    place.put_library("bad/bad_" + bad + ".so", "bad.so");
    describe_as(library, "note/test_note.so");
    place.write_stages("\n  first: {type: test.sink, input: {file: a.number}, path: a}\n  note: {type: test.note}\n");
    place.write("a.number", "1");
    place.run({"check", "room.yaml"}, 0);
    const Finished finished = place.run({"run", "room.yaml", "--json-log"}, 4);
    CHECK(contains(outcomes(finished, "error").at("note"), "plugin " + library.string() + ": " + reason));
    CHECK(outcomes(finished) == std::map<std::string, std::string>{{"first", "not run"}, {"note", "failed"}});
    place.run({"run", "room.yaml", "--until", "first"}, 0);
    CHECK(contains(place.listed(), library.string() + ": " + reason));
    CHECK(contains(place.run({"doctor"}, 4).out, reason));
}

TEST_CASE("A plugin that the loader gives another library than the one in the key is refused")
{
    OwnPlugins place("\n  side: {type: test.sided}\n");
    for (const char* folder : {"plugins", "elsewhere"})
        fs::copy(test_plugin("sided"), place.root() / folder);
    place.environment["LD_LIBRARY_PATH"] += ":" + (place.root() / "elsewhere").string();
    place.make();
    place.environment["LD_PRELOAD"] = place.root() / "elsewhere/libside.so";
    CHECK_THAT(place.run({"run", "room.yaml", "--store", "other"}, 4).err,
               Contains("runs with " + (place.root() / "elsewhere/libside.so").string() + " instead of "));
}

TEST_CASE("A library that comes to the plugin only with the installation counts from then on")
{
    OwnPlugins place("\n  side: {type: test.sided}\n");
    place.put_library("sided/sided.so", "sided.so");
    const auto usual = place.environment;
    place.environment["LD_LIBRARY_PATH"] += ":" + test_plugin("sided").string();
    REQUIRE(place.describe("sided.so").code == 0);
    place.environment = usual;
    place.put_library("sided/libside.so", "libside.so");
    place.make();
    std::ofstream(place.plugins / "libside.so", std::ios::app) << "another build";
    CHECK(contains(place.run({"plan", "room.yaml"}).out, "the plugin of test.sided was rebuilt"));
}

TEST_CASE("Plugins of one file name, and those whose libraries have one, do not refuse each other")
{
    OwnPlugins place;
    const fs::path root = place.root();
    for (const char* name : {"one", "other"})
        fs::copy(test_plugin("sided"), root / name);
    fs::remove(root / "other/libside.so");
    fs::create_hard_link(root / "one/libside.so", root / "other/libside.so");
    CHECK_NOTHROW(open_plugin(root / "one/sided.so"));
    CHECK_NOTHROW(open_plugin(root / "other/sided.so"));

    // The loader gives both the library of the first, if one process opens them.
    fs::remove(root / "other/libside.so");
    fs::copy_file(test_plugin("sided/libside.so"), root / "other/libside.so");
    describe_as(root / "other/sided.so", "sided/sided.so",
                [](auto& description) { description.find("types")->as_list()[0].set("type", "test.other"); });
    place.environment["FRESCO_PLUGIN_PATH"] = (root / "one").string() + ":" + (root / "other").string();
    CHECK(place.run({"stages", "--all"}, 0).out.find("instead of") == std::string::npos);
}

TEST_CASE("fresco-describe writes the same description again, and refuses what cannot be used")
{
    OwnPlugins place;
    place.put_library("good/test_stages.so", "one.so");
    CHECK(place.describe("one.so").code == 0);
    CHECK(fresco::read_text_file(place.plugins / "one.json") == fresco::read_text_file(test_plugin("good/test_stages.json")));
    for (const auto& [bad, reason] : {std::pair("throws", "the constructor of bad.throws throws: no license for today"),
                                      {"wrong_abi", "\"99\""},
                                      {"undefined_symbol", "fresco_function_that_nobody_has"}})
    {
        place.put_library("bad/bad_" + std::string(bad) + ".so", bad);
        const Finished finished = place.describe(bad);
        CHECK(finished.code == 1);
        CHECK_THAT(finished.err, Contains((place.plugins / bad).string() + ": ") && Contains(reason));
        CHECK_FALSE(fs::exists(description_of(place.plugins / bad)));
    }
}

TEST_CASE("Of a type that two libraries have, neither is used")
{
    OwnPlugins place;
    place.put("good/test_stages.so", "one.so");
    place.put("good/test_stages.so", "two.so");
    std::ofstream(place.plugins / "two.so", std::ios::app) << "other";
    place.put("note/test_note.so", "test_note.so");
    const Finished needed = place.run({"run", "room.yaml"}, 4);
    for (const char* name : {"one.so", "two.so"})
    {
        CHECK(contains(place.listed(), name));
        CHECK(contains(needed.err, name));
    }
    CHECK(contains(place.run({"doctor"}, 4).out, "not used, because several plugins have it: "));
    place.write_stages("\n  note: {type: test.note}\n");
    place.make();
}

TEST_CASE("A folder of FRESCO_PLUGIN_PATH shadows the installation, and doctor says so")
{
    Workplace place;
    const fs::path installed = place.root() / "lib/fresco/installed.so";
    const fs::path built = fs::canonical(test_plugin("good/test_stages.so"));
    fs::create_directories(installed.parent_path());
    fs::copy_file(built, installed);
    fs::copy_file(description_of(built), description_of(installed));
    const auto library = [&] {
        return fresco::parse_json(place.run({"describe", "--json", "test.source"}).out).at("library").as_string();
    };
    CHECK(library() == built);
    CHECK(contains(place.run({"doctor"}, 0).out, "shadowed: test.source of " + fs::canonical(installed).string() + ", by "));
    place.environment["FRESCO_PLUGIN_PATH"] = "";
    CHECK(library() == fs::canonical(installed));
}

TEST_CASE("A plugin that was not built is named with the reason, until it is there")
{
    Workplace place(Words{});
    const fs::path folder = place.root() / "lib" / "fresco";
    fs::create_directories(folder);
    std::ofstream(folder / "plugins.txt") << "test_source\nloss_gram\ntest_in_the_tree: libtorch was not found\n";
    const auto errors = [&](const std::string& type)
    {
        place.write_stages("\n  source: {type: " + type + "}\n");
        const Finished finished = place.run({"check", "room.yaml"});
        return std::to_string(finished.code) + " " + finished.err;
    };
    CHECK(contains(errors("test.source"),
                   "4 room.yaml:3:18: error: stage 'source': the plugin of 'test.source' is not built: run "));
    CHECK(
        contains(errors("test.in_the_tree"), "'test.in_the_tree' is not built (libtorch was not found): run ./bootstrap build"));
    CHECK(contains(errors("test.elsewhere"), "2 room.yaml:3:18: error: stage 'source': unknown type 'test.elsewhere'"));
    CHECK(contains(place.run({"doctor"}, 0).out,
                   "\n  not built: loss.gram\n  not built: test.in_the_tree: libtorch was not found\n"));

    // Another library has one of the listed types: the folder's own library is what counts, then the type.
    for (const char* extension : {".so", ".json"})
        fs::copy_file(test_plugin(std::string("good/test_stages") + extension), folder / (std::string("elsewhere") + extension));
    CHECK(contains(errors("test.source"), "0 "));
    CHECK(place.run({"stages", "--all"}).out.find("test.source: ") == std::string::npos);
    std::ofstream(folder / "loss_gram.so") << no_library;
    CHECK(contains(errors("loss.gram"), "is not a shared library"));
}

TEST_CASE("A folder of FRESCO_PLUGIN_PATH without plugins is warned of, where a type is unknown and by doctor")
{
    RoomPlace place("\n  room: {type: paint.walls}\n", {"good", "misbehaving"});
    const std::string usual = place.environment["FRESCO_PLUGIN_PATH"];
    const std::string nowhere = place.root() / "nowhere";
    const std::string empty = place.root() / "empty";
    fs::create_directory(empty);
    for (const auto& [folder, reason] :
         {std::pair(nowhere, "No such file or directory"), std::pair(empty, "holds no plugin (NAME.so)")})
    {
        place.environment["FRESCO_PLUGIN_PATH"] = usual + ":" + folder;
        const std::string warning = "warning: FRESCO_PLUGIN_PATH: " + folder + ": " + reason + "\n";
        CHECK_THAT(place.run({"check", "room.yaml"}, 2).err, Contains(warning) && Contains("unknown type 'paint.walls'"));
        CHECK_THAT(place.run({"doctor"}).err, Contains(warning));
    }
}

TEST_CASE("A folder that everybody may put plugins into gets a warning")
{
    OwnPlugins place;
    place.put("good/test_stages.so", "test_stages.so");
    const std::string warning = "warning: " + place.plugins.string() + ": every user may put plugins";
    for (const Words& words : {Words{"run", "room.yaml"}, {"check", "room.yaml"}, {"doctor"}})
        for (const bool open : {false, true})
        {
            fs::permissions(place.plugins, open ? fs::perms::all : fs::perms::owner_all);
            CHECK((place.run(words, 0).err.find(warning) != std::string::npos) == open);
        }
}

TEST_CASE("A library reached by two paths is one; plan names a rebuilt plugin")
{
    OwnPlugins place;
    place.put("good/test_stages.so", "one.so");
    fs::create_directories(place.root() / "links");
    fs::create_symlink(place.plugins / "one.so", place.root() / "links/again.so");
    place.environment["FRESCO_PLUGIN_PATH"] += ":" + (place.root() / "links").string();
    place.make();
    // As `strip` does, other bytes of the same build.
    std::ofstream(place.plugins / "one.so", std::ios::app) << "more";
    CHECK(contains(place.run({"plan", "room.yaml"}).out, "the plugin of test.source was rebuilt"));
}
