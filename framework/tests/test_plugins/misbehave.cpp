// A stage that does, on purpose, what no stage should: by its option, and in its constructor by the environment.
#include "misdeeds.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/stage.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace
{

constexpr int channel = 3;

/// Neither inlined nor turned into a loop: every call needs its room.
__attribute__((noinline)) int endless(volatile char* above)
{
    volatile char room[4096];
    room[0] = above == nullptr ? '0' : *above;
    return endless(room) + room[0];
}

void keep_busy()
{
    for (volatile bool on = true; on;)
        continue;
}

/// Allocates memory and uses it until none is left.
void take_all_memory()
{
    std::vector<std::vector<char>> taken;
    for (;;)
        taken.emplace_back(std::size_t{16} << 20U, 'x');
}

/// The same in two processes of their own, of which the host knows nothing and neither of which is too large by itself.
void take_all_memory_elsewhere()
{
    if (fork() == 0 || fork() == 0)
        for (;;)
        {
            auto* const block = static_cast<char*>(std::malloc(std::size_t{4} << 20U));
            if (block == nullptr)
                pause();
            else
                std::memset(block, 'x', std::size_t{4} << 20U);
        }
    pause();
}

void tell(const std::string& text)
{
    (void)send(channel, text.data(), text.size(), MSG_NOSIGNAL);
}

void write_garbage()
{
    tell("no JSON\n{\"event\": 7}\n{\"event\": \"progress\", \"done\": \"x\"}\n[[[[\n{\"event\": \"begin\"}\n");
    // Of a result that there is not.
    tell(R"({"event": "done", "object": "00", "references": [], "stored": false, "seconds": 1, "memory_mb": 1, "disk_mb": 1})"
         "\n");
    tell(std::string(std::size_t{40} << 20U, 'x'));
}

class Misbehave final : public fresco::Stage
{
    fresco::Input<fresco::Table> input{this, "input", fresco::optional, "Anything"};
    fresco::Output<fresco::Table> output{this, "output", "Made where the way allows it"};
    fresco::Option<fresco::InputFile> file{this, "file", fresco::InputFile{}, "What delete_inputs deletes"};
    fresco::Option<double> value{this, "value", 1, "The number of the table, and of the megabytes of print_much"};
    fresco::Option<std::string> how{this, "how", "nothing",
                                    fresco::one_of({"nothing",
                                                    "segfault",
                                                    "overflow",
                                                    "exit",
                                                    "exit_canceled",
                                                    "loop",
                                                    "allocate",
                                                    "allocate_elsewhere",
                                                    "abort",
                                                    "throw_int",
                                                    "close_channel",
                                                    "garbage",
                                                    "leave_process",
                                                    "leave_session",
                                                    "print",
                                                    "print_lines",
                                                    "print_and_throw",
                                                    "print_binary",
                                                    "print_much",
                                                    "fork",
                                                    "spoil_by_child",
                                                    "spoil_by_thread",
                                                    "spoil_others",
                                                    "write_beside",
                                                    "delete_inputs",
                                                    "crash_and_leave",
                                                    "kill_others",
                                                    "claim",
                                                    "deaf",
                                                    "close_all",
                                                    "block_signals",
                                                    "few_files",
                                                    "no_room",
                                                    "full_scratch",
                                                    "umask",
                                                    "move_away",
                                                    "locale",
                                                    "environment",
                                                    "end_by_exit"}),
                                    "What it does"};

  public:
    Misbehave() { misbehave_at_start(); }

  private:
    void run(fresco::RunContext& run) override
    {
        // Where a killed stage would leave things.
        const auto scratch = run.scratch_folder();
        if (*how == "full_scratch")
            throw fresco::Error((scratch / "file").string() + ": cannot be written: " + std::generic_category().message(ENOSPC));
        if (*how == "segfault")
            *reinterpret_cast<volatile int*>(std::uintptr_t{8}) = 1;
        if (*how == "overflow")
            run.report("depth", endless(nullptr));
        if (*how == "exit")
            std::_Exit(3);
        if (*how == "exit_canceled")
            std::_Exit(75);
        if (*how == "loop")
            keep_busy();
        if (*how == "allocate")
            take_all_memory();
        if (*how == "allocate_elsewhere")
            take_all_memory_elsewhere();
        if (*how == "abort")
            std::abort();
        if (*how == "throw_int")
            throw 7;
        if (*how == "close_channel")
            close(channel);
        if (*how == "garbage")
            write_garbage();
        if (how->starts_with("leave_"))
            leave_process(*how == "leave_session");
        if (*how == "delete_inputs")
            delete_inputs();
        do_misdeed(*how, output.folder().path);
        if (*how == "print")
            print_without_end();
        if (*how == "print_much")
            print_much();
        if (*how == "print_lines" || *how == "print_and_throw")
            print_lines(*how == "print_lines" ? 100'000 : 3);
        if (*how == "print_and_throw")
            throw fresco::Error("enough");
        run.message("still here");
        fresco::Table table;
        table.columns = {"value"};
        table.rows = {{fresco::Value(*value)}};
        output = std::move(table);
    }

    void delete_inputs()
    {
        if (!file->empty())
            std::filesystem::remove(file->path);
        if (input.has_value())
            std::filesystem::remove_all(input.folder().parent_path());
    }

    static void print_lines(int count)
    {
        std::printf("half of it\rall of it\r\n");
        for (int i = 0; i < count; ++i)
            std::printf("line %d\n", i);
        std::fflush(stdout);
        std::fprintf(stderr, "to the other stream\n");
    }

    /// `value` megabytes.
    void print_much()
    {
        const std::string line = std::string((std::size_t{1} << 10U) - 1, 'x') + "\n";
        for (int i = 0; i < 1024 * *value; ++i)
            std::fputs(line.c_str(), stdout);
    }

    static void print_without_end()
    {
        const std::string block(std::size_t{1} << 16U, 'x');
        while (write(STDOUT_FILENO, block.data(), block.size()) > 0)
            continue;
    }
};
FRESCO_STAGE("test.misbehave", Misbehave, "Does what no stage should")

}  // namespace
