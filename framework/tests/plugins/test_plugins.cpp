#include "program.h"

#include "plugins/plugin_library.h"
#include "plugins/plugin_search.h"

#include <sys/stat.h>

// What constructors of plugins may do: prove_hostile_plugins. That a changed library is seen: prove_never_stale.

using namespace fresco::host;

namespace
{

const char* const one_source = "version: 1\nstages:\n  source: {type: test.source}\n";
const char* const no_library = "no library, but long enough to be looked at for some time by a loader of plugins";

/// A workplace whose plugins are in a folder of its own.
struct OwnPlugins : Workplace
{
    explicit OwnPlugins(const std::string& name = "plugins") : Workplace({}, true), plugins(root() / name)
    {
        fs::create_directories(plugins);
        environment["FRESCO_PLUGIN_PATH"] = plugins;
        write("room.yaml", one_source);
    }

    void put(const std::string& plugin, const std::string& name) const { fs::copy_file(test_plugin(plugin), plugins / name); }
    std::string listed(bool all = true) { return run(all ? Words{"stages", "--all"} : Words{"stages"}).out; }

    fs::path plugins;
};

}  // namespace

TEST_CASE("The handshake names what differs, with both values")
{
    const fresco_plugin_info host = host_stamp();
    CHECK(!handshake_problem(host, host, nullptr));
    const auto problem = [&](const auto& change, const fresco_plugin_info* torch = nullptr)
    {
        fresco_plugin_info plugin = host;
        change(plugin);
        return handshake_problem(plugin, host, torch).value_or("none");
    };
    // Behind another ABI number nothing else is looked at.
    const std::string abi = problem(
        [](auto& plugin)
        {
            plugin.abi = 99;
            plugin.compiler = nullptr;
        });
    CHECK(contains(abi, "\"99\""));
    CHECK(contains(abi, "\"" + std::to_string(FRESCO_ABI) + "\""));
    CHECK(contains(problem([](auto& plugin) { plugin.magic = 0x12345678; }), "0x12345678"));
    const std::string compiler = problem([](auto& plugin) { plugin.compiler = "gcc 4"; });
    CHECK(contains(compiler, "\"gcc 4\""));
    CHECK(contains(compiler, host.compiler));
    CHECK(contains(problem([](auto& plugin) { plugin.standard_library = "libstdc++ 12 cxx11abi=0"; }), "cxx11abi=0"));
    CHECK(contains(problem([](auto& plugin) { plugin.containers = "debug"; }), "\"debug\""));

    fresco_plugin_info torch = host;
    torch.torch = "1.13.1";
    const auto uses = [](auto& plugin) { plugin.torch = "2.1.0"; };
    CHECK(problem([](auto&) {}, &torch) == "none");  // Does not use it.
    CHECK(contains(problem(uses, &torch), "\"2.1.0\""));
    CHECK(contains(problem(uses, &torch), "\"1.13.1\""));
    torch.torch = "2.1.0";
    CHECK(problem(uses, &torch) == "none");
    torch.cuda = "12.1";
    CHECK(contains(problem(uses, &torch), "CUDA"));
}

TEST_CASE("A library that is cut short is named without being opened")
{
    const fresco::testing::TemporaryFolder folder;
    const fs::path file = folder.path() / "x.so";
    CHECK(contains(library_file_problem(file).value(), "cannot be looked at"));
    fs::copy_file(test_plugin("good/test_stages.so"), file);
    CHECK(!library_file_problem(file));
    const auto whole = fs::file_size(file);
    for (const auto size : {whole - 1, whole / 2, std::uintmax_t{200}, std::uintmax_t{64}, std::uintmax_t{20}, std::uintmax_t{0}})
    {
        fs::resize_file(file, size);
        CHECK(library_file_problem(file));
    }
}

