#include "store_samples.h"

#include <cstdio>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

using namespace fresco::host;

namespace
{

/// Synced and renamed files, in order. Null: not recorded.
std::vector<std::string>* calls = nullptr;

void note(const std::string& call, const fs::path& path)
{
    if (calls != nullptr)
        calls->push_back(call + " " + path.string());
}

fs::path path_of(int fd)
{
    return fs::read_symlink("/proc/self/fd/" + std::to_string(fd));
}

}  // namespace

// In the C library's place, also for the SDK's library.
extern "C" int fsync(int fd)
{
    note("sync", path_of(fd));
    return static_cast<int>(syscall(SYS_fsync, fd));
}

extern "C" int syncfs(int fd) noexcept
{
    note("sync all with", path_of(fd));
    return static_cast<int>(syscall(SYS_syncfs, fd));
}

extern "C" int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept
{
    note("name", to_folder == AT_FDCWD ? fs::path(to) : path_of(to_folder) / to);
    return static_cast<int>(syscall(SYS_renameat, from_folder, from, to_folder, to));
}

TEST_CASE("What is published is on the disk before a record names it")
{
    const OwnStore store;
    const bool many = GENERATE(false, true);
    const fs::path made = store.make_temporary();
    for (int i = 0; i < (many ? 65 : 1); ++i)
        write(made / "out" / std::to_string(i), "1");
    std::vector<std::string> found;
    calls = &found;
    const StoredResult result = publish(store, made, {"key", {"out"}, {}, fresco::Value::Map{}});
    calls = nullptr;
    for (std::string& call : found)
    {
        for (const auto& [part, by] : {std::pair<std::string, const char*>{made.string(), "NEW"},
                                       {store.root().string() + "/", ""},
                                       {result.object, "ID"}})
            if (const std::size_t at = call.find(part); at != std::string::npos)
                call.replace(at, part.size(), by);
        // A file that is being written: it has no name yet, or a random one.
        if (call.ends_with(" (deleted)") || call.find(fresco::temporary_file_prefix) != std::string::npos)
            call = call.substr(0, call.rfind('/')) + "/DRAFT";
    }
    std::vector<std::string> expected{"sync NEW/out/0", "sync NEW/out", "sync NEW"};
    if (many)
        expected = {"sync all with NEW"};
    for (const char* call : {"name objects/ID", "sync objects", "sync keys/DRAFT", "name keys/key.json", "sync keys",
                             "sync objects/ID/DRAFT", "name objects/ID/manifest.json", "sync objects/ID"})
        expected.emplace_back(call);
    CHECK(found == expected);
}
