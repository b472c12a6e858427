#include "program.h"

#include "store/store.h"

#include <cerrno>
#include <unistd.h>

// Runs on strange machines and with strange names. Damage: prove_corruption; calls that fail: prove_failing_calls.

namespace
{

std::vector<std::string> names_below(const fs::path& folder)
{
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        names.push_back(entry.path().filename());
    return names;
}

}  // namespace

TEST_CASE("Exports touch neither the user's files next to them nor each other's")
{
    RoomPlace place(R"(
  source: {type: test.source}
  one:    {type: test.sink, input: source, path: a}
  two:    {type: test.sink, input: source, path: a.tmp}
  three:  {type: test.sink, input: source, path: b}
)");
    place.write("out/b.tmp", "mine");
    place.write("out/run.json.tmp", "mine");
    place.make();
#ifndef __SANITIZE_ADDRESS__
    // Some file systems have no unnamed files.
    CHECK(place.read("out/a") == "1.000000\n");
    place.environment["LD_PRELOAD"] = test_plugin("lacking/lacking.so");
    place.environment["LACKING_TMPFILE"] = "1";
    place.make({"--set", "source.value=2"});
    CHECK(place.read("out/a") == "2.000000\n");
    for (const std::string& name : names_below(place.file("out")))
        CHECK((name == ".fresco-outputs" || !name.starts_with(fresco::temporary_file_prefix)));
#endif
    CHECK(place.read("out/a.tmp") == place.read("out/a"));
    CHECK(place.read("out/b.tmp") == "mine");
    CHECK(place.read("out/run.json.tmp") == "mine");
}

TEST_CASE("Without a home nothing is written to the working directory")
{
    RoomPlace place("\n  source: {type: test.source}\n");
    for (const char* name : {"HOME", "XDG_DATA_HOME"})
        place.environment[name] = "";
    place.environment["TMPDIR"] = place.root();
    CHECK(place.run({"check", "room.yaml"}).code == 0);
    CHECK(names_below(place.work()) == Words{"room.yaml"});
}

TEST_CASE("A run that waits for a clean-up says so and can be stopped")
{
    RoomPlace place;
    place.make();
    fresco::host::FileLock lock(place.file(".fresco/locks/store"));
    REQUIRE(lock.try_exclusive());
    const auto run = place.start({"run", "room.yaml"});
    wait_until([&] { return run->says("store gc"); });
    const bool gives_up = GENERATE(false, true);
    if (gives_up)
        run->signal(SIGINT);
    else
        lock = fresco::host::FileLock();
    CHECK(run->wait().code == (gives_up ? 75 : 0));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("A clean-up needs no room for another file, and nothing but locks is called a lack of locks")
{
    RoomPlace place;
    place.make();
    place.make({"--set", "source.value=2"});
    REQUIRE(place.objects().size() == 6);
    place.environment["LD_PRELOAD"] = test_plugin("lacking/lacking.so");
    place.environment["LACKING_INODES"] = "1";
    const Finished finished = place.run({"run", "room.yaml"}, 1);
    CHECK(contains(finished.err, "No space left on device"));
    CHECK_FALSE(contains(finished.err, "locks"));
    place.run({"store", "gc", "--keep-days", "0"}, 0);
    CHECK(place.objects().size() == 3);
}

TEST_CASE("A file system without locks, permissions, or all characters in names is an error that says what to do")
{
    RoomPlace place;
    const auto [lack, words] = GENERATE(table<std::string, std::string>(
        {{"LACKING_FLOCK", "locks/store: cannot be locked: Function not implemented"},
         {"LACKING_PERMISSIONS", "permissions cannot be set: Operation not permitted; choose a store on another file system with "
                                 "--store"},
         {"LACKING_CHARACTERS", "a:b.txt: cannot be written: Invalid argument: this file system takes no ':' in names"}}));
    place.environment["LD_PRELOAD"] = test_plugin("lacking/lacking.so");
    place.environment[lack] = "1";
    CHECK(contains(place.run({"run", "room.yaml", "--set", "text.path=a:b.txt"}, 1).err, words));
}

TEST_CASE("What the machine refuses is not called a bug")
{
    RoomPlace place;
    const auto [commands, words] =
        GENERATE(table<std::string, std::string>({{"mkdir gone; cd gone; rmdir ../gone; $F run ../room.yaml", "current path"},
                                                  {"$F check room.yaml; ulimit -n 8; $F run room.yaml", "Too many open files"},
                                                  {"$F check room.yaml; ulimit -d 1000; $F run room.yaml", "memory"}}));
    const Finished finished = place.in_shell(commands);
    INFO(commands << ": " << finished.err);
    CHECK(finished.code == 1);
    CHECK(contains(finished.err, words));
    CHECK(finished.err.find("bug") == std::string::npos);
    CHECK(finished.err.find("author") == std::string::npos);
}
#endif

TEST_CASE("A full temporary folder is not called a full store; a stage that cannot start a thread has failed by the limit")
{
    RoomPlace place("\n  bad: {type: test.misbehave}\n", {"misbehaving"});
    place.environment["TMPDIR"] = place.root();
    const std::string full = "free some space in " + place.root().string() + ", or set TMPDIR to another folder";
    const char* const limit = "raise the limit (ulimit -u)";
    for (const auto& [how, words] : {std::pair<std::string, std::string>{"full_scratch", full},
                                     {"interrupt_itself", limit},
                                     {"say_no_thread", limit},
                                     {"throw_no_thread", limit}})
    {
        const Finished finished = place.run({"run", "room.yaml", "--set", "bad.how=" + how}, 1);
        CHECK(contains(finished.err, words));
        CHECK_FALSE(contains(finished.err, "report it to the author"));
    }
}