TEST_CASE("Bad plugins are refused by name, good ones beside them work")
{
    OwnPlugins place("odd");
    fs::create_directories(place.plugins / "folder.so");
    REQUIRE(mkfifo((place.plugins / "fifo.so").c_str(), 0600) == 0);
    std::ofstream(place.plugins / "text.so") << no_library;
    // A library that plugins link may lie beside them.
    std::ofstream(place.plugins / "libtext.so") << no_library;
    place.put("good/test_stages.so", "cut.so");
    fs::resize_file(place.plugins / "cut.so", fs::file_size(place.plugins / "cut.so") / 2);
    place.put("sided/libside.so", "side.so");
    std::string& path = place.environment["FRESCO_PLUGIN_PATH"];
    for (const char* folder : {"good", "bad/throws", "bad/channel", "bad/cost", "bad/wrong_abi", "bad/undefined_symbol"})
        path += ":" + test_plugin(folder).string();
    path += ":" + (place.root() / "nowhere").string();
    const std::string listed = place.listed();
    for (const char* text :
         {"no license for today", "bad.cost: cost(): the stage has no option \"max_facez\"",
          "wrote \"cache opened\" to descriptor 3, the host's channel, when an object of type bad.channel was made", "\"99\"",
          "side.so: has no symbol fresco_plugin_info_1", "fresco_function_that_nobody_has", "folder.so", "a folder", "fifo.so",
          "a FIFO", "/text.so", "does not begin as an ELF file", "cut.so", "is cut short", "nowhere", "test.source"})
        CHECK(contains(listed, text));
    CHECK(listed.find("libtext.so") == std::string::npos);
    place.make();
    place.write("bad.yaml", "version: 1\nstages:\n  bad: {type: bad.throws}\n");
    CHECK(place.run({"run", "bad.yaml"}).code != 0);
    CHECK(place.run({"doctor"}).code == 4);
}

TEST_CASE("A plugin that hangs is given up and remembered, unless it was replaced meanwhile, as by a build")
{
    OwnPlugins place;
    OwnPlugins other;
    for (OwnPlugins* one : {&place, &other})
    {
        one->put("bad/hangs/bad_hangs.so", "one.so");
        one->environment["BAD_LOG"] = one->file("log");
    }
    const auto asked = place.start({"stages", "--all"});
    const auto meanwhile = other.start({"stages", "--all"});
    Workplace::wait_until([&] { return !other.log().empty(); });
    other.put("good/test_stages.so", "next");
    fs::rename(other.plugins / "next", other.plugins / "one.so");

    const std::string refusal = "did not return within 5 s when an object of type bad.hangs was made";
    CHECK(contains(asked->wait().out, refusal));
    CHECK(contains(place.listed(), refusal));
    CHECK(place.log().size() == 1);
    CHECK(contains(meanwhile->wait().out, "did not return within 5 s"));
    CHECK(contains(other.listed(), "test.source"));
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
    const auto library = [&] {
        return fresco::parse_json(place.run({"describe", "--json", "test.source"}).out).at("library").as_string();
    };
    CHECK(library() == built);
    CHECK(contains(place.run({"doctor"}, 0).out, "shadowed: test.source of " + fs::canonical(installed).string() + ", by "));
    CHECK(contains(place.run({"stages", "--all"}).out, "shadowed by another of the type:"));
    place.environment["FRESCO_PLUGIN_PATH"] = "";
    CHECK(library() == fs::canonical(installed));
}

TEST_CASE("A plugin that was not built is named with the reason, until it is there")
{
    Workplace place({}, true);
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
    CHECK(contains(place.run({"stages", "--all"}).out, "\n  loss.gram\n  test.in_the_tree: libtorch was not found\n"));
    const Finished doctor = place.run({"doctor"});
    CHECK(doctor.code == 0);
    CHECK(contains(doctor.out, "not built: test.in_the_tree: libtorch was not found\n"));
    CHECK(contains(place.run({"doctor", "--json"}).out, "\"unbuilt\": ["));

    // Another library has one of the listed types: the folder's own library is what counts, then the type.
    fs::copy_file(test_plugin("good/test_stages.so"), folder / "elsewhere.so");
    CHECK(contains(errors("test.source"), "0 "));
    CHECK(place.run({"stages", "--all"}).out.find("test.source: ") == std::string::npos);
    std::ofstream(folder / "loss_gram.so") << no_library;
    CHECK(contains(errors("loss.gram"), "does not begin as an ELF file"));
}

