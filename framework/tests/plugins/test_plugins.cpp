#include "program.h"

#include "plugins/plugin_library.h"
#include "plugins/plugin_search.h"

#include <chrono>
#include <sys/stat.h>
#include <thread>

using namespace fresco::host;

TEST_CASE("The handshake names what differs, with both values")
{
    const fresco_plugin_info host = host_stamp();
    CHECK(!handshake_problem(host, host, nullptr));

    fresco_plugin_info plugin = host;
    plugin.abi = 99;
    plugin.compiler = nullptr;  // Behind another ABI number nothing else is looked at.
    CHECK(contains(handshake_problem(plugin, host, nullptr).value(), "\"99\""));
    CHECK(contains(handshake_problem(plugin, host, nullptr).value(), "\"" + std::to_string(FRESCO_ABI) + "\""));

    plugin = host;
    plugin.magic = 0x12345678;
    CHECK(contains(handshake_problem(plugin, host, nullptr).value(), "0x12345678"));
    plugin = host;
    plugin.compiler = "gcc 4";
    CHECK(contains(handshake_problem(plugin, host, nullptr).value(), "\"gcc 4\""));
    CHECK(contains(handshake_problem(plugin, host, nullptr).value(), host.compiler));
    plugin = host;
    plugin.standard_library = "libstdc++ 12 cxx11abi=0";
    CHECK(contains(handshake_problem(plugin, host, nullptr).value(), "cxx11abi=0"));
    plugin = host;
    plugin.containers = "debug";
    CHECK(contains(handshake_problem(plugin, host, nullptr).value(), "\"debug\""));

    fresco_plugin_info torch = host;
    torch.torch = "1.13.1";
    plugin = host;
    CHECK(!handshake_problem(plugin, host, &torch));  // Does not use it.
    plugin.torch = "2.1.0";
    CHECK(contains(handshake_problem(plugin, host, &torch).value(), "\"2.1.0\""));
    CHECK(contains(handshake_problem(plugin, host, &torch).value(), "\"1.13.1\""));
    torch.torch = "2.1.0";
    CHECK(!handshake_problem(plugin, host, &torch));
    torch.cuda = "12.1";
    CHECK(contains(handshake_problem(plugin, host, &torch).value(), "CUDA"));
}

