#include "worker/worker_context.h"
#include "base/common.h"
#include "base/machine.h"
#include "base/records.h"
#include "base/text.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <fcntl.h>
#include <fmt/format.h>
#include <stdexcept>
#include <sys/socket.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace fresco::host
{

namespace
{

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

constexpr std::string_view own_interrupt_event =
    "\n{\"event\":\"failed\",\"text\":\"a library interrupted its own process, which OpenBLAS does if it cannot start threads: "
    "raise the limit (ulimit -u)\"}\n";

/// A SIGINT that the process sends itself is a failure. One from outside stops the run, which may then be run again.
void ask_to_stop(int number, siginfo_t* info, void*)
{
    if (number == SIGINT && info->si_code <= 0 && info->si_pid == getpid())
    {
        write_all(child_channel, own_interrupt_event);
        _exit(worker_failed);
    }
    stop = true;
}

/// In the manifest, which is read as a whole.
constexpr std::size_t most_messages = 1000;

/// With null for every number that is not finite: JSON has no other word for them.
Value finite_or_null(Value value)
{
    if (value.is_number() && !std::isfinite(value.as_double()))
        return {};
    if (value.is_list())
        for (auto& entry : value.as_list())
            entry = finite_or_null(std::move(entry));
    if (value.is_map())
        for (auto& [name, entry] : value.as_map())
            entry = finite_or_null(std::move(entry));
    return value;
}

/// In nanoseconds; 0 if it does not exist.
std::int64_t modified(const fs::path& path)
{
    const auto status = path_status(path);
    return status ? std::int64_t{status->st_mtim.tv_sec} * 1'000'000'000 + status->st_mtim.tv_nsec : 0;
}

}  // namespace

bool MetricCurves::add(double done, const Value& metrics)
{
    if (!metrics.is_map() || metrics.as_map().empty())
        return false;
    while (!points_.empty() && points_.back().done >= done)
        points_.pop_back();
    if (!points_.empty() && done - points_.back().done < least_step_)
        return false;
    points_.push_back({done, metrics});
    if (points_.size() > most_points)
        thin();
    return true;
}

void MetricCurves::thin()
{
    // A little less than twice the step, so that rounding takes no third point.
    least_step_ = 1.999 * (points_.back().done - points_.front().done) / static_cast<double>(points_.size() - 1);
    std::vector<Point> kept;
    for (Point& point : points_)
        if (kept.empty() || point.done - kept.back().done >= least_step_)
            kept.push_back(std::move(point));
    points_ = std::move(kept);
}

Value MetricCurves::to_value(std::string_view unit) const
{
    if (points_.empty())
        return {};
    Value metrics = Value::Map{};
    for (std::size_t i = 0; i < points_.size(); ++i)
        for (const auto& [name, value] : points_[i].metrics.as_map())
        {
            if (metrics.find(name) == nullptr)
                metrics.set(name, Value::List(points_.size()));
            metrics.find(name)->as_list()[i] = value;
        }
    return Value::Map{{"unit", unit}, {"done", each<Value>(points_, &Point::done)}, {"metrics", std::move(metrics)}};
}

void WorkerChannel::send(std::string_view event, Value::Map entries)
{
    entries.insert(entries.begin(), Value::Entry{"event", event});
    const std::string line = to_json(Value(std::move(entries))) + "\n";
    const std::lock_guard lock(mutex_);
    if (!write_all(child_channel, line))
        stop = true;
}

void take_stop_signals()
{
    struct sigaction action = {};
    action.sa_sigaction = ask_to_stop;
    action.sa_flags = SA_RESTART | SA_SIGINFO;
    for (const int number : {SIGTERM, SIGINT, SIGHUP})
        sigaction(number, &action, nullptr);
}

WorkerContext::WorkerContext(WorkerChannel& channel, const Store& store, const WorkerRequest& request, std::string temporary)
    : channel_(channel), store_(store), request_(request), key_(request.key), temporary_(std::move(temporary)),
      place_(computing_place(request.on_gpu))
{
}

WorkerContext::~WorkerContext()
{
    keep_checkpoint_share();
    if (!scratch_.empty())
        remove_quietly(scratch_);
}

void WorkerContext::progress(double done, double total, std::string_view unit)
{
    if (!std::isfinite(done))
        return;
    if (!std::isfinite(total))
        total = 0;
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    keep_curves(done, unit);
    done_share_ = total > 0 ? done / total : 0;
    if (now < next_progress_)
        return;
    next_progress_ = now + std::chrono::milliseconds(100);
    keep_checkpoint_share();
    channel_.send("progress", {{"done", done}, {"total", total}, {"unit", unit}, {"metrics", metrics_}});
}

/// The progress that comes after a metric says where it belongs, in the unit that came first: "steps".
void WorkerContext::keep_curves(double done, std::string_view unit)
{
    if (!metrics_changed_ || (!curve_unit_.empty() && unit != curve_unit_))
        return;
    curve_unit_ = unit;
    metrics_changed_ = false;
    // A full disk does not end the stage.
    if (curves_.add(done, metrics_) && checkpointing_)
        attempt([&] { Journal(store_.checkpoint_file(key_, ".curves")).add(Value::Map{{"done", done}, {"metrics", metrics_}}); });
}

void WorkerContext::check_canceled() const
{
    if (stop)
        throw Canceled();
}

void WorkerContext::say(std::string_view event, std::string_view text)
{
    {
        const std::lock_guard lock(mutex_);
        auto& kept = messages_.as_list();
        if (kept.size() < most_messages)
            kept.push_back(Value::Map{{event == "warning" ? "warning" : "message", text}});
        else if (kept.size() == most_messages)
            kept.push_back(Value::Map{{"message", "(more was said, and is not kept)"}});
    }
    channel_.send(event, {{"text", text}});
}

void WorkerContext::metric(std::string_view name, double value)
{
    const std::lock_guard lock(mutex_);
    metrics_.set(name, finite_or_null(value));
    metrics_changed_ = true;
}

void WorkerContext::report(std::string_view key, Value value)
{
    const std::lock_guard lock(mutex_);
    report_.set(key, finite_or_null(std::move(value)));
}

fs::path WorkerContext::preview_folder()
{
    make_folder(request_.preview_folder);
    if (const fs::path mark = request_.preview_folder / progress_mark; !path_status(mark))
        write_file(mark, "The pictures here show a stage at work. fresco replaces them.\n");
    return request_.preview_folder;
}

fs::path WorkerContext::scratch_folder()
{
    const std::lock_guard lock(mutex_);
    if (scratch_.empty())
        scratch_ = make_scratch_folder(store_, temporary_);
    return scratch_;
}

/// A checkpoint was made from the outside files that its record names; it is worth nothing once one of them changed. Throws Error
/// if the record is gone or damaged.
bool WorkerContext::checkpoint_fits(const std::string& key) const
{
    const fs::path file = store_.checkpoint_file(key, ".dependencies");
    const Value record = read_record(file);
    if (record.at("key").as_string() != key)
        throw Error(file.string() + ": is the record of another checkpoint");
    const auto& dependencies = record.at("dependencies").as_list();
    for (const auto& entry : dependencies)
        if (Dependency dependency = dependency_from(entry); compare(dependency) == Change::contents)
            return false;
    // Files beside the inputs differ where the inputs have other paths.
    return dependencies.empty() || record.at("input_files") == input_file_names();
}

Value WorkerContext::input_file_names() const
{
    return each<Value>(request_.files, [](const Dependency& file) { return file.path.string(); });
}

void WorkerContext::record_dependencies() const
{
    Value dependencies = each<Value>(dependencies_, [](const auto& entry) { return to_value(entry.second); });
    write_record(store_.checkpoint_file(key_, ".dependencies"), Value::Map{{"key", key_},
                                                                           {"place", place_},
                                                                           {"input_files", input_file_names()},
                                                                           {"dependencies", std::move(dependencies)}});
}

void WorkerContext::drop_unfit_checkpoint()
{
    try
    {
        const std::string refusal = store_.checkpoint_refusal(key_, place_);
        if (refusal.empty() && checkpoint_fits(key_))
            return;
        if (!refusal.empty())
            channel_.send("message", {{"text", "begins again: " + refusal}});
    }
    catch (const Error& error)
    {
        channel_.send("warning", {{"text", std::string("the checkpoint cannot be used: ") + error.what()}});
    }
    store_.drop_checkpoint(key_);
}

/// A stage that `stop_at_step` ends early begins as it would without: continues from the checkpoint of that run. The other run
/// keeps its own: files of checkpoints are replaced, never changed, so links are enough.
void WorkerContext::take_over_checkpoint() const
{
    Value options = request_.key_document.at("options");
    const Value* stop = options.find("stop_at_step");
    if (stop == nullptr || *stop == Value(0))
        return;
    options.set("stop_at_step", 0);
    Value whole = request_.key_document;
    whole.set("options", std::move(options));
    const std::string key = content_hash(to_json(whole));
    attempt(
        [&]
        {
            if (!store_.checkpoint_refusal(key, place_).empty() || !checkpoint_fits(key))
                return;
            std::error_code error;
            fs::copy(store_.checkpoint(key), store_.checkpoint(key_),
                     fs::copy_options::recursive | fs::copy_options::create_hard_links, error);
            if (error)
            {
                channel_.send("message",
                              {{"text", "begins again: the checkpoint of the whole run cannot be linked: " + error.message()}});
                return store_.drop_checkpoint(key_);
            }
            fs::copy_file(store_.checkpoint_file(key, ".curves"), store_.checkpoint_file(key_, ".curves"), error);
        });
}

fs::path WorkerContext::checkpoint_folder()
{
    const std::lock_guard lock(mutex_);
    const fs::path folder = store_.checkpoint(key_);
    if (!checkpointing_)
    {
        if (path_status(folder))
            drop_unfit_checkpoint();
        else
            take_over_checkpoint();
        record_dependencies();
        make_folder(folder);
        checkpointing_ = true;
        checkpoint_time_ = modified(folder);
        for (const Value& point : Journal(store_.checkpoint_file(key_, ".curves")).read())
            attempt([&] { curves_.add(point.at("done").as_double(), point.at("metrics")); });
    }
    return folder;
}

void WorkerContext::depend_on(const fs::path& path, bool folder)
{
    const fs::path absolute = fs::absolute(path).lexically_normal();
    if (!is_utf8(absolute.string()))
        throw Error(absolute.string() + ": the name is not UTF-8 text: rename it");
    {
        const std::lock_guard lock(mutex_);
        if (dependencies_.contains({absolute, folder}))
            return;
    }
    Dependency taken = take_dependency(absolute, folder);
    const std::lock_guard lock(mutex_);
    const auto [entry, is_new] = dependencies_.emplace(std::pair(absolute, folder), std::move(taken));
    if (is_new && checkpointing_)
        record_dependencies();
}

void WorkerContext::reads_folder(const fs::path& folder, std::string_view names)
{
    if (names.empty() || names.find('/') != std::string_view::npos)
        throw std::invalid_argument("reads_folder: \"" + std::string(names) + "\" is not a pattern of names");
    depend_on(folder / names, true);
}

std::vector<Dependency> WorkerContext::settled_dependencies()
{
    std::vector<Dependency> all;
    for (auto& [place, dependency] : dependencies_)
    {
        if (compare(dependency) == Change::contents)
            throw Error(place.first.string() + ": changed while the stage read it; run again");
        all.push_back(dependency);
    }
    return all;
}

/// Records the share of work in the checkpoint whenever it has changed.
void WorkerContext::keep_checkpoint_share()
{
    const auto time = modified(store_.checkpoint(key_));
    if (!checkpointing_ || time == 0 || time == checkpoint_time_)
        return;
    checkpoint_time_ = time;
    // Only an estimate.
    attempt([&] { write_file(store_.checkpoint_file(key_, ".share"), fmt::format("{}\n", done_share_)); });
}

}  // namespace fresco::host