TEST_CASE("Equal plugins of two installations are each described with the libraries beside them")
{
    OwnPlugins place;
    place.write_stages("\n  side: {type: test.sided}\n");
    for (const char* name : {"one", "other"})
        fs::copy(test_plugin("sided"), place.root() / name);
    std::ofstream(place.root() / "other" / "libside.so", std::ios::app) << "another build";
    for (const char* name : {"one", "other", "one"})
    {
        place.environment["FRESCO_PLUGIN_PATH"] = place.root() / name;
        place.make({"--store", std::string("store of ") + name});
    }
}

TEST_CASE("A folder of FRESCO_PLUGIN_PATH without plugins is named where a type is unknown, and by doctor")
{
    Workplace place({"good", "misbehaving"});
    place.write_stages("\n  room: {type: paint.walls}\n");
    place.write("near.yaml", "version: 1\nstages:\n  room: {type: test.sorce}\n");
    const std::string usual = place.environment["FRESCO_PLUGIN_PATH"];
    const std::string nowhere = place.root() / "nowhere";
    const std::string empty = place.root() / "empty";
    fs::create_directory(empty);
    CHECK(contains(place.run({"check", "room.yaml"}).err, "unknown type 'paint.walls'; 'fresco stages' lists all types"));
    for (const auto& [folder, reason] :
         {std::pair(nowhere, "FRESCO_PLUGIN_PATH names this folder: No such file or directory"),
          std::pair(empty, "FRESCO_PLUGIN_PATH names this folder, which holds no plugin (NAME.so)")})
    {
        place.environment["FRESCO_PLUGIN_PATH"] = usual + ":" + folder;
        const Finished checked = place.run({"check", "room.yaml"});
        CHECK(checked.code == 2);
        CHECK(contains(checked.err, "unknown type 'paint.walls'; " + folder + ": " + reason + "\n"));
        CHECK((checked.err.find("warning: FRESCO_PLUGIN_PATH: " + nowhere) != std::string::npos) == (folder == nowhere));
        const Finished doctor = place.run({"doctor"});
        CHECK(doctor.code == 4);
        CHECK(contains(doctor.out, "refused: " + folder + ": " + reason));
        // It may be a typing error, too.
        CHECK(contains(place.run({"check", "near.yaml"}).err, "'test.sorce' (did you mean 'test.source'?); " + folder));
    }
}

TEST_CASE("A folder that everybody may put plugins into gets a warning")
{
    OwnPlugins place;
    place.put("good/test_stages.so", "test_stages.so");
    for (const bool open : {false, true})
    {
        fs::permissions(place.plugins, open ? fs::perms::all : fs::perms::owner_all);
        for (const Words& words : {Words{"run", "room.yaml"}, {"check", "room.yaml"}, {"doctor"}})
        {
            const Finished finished = place.run(words);
            CHECK(finished.code == 0);
            CHECK((finished.err.find("warning: " + place.plugins.string() + ": every user may put plugins") !=
                   std::string::npos) == open);
        }
    }
}

TEST_CASE("Descriptions are remembered by contents and place; plan names a rebuilt plugin")
{
    OwnPlugins place;
    const auto cached = [&]
    {
        CHECK(contains(place.listed(false), "test.source"));
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(place.root() / "home/cache/fresco/descriptors"))
            count += entry.path().filename() == "stamps.json" ? 0 : 1;
        return count;
    };
    place.put("good/test_stages.so", "one.so");
    CHECK(cached() == 1);
    fs::rename(place.plugins / "one.so", place.plugins / "other.so");
    CHECK(cached() == 2);
    CHECK(cached() == 2);
    // The same library reached by two paths is one library.
    fs::create_directories(place.root() / "links");
    fs::create_symlink(place.plugins / "other.so", place.root() / "links/again.so");
    place.environment["FRESCO_PLUGIN_PATH"] += ":" + (place.root() / "links").string();
    place.make();
    std::ofstream(place.plugins / "other.so", std::ios::app) << "more";
    CHECK(cached() == 3);
    CHECK(contains(place.run({"plan", "room.yaml"}).out, "the plugin of test.source was rebuilt"));
}
