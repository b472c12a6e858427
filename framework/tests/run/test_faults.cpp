#include "program.h"

#include "store/store.h"

#include <cerrno>

// What an attacker, a failing disk and a strange machine do to a run.

namespace
{

constexpr const char* chain = R"(version: 1
stages:
  source: {type: test.source, file: extra, value: 0, log: log}
  add:    {type: test.add, input: {left: source}, plus: 1, log: log}
  text:   {type: test.sink, input: add, path: x.txt, log: log}
)";

/// A workplace where the chain has run.
struct ChainPlace : Workplace
{
    explicit ChainPlace(bool own_cache = false) : Workplace({"good"}, own_cache)
    {
        write("extra", "123");
        write("room.yaml", chain);
        REQUIRE(run({"run", "room.yaml"}).code == 0);
        REQUIRE(read("out/x.txt") == "4.000000\n");
        clear_log();
    }
};

std::vector<fs::path> files_in(const fs::path& folder)
{
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

void flip(const fs::path& file, std::size_t at)
{
    std::string text = fresco::read_text_file(file);
    text[at] = static_cast<char>(text[at] ^ 1);
    std::ofstream(file) << text;
}

/// Commands in a shell; the program is $F.
[[maybe_unused]] Finished in_shell(const Workplace& place, const std::string& commands)
{
    std::string script = "ulimit -c 0\nF='" + (place.root() / "bin/fresco").string() + "'\ncd '" + place.work().string() + "'\n";
    for (const auto& [name, value] : place.environment)
        script += "export " + name + "='" + value + "'\n";
    const fs::path file = place.root() / "script";
    fresco::write_file(file, script + commands + "\n");
    const std::string line = "bash '" + file.string() + "' >'" + file.string() + ".out' 2>'" + file.string() + ".err'";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), fresco::read_text_file(file.string() + ".out"),
            fresco::read_text_file(file.string() + ".err"), 0};
}

}  // namespace

TEST_CASE("Exports touch neither the user's files next to them nor each other's")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source}
  one:    {type: test.sink, input: source, path: a}
  two:    {type: test.sink, input: source, path: a.tmp}
  three:  {type: test.sink, input: source, path: b}
)");
    place.write("out/b.tmp", "mine");
    place.write("out/run.json.tmp", "mine");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/a") == "1.000000\n");
    CHECK(place.read("out/a.tmp") == "1.000000\n");
    CHECK(place.read("out/b.tmp") == "mine");
    CHECK(place.read("out/run.json.tmp") == "mine");
#ifndef __SANITIZE_ADDRESS__
    // The same on a file system without files that have no name.
    place.environment["LD_PRELOAD"] = (fs::path(FRESCO_TEST_PLUGINS) / "lacking/lacking.so").string();
    place.environment["LACKING_TMPFILE"] = "1";
    REQUIRE(place.run({"run", "room.yaml", "--set", "source.value=2"}).code == 0);
    CHECK(place.read("out/a") == "2.000000\n");
    CHECK(place.read("out/b.tmp") == "mine");
    for (const auto& file : files_in(place.file("out")))
        CHECK(!file.filename().string().starts_with(fresco::temporary_file_prefix));
#endif
}

TEST_CASE("A plugin of other bytes under the old size and time is seen")
{
    Workplace place({"good"}, true);
    const fs::path plugins = place.root() / "plugins";
    fs::create_directory(plugins);
    const fs::path library = plugins / "test_stages.so";
    fs::copy_file(fs::path(FRESCO_TEST_PLUGINS) / "good/test_stages.so", library);
    const auto time = fs::file_time_type::clock::now() - std::chrono::hours(5);
    fs::last_write_time(library, time);
    place.environment["FRESCO_PLUGIN_PATH"] = plugins.string();
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source, log: log}\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.log().size() == 1);
    std::string bytes = fresco::read_text_file(library, std::size_t{1} << 30U);
    const std::size_t help = bytes.find("A number from options and files");
    REQUIRE(help != std::string::npos);
    bytes[help] = 'B';
    {
        std::fstream stream(library, std::ios::in | std::ios::out | std::ios::binary);
        stream << bytes;
    }
    fs::last_write_time(library, time);
    const Finished finished = place.run({"run", "room.yaml"});
    INFO(finished.err);
    CHECK(finished.code == 0);
    CHECK(place.log().size() == 2);
}

