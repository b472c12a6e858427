#include "runs.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/process.h>

#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <fmt/format.h>
#include <fstream>
#include <poll.h>

namespace fresco::studio
{
namespace
{
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds time_to_end(8);
constexpr std::chrono::seconds time_to_keep(300);  // A step and a checkpoint of some hundred megabytes.
constexpr const char* stop_option = "texture.stop_at_step";

bool is_id(const std::string& id)
{
    return id == "preview" ||
           (!id.empty() && id.size() < 10 && std::ranges::all_of(id, [](char c) { return c >= '0' && c <= '9'; }));
}

Process started(const fs::path& program, const std::vector<std::string>& words)
{
    ProcessStart start{.file = program, .arguments = {program.filename()}, .own_session = true};
    start.arguments.insert(start.arguments.end(), words.begin(), words.end());
    return start_process(start);
}

/// Waits for what the process prints; false: it has printed all.
bool hear(const Process& process, LineBuffer& lines, std::chrono::milliseconds patience)
{
    pollfd stream{process.output.get(), POLLIN, 0};
    return poll(&stream, 1, static_cast<int>(patience.count())) <= 0 || lines.read_from(process.output.get());
}

ProcessEnd end_of(const Process& process)
{
    ProcessEnd end;
    while (!take_group_end(process.pid, end))
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return end;
}

/// Follows the events of a run to know where StyleMesh is.
struct Optimization
{
    std::int64_t steps = 0;       ///< Done; 0: it has not begun, or it has ended.
    std::int64_t stopped_at = 0;  ///< The step that it was stopped after.

