#include "catch.h"

#include <fresco/error.h>
#include <fresco/programs/run_program.h>
#include <fresco/testing.h>

#include <unistd.h>
#include <vector>

using namespace fresco;

TEST_CASE("a program's lines arrive, and it ends by itself or at its limit of time, with all that it started", "[programs]")
{
    testing::TestRun run;
    std::vector<std::string> lines;
    const auto shell = [&](const std::string& text, double most_seconds)
    {
        return programs::run_program(
            {.file = "/bin/sh", .arguments = {"sh", "-c", text}}, run, [&](const std::string& line) { lines.push_back(line); },
            most_seconds);
    };
    CHECK(shell("echo one; printf two; exit 3", 60).exit_code == 3);
    CHECK(lines == std::vector<std::string>{"one", "two"});
    CHECK_THROWS_WITH(shell("sleep 100 & sleep 100", 0.2), Contains("/bin/sh: it runs for more than 0.2 s, the limit"));
    CHECK(children_of(getpid()).empty());
    run.cancel_after(1);
    CHECK_THROWS_AS(shell("sleep 100", 60), Canceled);
}
