#include "base/text_layout.h"
#include "base/unit_text.h"
#include "display/live_display.h"
#include "display/progress_rate.h"

#include "display/display.h"

#include <cstdio>
#include <fmt/format.h>
#include <map>
#include <string>

namespace fresco::host
{
namespace
{

using Clock = std::chrono::steady_clock;

/// Prints only errors; the base of the other text displays.
class QuietDisplay : public ProgressDisplay
{
  public:
    void stage_begins(const std::string&, int) override {}
    void stage_waits(const std::string&, const std::string&) override {}
    void stage_progress(const std::string&, double, double, const std::string&, const Value&) override {}
    void stage_says(const std::string&, const std::string&, bool) override {}
    void stage_prints(const std::string&, const std::string&) override {}
    void stage_ends(const StageOutcome& outcome) override
    {
        if (!outcome.error.empty())
            problem(outcome.error);
    }
    void exported(const std::string&, const std::filesystem::path&, bool) override {}
    void problem(const std::string& text) override { print_message(text); }
    void note(const std::string&) override {}
    void tick() override {}
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
        line(fmt::format("{}: running on {} {}", stage, threads, threads == 1 ? "core" : "cores"));
        running_.insert_or_assign(stage, Entry{});
    }
    void stage_waits(const std::string& stage, const std::string& holder) override
    {
        line(stage + ": waiting for another run that makes the same result" + (holder.empty() ? "" : ": " + holder));
    }
    void stage_progress(const std::string& stage, double done, double total, const std::string& unit,
                        const Value& metrics) override
    {
        Entry& entry = running_[stage];
        entry.rate.update(done, total, unit);
        entry.metrics = metrics;
    }
    void stage_says(const std::string& stage, const std::string& text, bool warning) override
    {
        line(stage + ": " + (warning ? "warning: " : "") + text);
    }
    void stage_ends(const StageOutcome& outcome) override
    {
        running_.erase(outcome.stage);
        line(end_text(outcome));
        QuietDisplay::stage_ends(outcome);
    }
    void problem(const std::string& text) override { line(text); }
    void note(const std::string& text) override { line(text); }
    void tick() override
    {
        for (auto& [stage, entry] : running_)
            if (Clock::now() - entry.shown >= std::chrono::seconds(30))
            {
                entry.shown = Clock::now();
                line(stage + ": " + entry.rate.text() + metrics_text(entry.metrics));
            }
    }

  private:
    struct Entry
    {
        ProgressRate rate;
        Value metrics{Value::Map{}};
        Clock::time_point shown = Clock::now();
    };

    static void line(const std::string& text) { print_message(text); }
    static std::string metrics_text(const Value& metrics)
    {
        std::string text;
        for (const auto& [name, value] : metrics.as_map())
            text += value.is_null() ? ", " + name + " not finite" : fmt::format(", {} {:.4g}", name, value.as_double());
        return text;
    }

    std::map<std::string, Entry> running_;
};

/// For machines.
class JsonDisplay final : public ProgressDisplay
{
  public:
    void stage_begins(const std::string& stage, int threads) override { event("begin", stage, {{"threads", threads}}); }
    void stage_waits(const std::string& stage, const std::string& holder) override { event("wait", stage, {{"holder", holder}}); }
    void stage_progress(const std::string& stage, double done, double total, const std::string& unit,
                        const Value& metrics) override
    {
        event("progress", stage, {{"done", done}, {"total", total}, {"unit", unit}, {"metrics", metrics}});
    }
    void stage_says(const std::string& stage, const std::string& text, bool warning) override
    {
        event(warning ? "warning" : "message", stage, {{"text", text}});
    }
    void stage_prints(const std::string& stage, const std::string& line) override { event("output", stage, {{"text", line}}); }
    void stage_ends(const StageOutcome& outcome) override
    {
        event("end", outcome.stage,
              {{"state", to_string(outcome.state)},
               {"seconds", outcome.seconds},
               {"memory_mb", outcome.memory_mb},
               {"disk_mb", outcome.disk_mb},
               {"object", outcome.object},
               {"error", outcome.error}});
    }
    void exported(const std::string& stage, const std::filesystem::path& file, bool written) override
    {
        event("file", stage, {{"path", file.string()}, {"written", written}});
    }
    void problem(const std::string& text) override { event("error", "", {{"text", text}}); }
    void note(const std::string& text) override { event("note", "", {{"text", text}}); }
    void tick() override {}

  private:
    static void event(const char* name, const std::string& stage, Value::Map entries)
    {
        Value::Map all{{"event", name}};
        if (!stage.empty())
            all.emplace_back("stage", stage);
        all.insert(all.end(), entries.begin(), entries.end());
        std::fputs((to_json(Value(std::move(all))) + "\n").c_str(), stdout);
        std::fflush(stdout);
    }
};

}  // namespace

std::unique_ptr<ProgressDisplay> make_display(DisplayKind kind)
{
    switch (kind)
    {
    case DisplayKind::live:
        return make_live_display();
    case DisplayKind::plain:
        return std::make_unique<PlainDisplay>();
    case DisplayKind::quiet:
        return std::make_unique<QuietDisplay>();
    case DisplayKind::json:
        break;
    }
    return std::make_unique<JsonDisplay>();
}

}  // namespace fresco::host
