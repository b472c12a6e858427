#include "display/display.h"
#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include "display/run_view.h"
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <map>
#include <string>
#include <sys/ioctl.h>
#include <unistd.h>

namespace fresco::host
{

namespace
{
using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Count and rate of a stage.
class Progress : public Count
{
  public:
    /// A new unit or total begins a new count; a resumed stage's head start does not count as speed.
    void update(double new_done, double new_total, const std::string& new_unit, const Value& new_metrics)
    {
        if (!begun_ || unit != new_unit || total < new_total || total > new_total || new_done < done)
        {
            first_ = new_done;
            first_time_ = Clock::now();
        }
        begun_ = true;
        done = new_done;
        total = new_total;
        unit = new_unit;
        const double seconds = since(first_time_);
        metrics.clear();
        for (const auto& [name, value] : new_metrics.as_map())
            metrics.emplace_back(name, value.is_null() ? std::nullopt : std::optional(value.as_double()));
        // Else it is too early to tell.
        rate = seconds >= 0.5 && done > first_ ? (done - first_) / seconds : 0;
    }

    /// "120 of 400 steps, 1.9 steps/s, 2:27 left, loss 0.25".
    std::string text() const
    {
        std::string text = count_text();
        if (rate > 0)
            text += ", " + rate_text();
        if (rate > 0 && total > done)
            text += ", " + duration_text((total - done) / rate) + " left";
        for (const Metric& metric : metrics)
            text += ", " + metric_text(metric);
        return text;
    }

    /// Whether the stage reported any progress.
    bool has_begun() const { return begun_; }

  private:
    bool begun_ = false;
    double first_ = 0;
    Clock::time_point first_time_;
};

volatile std::sig_atomic_t continued = 0;

void note_continue(int)
{
    continued = 1;
}

bool speaks_utf8()
{
    for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"})
        if (const char* value = std::getenv(name); value != nullptr && *value != '\0')
        {
            const std::string text = lower_case(value);
            return text.find("utf-8") != std::string::npos || text.find("utf8") != std::string::npos;
        }
    return false;
}

bool wants_color()
{
    const char* refusal = std::getenv("NO_COLOR");
    return refusal == nullptr || *refusal == '\0';
}

ViewFrame terminal()
{
    ViewFrame frame;
    winsize size{};
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0)
    {
        frame.width = size.ws_col;
        frame.height = size.ws_row;
    }
    return frame;
}

/// Whether the terminal is the shell's while this runs beside it. `timeout` runs programs in a group of its own in the
/// foreground, too.
bool in_background()
{
    const pid_t foreground = tcgetpgrp(STDERR_FILENO);
    return foreground >= 0 && foreground != getpgrp() && getpgrp() == getpid();
}

/// The newest file that was written after a stage began; empty: none.
std::string newest_file(const fs::path& folder, fs::file_time_type begin)
{
    std::error_code error;
    fs::path newest;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    {
        const fs::file_time_type time = entry.last_write_time(error);
        if (error || time < begin || !entry.is_regular_file(error) ||
            entry.path().filename().string().starts_with(temporary_file_prefix))
            continue;
        begin = time;
        newest = entry.path();
    }
    return newest.empty() ? "" : path_text(newest);
}

/// For a terminal at standard error: all stages below everything else, redrawn in place. What is drawn is written at once and
/// stays where it is: no mode of the terminal is changed and its cursor stays visible, so that there is nothing to put back,
/// however the program ends. Goes away with the object.
class LiveDisplay final : public ProgressDisplay
{
  public:
    LiveDisplay() : utf8_(speaks_utf8()), color_(wants_color())
    {
        struct sigaction action = {};
        action.sa_handler = note_continue;
        action.sa_flags = SA_RESTART;
        sigaction(SIGCONT, &action, &before_);
    }

    LiveDisplay(const LiveDisplay&) = delete;
    LiveDisplay& operator=(const LiveDisplay&) = delete;
    ~LiveDisplay() override
    {
        if (!in_background())
            write_all(STDERR_FILENO, back(terminal()) + "\x1b[J");
        sigaction(SIGCONT, &before_, nullptr);
    }

    void stages(const std::vector<StageStanding>& stages, int cores) override
    {
        cores_ = cores;
        for (const StageStanding& standing : stages)
        {
            Entry& entry = entry_of(standing.stage);
            entry.view.state = standing.state;
            entry.view.expected_s = standing.expected_s;
            entry.preview_folder = standing.preview_folder;
        }
        draw();
    }

    void stage_begins(const std::string& stage, int threads) override
    {
        Entry& entry = entry_of(stage);
        entry.view.state = StageState::running;
        entry.view.waits = false;
        entry.view.threads = threads;
        entry.begin = Clock::now();
        entry.begin_time = fs::file_time_type::clock::now();
        entry.progress = Progress();
    }

    void stage_waits(const std::string& stage, const std::string& holder) override
    {
        entry_of(stage).view.waits = true;
        entry_of(stage).view.holder = holder;
    }

