#include "pipeline/problems.h"

#include <algorithm>
#include <fmt/format.h>
#include <tuple>

namespace fresco::host
{

void ProblemList::add(Position position, std::string text, ProblemKind kind)
{
    problems_.push_back({std::move(position), std::move(text), kind});
}

void ProblemList::announce_file(std::string file)
{
    files_.push_back(std::move(file));
}

std::vector<Problem> ProblemList::sorted() const
{
    const auto place = [this](const Problem& problem)
    {
        const auto file = std::find(files_.begin(), files_.end(), problem.position.file) - files_.begin();
        return std::tuple(file, problem.position.line, problem.position.column);
    };
    std::vector<Problem> result = problems_;
    std::stable_sort(result.begin(), result.end(), [&](const Problem& a, const Problem& b) { return place(a) < place(b); });
    const auto same = [&](const Problem& a, const Problem& b)
    { return a.text == b.text && a.position.file == b.position.file && place(a) == place(b); };
    result.erase(std::unique(result.begin(), result.end(), same), result.end());
    return result;
}

std::string to_string(const Problem& problem)
{
    const Position& at = problem.position;
    const std::string place = at.line > 0 ? fmt::format(":{}:{}", at.line, at.column) : "";
    return at.file + place + ": error: " + problem.text;
}

}  // namespace fresco::host
