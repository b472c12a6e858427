#include "display/run_view.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numeric>

namespace fresco::host
{
namespace
{

bool is_finished(const ViewStage& stage)
{
    return stage.state == StageState::done || stage.state == StageState::stored || stage.state == StageState::not_needed;
}

struct Mark
{
    const char* utf8;
    const char* ascii;
    Tone tone;
};

Mark mark_of(StageState state)
{
    static const std::map<StageState, Mark> marks{
        {StageState::done, {"✓", "+", Tone::good}},       {StageState::stored, {"=", "=", Tone::good}},
        {StageState::running, {"●", ">", Tone::busy}},    {StageState::failed, {"✗", "x", Tone::bad}},
        {StageState::interrupted, {"!", "!", Tone::bad}}, {StageState::waiting, {"·", ".", Tone::faint}}};
    const auto mark = marks.find(state);
    return mark == marks.end() ? Mark{"-", "-", Tone::faint} : mark->second;
}

std::string bar(const ViewStage& stage, std::size_t width, bool utf8)
{
    const double share = std::clamp(stage.done / stage.total, 0.0, 1.0);
    const auto filled = static_cast<std::size_t>(std::lround(share * static_cast<double>(width)));
    std::string text;
    for (std::size_t i = 0; i < width; ++i)
        text += i < filled ? (utf8 ? "━" : "#") : (utf8 ? "┈" : "-");
    return text;
}

class View
{
  public:
    View(const std::vector<ViewStage>& stages, const ViewFrame& frame) : stages_(stages), frame_(frame)
    {
        std::size_t longest = 0;
        for (const ViewStage& stage : stages)
            longest = std::max(longest, columns(stage.name));
        name_ = std::min({longest, std::size_t{32}, std::max<std::size_t>(8, frame.width / 3)});
        bar_ = frame.width < 30 ? 0 : std::min<std::size_t>(24, frame.width / 5);
    }

    std::vector<std::string> draw() const
    {
        const std::size_t room = frame_.height > 2 ? frame_.height - 2 : 0;  // the last line is that of the run
        std::vector<std::string> lines;
        if (stages_.size() <= room)
        {
            const auto details = std::ranges::count_if(stages_, [&](const ViewStage& stage) { return !detail(stage).empty(); });
            const bool with_details = stages_.size() + static_cast<std::size_t>(details) <= room;
            for (const ViewStage& stage : stages_)
                draw_stage(stage, with_details, lines);
        }
        else if (room > 0)
            draw_some(room, lines);
        if (frame_.height > 1)
            lines.push_back(whole());
        return lines;
    }

  private:
    LineRoom line_room() const { return {frame_.width > 1 ? frame_.width - 1 : 0, frame_.utf8, frame_.color}; }
    const char* dot() const { return frame_.utf8 ? " · " : ", "; }

    void draw_stage(const ViewStage& stage, bool with_detail, std::vector<std::string>& lines) const
    {
        lines.push_back(row(stage));
        if (const std::string text = detail(stage); with_detail && !text.empty())
            lines.push_back(Line(line_room()).pad_to(name_ + 4).add(text, Tone::faint).take());
    }

    /// Draws running and failed stages, the next and the last ones, and counts the others.
    void draw_some(std::size_t room, std::vector<std::string>& lines) const
    {
        const auto rank = [&](std::size_t i)
        {
            const StageState state = stages_[i].state;
            const int kind = state == StageState::running                                      ? 0
                             : state == StageState::failed || state == StageState::interrupted ? 1
                             : state == StageState::waiting                                    ? 2
                                                                                               : 3;
            return std::pair(kind, kind < 3 ? i : stages_.size() - i);
        };
        std::vector<std::size_t> wanted(stages_.size());
        std::iota(wanted.begin(), wanted.end(), 0);
        std::ranges::sort(wanted, {}, rank);
        wanted.resize(std::min(wanted.size(), room > 2 ? room - 2 : 0));
        std::vector<bool> shown(stages_.size());
        for (const std::size_t i : wanted)
            shown[i] = true;
        std::size_t finished = 0;
        std::size_t others = 0;
        for (std::size_t i = 0; i < stages_.size(); ++i)
            if (!shown[i])
                ++(is_finished(stages_[i]) ? finished : others);
        const auto fold = [&](std::size_t count, StageState state, const char* what)
        {
            if (count > 0 && lines.size() < room)
                lines.push_back(Line(line_room())
                                    .add(" ")
                                    .add(symbol(state), Tone::faint)
                                    .add(fmt::format(" {} more {}", count, what), Tone::faint)
                                    .take());
        };
        fold(finished, StageState::done, "done");
        for (std::size_t i = 0; i < stages_.size(); ++i)
            if (shown[i])
                lines.push_back(row(stages_[i]));
        fold(others, StageState::waiting, "to do");
    }

    const char* symbol(StageState state) const
    {
        const Mark mark = mark_of(state);
        return frame_.utf8 ? mark.utf8 : mark.ascii;
    }

