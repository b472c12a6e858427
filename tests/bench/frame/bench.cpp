#include "bench.h"

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <limits>
#include <span>
#include <thread>

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

std::string fixed(double number, int digits)
{
    std::array<char, 400> text{};
    // Small and not zero: the digits that count.
    const bool small = number != 0 && std::abs(number) < 0.5 * std::pow(10, -digits);
    const auto end = small ? std::to_chars(text.begin(), text.end(), number, std::chars_format::scientific, 1)
                           : std::to_chars(text.begin(), text.end(), number, std::chars_format::fixed, digits);
    return {text.data(), end.ptr};
}

/// Of UTF-8: code points.
std::size_t width(const std::string& text)
{
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t to, bool left)
{
    const std::string gap(to - std::min(to, width(text)), ' ');
    return left ? text + gap : gap + text;
}

std::string processor()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            return line.substr(line.find(": ") + 2);
    return "unknown";
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

fresco::Value figure(double number)
{
    return std::isfinite(number) ? fresco::Value(number) : fresco::Value();
}

fresco::Value entry(const fresco::Value& row, const std::string& key)
{
    const auto* found = row.find(key);
    return found != nullptr ? *found : fresco::Value();
}

fresco::Value ratio(const fresco::Value& more, const fresco::Value& less)
{
    if (!more.is_number() || !less.is_number() || !(more.as_double() > 0) || !(less.as_double() > 0))
        return {};
    return more.as_double() / less.as_double();
}

Table::Table(std::string name, std::string caption, std::vector<Column> columns)
    : name_(std::move(name)), caption_(std::move(caption)), columns_(std::move(columns))
{
}

void Table::add(fresco::Value row)
{
    rows_.push_back(std::move(row));
}

std::string Table::cell(const fresco::Value& row, const Column& column) const
{
    const auto value = entry(row, column.key);
    if (value.is_string())
        return value.as_string();
    if (value.is_int())
        return std::to_string(value.as_int());
    if (value.is_number())
        return fixed(value.as_double(), column.digits);
    return "-";
}

std::string Table::text() const
{
    std::vector<std::vector<std::string>> lines(1);
    for (const auto& column : columns_)
        lines[0].push_back(column.title);
    for (const auto& row : rows_)
    {
        lines.emplace_back();
        for (const auto& column : columns_)
            lines.back().push_back(cell(row, column));
    }
    std::string out = "\n" + name_ + ": " + caption_ + "\n";
    for (const auto& line : lines)
    {
        std::string text;
        for (std::size_t c = 0; c < columns_.size(); ++c)
        {
            std::size_t widest = 0;
            for (const auto& other : lines)
                widest = std::max(widest, width(other[c]));
            const bool words =
                std::any_of(rows_.begin(), rows_.end(), [&](const auto& row) { return entry(row, columns_[c].key).is_string(); });
            text += "  " + padded(line[c], widest, words);
        }
        text.erase(text.find_last_not_of(' ') + 1);
        out += text + "\n";
    }
    // Why a row is missing figures.
    for (const auto& row : rows_)
        if (const auto note = entry(row, "note"); note.is_string())
            out += "  * " + cell(row, columns_.front()) + ": " + note.as_string() + "\n";
    return out;
}

Report::Report(std::string suite, fresco::Value settings)
{
    const auto machine =
        fresco::Value::Map{{"processor", processor()}, {"cores", static_cast<int>(std::thread::hardware_concurrency())}};
    all_ = fresco::Value::Map{
        {"suite", std::move(suite)}, {"machine", machine}, {"settings", std::move(settings)}, {"tables", fresco::Value::Map{}}};
    std::printf("%s\n%s\n", fresco::to_json(all_.at("machine")).c_str(), fresco::to_json(all_.at("settings")).c_str());
    std::fflush(stdout);
}

void Report::add(const Table& table)
{
    std::printf("%s", table.text().c_str());
    std::fflush(stdout);
    all_.find("tables")->set(table.name(), table.rows());
}

void Report::write(const std::filesystem::path& file) const
{
    const std::string text = fresco::to_json(all_) + "\n";
    fresco::write_file(file, std::as_bytes(std::span(text)));
}

int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& run)
{
    try
    {
        app.parse(argc, argv);
        run();
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : 2;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return dynamic_cast<const fresco::MissingInput*>(&error) != nullptr ? 3 : 1;
    }
    return 0;
}

}  // namespace bench
