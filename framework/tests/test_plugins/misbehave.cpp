// A stage that does, on purpose, what no stage should: by its option, and in its constructor by the environment.
#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/stage.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <functional>
#include <locale>
#include <map>
#include <memory>
#include <string>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

namespace
{

namespace fs = std::filesystem;

/// A comma in numbers, and points between thousands.
struct Comma : std::numpunct<char>
{
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
};

/// Neither inlined nor turned into a loop: every call needs its room.
__attribute__((noinline)) int endless(volatile char* above)
{
    volatile char room[4096];
    room[0] = above == nullptr ? '0' : *above;
    return endless(room) + room[0];
}

/// Uses memory until none is left.
[[noreturn]] void take_all_memory()
{
    constexpr std::size_t size = std::size_t{4} << 20U;
    for (;;)
        if (void* const block = std::malloc(size))
            std::memset(block, 'x', size);
        else
            pause();
}

void tell(const std::string& text)
{
    (void)send(3, text.data(), text.size(), MSG_NOSIGNAL);
}

void tell_done(const std::string& object, const char* stored)
{
    tell(R"({"event": "done", "object": ")" + object + R"(", "references": [], "stored": )" + stored +
         R"(, "seconds": 1, "memory_mb": 1, "disk_mb": 1})" + "\n");
}

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
    const auto middle = static_cast<off_t>(fs::file_size(file, error) / 2);
    const int fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
    char byte = 0;
    if (!error && pread(fd, &byte, 1, middle) == 1)
    {
        byte = static_cast<char>(byte ^ 1);
        (void)!pwrite(fd, &byte, 1, middle);
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

/// A process that never ends: in a session of its own, the grandchild of a process that has ended, as services start.
void leave_process()
{
    if (fork() != 0)
        return;
    if (setsid() < 0 || fork() != 0)
        std::_Exit(0);
    for (;;)
        pause();
}

[[noreturn]] void stay_deaf()
{
    for (int number = 1; number < 32; ++number)
        (void)signal(number, SIG_IGN);
    for (;;)
        pause();
}

void limit(int resource, rlim_t most)
{
    const rlimit both{most, most};
    setrlimit(static_cast<decltype(RLIMIT_NOFILE)>(resource), &both);
}

void print_lines(int count)
{
    std::printf("half of it\rall of it\r\n");
    for (int i = 0; i < count; ++i)
        std::printf("line %d\n", i);
    std::fflush(stdout);
    std::fprintf(stderr, "to the other stream\n");
}

/// Surroundings of a misbehavior.
struct Surroundings
{
    fs::path output, store, scratch, file, input;
    double value;
};

const std::map<std::string, std::function<void(const Surroundings&)>>& ways()
{
    using In = const Surroundings&;
    static const std::map<std::string, std::function<void(In)>> all{
        {"nothing", [](In) {}},
        {"segfault", [](In) { *reinterpret_cast<volatile int*>(std::uintptr_t{8}) = 1; }},
        {"overflow", [](In) { (void)endless(nullptr); }},
        {"exit_canceled", [](In) { std::_Exit(75); }},
        {"end_by_exit",
         [](In)
         {
             std::atexit([] { std::abort(); });
             std::exit(0);
         }},
        {"throw_int", [](In) { throw 7; }},
        // As OpenBLAS, libgomp and the standard library do where no thread can be started.
        {"interrupt_itself", [](In) { (void)std::raise(SIGINT); }},
        {"say_no_thread",
         [](In)
         {
             std::fprintf(stderr, "libgomp: Thread creation failed: %s\n", std::strerror(EAGAIN));
             std::_Exit(1);
         }},
        {"throw_no_thread", [](In) { throw std::system_error(EAGAIN, std::generic_category()); }},
        {"loop",
         [](In)
         {
             for (volatile bool on = true; on;)
                 continue;
         }},
        {"deaf", [](In) { stay_deaf(); }},
        {"allocate",
         [](In)
         {
             for (std::vector<std::vector<char>> taken;;)
                 taken.emplace_back(std::size_t{16} << 20U, 'x');
         }},
        // In two processes of its own, of which the host knows nothing and neither of which is too large by itself.
        {"allocate_elsewhere", [](In) { fork() == 0 || fork() == 0 ? take_all_memory() : (void)pause(); }},
        {"crash_and_leave",
         [](In)
         {
             leave_process();
             std::this_thread::sleep_for(std::chrono::milliseconds(50));
             (void)std::raise(SIGSEGV);
         }},
        {"leave_session", [](In) { leave_process(); }},
        {"fork", [](In) { (void)!fork(); }},
        {"kill_others", [](In) { kill_others(); }},
        {"close_all", [](In) { close_range(0, ~0U, 0); }},
        {"block_signals",
         [](In)
         {
             sigset_t every;
             sigfillset(&every);
             sigprocmask(SIG_SETMASK, &every, nullptr);
         }},
        {"few_files", [](In) { limit(RLIMIT_NOFILE, 4); }},
        {"no_room", [](In) { limit(RLIMIT_FSIZE, 10); }},
        {"full_scratch",
         [](In in) {
             throw fresco::Error((in.scratch / "file").string() +
                                 ": cannot be written: " + std::generic_category().message(ENOSPC));
         }},
        {"umask", [](In) { umask(0777); }},
        {"move_away", [](In) { fs::current_path("/"); }},
        {"locale", [](In) { std::locale::global(std::locale(std::locale(), std::make_unique<Comma>().release())); }},
        {"environment", [](In) { clearenv(); }},
        {"garbage",
         [](In)
         {
             tell("no JSON\n{\"event\": 7}\n{\"event\": \"progress\", \"done\": \"x\"}\n[[[[\n{\"event\": \"begin\"}\n");
             tell_done("00", "false");  // A result that there is not.
             tell(std::string(std::size_t{40} << 20U, 'x'));
         }},
        // Another stage's result, and an end as if all was well.
        {"claim",
         [](In in)
         {
             for (const auto& entry : fs::directory_iterator(in.store / "objects"))
                 tell_done(entry.path().filename(), "true");
             std::_Exit(0);
         }},
        {"delete_inputs",
         [](In in)
         {
             fs::remove(in.file);
             fs::remove_all(in.input);
         }},
        {"spoil_by_child",
         [](In in)
         {
             const int folder = open(in.output.c_str(), O_RDONLY | O_DIRECTORY);
             if (fork() == 0)
                 keep_spoiling(folder);
         }},
        {"spoil_by_thread", [](In in) { std::thread(keep_spoiling, open(in.output.c_str(), O_RDONLY | O_DIRECTORY)).detach(); }},
        {"spoil_others",
         [](In in)
         {
             for (const auto& entry : fs::directory_iterator(in.store))
                 if (entry.path().filename() != "tmp")
                     for (const fs::path& file : files_below(entry.path()))
                         spoil(file);
         }},
        {"write_beside", [](In in) { write_beside(in.store); }},
        {"print",
         [](In)
         {
             const std::string block(std::size_t{1} << 16U, 'x');
             while (write(STDOUT_FILENO, block.data(), block.size()) > 0)
                 continue;
         }},
        {"print_binary",
         [](In)
         {
             for (int i = 0; i < 25'600; ++i)
                 std::putchar(i % 256);
             std::fflush(stdout);
         }},
        {"print_lines", [](In) { print_lines(300'000); }},
        {"print_and_throw",
         [](In)
         {
             print_lines(3);
             throw fresco::Error("enough");
         }},
        // `value` megabytes.
        {"print_much",
         [](In in)
         {
             const std::string line((std::size_t{1} << 10U) - 1, 'x');
             for (int i = 0; i < 1024 * in.value; ++i)
                 std::puts(line.c_str());
         }},
    };
    return all;
}

fresco::OneOf names_of_ways()
{
    fresco::OneOf names;
    for (const auto& [name, way] : ways())
        names.words.push_back(name);
    return names;
}

class Misbehave final : public fresco::Stage
{
    fresco::Input<fresco::Table> input{this, "input", fresco::optional, "Anything"};
    fresco::Output<fresco::Table> output{this, "output", "Made where the way allows it"};
    fresco::Option<fresco::InputFile> file{this, "file", fresco::InputFile{}, "What delete_inputs deletes"};
    fresco::Option<double> value{this, "value", 1, "The number of the table, and of the megabytes of print_much"};
    fresco::Option<std::string> how{this, "how", "nothing", names_of_ways(), "What it does"};

  public:
    double memory_mb() const override { return 30; }

  private:
    void run(fresco::RunContext& run) override
    {
        const auto made = output.folder().path;
        ways().at (*how)({.output = made,
                          .store = made.parent_path().parent_path().parent_path(),
                          .scratch = run.scratch_folder(),  // A killed stage leaves files there.
                          .file = file->path,
                          .input = input.has_value() ? input.folder().parent_path() : fs::path(),
                          .value = *value});
        run.message("still here");
        fresco::Table table;
        table.columns = {"value"};
        table.rows = {{fresco::Value(*value)}};
        output = std::move(table);
    }
};
FRESCO_STAGE("test.misbehave", Misbehave, "Does what no stage should")

}  // namespace
