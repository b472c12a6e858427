#include "forked_case.h"

#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <limits>

#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace bench
{
namespace
{

double peak_mb()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

double processor_seconds()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

fresco::Value note(const std::string& text)
{
    return fresco::Value::Map{{"note", text}};
}

fresco::Value figures_of(const std::function<fresco::Value(Measure&)>& work)
{
    try
    {
        Measure measure;
        auto figures = work(measure);
        figures.set("peak_mb", measure.peak_growth_mb());
        figures.set("process_mb", peak_mb());
        return figures;
    }
    catch (const std::exception& error)
    {
        return note(error.what());
    }
}

[[noreturn]] void run_child(int pipe, const std::function<fresco::Value(Measure&)>& work)
{
    const std::string text = fresco::to_json(figures_of(work));
    std::size_t written = 0;
    while (written < text.size())
    {
        const auto count = ::write(pipe, text.data() + written, text.size() - written);
        if (count < 0 && errno != EINTR)
            break;
        written += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
    }
    // No destructors: what the parent holds is not the child's to end.
    ::_exit(0);
}

std::string read_all(int pipe)
{
    std::string text;
    std::array<char, 4096> buffer{};
    while (true)
    {
        const auto count = ::read(pipe, buffer.data(), buffer.size());
        if (count == 0)
            return text;
        if (count > 0)
            text.append(buffer.data(), static_cast<std::size_t>(count));
        else if (errno != EINTR)
            throw fresco::Error(std::string("a case's figures cannot be read: ") + std::strerror(errno));
    }
}

}  // namespace

Times Measure::times(int times, const std::function<void()>& work)
{
    const double before = peak_mb();
    constexpr double far = std::numeric_limits<double>::infinity();
    Times best{far, far};
    for (int i = 0; i < times; ++i)
    {
        const auto begin = std::chrono::steady_clock::now();
        const double processor = processor_seconds();
        work();
        best.processor = std::min(best.processor, processor_seconds() - processor);
        best.wall = std::min(best.wall, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    if (!used_)
        growth_mb_ = peak_mb() - before;
    used_ = true;
    return best;
}

fresco::Value run_case(const std::function<fresco::Value(Measure&)>& work)
{
    // Pages that the parent has freed but not returned would be used again by the child without counting.
    ::malloc_trim(0);
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0)
        throw fresco::Error(std::string("no pipe for a case: ") + std::strerror(errno));
    const auto child = ::fork();
    if (child < 0)
        throw fresco::Error(std::string("no process for a case: ") + std::strerror(errno));
    if (child == 0)
    {
        ::close(ends[0]);
        run_child(ends[1], work);
    }
    ::close(ends[1]);
    const std::string text = read_all(ends[0]);
    ::close(ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR)
    {
    }
    if (WIFSIGNALED(status))
        return note(std::string("the case was ended by signal ") + std::to_string(WTERMSIG(status)) +
                    (WTERMSIG(status) == SIGKILL ? " (out of memory?)" : ""));
    return fresco::parse_json(text, "the figures of a case");
}

double available_memory_mb()
{
    std::ifstream file("/proc/meminfo");
    std::string key;
    double kilobytes = 0;
    for (std::string unit; file >> key >> kilobytes; std::getline(file, unit))
        if (key == "MemAvailable:")
            return kilobytes * 1024 / 1e6;
    return 0;
}

}  // namespace bench