    void hear(const std::string& line)
    {
        if (!line.starts_with('{') || line.find("\"stage\":\"texture\"") == std::string::npos)
            return;
        const Value event = parse_json(line, "an event of fresco run");
        const std::string& name = event.at("event").as_string();
        if (name == "progress" && event.at("unit").as_string() == "steps")
            steps = static_cast<std::int64_t>(event.at("done").as_double());
        else if (name == "end")
            steps = 0;
        else if (name == "message")
            std::sscanf(event.at("text").as_string().c_str(), "stopped after step %" SCNd64 ";", &stopped_at);
    }
};

/// The step after which a painting ends; null: it makes all.
const Value* stop_of(const Value& request)
{
    const Value* settings = request.find("settings");
    return settings != nullptr ? settings->find(stop_option) : nullptr;
}

void stop_at(const fs::path& painting, std::int64_t step)
{
    Value request = parse_json(read_text_file(painting / "painting.json"), "painting.json");
    request.find("settings")->set(stop_option, step);
    write_durable_file(painting / "painting.json", to_json(request));
    const std::string text = read_text_file(painting / "painting.yaml");
    if (text.find("stop_at_step: ") == std::string::npos)
        write_durable_file(painting / "painting.yaml", paint::stopped_at(text, step));
}
}  // namespace

Runs::Runs(fs::path program, fs::path studio) : program_(std::move(program)), studio_(std::move(studio))
{
    if (!studio_.empty())
    {
        fs::create_directories(studio_ / "paintings");
        resume();
        tidy_store();
    }
    thread_ = std::thread([this] { work(); });
}

Runs::~Runs()
{
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

fs::path Runs::folder_of(const std::string& id) const
{
    if (!is_id(id) || studio_.empty())
        throw Error(id + ": not a painting");
    return studio_ / "paintings" / id;
}

std::string Runs::answer_of(const std::vector<std::string>& words) const
{
    const Process process = started(program_, words);
    LineBuffer lines;
    std::string text;
    for (bool more = true; more;)
    {
        more = hear(process, lines, std::chrono::seconds(1));
        for (std::string line; lines.next(line);)
            text += line + "\n";
    }
    text += lines.rest();
    if (end_of(process).exit_code != 0)
        throw Error(text);
    const std::size_t begin = text.starts_with('{') ? 0 : text.find("\n{") + 1;  // Warnings come first.
    fmt::print(stderr, "{}", text.substr(0, begin));
    return text.substr(begin);
}

Started Runs::paint(const paint::Settings& settings, const Value& asked, const std::string& care)
{
    if (care != "quick" && care != "preview" && care != "full")
        throw Error("care: expected quick, preview or full");
    const paint::ScanKind kind = paint::kind_of(settings.scan);
    const std::string text = paint::pipeline_text(settings, kind);
    const Value* view = asked.find("view");
    const bool only_prepares = care != "full" && !settings.weights.empty();  // StyleMesh takes hours.
    const std::string look = view != nullptr && care == "quick" && !only_prepares ? paint::look_text(settings, kind, *view) : "";
    const std::lock_guard one_at_a_time(asking_);
    std::string id = "preview";
    if (care == "full")
    {
        int last = 0;
        for (const Painting& painting : paintings())
            last = std::max(last, std::stoi(painting.id));
        id = fmt::format("{:04}", last + 1);
    }
    const fs::path folder = folder_of(id);
    refuse_if_painting();
    fs::create_directories(folder);
    const auto last = find(id);
    const Value *scan = asked.find("scan"), *last_scan = last ? last->request.find("scan") : nullptr;
    const bool is_same_scan = scan != nullptr && last_scan != nullptr && *scan == *last_scan;
    write_durable_file(folder / "painting.yaml", text);
    write_durable_file(folder / "painting.json", to_json(asked));
    if (!look.empty())
        write_durable_file(folder / "look.yaml", look);
    Job job{.id = id,
            .care = care,
            .folder = folder,
            .log = folder / "log.jsonl",
            .words = {"run", folder / (look.empty() ? "painting.yaml" : "look.yaml")}};
    if (care == "full")
        job.first = {"photo_view"};
    else if (!is_same_scan)
        job.first = {"mesh_view", "photo_view"};
    const auto add = [&](std::initializer_list<const char*> more)
    { job.words.insert(job.words.end(), more.begin(), more.end()); };
    if (care != "full")
        add({"--preview", "--without", "glb"});
    if (care != "full" && kind == paint::ScanKind::splats)
        add({"--without", "painted"});
    if (care != "full" && text.find("\n  relief: ") != std::string::npos)
        add({"--without", "relief"});
    if (only_prepares)
        add({"--without", "texture", "--without", "bake", "--without", "view"});
    if (care == "quick" && look.empty() && !only_prepares)
        add({"--set", "texture.levels_count=1", "--set", "texture.rounds_count=1", "--set", "atlas.size_px=512"});
    write_durable_file(folder / "words.json", to_json(Value::List(job.words.begin(), job.words.end())));
    write_durable_file(folder / "state", std::string_view("running"));
    return start(std::move(job));
}

Started Runs::take(const std::string& id, const paint::Settings& settings, const std::string& kind)
{
    const std::lock_guard one_at_a_time(asking_);
    const fs::path folder = folder_of(id);
    refuse_if_painting();
    const auto [text, stage] = paint::export_text(settings, paint::kind_of(settings.scan), kind);
    write_durable_file(folder / (kind + ".yaml"), text);
    return start({.id = id,
                  .care = "export",
                  .folder = folder,
                  .log = folder / "export.jsonl",
                  .words = {"run", folder / (kind + ".yaml"), "--until", stage},
                  .is_painting = false});
}

Started Runs::start(Job job)
{
    const std::string id = job.id;
    const std::lock_guard lock(mutex_);
    job.serial = ++serial_;
    if (id == "preview")  // The one that it ends still writes into its own.
        job.log = job.folder / fmt::format("log{}.jsonl", serial_);
    else
        std::ofstream(job.log, std::ios::trunc).flush();
    next_ = std::move(job);
    changed_.notify_all();
    return {id, serial_};
}

void Runs::refuse_if_painting() const
{
    const std::lock_guard lock(mutex_);
    const auto is_wanted = [](const Job& job) { return job.care == "full" || job.care == "export"; };
    if ((next_ && is_wanted(*next_)) || (current_ && is_wanted(*current_) && !canceled_))
        throw Error("a painting or an export is being made; cancel it first, or wait for it");
}

void Runs::cancel()
{
    const std::lock_guard lock(mutex_);
    if (next_)
    {
        std::ofstream(next_->log, std::ios::app)
            << to_json(Value::Map{{"event", "ended"}, {"exit_code", 1}, {"canceled", true}}) << "\n";
        if (next_->is_painting)
            write_durable_file(next_->folder / "state", std::string_view("canceled"));
    }
    next_.reset();
    canceled_ = current_.has_value();
}

void Runs::keep()
{
    const std::lock_guard lock(mutex_);
    const auto painting = current_ && current_->care == "full" && !canceled_ ? find(current_->id) : std::nullopt;
    if (!painting)
        throw Error("no painting is being made that could be kept");
    const Value* method = painting->request.at("settings").find("method");
    if (method == nullptr || method->as_string() != "stylemesh")
        throw Error(
            "only StyleMesh can be stopped and kept: brush strokes are no result before the last of them; wait, or cancel");
    if (const Value* stop = stop_of(painting->request))
        throw Error(fmt::format("this painting ends after step {} anyway, as its settings say", stop->as_int()));
    if (steps_ == 0)
        throw Error("StyleMesh has not made its first step, or has made its last: there is nothing to stop; wait, or cancel");
    write_durable_file(current_->folder / "keep", std::string_view());
    keeps_ = true;
}

void Runs::remove(const std::string& id)
{
    const std::lock_guard one_at_a_time(asking_);
    {
        const std::lock_guard lock(mutex_);
        if ((current_ && current_->id == id) || (next_ && next_->id == id))
            throw Error("this painting is being made; cancel it first");
    }
    if (!fs::exists(folder_of(id) / "painting.json"))
        throw Error(id + ": no such painting");
    fs::remove_all(folder_of(id));
}

std::vector<Painting> Runs::paintings() const
{
    std::vector<Painting> all;
    if (studio_.empty())
        return all;
    for (const fs::directory_entry& entry : fs::directory_iterator(studio_ / "paintings"))
        if (const std::string id = entry.path().filename(); is_id(id) && id != "preview")
            if (auto painting = find(id))
                all.push_back(std::move(*painting));
    std::ranges::sort(all, std::ranges::greater{}, [](const Painting& painting) { return std::stoi(painting.id); });
    return all;
}

std::optional<Painting> Runs::find(const std::string& id) const
{
    const fs::path folder = folder_of(id);
    try
    {
        return Painting{id, parse_json(read_text_file(folder / "painting.json"), "painting.json"),
                        read_text_file(folder / "state"), fs::exists(folder / "thumb.jpg")};
    }
    catch (const Error&)
    {
        return std::nullopt;  // Half made, or half removed.
    }
}

Value Runs::running() const
{
    const std::lock_guard lock(mutex_);
    const auto& job = next_ ? next_ : current_;
    if (!job)
        return {};
    const auto painting = find(job->id);
    return Value::Map{{"id", job->id},
                      {"care", job->care},
                      {"serial", job->serial},
                      {"request", painting ? painting->request : Value()},
                      {"keeps", keeps_}};
}

/// Removes what old previews left; the paintings' results stay. The store knows paintings by their paths: where the folder was
/// ever moved, it would take them for gone, so that nothing is removed there. A checkpoint to resume from stays, too.
void Runs::tidy_store() const
{
    const fs::path place = studio_ / "place";
    try
    {
        if (!fs::exists(studio_ / "store"))
            write_durable_file(place, std::string_view(studio_.native()));
        else if (!fs::exists(place) || read_text_file(place) != studio_.native())
            fs::remove(place);
        else if (!next_)
            answer_of({"store", "gc", "--store", studio_ / "store"});
    }
    catch (const std::exception& error)
    {
        fmt::print(stderr, "warning: old previews stay: {}\n", error.what());
    }
}

/// The newest painting that was being made when this program was killed is made on.
void Runs::resume()
{
    for (const Painting& painting : paintings())
        if (painting.state == "running")
        {
            const fs::path folder = folder_of(painting.id);
            if (next_)
            {
                write_durable_file(folder / "state", std::string_view("canceled"));
                continue;
            }
            Job job{.id = painting.id, .care = "full", .folder = folder, .log = folder / "log.jsonl", .first = {"photo_view"}};
            const Value words = parse_json(read_text_file(folder / "words.json"), "words.json");
            for (const Value& word : words.as_list())
                job.words.push_back(word.as_string());
            job.serial = ++serial_;
            next_ = std::move(job);
        }
}

void Runs::work()
{
    std::unique_lock lock(mutex_);
    while (true)
    {
        changed_.wait(lock, [&] { return ending_ || next_; });
        if (ending_)
            return;
        current_ = std::move(next_);
        next_.reset();
        canceled_ = false;
        const Job job = *current_;
        lock.unlock();
        try
        {
            run(job);
        }
        catch (const std::exception& error)
        {
            std::ofstream(job.log, std::ios::app)
                << to_json(Value::Map{{"event", "ended"}, {"exit_code", 1}, {"error", error.what()}}) << "\n";
        }
        lock.lock();
        current_.reset();
    }
}

/// On this thread, because the kernel ends a program with the thread that started it.
void Runs::run(const Job& job)
{
    if (job.id == "preview")
        for (const fs::directory_entry& entry : fs::directory_iterator(job.folder))
            if (entry.path().extension() == ".jsonl")
                fs::remove(entry.path());
    if (job.is_painting)
        write_durable_file(job.folder / "state", std::string_view("running"));
    const fs::path keep = job.folder / "keep";
    if (const auto painting = find(job.id); fs::exists(keep) && painting && stop_of(painting->request) != nullptr)
    {
        stop_at(job.folder, stop_of(painting->request)->as_int());
        fs::remove(keep);
    }
    {
        const std::lock_guard lock(mutex_);
        keeps_ = job.care == "full" && fs::exists(keep);
    }
    std::ofstream log(job.log, std::ios::trunc);
    for (const std::string& stage : job.first)
        if (!run_once(job, stage, log))
            return;
    while (run_once(job, {}, log))
    {
    }
}

/// Runs all, or up to one stage; whether another run has to follow, because there is more or this one was stopped to be kept.
bool Runs::run_once(const Job& job, const std::string& until, std::ostream& log)
{
    std::vector<std::string> words = job.words;
    if (!until.empty())
        words.insert(words.end(), {"--until", until});
    for (const std::string& word : std::initializer_list<std::string>{"--json-log", "--no-report", "--replace", "--store",
                                                                      studio_ / "store", "--out", job.folder / "out"})
        words.push_back(word);
    const Process process = started(program_, words);
    LineBuffer lines;
    Optimization optimization;
    std::optional<Clock::time_point> told;
    bool dropped = false;
    for (bool more = true; more;)
    {
        more = hear(process, lines, std::chrono::milliseconds(50));
        for (std::string line; lines.next(line);)
        {
            log << (line.starts_with('{') ? line : to_json(Value::Map{{"event", "note"}, {"text", line}})) << "\n";
            optimization.hear(line);
        }
        const std::lock_guard lock(mutex_);
        steps_ = optimization.steps;
        log.flush();
        dropped = dropped || canceled_ || (next_ && job.care != "full" && job.care != "export");
        if ((dropped || ending_ || (keeps_ && steps_ > 0)) && !told)
        {
            told = Clock::now();
            kill(process.pid, SIGTERM);
        }
        else if (told && Clock::now() - *told > (dropped || ending_ ? time_to_end : time_to_keep))
            kill(-process.pid, SIGKILL);
    }
    const ProcessEnd end = end_of(process);
    const std::lock_guard lock(mutex_);
    steps_ = 0;
    if (!until.empty() && end.exit_code == 0 && !dropped && !ending_)
        return true;
    const bool again = keeps_ && told && !dropped && !ending_ && end.exit_code != 0;
    if (keeps_ && !dropped && optimization.stopped_at > 0)
        stop_at(job.folder, optimization.stopped_at);
    if (keeps_ && (!ending_ || optimization.stopped_at > 0))
        fs::remove(job.folder / "keep");
    keeps_ = false;
    if (again)
        return true;
    log << to_json(Value::Map{{"event", "ended"}, {"exit_code", end.exit_code}, {"signal", end.signal}, {"canceled", dropped}})
        << "\n";
    log.flush();
    if (job.is_painting && (dropped || !ending_))
        write_durable_file(job.folder / "state", std::string_view(dropped ? "canceled" : end.exit_code == 0 ? "done" : "failed"));
    return false;
}

}  // namespace fresco::studio
