#include "catch.h"
#include "report/page_process.h"

#include <sys/socket.h>

using namespace fresco::host;

namespace
{

/// What is said of a page that this shell script makes.
std::string said_of(const std::string& script, std::chrono::milliseconds limit)
{
    int sockets[2];
    REQUIRE(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, sockets) == 0);
    const fresco::FileDescriptor its_channel(sockets[1]);
    fresco::Process process = fresco::start_process(
        {.file = "/bin/sh", .arguments = {"sh", "-c", script}, .channel = its_channel.get(), .own_session = true});
    return wait_for_page({process.pid, fresco::FileDescriptor(sockets[0]), std::move(process.output)}, limit);
}

}  // namespace

TEST_CASE("a preview that hangs is ended, and its artifact is named")
{
    using namespace std::chrono_literals;
    const std::string process = "the process that makes them ";
    CHECK(said_of("exec sleep 100", 300ms) == process + "did not return within 0.3 s");
    CHECK(said_of("trap '' TERM; echo scan.frames >&3; sleep 100", 300ms) ==
          process + "did not return within 0.3 s when it showed scan.frames");
    CHECK(said_of("echo scan.frames >&3; kill -SEGV $$", 100s) ==
          process + "ended by Segmentation fault (signal 11) when it showed scan.frames");
    CHECK(said_of("exit 3", 100s) == process + "ended with code 3");
    CHECK(said_of("echo scan.frames >&3; echo first; echo why; exit 1", 100s) == "why");
    // The limit is that of one artifact; and what such a process leaves running is not waited for.
    CHECK(said_of("for i in 1 2 3 4 5 6 7 8; do echo $i >&3; sleep 0.2; done", 1200ms).empty());
    CHECK(said_of("sleep 100 & echo done", 100s).empty());
}