    std::string row(const ViewStage& stage) const
    {
        Line line(line_room());
        const Mark mark = mark_of(stage.state);
        line.add(" ").add(symbol(stage.state), mark.tone).add(" ");
        const bool faint = stage.state == StageState::waiting || mark.tone == Tone::faint;
        line.add(Line({name_, frame_.utf8, false}).add(stage.name).take(), faint ? Tone::faint : Tone::plain).pad_to(name_ + 4);
        if (stage.state == StageState::running)
            add_running(stage, line);
        else if (stage.state == StageState::done)
            line.add(duration_text(stage.seconds), Tone::faint);
        else if (stage.state == StageState::waiting)
            line.add(stage.expected_s > 0 ? "~" + duration_text(stage.expected_s) : "", Tone::faint);
        else if (stage.state == StageState::failed)
            line.add(stage.seconds > 0 ? "failed after " + duration_text(stage.seconds) : "failed", Tone::bad);
        else
            line.add(to_string(stage.state), mark.tone == Tone::good ? Tone::faint : mark.tone);
        return line.take();
    }

    void add_running(const ViewStage& stage, Line& line) const
    {
        if (stage.waits)
        {
            line.add("another run makes this result" + (stage.holder.empty() ? "" : ": " + stage.holder), Tone::faint);
            return;
        }
        const bool counts = !stage.unit.empty() && stage.total > 0;
        if (counts && bar_ > 0)
            line.add(bar(stage, bar_, frame_.utf8), Tone::busy).add(" ");
        std::string text;
        const auto add = [&](const std::string& more) { text += (text.empty() ? "" : dot()) + more; };
        const auto left = left_s(stage);
        if (counts && frame_.width < 60)
            add(fmt::format("{:.0f} %", 100 * std::clamp(stage.done / stage.total, 0.0, 1.0)));
        else if (!stage.unit.empty())
            add(stage.count_text());
        else
            add(duration_text(stage.seconds));
        if (left)
            add(duration_text(*left) + " left");
        if (stage.rate > 0 && frame_.width >= 60)
            add(stage.rate_text());
        line.add(text);
    }

    std::string detail(const ViewStage& stage) const
    {
        if (stage.state != StageState::running)
            return "";
        std::string text;
        const auto add = [&](const std::string& more) { text += (text.empty() ? "" : dot()) + more; };
        for (std::size_t i = 0; i < stage.metrics.size() && i < 4; ++i)
            add(metric_text(stage.metrics[i]));
        if (!stage.preview.empty())
            add(stage.preview);
        return text;
    }

    std::string whole() const
    {
        const auto count = [&](StageState state) { return std::ranges::count(stages_, state, &ViewStage::state); };
        const auto selected = std::ssize(stages_) - count(StageState::not_selected);
        const auto finished = std::ranges::count_if(stages_, is_finished);
        const auto failed = count(StageState::failed);
        Line line(line_room());
        line.add(fmt::format("{} of {} done", finished, selected));
        if (failed > 0)
            line.add(dot()).add(fmt::format("{} failed", failed), Tone::bad);
        line.add(dot()).add(duration_text(frame_.seconds));
        if (const auto left = left_s(stages_, frame_.cores))
            line.add(dot()).add("about " + duration_text(*left) + " left");
        return line.take();
    }

    const std::vector<ViewStage>& stages_;
    const ViewFrame& frame_;
    std::size_t name_ = 0;
    std::size_t bar_ = 0;
};

}  // namespace

std::string metric_text(const Metric& metric)
{
    return metric.first + " " + (metric.second ? fmt::format("{:.4g}", *metric.second) : "not finite");
}

std::string Count::count_text() const
{
    constexpr double few = 20;
    if (total > 0 && total <= few && done < total && unit.size() > 1 && unit.ends_with('s'))
        return fmt::format("{} {:.0f} of {:.0f}", unit.substr(0, unit.size() - 1), std::floor(done) + 1, total);
    return fmt::format("{:.0f}{} {}", done, total > 0 ? fmt::format(" of {:.0f}", total) : "", unit);
}

std::string Count::rate_text() const
{
    return rate >= 10 ? fmt::format("{:.0f} {}/s", rate, unit) : fmt::format("{:.2g} {}/s", rate, unit);
}

std::optional<double> left_s(const ViewStage& stage)
{
    if (stage.state == StageState::waiting)
        return stage.expected_s > 0 ? std::optional(stage.expected_s) : std::nullopt;
    if (stage.state != StageState::running)
        return std::nullopt;
    const double by_past = stage.expected_s - stage.seconds;
    if (stage.rate <= 0 || stage.total <= stage.done)
        return by_past > 0 ? std::optional(by_past) : std::nullopt;
    const double by_rate = (stage.total - stage.done) / stage.rate;
    const double share = std::clamp(stage.done / stage.total, 0.0, 1.0);
    return by_past > 0 ? share * by_rate + (1 - share) * by_past : by_rate;
}

std::optional<double> left_s(const std::vector<ViewStage>& stages, int cores)
{
    double longest = 0;
    double shared = 0;
    for (const ViewStage& stage : stages)
    {
        const double left = left_s(stage).value_or(0);
        const bool runs = stage.state == StageState::running;
        longest = std::max(longest, runs ? left : 0);
        shared += runs ? left * std::clamp(static_cast<double>(stage.threads) / std::max(1, cores), 0.0, 1.0) : left;
    }
    const double all = std::max(longest, shared);
    return all > 0 ? std::optional(all) : std::nullopt;
}

std::vector<std::string> draw_view(const std::vector<ViewStage>& stages, const ViewFrame& frame)
{
    return View(stages, frame).draw();
}

}  // namespace fresco::host
