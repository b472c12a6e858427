#include "misdeeds.h"

#include <fresco/files_io.h>
#include <fresco/value.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <locale>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace
{

namespace fs = std::filesystem;

/// Ends the process badly where it ends by exit.
struct Aborting
{
    Aborting() = default;
    Aborting(const Aborting&) = delete;
    Aborting& operator=(const Aborting&) = delete;
    ~Aborting() { std::abort(); }
};

/// A comma in numbers, and points between thousands.
struct Comma : std::numpunct<char>
{
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
};

std::vector<fs::path> files_below(const fs::path& folder)
{
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
        if (entry->is_regular_file(error))
            files.push_back(entry->path());
    return files;
}

/// Changes a byte in the middle, where the size stays.
void spoil(const fs::path& file)
{
    std::error_code error;
    const auto size = fs::file_size(file, error);
    const int fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
    char byte = 0;
    if (fd < 0)
        return;
    if (!error && size > 0 && pread(fd, &byte, 1, static_cast<off_t>(size / 2)) == 1)
    {
        byte = static_cast<char>(byte ^ 1);
        (void)!pwrite(fd, &byte, 1, static_cast<off_t>(size / 2));
    }
    close(fd);
}

/// By its descriptor, so that the folder is followed to where it is published.
[[noreturn]] void keep_spoiling(int folder)
{
    for (;;)
        for (const fs::path& file : files_below("/proc/self/fd/" + std::to_string(folder)))
            spoil(file);
}

/// Everything in the store outside tmp/.
void spoil_others(const fs::path& store)
{
    for (const auto& entry : fs::directory_iterator(store))
        if (entry.path().filename() != "tmp")
            for (const fs::path& file : files_below(entry.path()))
                spoil(file);
}

/// In every folder that a stage is at work in, this one's too, and in the store.
void write_beside(const fs::path& store)
{
    for (const auto& entry : fs::directory_iterator(store / "tmp"))
        for (const char* name : {"output", "sum", "counted", ""})
            if (std::error_code error; fs::is_directory(entry.path() / name, error))
                for (const char* file : {"manifest.json", "left by another"})
                    std::ofstream(entry.path() / name / file) << "of another stage";
    for (const char* folder : {"objects", "keys", "stages", "checkpoints", "logs", "locks"})
        std::ofstream(store / folder / "left by another") << "of another stage";
}

/// Whatever the host has started, itself excepted.
void kill_others()
{
    const std::string host = std::to_string(getppid());
    std::ifstream children("/proc/" + host + "/task/" + host + "/children");
    for (pid_t child = 0; children >> child;)
        if (child != getpid())
            kill(child, SIGKILL);
}

/// Says over the host's channel that another stage's result is the one of this, and ends as if all was well.
[[noreturn]] void claim(const fs::path& store)
{
    for (const auto& entry : fs::directory_iterator(store / "objects"))
    {
        const std::string text = R"({"event": "done", "object": ")" + entry.path().filename().string() +
                                 R"(", "references": [], "stored": true, "seconds": 1, "memory_mb": 1, "disk_mb": 1})" + "\n";
        (void)send(3, text.data(), text.size(), MSG_NOSIGNAL);
    }
    std::_Exit(0);
}

void limit(int resource, rlim_t most)
{
    const rlimit both{most, most};
    setrlimit(static_cast<decltype(RLIMIT_NOFILE)>(resource), &both);
}

[[noreturn]] void stay_deaf()
{
    for (int number = 1; number < 32; ++number)
        (void)signal(number, SIG_IGN);
    for (;;)
        pause();
}

void block_signals()
{
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_SETMASK, &all, nullptr);
}

void print_binary()
{
    for (int i = 0; i < 100; ++i)
        for (int byte = 0; byte < 256; ++byte)
            std::putchar(byte);
    std::fflush(stdout);
}

}  // namespace

void leave_process(bool in_session)
{
    if (fork() != 0)
        return;
    if (in_session && (setsid() < 0 || fork() != 0))
        std::_Exit(0);
    for (;;)
        pause();
}

void do_misdeed(const std::string& how, const fs::path& output)
{
    const fs::path store = output.parent_path().parent_path().parent_path();
    if (how == "print_binary")
        print_binary();
    if (how == "fork")
        (void)!fork();
    if (how == "spoil_by_child" || how == "spoil_by_thread")
    {
        const int folder = open(output.c_str(), O_RDONLY | O_DIRECTORY);
        if (how == "spoil_by_thread")
            std::thread(keep_spoiling, folder).detach();
        else if (fork() == 0)
            keep_spoiling(folder);
    }
    if (how == "spoil_others")
        spoil_others(store);
    if (how == "write_beside")
        write_beside(store);
    if (how == "crash_and_leave")
    {
        leave_process(true);
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        (void)std::raise(SIGSEGV);
    }
    if (how == "kill_others")
        kill_others();
    if (how == "claim")
        claim(store);
    if (how == "deaf")
        stay_deaf();
    if (how == "close_all")
        close_range(0, ~0U, 0);
    if (how == "block_signals")
        block_signals();
    if (how == "few_files")
        limit(RLIMIT_NOFILE, 4);
    if (how == "no_room")
        limit(RLIMIT_FSIZE, 10);
    if (how == "umask")
        umask(0777);
    if (how == "move_away")
        fs::current_path("/");
    if (how == "locale")
        std::locale::global(std::locale(std::locale(), std::make_unique<Comma>().release()));
    if (how == "environment")
        clearenv();
    if (how == "end_by_exit")
    {
        static const Aborting at_exit;
        std::exit(0);
    }
}

void misbehave_at_start()
{
    const char* const variable = std::getenv("MISBEHAVE_AT_START");
    const std::string_view how = variable != nullptr ? variable : "";
    if (how == "throw_int")
        throw 7;
    if (how == "fork")
        (void)!fork();
    if (how == "leave_session")
        leave_process(true);
    if (how == "leave_and_crash")
    {
        leave_process(true);
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        (void)std::raise(SIGSEGV);
    }
    if (how == "allocate")
        (void)std::vector<char>(std::size_t{10} << 30U, 'x');
    if (how == "print")
        for (int i = 0; i < 1 << 14; ++i)
            std::puts(std::string(std::size_t{1} << 12U, 'x').c_str());
    if (how == "close_all")
        close_range(0, ~0U, 0);
    if (how == "exit_later")
    {
        static const Aborting at_exit;
        std::exit(0);
    }
    if (how == "sleep")
        stay_deaf();
    if (how == "umask")
        umask(0777);
}