TEST_CASE("Damage to any file beside the results costs work at most")
{
    ChainPlace place(true);
    // Hashes are only kept of files that have rested for a while.
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    std::vector<fs::path> files = files_in(place.root() / "home/cache");
    for (const char* folder : {"keys", "stages", "locks"})
        for (const auto& file : files_in(place.file(std::string(".fresco/") + folder)))
            files.push_back(file);
    for (const char* file : {"format", "files.jsonl", "stats.jsonl"})
        files.push_back(place.file(std::string(".fresco/") + file));
    REQUIRE(files.size() > 10);
    for (const auto& file : files)
    {
        INFO(file);
        const std::string whole = fresco::read_text_file(file);
        for (const std::size_t part : {std::size_t{8}, std::size_t{3}, std::size_t{2}, std::size_t{1}})
        {
            if (whole.empty())
                continue;
            flip(file, whole.size() - 1 - whole.size() / (part + 1));
            const Finished finished = place.run({"run", "room.yaml"});
            INFO(finished.err);
            REQUIRE(finished.code == 0);
            CHECK(place.read("out/x.txt") == "4.000000\n");
            CHECK(place.log().empty());
            std::ofstream(file) << whole;
        }
        std::ofstream(file) << "";
        CHECK(place.run({"run", "room.yaml"}).code == 0);
        CHECK(place.log().empty());
    }
}

TEST_CASE("Without a home nothing is written to the working directory")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source}\n");
    place.write("stamps.json", "mine");
    place.environment["HOME"] = "";
    place.environment["XDG_CACHE_HOME"] = "";
    place.environment["XDG_DATA_HOME"] = "";
    CHECK(place.run({"check", "room.yaml"}).code == 0);
    CHECK(place.read("stamps.json") == "mine");
    CHECK(files_in(place.work()).size() == 2);
}

TEST_CASE("A path remembered by another pipeline is nobody's business")
{
    Workplace place;
    place.write("elsewhere/a.number", "3");
    place.write("one.yaml", "version: 1\nstages:\n  sum: {type: test.add, input: {left: {file: elsewhere/a.number}}}\n");
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source}\n  text: {type: test.sink, input: source}\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
    REQUIRE(place.run({"run", "one.yaml"}).code == 0);
    fs::remove_all(place.file("elsewhere"));
    fs::create_symlink(place.file("elsewhere"), place.file("elsewhere"));
    const Finished finished = place.run({"run", "room.yaml"});
    INFO(finished.err);
    CHECK(finished.code == 0);
}

TEST_CASE("A run that waits for a clean-up says so and can be stopped")
{
    ChainPlace place;
    fresco::host::FileLock lock(place.file(".fresco/locks/store"));
    REQUIRE(lock.try_exclusive());
    const auto run = place.start({"run", "room.yaml"});
    Workplace::wait_until(
        [&]
        {
            const fs::path err = place.root() / "err2";
            return fs::exists(err) && fresco::read_text_file(err).find("store gc") != std::string::npos;
        });
    SECTION("it ends")
    {
        lock = fresco::host::FileLock();
        CHECK(run->wait().code == 0);
    }
    SECTION("the user gives up")
    {
        run->signal(SIGINT);
        const Finished finished = run->wait();
        CHECK(finished.code == 75);
        CHECK(finished.seconds < 5);
    }
}

TEST_CASE("A terminal that hangs up ends a run in order")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 1000, step_ms: 20, log: log}\n");
    const auto run = place.start({"run", "room.yaml"});
    Workplace::wait_until([&] { return !place.log().empty(); });
    run->signal(SIGHUP);
    CHECK(run->wait().code == 75);
    CHECK(place.log().back() == "slow was stopped");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("A file system without locks is refused at once")
{
    Workplace place;
    place.write("room.yaml", chain);
    place.write("extra", "123");
    place.environment["LD_PRELOAD"] = (fs::path(FRESCO_TEST_PLUGINS) / "lacking/lacking.so").string();
    for (const int number : {ENOSYS, ENOLCK, EOPNOTSUPP})
    {
        place.environment["LACKING_FLOCK"] = std::to_string(number);
        for (const std::string command : {"run", "store"})
        {
            const Finished finished = command == "run" ? place.run({"run", "room.yaml"}) : place.run({"store", "gc"});
            CHECK(finished.code == 1);
            CHECK(finished.seconds < 5);
            CHECK(contains(finished.err, ".fresco: cannot be locked"));
            CHECK(contains(finished.err, "--store"));
        }
    }
}

