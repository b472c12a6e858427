#include "store/presence.h"
#include "base/common.h"
#include "base/process.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <fcntl.h>
#include <map>
#include <optional>
#include <sys/stat.h>
#include <thread>

namespace fresco::host
{

namespace
{

using Clock = std::chrono::steady_clock;
constexpr auto beat_period = std::chrono::seconds(1);
/// As long as another machine's process is watched. A network file system's times are up to date when a file is opened.
constexpr auto watch_time = std::chrono::seconds(4);
/// Older beats are of processes that have ended, or that stand still.
constexpr std::int64_t recent_ns = 30'000'000'000;
/// After that, a process of another machine that holds no lock has ended.
constexpr std::int64_t ended_ns = 600'000'000'000;

/// By the file server's clock, as it is now; nothing if the file is gone.
std::optional<std::int64_t> last_beat(const fs::path& file)
{
    // Opened, not only looked at: network file systems are up to date then.
    const FileDescriptor fd = is_file(file) ? open_file(file, O_RDONLY) : FileDescriptor();
    struct stat status = {};
    if (!fd.valid() || fstat(fd.get(), &status) != 0)
        return std::nullopt;
    return std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
}

bool can_be_locked(const fs::path& file)
{
    // Shared: those who try at once do not take each other for the owner.
    return is_file(file) && FileLock(file).try_shared();
}

/// The processes of other machines that beat lately and whose locks this machine gets. Empty where one is locked against this
/// machine: then all locks are. Removes the files of those that have ended.
std::map<fs::path, std::int64_t> unlocked_strangers(const Store& store, const fs::path& own)
{
    std::map<fs::path, std::int64_t> strangers;
    const std::int64_t now = last_beat(own).value_or(0);
    bool locks_hold = false;
    for (const fs::path& file : entries_of(store.root() / "runs"))
    {
        const auto process = process_named_by(file.filename().string());
        if (file == own || !process)
            continue;
        if (process->is_on_this_machine())
        {
            if (!process->is_running())
                remove_quietly(file);
            continue;
        }
        const auto beat = last_beat(file);
        if (!beat || locks_hold)
            continue;
        if (!can_be_locked(file))
            locks_hold = true;
        else if (now - *beat > ended_ns)
            remove_quietly(file);
        else if (now - *beat < recent_ns)
            strangers.emplace(file, *beat);
    }
    return locks_hold ? std::map<fs::path, std::int64_t>{} : strangers;
}

void check_locks(const Store& store)
{
    const WorkFolder folder(store);
    if (const std::string problem = broken_lock(folder.path() / "lock"); !problem.empty())
        throw Error(store.root().string() + ": " + problem);
}

void check_locks_between_machines(const Store& store, const fs::path& own)
{
    auto strangers = unlocked_strangers(store, own);
    for (const auto end = Clock::now() + watch_time; !strangers.empty() && Clock::now() < end;)
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        for (auto stranger = strangers.begin(); stranger != strangers.end();)
        {
            const auto& [file, beat] = *stranger;
            const auto now = last_beat(file);
            if (now && !can_be_locked(file))
                return;
            if (now && *now != beat)
                throw Error(store.root().string() + ": its locks hold only on one machine: " + FileLock::holder_of(file) +
                            " is at work in it, and its lock " + file.string() +
                            " is free on this one: mount the file system with locks across machines (NFS: without nolock and "
                            "local_lock), or choose another store with --store");
            stranger = now ? std::next(stranger) : strangers.erase(stranger);
        }
    }
}

}  // namespace

Presence::Presence(const Store& store) : file_(store.root() / "runs" / this_process().text())
{
    check_locks(store);
    try
    {
        lock_ = FileLock(file_);
        // Others may be trying.
        if (!lock_.try_exclusive_for(std::chrono::seconds(2)))
            throw Error(file_.string() + ": cannot be locked: another process holds it; remove the file");
        lock_.sign();
        next_beat_ = Clock::now() + beat_period;
        check_locks_between_machines(store, file_);
    }
    catch (...)
    {
        remove_quietly(file_);
        throw;
    }
}

Presence::~Presence()
{
    remove_quietly(file_);
}

void Presence::beat()
{
    if (Clock::now() < next_beat_)
        return;
    next_beat_ = Clock::now() + beat_period;
    // By the file server's clock.
    futimens(lock_.descriptor(), nullptr);
}

std::string present_processes(const Store& store)
{
    std::string text;
    const fs::path own = store.root() / "runs" / this_process().text();
    for (const fs::path& file : entries_of(store.root() / "runs"))
        if (const std::string holder = file == own ? "" : FileLock::holder_of(file); !holder.empty())
            text += (text.empty() ? "" : "; ") + holder;
    return text;
}

std::vector<fs::path> abandoned_temporaries(const Store& store)
{
    std::vector<fs::path> abandoned;
    for (const fs::path& path : entries_of(store.root() / "tmp"))
    {
        const auto process = process_named_by(path.filename().string());
        if (process &&
            !(process->is_on_this_machine() ? process->is_running() : is_file(store.root() / "runs" / process->text())))
            abandoned.push_back(path);
    }
    return abandoned;
}

StoreUse::StoreUse(const Store& store, const Store* lender) : store_(store), presence_(store), lock_(store_lock(store))
{
    // Without the lock, what is copied from there is still verified.
    if (lender != nullptr && attempt([&] { lender_lock_ = store_lock(*lender); }))
        attempt([&] { lender_lock_.try_shared(); });
}

bool StoreUse::try_enter()
{
    if (lock_.try_exclusive())
        for (const auto& path : abandoned_temporaries(store_))
            remove_quietly(path);
    return lock_.try_shared();
}

std::string StoreUse::tidier() const
{
    return FileLock::holder_of(store_.lock_file("store"));
}

}  // namespace fresco::host
