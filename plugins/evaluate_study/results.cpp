#include "results.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/value.h>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace study
{
namespace
{

using fresco::Error;
using fresco::JsonPlace;
using fresco::Value;

constexpr std::string_view sheet_format = "fresco.study_answers";
constexpr int sheet_version = 1;
constexpr std::size_t longest_code = 40;

std::size_t index_from(const JsonPlace& place, std::size_t count)
{
    const std::int64_t index = place.integer();
    if (index < 0 || index >= static_cast<std::int64_t>(count))
        place.fail(fmt::format("{}; the study has {}, numbered from 0", index, count));
    return static_cast<std::size_t>(index);
}

Choice choice_from(const JsonPlace& place)
{
    constexpr std::array<std::string_view, 3> words{"left", "right", "neither"};
    if (const auto word = std::ranges::find(words, place.text()); word != words.end())
        return static_cast<Choice>(word - words.begin());
    place.fail("expected left, right or neither");
}

Answer answer_from(const JsonPlace& place, const Study& study)
{
    place.has_only({"question", "left", "right", "choice", "seconds"});
    Answer answer;
    answer.question = index_from(place["question"], study.questions.size());
    answer.left = index_from(place["left"], study.pictures.size());
    answer.right = index_from(place["right"], study.pictures.size());
    answer.choice = choice_from(place["choice"]);
    answer.seconds = place["seconds"].amount();
    const Picture& left = study.pictures[answer.left];
    const Picture& right = study.pictures[answer.right];
    const std::string& ours = study.design.ours;
    const bool is_compared = ours.empty() || left.method == ours || right.method == ours;
    if (left.name != right.name || left.method == right.method || !is_compared)
        place.fail(fmt::format("the pictures {} and {} are not a pair of the study", answer.left, answer.right));
    return answer;
}

std::string code_from(const JsonPlace& place)
{
    const std::string& code = place.text();
    const auto good = [](char c)
    { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_'; };
    if (code.empty() || code.size() > longest_code || !std::ranges::all_of(code, good))
        place.fail("expected 1 to 40 letters, digits, - and _");
    return code;
}

}  // namespace

AnswerSheet sheet_from(std::string_view text, std::string_view source, const Study& study)
{
    const Value root = fresco::parse_json(text, source);
    const JsonPlace whole(root, std::string(source));
    if (whole["format"].value() != Value(sheet_format) || whole["version"].value() != Value(sheet_version))
        whole.fail(fmt::format("not the answers of a study, version {}; keep only files that the page wrote in this folder",
                               sheet_version));
    if (whole["study"].value() != Value(study.id))
        whole.fail("answers of another study; move the file away, or set option \"key\" to that study's key");
    whole.has_only({"format", "version", "study", "participant", "complete", "answers"});
    AnswerSheet sheet;
    sheet.participant = code_from(whole["participant"]);
    sheet.complete = whole["complete"].flag();
    std::set<std::tuple<std::size_t, std::size_t, std::size_t>> known;
    for (const JsonPlace& place : whole["answers"].list())
    {
        const Answer answer = answer_from(place, study);
        if (!known.emplace(answer.question, std::min(answer.left, answer.right), std::max(answer.left, answer.right)).second)
            place.fail("this pair is answered twice");
        sheet.answers.push_back(answer);
    }
    if (sheet.answers.size() > static_cast<std::size_t>(study.pairs_count))
        whole.fail("answers", fmt::format("{}; expected at most {}, the pairs that a participant sees", sheet.answers.size(),
                                          study.pairs_count));
    return sheet;
}

std::vector<AnswerSheet> read_sheets(const std::vector<std::filesystem::path>& files, const Study& study)
{
    std::map<std::string, std::pair<AnswerSheet, std::filesystem::path>> by_participant;
    for (const auto& file : files)
    {
        AnswerSheet sheet = sheet_from(fresco::read_text_file(file), file.string(), study);
        const std::string participant = sheet.participant;
        const auto [entry, is_new] = by_participant.try_emplace(participant, std::move(sheet), file);
        if (!is_new)
            throw Error(file.string() + " and " + entry->second.second.string() + " are answers of the same participant, " +
                        participant + ": keep one of them");
    }
    std::vector<AnswerSheet> sheets;
    for (auto& [participant, entry] : by_participant)
        sheets.push_back(std::move(entry.first));
    return sheets;
}

namespace
{

using fresco::evaluation::Interval;

constexpr std::size_t neither = 2;

/// Of one participant: how often the first method, the second, and neither was chosen.
using Counts = std::array<std::int64_t, 3>;

std::int64_t sum(const Counts& counts)
{
    return counts[0] + counts[1] + counts[2];
}

std::size_t chosen(const Answer& answer, const Study& study, const std::string& first)
{
    if (answer.choice == Choice::neither)
        return neither;
    const std::size_t picture = answer.choice == Choice::left ? answer.left : answer.right;
    return study.pictures[picture].method == first ? 0 : 1;
}

bool is_about(const Answer& answer, const Study& study, const Comparison& comparison)
{
    const std::string& left = study.pictures[answer.left].method;
    const std::string& right = study.pictures[answer.right].method;
    return std::minmax(left, right) == std::minmax(comparison.first, comparison.second);
}

/// Of the participants that answered.
std::vector<Counts> counted(const Study& study, const std::vector<AnswerSheet>& sheets, std::size_t question,
                            const Comparison& comparison)
{
    std::vector<Counts> result;
    for (const AnswerSheet& sheet : sheets)
    {
        Counts counts{};
        for (const Answer& answer : sheet.answers)
            if (answer.question == question && is_about(answer, study, comparison))
                ++counts[chosen(answer, study, comparison.first)];
        if (sum(counts) > 0)
            result.push_back(counts);
    }
    return result;
}

Share share_of(const std::vector<Counts>& participants, std::size_t which, const fresco::evaluation::Bootstrap& bootstrap)
{
    const auto value_of = [&](std::span<const std::size_t> drawn)
    {
        std::int64_t count = 0;
        std::int64_t all = 0;
        for (const std::size_t i : drawn)
        {
            count += participants[i][which];
            all += sum(participants[i]);
        }
        return static_cast<double>(count) / static_cast<double>(all);
    };
    Share share;
    std::int64_t all = 0;
    for (const Counts& counts : participants)
    {
        share.count += counts[which];
        all += sum(counts);
    }
    share.value = static_cast<double>(share.count) / static_cast<double>(all);
    share.interval = fresco::evaluation::wilson_interval(share.count, all);
    if (participants.size() >= 2)
    {
        const Interval drawn = fresco::evaluation::bootstrap_interval(participants.size(), value_of, bootstrap);
        share.interval = {std::min(share.interval.low, drawn.low), std::max(share.interval.high, drawn.high)};
    }
    return share;
}

}  // namespace

std::vector<Verdict> verdicts(const Study& study, const std::vector<AnswerSheet>& sheets,
                              const fresco::evaluation::Bootstrap& bootstrap)
{
    std::vector<Verdict> result;
    const auto compared = comparisons(study);
    for (std::size_t question = 0; question < study.questions.size(); ++question)
        for (const Comparison& comparison : compared)
        {
            const auto participants = counted(study, sheets, question, comparison);
            if (participants.empty())
                continue;
            Verdict verdict{question, comparison.first, comparison.second, participants.size(), 0, {}, {}};
            for (std::size_t which = 0; which < verdict.shares.size(); ++which)
            {
                verdict.shares[which] = share_of(participants, which, bootstrap);
                verdict.answers += verdict.shares[which].count;
            }
            const Interval& first = verdict.shares[0].interval;
            const Interval& second = verdict.shares[1].interval;
            if (participants.size() >= 2 && first.low > second.high)
                verdict.preferred = verdict.first;
            if (participants.size() >= 2 && second.low > first.high)
                verdict.preferred = verdict.second;
            result.push_back(std::move(verdict));
        }
    return result;
}

namespace
{

using fresco::Value;

std::string percent_text(const Share& share)
{
    return fmt::format("{:.1f} % [{:.1f}, {:.1f}]", 100 * share.value, 100 * share.interval.low, 100 * share.interval.high);
}

Value share_value(const Share& share)
{
    Value value = fresco::evaluation::figure(share.value, share.interval);
    value.set("count", share.count);
    return value;
}

Value verdict_value(const Verdict& verdict)
{
    return Value::Map{{"first", verdict.first},
                      {"second", verdict.second},
                      {"participants", verdict.participants},
                      {"answers", verdict.answers},
                      {"first_share", share_value(verdict.shares[0])},
                      {"second_share", share_value(verdict.shares[1])},
                      {"neither_share", share_value(verdict.shares[2])},
                      {"preferred", verdict.preferred.empty() ? Value() : Value(verdict.preferred)}};
}

}  // namespace

std::string verdict_line(const Study& study, const Verdict& verdict)
{
    return fmt::format("{} {} {}, {} {}, neither {} of {} answers: {}", study.questions[verdict.question], verdict.first,
                       percent_text(verdict.shares[0]), verdict.second, percent_text(verdict.shares[1]),
                       percent_text(verdict.shares[2]), verdict.answers,
                       verdict.preferred.empty() ? "no significant preference" : verdict.preferred + " is chosen more often");
}

Value results_value(const Study& study, const std::vector<AnswerSheet>& sheets, const std::vector<Verdict>& verdicts)
{
    std::vector<double> seconds;
    for (const AnswerSheet& sheet : sheets)
        for (const Answer& answer : sheet.answers)
            seconds.push_back(answer.seconds);
    Value::List questions;
    for (std::size_t question = 0; question < study.questions.size(); ++question)
    {
        Value::List compared;
        for (const Verdict& verdict : verdicts)
            if (verdict.question == question)
                compared.push_back(verdict_value(verdict));
        questions.emplace_back(Value::Map{{"question", study.questions[question]}, {"comparisons", std::move(compared)}});
    }
    return Value::Map{{"study", study.id},
                      {"participants", sheets.size()},
                      {"complete", static_cast<std::size_t>(std::ranges::count(sheets, true, &AnswerSheet::complete))},
                      {"answers", seconds.size()},
                      {"mean_seconds", fresco::evaluation::number_or_null(fresco::evaluation::mean(seconds))},
                      {"questions", std::move(questions)}};
}

}  // namespace study