TEST_CASE("Locks that everybody gets, or that nobody comes back from, are refused by name within five seconds")
{
    Workplace place;
    place.write("room.yaml", chain);
    place.write("extra", "123");
    place.environment["LD_PRELOAD"] = (fs::path(FRESCO_TEST_PLUGINS) / "lacking/lacking.so").string();
    const std::string how = GENERATE("granted", "blocks");
    place.environment["LACKING_FLOCK"] = how;
    const Finished finished = place.run({"run", "room.yaml"});
    CHECK(finished.code == 1);
    CHECK(finished.seconds < 5);
    CHECK(contains(finished.err, how == "granted" ? "was locked twice at once" : "flock did not return within 3 seconds"));
    CHECK(contains(finished.err, "--store"));
    CHECK(place.log().empty());
    CHECK(fs::is_empty(place.file(".fresco/runs")));
    CHECK(fs::is_empty(place.file(".fresco/tmp")));
}

TEST_CASE("With few descriptors stages wait for each other")
{
    Workplace place;
    std::string text = "version: 1\nstages:\n";
    for (int i = 0; i < 32; ++i)
        text += "  s" + std::to_string(i) + ": {type: test.source, value: " + std::to_string(i) + ", wait_ms: 200, log: log}\n";
    place.write("room.yaml", text);
    // How many are left over when no further stage fits depends on those inherited.
    const std::string inherited = GENERATE("", "exec 7</dev/null; ", "exec 7</dev/null 8</dev/null; ");
    const Finished finished = in_shell(place, inherited + "ulimit -n 64; $F run room.yaml --cores 32");
    INFO(inherited << finished.err);
    CHECK(finished.code == 0);
    CHECK(place.log().size() == 32);
}

TEST_CASE("What the machine refuses is not called a bug")
{
    Workplace place;
    place.write("extra", "123");
    place.write("room.yaml", chain);
    const auto refused = [&](const std::string& commands, const std::string& words)
    {
        const Finished finished = in_shell(place, commands);
        INFO(commands << ": " << finished.err);
        CHECK(finished.code == 1);
        CHECK(contains(finished.err, words));
        CHECK(finished.err.find("bug") == std::string::npos);
        CHECK(finished.err.find("author") == std::string::npos);
    };
    refused("mkdir gone; cd gone; rmdir ../gone; $F run ../room.yaml", "current path");
    refused("$F check room.yaml; ulimit -n 8; $F run room.yaml", "ulimit -n");
    refused("$F check room.yaml; ulimit -d 1000; $F run room.yaml", "memory");
}

TEST_CASE("A limit on memory that lets no plugin in is named")
{
    Workplace place({"huge"}, true);
    const Finished finished = in_shell(place, "ulimit -v 1024000; $F stages --all");
    INFO(finished.out);
    CHECK(contains(finished.out,
                   "huge.so: cannot be loaded: there is not enough memory for it: raise the limit of 1000 MB (ulimit -v)"));
    CHECK(contains(in_shell(place, "$F stages --all").out, "huge.so: has no symbol"));
}
#endif

TEST_CASE("A full temporary folder is not called a full store")
{
    Workplace place({"misbehaving"});
    place.environment["TMPDIR"] = place.root().string() + "/";
    place.write("room.yaml", "version: 1\nstages:\n  bad: {type: test.misbehave, how: full_scratch}\n");
    const Finished finished = place.run({"run", "room.yaml"});
    INFO(finished.err);
    CHECK(finished.code == 1);
    CHECK(contains(finished.err, "No space left on device: free some space in " + place.root().string() +
                                     "/, or set TMPDIR to another folder; nothing was lost"));
    CHECK_FALSE(contains(finished.err, "--store"));
}

TEST_CASE("A path that is not UTF-8 is shown by its bytes")
{
    Workplace place;
    place.write("caf\xe9.number", "3");
    place.write("room.yaml",
                "version: 1\nvars: {file: a.number}\nstages:\n  sum: {type: test.add, input: {left: {file: \"${file}\"}}}\n");
    const Finished finished = place.run({"run", "room.yaml", "--set", "file=caf\xe9.number"});
    CHECK(finished.code == 3);
    CHECK(contains(finished.err, "caf\\xe9.number': the name is not UTF-8"));
}