    void stage_progress(const std::string& stage, double done, double total, const std::string& unit,
                        const Value& metrics) override
    {
        entry_of(stage).progress.update(done, total, unit, metrics);
    }

    void stage_says(const std::string& stage, const std::string& text, bool warning) override
    {
        above(stage + ": " + (warning ? "warning: " : "") + text);
    }

    void stage_ends(const StageOutcome& outcome) override
    {
        Entry& entry = entry_of(outcome.stage);
        entry.view.state = outcome.state;
        entry.view.seconds = outcome.seconds;
        if (!outcome.error.empty())
            above(outcome.error);
    }

    void note(const std::string& text) override { above(text); }
    void tick() override
    {
        if (since(drawn_) >= 0.15)
            draw();
    }

  private:
    struct Entry
    {
        ViewStage view;
        Progress progress;
        Clock::time_point begin;
        Clock::time_point looked;
        fs::file_time_type begin_time;
        fs::path preview_folder;
    };

    Entry& entry_of(const std::string& stage)
    {
        const auto [entry, fresh] = entries_.try_emplace(stage);
        if (fresh)
        {
            entry->second.view.name = stage;
            order_.push_back(stage);
        }
        return entry->second;
    }

    /// Back to where the view begins. A terminal that became narrower wrapped its lines again: they are erased.
    std::string back(const ViewFrame& frame)
    {
        std::size_t rows = 0;
        for (const std::string& line : lines_)
            rows += 1 + (columns(line) > 0 ? (columns(line) - 1) / std::max<std::size_t>(1, frame.width) : 0);
        const bool broken = rows > lines_.size();
        lines_.clear();
        if (continued != 0)
        {
            // Others have written below meanwhile.
            continued = 0;
            return "\r";
        }
        if (rows == 0)
            return "";
        return "\x1b[" + std::to_string(std::min(rows, frame.height)) + "A\r" + (broken ? "\x1b[J" : "");
    }

    void above(const std::string& said)
    {
        std::string text = folded(harmless(said, LineEnds::continued), terminal().width, 4);
        for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', end + 4))
            text.insert(end, "\x1b[K");
        draw(text + "\x1b[K\n");
    }

    void draw(const std::string& above = {})
    {
        if (in_background())
        {
            // Messages interleave with other output; redraw the view below.
            lines_.clear();
            write_all(STDERR_FILENO, above);
            return;
        }
        ViewFrame frame = terminal();
        frame.utf8 = utf8_;
        frame.color = color_;
        frame.cores = cores_;
        frame.seconds = since(begin_);
        std::vector<ViewStage> stages;
        for (const std::string& name : order_)
            stages.push_back(seen(entries_[name]));
        // Each line is written over the old one, so that nothing flickers.
        std::string text = back(frame) + above;
        lines_ = draw_view(stages, frame);
        for (const std::string& line : lines_)
            text += line + "\x1b[K\n";
        write_all(STDERR_FILENO, text + "\x1b[J");
        drawn_ = Clock::now();
    }

    static const ViewStage& seen(Entry& entry)
    {
        ViewStage& view = entry.view;
        if (view.state != StageState::running)
            return view;
        view.seconds = view.threads > 0 ? since(entry.begin) : 0;
        static_cast<Count&>(view) = entry.progress;
        if (view.threads > 0 && since(entry.looked) > 1)
        {
            entry.looked = Clock::now();
            view.preview = newest_file(entry.preview_folder, entry.begin_time);
        }
        return view;
    }

    bool utf8_;
    bool color_;
    int cores_ = 1;
    std::map<std::string, Entry> entries_;
    std::vector<std::string> order_;
    std::vector<std::string> lines_;  ///< On the terminal.
    Clock::time_point begin_ = Clock::now();
    Clock::time_point drawn_;
    struct sigaction before_ = {};
};

/// Prints only errors; the base of the other text displays.
class QuietDisplay : public ProgressDisplay
{
  public:
    void stage_ends(const StageOutcome& outcome) override
    {
        if (!outcome.error.empty())
            print_message(outcome.error);
    }
};

std::string end_text(const StageOutcome& outcome)
{
    std::string text = outcome.stage + ": " + std::string(to_string(outcome.state));
    if (outcome.state == StageState::done)
        text = fmt::format("{}: done in {}, peak memory {}", outcome.stage, duration_text(outcome.seconds),
                           size_text(outcome.memory_mb));
    else if (outcome.state == StageState::failed && outcome.seconds > 0)
        text += " after " + duration_text(outcome.seconds);
    return text;
}

/// For logs: whole lines.
class PlainDisplay final : public QuietDisplay
{
  public:
    void stage_begins(const std::string& stage, int threads) override
    {
        print_message(fmt::format("{}: running on {} {}", stage, threads, threads == 1 ? "core" : "cores"));
        running_.insert_or_assign(stage, Entry{});
    }

    void stage_waits(const std::string& stage, const std::string& holder) override
    {
        print_message(stage + ": waiting for another run that makes the same result" + (holder.empty() ? "" : ": " + holder));
    }

