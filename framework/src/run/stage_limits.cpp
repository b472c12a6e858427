#include "run/stage_limits.h"
#include "base/common.h"
#include "base/machine.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

namespace fresco::host
{
namespace
{

constexpr double share_of_machine = 0.9;
constexpr double times_expected = 10;
constexpr double shortest_s = 600;

/// Takes a number without a sign from the front of `text`.
std::optional<double> take_number(std::string_view& text)
{
    if (text.empty() || std::isdigit(static_cast<unsigned char>(text.front())) == 0)
        return std::nullopt;  // from_chars knows "inf", too.
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
    if (error != std::errc())
        return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return number;
}

/// Takes what is no digit from the front, in lower case, without blanks.
std::string take_unit(std::string_view& text)
{
    std::string unit;
    while (!text.empty() && std::isdigit(static_cast<unsigned char>(text.front())) == 0)
    {
        if (text.front() != ' ')
            unit += static_cast<char>(std::tolower(static_cast<unsigned char>(text.front())));
        text.remove_prefix(1);
    }
    return unit;
}

/// In the file, or of one combination of a matrix.
bool is_called(const PipelineStage& stage, const std::string& name)
{
    return stage.name == name || stage.own_name == name;
}

/// Puts each "STAGE=VALUE", and the value for all others, into `field` of the limits.
void put_in(std::map<std::string, StageLimits>& limits, const Pipeline& pipeline, double StageLimits::*field,
            const std::vector<std::string>& values, double (*parse)(std::string_view), const std::string& option)
{
    for (const bool named : {false, true})
        for (const auto& value : values)
        {
            const auto equals = value.find('=');
            if ((equals != std::string::npos) != named)
                continue;
            try
            {
                const double limit = parse(named ? std::string_view(value).substr(equals + 1) : std::string_view(value));
                const std::string name = named ? value.substr(0, equals) : "";
                bool found = !named;
                for (const auto& stage : pipeline.stages)
                    if (const auto isolated = limits.find(stage.name);
                        isolated != limits.end() && (!named || is_called(stage, name)))
                    {
                        isolated->second.*field = limit;
                        found = true;
                    }
                if (!found)
                    throw Error("the stage '" + name + "' is not isolated: add --isolate " + name);
            }
            catch (const Error& error)
            {
                throw Error(option + " " + value + ": " + error.what());
            }
        }
}

}  // namespace

double parse_memory_mb(std::string_view text)
{
    std::optional<double> number = take_number(text);
    std::string unit = take_unit(text);
    if (unit.ends_with("b"))
        unit.pop_back();
    if (unit.ends_with("i"))
        unit.pop_back();
    const auto power = std::string_view("kmgt").find(unit);
    if (!number || unit.size() != 1 || power == std::string_view::npos || !text.empty())
        throw Error("expected an amount of memory such as 4G or 500M");
    double megabytes = *number / 1024;
    for (std::size_t i = 0; i < power; ++i)
        megabytes *= 1024;
    constexpr double least_mb = 16;
    constexpr double most_mb = 1e9;
    if (megabytes < least_mb || megabytes > most_mb)
        throw Error("a stage needs at least 16M, and no machine has more than 900T");
    return megabytes;
}

double parse_seconds(std::string_view text)
{
    double sum = 0;
    std::size_t next_unit = 0;
    bool good = !text.empty();
    while (good && !text.empty())
    {
        const auto number = take_number(text);
        const std::string unit = take_unit(text);
        constexpr std::string_view units = "hms";
        const std::size_t place = unit.empty() ? 2 : units.find(unit);
        good = number && unit.size() <= 1 && place != std::string_view::npos && place >= next_unit;
        if (!good)
            break;
        sum += *number * (place == 0 ? 3600 : place == 1 ? 60 : 1);
        next_unit = place + 1;
    }
    if (!good || sum <= 0)
        throw Error("expected a time such as 90s, 10m or 1h30m");
    return sum;
}

std::map<std::string, StageLimits> stage_limits(const IsolationRequest& request, const Pipeline& pipeline,
                                                const std::map<std::string, double>& expected_seconds)
{
    std::map<std::string, StageLimits> limits;
    for (const auto& wanted : request.stages)
    {
        bool found = false;
        for (const auto& stage : pipeline.stages)
            if (wanted == "all" || is_called(stage, wanted))
            {
                found = true;
                const auto expected = expected_seconds.find(stage.name);
                const double seconds = expected == expected_seconds.end() ? 0 : expected->second;
                limits[stage.name] = {share_of_machine * machine_memory_mb(), std::max(shortest_s, times_expected * seconds)};
            }
        if (!found)
            throw Error("--isolate " + wanted + ": unknown stage '" + wanted + "'" +
                        suggestion(wanted, each(pipeline.stages, &PipelineStage::own_name)));
    }
    put_in(limits, pipeline, &StageLimits::memory_mb, request.memory, parse_memory_mb, "--isolate-memory");
    put_in(limits, pipeline, &StageLimits::seconds, request.seconds, parse_seconds, "--isolate-time");
    return limits;
}

}  // namespace fresco::host
