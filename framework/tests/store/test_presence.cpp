#include "store_samples.h"

#include "base/process.h"
#include "store/presence.h"
#include "store/store_tidy.h"
#include <fresco/error.h>

#include <atomic>

using namespace fresco::host;
using fresco::testing::TemporaryFolder;

namespace
{

/// A process of another machine.
const std::string stranger = "0123456789ab-4711-123456";

fs::path sign_as_stranger(const Store& store)
{
    const fs::path file = store.root() / "runs" / stranger;
    write(file, "process 4711 on kitchen, since 2026-11-23 13:05:10\n");
    return file;
}

/// Touches a file several times a second.
class Beating
{
  public:
    explicit Beating(fs::path file) : file_(std::move(file)), thread_([this] { beat(); }) {}
    ~Beating()
    {
        ended_ = true;
        thread_.join();
    }
    Beating(const Beating&) = delete;
    Beating& operator=(const Beating&) = delete;

  private:
    void beat() const
    {
        for (; !ended_; std::this_thread::sleep_for(std::chrono::milliseconds(300)))
            touch(file_, 0);
    }

    fs::path file_;
    std::atomic<bool> ended_{false};
    std::thread thread_;
};

double seconds_since(std::chrono::steady_clock::time_point begin)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

TEST_CASE("A process is identified by the name of its file")
{
    const ProcessIdentity own = this_process();
    CHECK(own.is_on_this_machine());
    CHECK(own.is_running());
    for (const std::string end : {"", ".0123", "-x"})
    {
        const auto read = process_named_by(own.text() + end);
        REQUIRE(read);
        CHECK(read->text() == own.text());
    }
    CHECK_FALSE(process_named_by(stranger)->is_on_this_machine());
    for (const char* name : {"", "run.0123", "0123456789ab", "0123456789ab-", "0123456789ab-1", "0123456789ab-1-",
                             "0123456789ab-0-1", "0123456789ab-1-1x", "0123456789abc-1-1"})
        CHECK_FALSE(process_named_by(name));
    ProcessIdentity earlier = own;
    ++earlier.start;
    CHECK_FALSE(earlier.is_running());
}

TEST_CASE("A process of another machine that goes on although its lock is free here is named, and the store refused")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    const fs::path file = sign_as_stranger(store);
    const auto begin = std::chrono::steady_clock::now();
    SECTION("its lock is free")
    {
        const Beating beating(file);
        CHECK_THROWS_WITH(Presence(store), Catch::Contains("hold only on one machine") &&
                                               Catch::Contains("process 4711 on kitchen, since 2026-11-23 13:05:10") &&
                                               Catch::Contains("--store"));
        CHECK(names_in(store.root() / "runs") == std::vector<std::string>{stranger});
    }
    SECTION("its lock holds")
    {
        FileLock lock(file);
        REQUIRE(lock.try_exclusive());
        const Beating beating(file);
        const Presence presence(store);
        CHECK(contains(present_processes(store), "process 4711 on kitchen"));
        CHECK(seconds_since(begin) < 1);
    }
    SECTION("it has ended just now")
    {
        const Presence presence(store);
        CHECK(fs::exists(file));
    }
    SECTION("it has ended long ago")
    {
        touch(file, 1);
        const Presence presence(store);
        CHECK(names_in(store.root() / "runs") == std::vector<std::string>{this_process().text()});
        CHECK(seconds_since(begin) < 1);
    }
    CHECK(seconds_since(begin) < 5);
}

TEST_CASE("Temporary folders are left to processes of other machines")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    ProcessIdentity ended = this_process();
    ++ended.start;
    const auto make = [&](const std::string& name) { fs::create_directory(store.root() / "tmp" / name); };
    for (const std::string& name :
         {stranger + ".01", ended.text() + ".02", this_process().text() + ".03", std::string("other.04")})
        make(name);
    const auto abandoned = [&]
    {
        std::set<std::string> names;
        for (const auto& path : abandoned_temporaries(store))
            names.insert(path.filename().string());
        return names;
    };
    const std::set<std::string> own{ended.text() + ".02"};
    const fs::path file = sign_as_stranger(store);
    fs::last_write_time(file, fs::last_write_time(file) - std::chrono::minutes(5));
    CHECK(abandoned() == own);
    tidy_store(store, 0, false);
    // What no process of fresco's can have made is somebody else's.
    CHECK(names_in(store.root() / "tmp").size() == 3);
    fs::remove(file);
    CHECK(abandoned() == std::set<std::string>{stranger + ".01"});
}
