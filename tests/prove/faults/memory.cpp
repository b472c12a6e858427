// Loaded before the C library (LD_PRELOAD): operator new of the host fails, from the moment that main begins.
//
// MEMORY_COUNT is a file of eight bytes in which the allocations are counted. MEMORY_FAILS is "N": the N-th fails; or "N on": all
// from the N-th on. Processes that the host starts have all the memory they want.
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <new>
#include <sys/mman.h>
#include <unistd.h>

namespace
{

using Main = int (*)(int, char**, char**);
using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);

Main original_main = nullptr;
std::atomic<std::uint64_t>* count = nullptr;
std::uint64_t first_failure = 0;
bool all_fail_from_then = false;

int counted_main(int argc, char** argv, char** environment)
{
    const char* file = std::getenv("MEMORY_COUNT");
    const char* fails = std::getenv("MEMORY_FAILS");
    if (file != nullptr && argc > 1 && std::strncmp(argv[1], "internal-", 9) != 0)
    {
        if (fails != nullptr)
        {
            char* end = nullptr;
            first_failure = std::strtoull(fails, &end, 10);
            all_fail_from_then = std::strcmp(end, " on") == 0;
        }
        const int fd = open(file, O_RDWR | O_CLOEXEC);
        void* const mapped = mmap(nullptr, sizeof *count, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
        close(fd);
        if (fd < 0 || mapped == MAP_FAILED)
            std::abort();
        count = static_cast<std::atomic<std::uint64_t>*>(mapped);
    }
    return original_main(argc, argv, environment);
}

/// As operator new does: a handler that the program has set is called first, and may throw.
void* failed()
{
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr)
        throw std::bad_alloc();
    handler();
    std::abort();  // That would mean to try again.
}

void* allocated(std::size_t size, std::size_t alignment)
{
    if (count != nullptr)
    {
        const std::uint64_t number = ++*count;
        if (number == first_failure || (all_fail_from_then && number > first_failure))
            return failed();
    }
    const std::size_t whole = (size + alignment - 1) / alignment * alignment;
    return std::aligned_alloc(alignment, whole > 0 ? whole : alignment);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) int __libc_start_main(Main main, int argc, char** argv, void (*init)(),
                                                                        void (*fini)(), void (*rtld_fini)(), void* stack_end)
{
    original_main = main;
    const auto start = reinterpret_cast<Start>(dlsym(RTLD_NEXT, "__libc_start_main"));
    return start(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}

// The other forms of new and delete are the library's: they call these, and free().

void* operator new(std::size_t size)
{
    return allocated(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__);
}

void* operator new(std::size_t size, std::align_val_t alignment)
{
    return allocated(size, static_cast<std::size_t>(alignment));
}