    void stage_progress(const std::string& stage, double done, double total, const std::string& unit,
                        const Value& metrics) override
    {
        running_[stage].progress.update(done, total, unit, metrics);
    }

    void stage_says(const std::string& stage, const std::string& text, bool warning) override
    {
        print_message(stage + ": " + (warning ? "warning: " : "") + text);
    }

    void stage_ends(const StageOutcome& outcome) override
    {
        running_.erase(outcome.stage);
        print_message(end_text(outcome));
        QuietDisplay::stage_ends(outcome);
    }

    void note(const std::string& text) override { print_message(text); }
    void tick() override
    {
        for (auto& [stage, entry] : running_)
            if (Clock::now() - entry.shown >= std::chrono::seconds(30))
            {
                entry.shown = Clock::now();
                print_message(stage + ": " +
                              (!entry.progress.has_begun() ? duration_text(since(entry.begin)) : entry.progress.text()));
            }
    }

  private:
    struct Entry
    {
        Progress progress;
        Clock::time_point begin = Clock::now();
        Clock::time_point shown = begin;
    };

    std::map<std::string, Entry> running_;
};

/// Shows nothing.
class NoDisplay final : public ProgressDisplay
{
  public:
    void stage_ends(const StageOutcome& /*outcome*/) override {}
};

/// For machines, beside another display.
class JsonDisplay final : public ProgressDisplay
{
  public:
    JsonDisplay(std::FILE* file, std::unique_ptr<ProgressDisplay> next) : file_(file), next_(std::move(next)) {}

    void stages(const std::vector<StageStanding>& stages, int cores) override
    {
        const auto standing = [](const StageStanding& stage) {
            return Value::Map{{"stage", stage.stage}, {"state", to_string(stage.state)}, {"expected_s", stage.expected_s}};
        };
        event("stages", "", {{"stages", each<Value>(stages, standing)}, {"cores", cores}});
        next_->stages(stages, cores);
    }
    void stage_begins(const std::string& stage, int threads) override
    {
        event("begin", stage, {{"threads", threads}});
        next_->stage_begins(stage, threads);
    }
    void stage_waits(const std::string& stage, const std::string& holder) override
    {
        event("wait", stage, {{"holder", holder}});
        next_->stage_waits(stage, holder);
    }
    void stage_progress(const std::string& stage, double done, double total, const std::string& unit,
                        const Value& metrics) override
    {
        event("progress", stage, {{"done", done}, {"total", total}, {"unit", unit}, {"metrics", metrics}});
        next_->stage_progress(stage, done, total, unit, metrics);
    }

    void stage_says(const std::string& stage, const std::string& text, bool warning) override
    {
        event(warning ? "warning" : "message", stage, {{"text", text}});
        next_->stage_says(stage, text, warning);
    }

    void stage_prints(const std::string& stage, const std::string& line) override
    {
        event("output", stage, {{"text", line}});
        next_->stage_prints(stage, line);
    }
    void stage_ends(const StageOutcome& outcome) override
    {
        event("end", outcome.stage,
              {{"state", to_string(outcome.state)},
               {"seconds", outcome.seconds},
               {"memory_mb", outcome.memory_mb},
               {"disk_mb", outcome.disk_mb},
               {"object", outcome.object},
               {"error", outcome.error}});
        next_->stage_ends(outcome);
    }

    void exported(const std::string& stage, const std::filesystem::path& file, bool written) override
    {
        event("file", stage, {{"path", file.string()}, {"written", written}});
        next_->exported(stage, file, written);
    }

    void note(const std::string& text) override
    {
        event("note", "", {{"text", text}});
        next_->note(text);
    }
    void tick() override { next_->tick(); }

  private:
    void event(const char* name, const std::string& stage, Value::Map entries)
    {
        Value::Map all{{"event", name}};
        if (!stage.empty())
            all.emplace_back("stage", stage);
        all.insert(all.end(), entries.begin(), entries.end());
        all.emplace_back("time_s", std::round(1000 * since(begin_)) / 1000);
        std::fputs((to_json(Value(std::move(all))) + "\n").c_str(), file_);
        std::fflush(file_);
    }

    Clock::time_point begin_ = Clock::now();
    std::FILE* file_;
    std::unique_ptr<ProgressDisplay> next_;
};

}  // namespace

std::unique_ptr<ProgressDisplay> make_display(DisplayKind kind)
{
    switch (kind)
    {
    case DisplayKind::live:
        return std::make_unique<LiveDisplay>();
    case DisplayKind::plain:
        return std::make_unique<PlainDisplay>();
    case DisplayKind::quiet:
        return std::make_unique<QuietDisplay>();
    case DisplayKind::json:
        break;
    }
    return make_recording_display(std::make_unique<NoDisplay>(), stdout);
}

std::unique_ptr<ProgressDisplay> make_recording_display(std::unique_ptr<ProgressDisplay> display, std::FILE* file)
{
    return std::make_unique<JsonDisplay>(file, std::move(display));
}

}  // namespace fresco::host
