#include "answers.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/strict_map.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>
#include <tuple>

namespace study
{
namespace
{

using fresco::Error;
using fresco::StrictMap;
using fresco::Value;

constexpr std::string_view sheet_format = "fresco.study_answers";
constexpr int sheet_version = 1;
constexpr std::size_t longest_code = 40;

std::size_t index_from(const Value& value, std::size_t count, const char* entry)
{
    const std::int64_t index = value.as_int();
    if (index < 0 || index >= static_cast<std::int64_t>(count))
        throw Error(fmt::format("{}: {}; the study has {}, numbered from 0", entry, index, count));
    return static_cast<std::size_t>(index);
}

Choice choice_from(const Value& value)
{
    const std::string& word = value.as_string();
    if (word == "left")
        return Choice::left;
    if (word == "right")
        return Choice::right;
    if (word == "neither")
        return Choice::neither;
    throw Error("choice: expected left, right or neither");
}

Answer answer_from(const Value& value, const Study& study)
{
    StrictMap entries(value);
    Answer answer;
    answer.question = index_from(entries.take("question"), study.questions.size(), "question");
    answer.left = index_from(entries.take("left"), study.pictures.size(), "left");
    answer.right = index_from(entries.take("right"), study.pictures.size(), "right");
    answer.choice = choice_from(entries.take("choice"));
    answer.seconds = entries.take("seconds").as_double();
    entries.refuse_others();
    if (!(answer.seconds >= 0))
        throw Error("seconds: expected a number that is not negative");
    const Picture& left = study.pictures[answer.left];
    const Picture& right = study.pictures[answer.right];
    const std::string& ours = study.design.ours;
    const bool is_compared = ours.empty() || left.method == ours || right.method == ours;
    if (left.name != right.name || left.method == right.method || !is_compared)
        throw Error(fmt::format("the pictures {} and {} are not a pair of the study", answer.left, answer.right));
    return answer;
}

std::string code_from(const Value& value)
{
    const std::string& code = value.as_string();
    const auto good = [](char c)
    { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_'; };
    if (code.empty() || code.size() > longest_code || !std::ranges::all_of(code, good))
        throw Error("participant: expected 1 to 40 letters, digits, - and _");
    return code;
}

AnswerSheet sheet_from_value(const Value& root, const Study& study)
{
    StrictMap entries(root);
    if (entries.take("format") != Value(sheet_format) || entries.take("version") != Value(sheet_version))
        throw Error(fmt::format("not the answers of a study, version {}; keep only files that the page wrote in this folder",
                                sheet_version));
    if (entries.take("study") != Value(study.id))
        throw Error("answers of another study; move the file away, or set option \"key\" to that study's key");
    AnswerSheet sheet;
    sheet.participant = code_from(entries.take("participant"));
    sheet.complete = entries.take("complete").as_bool();
    std::set<std::tuple<std::size_t, std::size_t, std::size_t>> known;
    for (const Value& value : entries.take("answers").as_list())
    {
        const std::string place = fmt::format("answers[{}]: ", sheet.answers.size());
        try
        {
            const Answer answer = answer_from(value, study);
            if (!known.emplace(answer.question, std::min(answer.left, answer.right), std::max(answer.left, answer.right)).second)
                throw Error("this pair is answered twice");
            sheet.answers.push_back(answer);
        }
        catch (const Error& error)
        {
            throw Error(place + error.what());
        }
    }
    entries.refuse_others();
    if (sheet.answers.size() > static_cast<std::size_t>(study.pairs_count))
        throw Error(fmt::format("answers: {}; expected at most {}, the pairs that a participant sees", sheet.answers.size(),
                                study.pairs_count));
    return sheet;
}

}  // namespace

AnswerSheet sheet_from(std::string_view text, std::string_view source, const Study& study)
{
    const Value root = fresco::parse_json(text, source);
    try
    {
        return sheet_from_value(root, study);
    }
    catch (const Error& error)
    {
        throw Error(std::string(source) + ": " + error.what());
    }
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

}  // namespace study
