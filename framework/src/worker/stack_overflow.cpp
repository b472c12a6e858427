#include "worker/stack_overflow.h"

#include "base/process.h"

#include <csignal>
#include <cstdint>
#include <pthread.h>
#include <string_view>
#include <vector>

namespace fresco::host
{
namespace
{

/// Addresses that only an overflow reaches: from far below the stack's end to a little above it.
std::uintptr_t lowest = 0;
std::uintptr_t highest = 0;

// The line before may have been cut by the overflow.
constexpr std::string_view overflow_event =
    "\n{\"event\":\"failed\",\"text\":\"its stack overflowed: infinite recursion, or arrays "
    "that are too large for it; please "
    "report it to the plugin's author\"}\n";

void take_fault(int number, siginfo_t* info, void*)
{
    const auto address = reinterpret_cast<std::uintptr_t>(info->si_addr);
    if (address >= lowest && address < highest)
        send_all(child_channel, overflow_event);
    // Back to the instruction: it faults again, and the process dies as it would have. A signal that was sent does not come
    // again.
    signal(number, SIG_DFL);
    if (info->si_code <= 0)
        raise(number);
}

}  // namespace

void report_stack_overflow()
{
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0)
        return;
    void* end = nullptr;
    std::size_t size = 0;
    const bool known = pthread_attr_getstack(&attributes, &end, &size) == 0;
    pthread_attr_destroy(&attributes);
    if (!known)
        return;
    constexpr std::uintptr_t below = std::uintptr_t{16} << 20U;
    constexpr std::uintptr_t above = std::uintptr_t{1} << 16U;
    const auto stack = reinterpret_cast<std::uintptr_t>(end);
    lowest = stack > below ? stack - below : 1;
    highest = stack + above;

    static std::vector<char> room(std::size_t{1} << 16U);
    stack_t alternative{};
    alternative.ss_sp = room.data();
    alternative.ss_size = room.size();
    struct sigaction action
    {
    };
    action.sa_sigaction = take_fault;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    if (sigaltstack(&alternative, nullptr) == 0)
        sigaction(SIGSEGV, &action, nullptr);
}

}  // namespace fresco::host
