#include "store/stage_log.h"
#include "base/common.h"
#include "base/process.h"
#include "store/stage_record.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <algorithm>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

constexpr std::size_t most_bytes = std::size_t{1} << 20U;
constexpr std::size_t head_bytes = most_bytes / 4;
constexpr std::size_t tail_bytes = most_bytes / 2;

/// The first line start from `at` on, or the end.
std::size_t line_begin(std::string_view text, std::size_t at)
{
    const std::size_t end = at == 0 ? std::string_view::npos : text.find('\n', at - 1);
    return at == 0 ? 0 : std::min(end, text.size() - 1) + 1;
}

std::string whole_text(int fd, std::size_t size)
{
    std::string text(size, '\0');
    const ssize_t count = pread(fd, text.data(), size, 0);
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    return text;
}

}  // namespace

void StageLog::begin(bool resumes)
{
    fd_ = open_file(file_, O_RDWR | O_CREAT | O_APPEND | (resumes ? 0 : O_TRUNC));
    struct stat status = {};
    if (fd_.valid() && fstat(fd_.get(), &status) == 0)
        size_ = static_cast<std::size_t>(status.st_size);
    if (size_ > 0)
        added_.insert(0, "--- resumed ---\n");
    flush();
}

void StageLog::add(std::string_view line)
{
    if (line.ends_with('\r'))
        line.remove_suffix(1);
    if (const std::size_t over = line.rfind('\r'); over != std::string_view::npos)
        line.remove_prefix(over + 1);
    // The process printed before its stage began, or its log cannot be opened.
    if (!fd_.valid() && added_.size() > head_bytes)
        return;
    added_.append(line).append("\n");
}

void StageLog::flush()
{
    if (!fd_.valid() || added_.empty())
        return;
    std::string text;
    text.swap(added_);
    if (size_ + text.size() <= most_bytes)
        write(text);
    else
        cut(whole_text(fd_.get(), size_) + text);
}

/// Keeps the beginning, and the newest half megabyte.
void StageLog::cut(std::string text)
{
    if (head_ == 0)
        head_ = std::min(line_begin(text, head_bytes), head_bytes + head_bytes / 4);
    const std::size_t tail = line_begin(text, text.size() - std::min(tail_bytes, text.size()));
    cut_lines_ += std::ranges::count(std::string_view(text).substr(head_ + note_, tail - head_ - note_), '\n');
    const std::string note =
        "--- " + std::to_string(cut_lines_) + " lines left out here: a log keeps its beginning and its end ---\n";
    note_ = note.size();
    text.replace(head_, tail - head_, note);
    if (uninterrupted([&] { return ftruncate(fd_.get(), 0); }) == 0)
        size_ = 0;
    write(text);
}

void StageLog::write(std::string_view text)
{
    if (struct stat status = {}; write_all(fd_.get(), text))
        size_ += text.size();
    else if (fstat(fd_.get(), &status) == 0)
        size_ = static_cast<std::size_t>(status.st_size);  // A full disk took a part of it.
}

void link_stage_log(const Store& store, const fs::path& pipeline, const std::string& stage, const std::string& key)
{
    // Whatever is wrong there, the stage's record meets it too, and says so.
    const fs::path folder = pipeline_folder(store, pipeline);
    const fs::path link = folder / (stage + ".log");
    const fs::path target = fs::path("../..") / store.log_file(key).lexically_relative(store.root());
    if (std::error_code error; attempt([&] { make_folder(folder); }) && fs::read_symlink(link, error) != target)
        attempt([&] { make_link(target, link); });
}

std::map<std::string, fs::path> stage_logs(const Store& store, const fs::path& pipeline)
{
    std::map<std::string, fs::path> logs;
    const fs::path folder = pipeline_folder(store, pipeline);
    std::error_code error;
    for (const fs::path& link : is_folder(folder) ? entries_of(folder) : std::vector<fs::path>())
        // The name says which log of the store it is; the link itself is for people.
        if (const std::string key = fs::read_symlink(link, error).stem(); link.extension() == ".log" && is_stored_name(key))
            logs[link.stem().string()] = store.log_file(key);
    return logs;
}

}  // namespace fresco::host