TEST_CASE("Files that are no whole library are named without being opened as one")
{
    const fresco::testing::TemporaryFolder folder;
    const fs::path file = folder.path() / "x.so";
    const auto problem = [&] { return library_file_problem(file).value_or("none"); };

    CHECK(contains(problem(), "cannot be looked at"));
    fs::create_directory(file);
    CHECK(contains(problem(), "a folder"));
    fs::remove(file);
    REQUIRE(mkfifo(file.c_str(), 0600) == 0);
    CHECK(contains(problem(), "a FIFO"));
    fs::remove(file);
    std::ofstream(file) << "#!/bin/sh\necho no library, but longer than an ELF header would have to be\n";
    CHECK(contains(problem(), "does not begin as an ELF file"));
    fs::remove(file);
    const auto whole = fs::file_size(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so");
    fs::copy_file(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so", file);
    CHECK(problem() == "none");
    for (const auto size : {whole - 1, whole / 2, std::uintmax_t{200}, std::uintmax_t{64}, std::uintmax_t{20}, std::uintmax_t{0}})
    {
        fs::resize_file(file, size);
        CHECK(problem() != "none");
    }
}

TEST_CASE("Bad plugins are refused by name, good ones beside them work")
{
    Workplace place({"good", "bad/throws", "bad/exits", "bad/crashes", "bad/channel", "bad/cost", "bad/wrong_abi",
                     "bad/wrong_magic", "bad/wrong_compiler", "bad/no_symbol", "bad/undefined_symbol"},
                    true);
    const fs::path odd = place.root() / "odd";
    fs::create_directories(odd / "folder.so");
    REQUIRE(mkfifo((odd / "fifo.so").c_str(), 0600) == 0);
    std::ofstream(odd / "text.so") << "I am a text, honestly, and long enough to be looked at for some time by a loader";
    fs::copy_file(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so", odd / "cut.so");
    fs::resize_file(odd / "cut.so", fs::file_size(odd / "cut.so") / 2);
    place.environment["FRESCO_PLUGIN_PATH"] += ":" + odd.string() + ":" + (place.root() / "nowhere").string();

    const Finished listed = place.run({"stages", "--all"});
    CHECK(listed.code == 0);
    for (const char* text :
         {"no license for today",
          "bad.cost: cost(): the stage has no option \"max_facez\"",
          "bad_exits.so",
          "ended the process with exit code 0",
          "bad_crashes.so",
          "Segmentation fault",
          "bad_channel.so",
          "wrote \"cache opened\" to descriptor 3, the host's channel, when an object of type bad.channel was made",
          "\"99\"",
          "0x12345678",
          "\"gcc 4\"",
          "fresco_plugin_info_1",
          "fresco_function_that_nobody_has",
          "folder.so",
          "a folder",
          "fifo.so",
          "a FIFO",
          "text.so",
          "does not begin as an ELF file",
          "cut.so",
          "is cut short",
          "nowhere",
          "test.source"})
        CHECK(contains(listed.out, text));

    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source}\n");
    CHECK(place.run({"run", "room.yaml"}).code == 0);
    place.write("bad.yaml", "version: 1\nstages:\n  bad: {type: bad.throws}\n");
    const Finished needed = place.run({"run", "bad.yaml"});
    CHECK((needed.code == 4 || needed.code == 2));
    CHECK(place.run({"doctor"}).code == 4);
}

TEST_CASE("A plugin that hangs is given up after five seconds, and remembered")
{
    Workplace place({"good", "bad/loops"}, true);
    const Finished first = place.run({"stages", "--all"});
    CHECK(first.code == 0);
    CHECK(first.seconds > 4);
    CHECK(contains(first.out, "did not return within 5 s when an object of type bad.loops was made"));
    const Finished second = place.run({"stages", "--all"});
    CHECK(second.seconds < 2);
    CHECK(contains(second.out, "did not return within 5 s"));
}

TEST_CASE("What is said of a library that is replaced meanwhile, as by a build, is not remembered")
{
    Workplace place({}, true);
    const fs::path plugins = place.root() / "plugins";
    fs::create_directories(plugins);
    place.environment["FRESCO_PLUGIN_PATH"] = plugins.string();
    const fs::path test_plugins = FRESCO_TEST_PLUGINS;
    fs::copy_file(test_plugins / "bad/loops/bad_loops.so", plugins / "one.so");
    fs::copy_file(test_plugins / "good/test_stages.so", plugins / "next");
    std::thread build(
        [&]
        {
            std::this_thread::sleep_for(std::chrono::seconds(2));
            fs::rename(plugins / "next", plugins / "one.so");
        });
    const Finished meanwhile = place.run({"stages", "--all"});
    build.join();
    CHECK(contains(meanwhile.out, "did not return within 5 s"));
    CHECK(contains(place.run({"stages"}).out, "test.source"));
}

TEST_CASE("Of a type that two libraries have, neither is used")
{
    Workplace place({"good", "bad/duplicate"});
    const Finished listed = place.run({"stages", "--all"});
    CHECK(contains(listed.out, "test_stages.so"));
    CHECK(contains(listed.out, "bad_duplicate.so"));
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source}\n");
    const Finished needed = place.run({"run", "room.yaml"});
    CHECK(needed.code == 4);
    CHECK(contains(needed.err, "bad_duplicate.so"));
    CHECK(contains(needed.err, "test_stages.so"));
    const Finished doctor = place.run({"doctor"});
    CHECK(doctor.code == 4);
    CHECK(contains(doctor.out, "not used, because several plugins have it: "));
    place.write("other.yaml", "version: 1\nstages:\n  other: {type: test.only_here}\n");
    CHECK(place.run({"run", "other.yaml"}).code == 0);
}

TEST_CASE("A folder of FRESCO_PLUGIN_PATH shadows the installation, and doctor says so")
{
    Workplace place;
    const fs::path installed = place.root() / "lib" / "fresco" / "installed.so";
    fs::create_directories(installed.parent_path());
    fs::copy_file(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so", installed);
    const fs::path built = fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so";
    const auto library = [&] {
        return fresco::parse_json(place.run({"describe", "--json", "test.source"}).out).at("library").as_string();
    };
    CHECK(library() == fs::canonical(built));
    const Finished doctor = place.run({"doctor"});
    CHECK(doctor.code == 0);
    CHECK(contains(doctor.out, "shadowed: test.source of " + fs::canonical(installed).string() + ", by "));
    CHECK(contains(place.run({"stages", "--all"}).out, "shadowed by another of the type:"));
    place.environment["FRESCO_PLUGIN_PATH"] = "";
    CHECK(library() == fs::canonical(installed));
}

TEST_CASE("A library that plugins link may lie beside them")
{
    Workplace place;
    const fs::path beside = place.root() / "beside";
    fs::create_directories(beside);
    std::ofstream(beside / "libclouds.so") << "an artifact type would be here: a library without fresco's entry point, or with";
    std::ofstream(beside / "clouds.so") << "no library, but named as a plugin is, and so refused with the reason";
    place.environment["FRESCO_PLUGIN_PATH"] += ":" + beside.string();
    const Finished listed = place.run({"stages", "--all"});
    CHECK(contains(listed.out, "/clouds.so: "));
    CHECK(listed.out.find("libclouds.so") == std::string::npos);
}

TEST_CASE("A plugin that was not built is named with the reason, until it is there")
{
    Workplace place({}, true);
    const fs::path folder = place.root() / "lib" / "fresco";
    fs::create_directories(folder);
    std::ofstream(folder / "plugins.txt") << "test_source\nloss_gram\ntest_in_the_tree: libtorch was not found\n";
    const auto errors = [&](const std::string& type)
    {
        place.write("room.yaml", "version: 1\nstages:\n  source: {type: " + type + "}\n");
        const Finished finished = place.run({"check", "room.yaml"});
        return std::to_string(finished.code) + " " + finished.err;
    };
    CHECK(contains(errors("test.source"),
                   "4 room.yaml:3:18: error: stage 'source': the plugin of 'test.source' is not built: run "
                   "./bootstrap build\n"));
    CHECK(
        contains(errors("test.in_the_tree"), "'test.in_the_tree' is not built (libtorch was not found): run ./bootstrap build"));
    CHECK(contains(errors("test.elsewhere"), "2 room.yaml:3:18: error: stage 'source': unknown type 'test.elsewhere'"));
    const Finished listed = place.run({"stages", "--all"});
    CHECK(contains(listed.out, "\n  loss.gram\n  test.in_the_tree: libtorch was not found\n"));
    const Finished doctor = place.run({"doctor"});
    CHECK(doctor.code == 0);
    CHECK(contains(doctor.out, "not built: test.in_the_tree: libtorch was not found\n"));
    CHECK(contains(place.run({"doctor", "--json"}).out, "\"unbuilt\": ["));

    // Of the same name, and another that has one of the listed types: the folder's own library is what counts, then the type.
    fs::copy_file(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so", folder / "elsewhere.so");
    CHECK(contains(errors("test.source"), "0 "));
    CHECK(place.run({"stages", "--all"}).out.find("test.source: ") == std::string::npos);
    std::ofstream(folder / "loss_gram.so") << "no library, but long enough to be looked at for some time by a loader of plugins";
    CHECK(contains(errors("loss.gram"), "does not begin as an ELF file"));
}

TEST_CASE("The same library reached by two paths is one library")
{
    Workplace place;
    fs::create_directories(place.root() / "links");
    fs::create_symlink(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so", place.root() / "links" / "again.so");
    place.environment["FRESCO_PLUGIN_PATH"] +=
        ":" + (place.root() / "links").string() + ":" + place.environment["FRESCO_PLUGIN_PATH"];
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source}\n");
    CHECK(place.run({"run", "room.yaml"}).code == 0);
}

TEST_CASE("Equal plugins of two installations are each described with the libraries beside them")
{
    Workplace place({}, true);
    const fs::path made = fs::path(FRESCO_TEST_PLUGINS) / "sided";
    for (const char* name : {"one", "other"})
    {
        const fs::path folder = place.root() / name;
        fs::create_directories(folder);
        for (const char* file : {"sided.so", "libside.so"})
            fs::copy_file(made / file, folder / file);
    }
    std::ofstream(place.root() / "other" / "libside.so", std::ios::app) << "another build";
    place.write("room.yaml", "version: 1\nstages:\n  side: {type: test.sided}\n");
    for (const char* name : {"one", "other", "one"})
    {
        CAPTURE(name);
        place.environment["FRESCO_PLUGIN_PATH"] = (place.root() / name).string();
        const Finished done = place.run({"run", "room.yaml", "--store", std::string("store of ") + name});
        CAPTURE(done.err);
        CHECK(done.code == 0);
    }
}

TEST_CASE("A library that the loader finds before another is seen")
{
    Workplace place({"good"}, true);
    const fs::path made = fs::path(FRESCO_TEST_PLUGINS) / "sided";
    for (const char* folder : {"plugins", "elsewhere"})
        fs::create_directories(place.root() / folder);
    fs::copy_file(made / "sided.so", place.root() / "plugins/sided.so");
    fs::copy_file(made / "libside.so", place.root() / "libside.so");
    std::string other = fresco::read_text_file(made / "libside.so", std::size_t{1} << 30U);
    constexpr double seven = 7;
    constexpr double nine = 9;
    const std::size_t at = other.find(std::string(reinterpret_cast<const char*>(&seven), sizeof seven));
    REQUIRE(at != std::string::npos);
    other.replace(at, sizeof nine, reinterpret_cast<const char*>(&nine), sizeof nine);
    place.environment["FRESCO_PLUGIN_PATH"] += ":" + (place.root() / "plugins").string();
    place.write("room.yaml",
                "version: 1\nstages:\n  side: {type: test.sided}\n  text: {type: test.sink, input: side, path: x}\n");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    REQUIRE(place.read("out/x") == "7.000000\n");
    const std::string usual = place.environment["LD_LIBRARY_PATH"];
    SECTION("in a folder that it searches earlier")
    {
        std::ofstream(place.root() / "plugins/libside.so") << other;
    }
    SECTION("by LD_LIBRARY_PATH")
    {
        std::ofstream(place.root() / "elsewhere/libside.so") << other;
        place.environment["LD_LIBRARY_PATH"] += ":" + (place.root() / "elsewhere").string();
    }
    CHECK(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x") == "9.000000\n");
    fs::remove(place.root() / "plugins/libside.so");
    place.environment["LD_LIBRARY_PATH"] = usual;
    CHECK(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x") == "7.000000\n");
}

TEST_CASE("A folder of FRESCO_PLUGIN_PATH without plugins is named where a type is unknown, and by doctor")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  room: {type: paint.walls}\n");
    const std::string usual = place.environment["FRESCO_PLUGIN_PATH"];
    const std::string nowhere = (place.root() / "nowhere").string();
    const std::string empty = (place.root() / "empty").string();
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
        CHECK(contains(checked.err, "warning: FRESCO_PLUGIN_PATH: " + nowhere + ": No such file or directory\n") ==
              (folder == nowhere));
        const Finished doctor = place.run({"doctor"});
        CHECK(doctor.code == 4);
        CHECK(contains(doctor.out, "refused: " + folder + ": " + reason));
        // It may be a typing error, too.
        place.write("near.yaml", "version: 1\nstages:\n  room: {type: test.sorce}\n");
        CHECK(contains(place.run({"check", "near.yaml"}).err, "'test.sorce' (did you mean 'test.source'?); " + folder));
    }
}

TEST_CASE("A folder that everybody may put plugins into gets a warning")
{
    Workplace place;
    const fs::path folder = place.root() / "good";
    fs::create_directory(folder);
    fs::copy_file(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so", folder / "test_stages.so");
    place.environment["FRESCO_PLUGIN_PATH"] = folder.string();
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source}\n");
    const std::string warning =
        "warning: " + folder.string() + ": every user may put plugins into this folder, and they run as you: chmod o-w ";
    for (const bool open : {false, true})
    {
        fs::permissions(folder, open ? fs::perms::all : fs::perms::owner_all);
        for (const char* command : {"run", "check", "doctor"})
        {
            const Finished finished = command == std::string("doctor") ? place.run({command}) : place.run({command, "room.yaml"});
            CHECK(finished.code == 0);
            CHECK(contains(finished.err, warning) == open);
        }
    }
}

TEST_CASE("Descriptions are remembered by contents and place: a changed, moved or otherwise linked library is asked again")
{
    Workplace place({}, true);
    const fs::path plugins = place.root() / "plugins";
    fs::create_directories(plugins);
    place.environment["FRESCO_PLUGIN_PATH"] = plugins.string();
    const auto cached = [&]
    {
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(place.root() / "home/cache/fresco/descriptors"))
            count += entry.path().filename() == "stamps.json" ? 0 : 1;
        return count;
    };
    fs::copy_file(fs::path(FRESCO_TEST_PLUGINS) / "good" / "test_stages.so", plugins / "one.so");
    REQUIRE(contains(place.run({"stages"}).out, "test.source"));
    CHECK(cached() == 1);
    fs::rename(plugins / "one.so", plugins / "other.so");
    CHECK(contains(place.run({"stages"}).out, "test.source"));
    CHECK(cached() == 2);
    CHECK(contains(place.run({"stages"}).out, "test.source"));
    CHECK(cached() == 2);
    std::ofstream(plugins / "other.so", std::ios::app) << "more";
    CHECK(contains(place.run({"stages"}).out, "test.source"));
    CHECK(cached() == 3);
}
