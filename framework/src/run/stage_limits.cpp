#include "run/stage_limits.h"
#include "base/common.h"
#include "base/machine.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <charconv>
#include <regex>

namespace fresco::host
{
namespace
{

constexpr double share_of_machine = 0.9;
constexpr double times_measured = 10;
constexpr double shortest_s = 600;
constexpr double unmeasured_s = 3600;

/// Match of the whole text, ignoring case; empty if it does not match.
std::cmatch matched(std::string_view text, const char* pattern)
{
    std::cmatch match;
    constexpr std::size_t longest = 100;  // Matching takes stack for each character.
    if (text.size() <= longest)
        std::regex_match(text.data(), text.data() + text.size(), match, std::regex(pattern, std::regex::icase));
    return match;
}

/// 0 where the part did not match.
double number_in(const std::csub_match& part)
{
    double number = 0;
    std::from_chars(part.first, part.second, number);
    return number;
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
    const std::cmatch match = matched(text, R"((\d+\.?\d*) *(?:(k)|(m)|(g)|(t)) *i? *b? *)");
    if (match.empty())
        throw Error("expected an amount of memory such as 4G or 500M");
    double megabytes = number_in(match[1]) / 1024;
    for (std::size_t unit = 2; !match[unit].matched; ++unit)
        megabytes *= 1024;
    constexpr double least_mb = 16;
    constexpr double most_mb = 1e9;
    if (megabytes < least_mb || megabytes > most_mb)
        throw Error("a stage needs at least 16M, and no machine has more than 900T");
    return megabytes;
}

double parse_seconds(std::string_view text)
{
    const std::cmatch match = matched(text, R"((?:(\d+\.?\d*) *h *)?(?:(\d+\.?\d*) *m *)?(?:(\d+\.?\d*) *s? *)?)");
    const double sum = match.empty() ? 0 : 3600 * number_in(match[1]) + 60 * number_in(match[2]) + number_in(match[3]);
    if (sum <= 0)
        throw Error("expected a time such as 90s, 10m or 1h30m");
    return sum;
}

std::map<std::string, StageLimits> stage_limits(const IsolationRequest& request, const Pipeline& pipeline,
                                                const std::map<std::string, double>& measured_seconds)
{
    std::map<std::string, StageLimits> limits;
    for (const auto& wanted : request.stages)
    {
        bool found = false;
        for (const auto& stage : pipeline.stages)
            if (wanted == "all" || is_called(stage, wanted))
            {
                found = true;
                const auto measured = measured_seconds.find(stage.name);
                const double seconds =
                    measured == measured_seconds.end() ? unmeasured_s : std::max(shortest_s, times_measured * measured->second);
                limits[stage.name] = {share_of_machine * machine_memory_mb(), seconds};
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
