#include "study.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/random.h>
#include <fresco/value.h>

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace study
{
namespace
{

using fresco::Error;
using fresco::JsonPlace;
using fresco::Value;

constexpr std::string_view key_format = "fresco.study_key";
constexpr int key_version = 1;

Value hints_value(const std::vector<Hint>& hints)
{
    Value::List list;
    for (const Hint& hint : hints)
    {
        Value entry = Value::Map{
            {"view", hint.name}, {"left", hint.left}, {"top", hint.top}, {"width", hint.width}, {"height", hint.height}};
        if (hint.question)
            entry.set("question", *hint.question);
        list.push_back(std::move(entry));
    }
    return list;
}

std::vector<Hint> hints_from(const JsonPlace& list)
{
    std::vector<Hint> hints;
    for (const JsonPlace& place : list.list())
    {
        place.has_only({"view", "left", "top", "width", "height", "question"});
        Hint hint;
        hint.name = place["view"].text();
        hint.left = place["left"].number();
        hint.top = place["top"].number();
        hint.width = place["width"].number();
        hint.height = place["height"].number();
        if (const auto question = place.find("question"))
            hint.question = static_cast<std::size_t>(question->integer(0));
        if (!(hint.left >= 0 && hint.top >= 0 && hint.width > 0 && hint.height > 0 && hint.left + hint.width <= 1 &&
              hint.top + hint.height <= 1))
            place.fail("left, top, width and height: expected shares of the picture, from 0 to 1");
        hints.push_back(std::move(hint));
    }
    return hints;
}

/// Throws Error unless the design is about this study's methods, views and questions.
void check_design(const Study& study)
{
    const auto has = [&](auto member, const std::string& name)
    { return std::ranges::find(study.pictures, name, member) != study.pictures.end(); };
    if (!study.design.ours.empty() && !has(&Picture::method, study.design.ours))
        throw Error("option \"ours\": no method is called " + study.design.ours + "; expected one of the compared methods");
    for (const Hint& hint : study.design.hints)
    {
        if (!has(&Picture::name, hint.name))
            throw Error("a hint names the view " + hint.name + ", which has no pictures in the study");
        if (hint.question && *hint.question >= study.questions.size())
            throw Error(
                fmt::format("a hint names question {}; there are {}, numbered from 0", *hint.question, study.questions.size()));
    }
}

std::string names_of(const std::map<std::string, std::filesystem::path>& files)
{
    return files.empty() ? "no pictures" : files.begin()->first + (files.size() > 1 ? ", …" : "");
}

Value::List pictures_value(const std::vector<Picture>& pictures)
{
    Value::List list;
    for (const Picture& picture : pictures)
        list.emplace_back(Value::Map{{"method", picture.method}, {"name", picture.name}});
    return list;
}

}  // namespace

std::vector<Group> compared_groups(const std::vector<MethodPictures>& methods, std::size_t most)
{
    if (methods.size() < 2)
        throw Error("a study compares two methods or more, found " + std::string(methods.empty() ? "none" : "one") +
                    ": set \"folder\" to a folder with a subfolder of pictures per method, or the ports 'first' and 'second'");
    std::map<std::string, Group> groups;
    std::set<std::string> names;
    for (const MethodPictures& method : methods)
    {
        if (!names.insert(method.method).second)
            throw Error("two methods are named " + method.method + ": give them different names");
        for (const auto& [name, file] : method.files)
        {
            groups[name].name = name;
            groups[name].files.emplace(method.method, file);
        }
    }
    std::vector<Group> shared;
    for (auto& [name, group] : groups)
        if (group.files.size() >= 2)
            shared.push_back(std::move(group));
    if (shared.empty())
        throw Error("no file name is shared by two methods: " + methods[0].method + " has " + names_of(methods[0].files) +
                    " and " + methods[1].method + " has " + names_of(methods[1].files) + "; use one file name for one view");
    if (shared.size() <= most)
        return shared;
    std::vector<Group> chosen;
    for (std::size_t i = 0; i < most; ++i)
        chosen.push_back(shared[(2 * i + 1) * shared.size() / (2 * most)]);
    return chosen;
}

std::vector<Comparison> comparisons(const Study& study)
{
    std::map<std::string, std::map<std::string, std::size_t>> by_name;
    for (std::size_t i = 0; i < study.pictures.size(); ++i)
        by_name[study.pictures[i].name][study.pictures[i].method] = i;
    std::map<std::pair<std::string, std::string>, Comparison> found;
    for (const auto& [name, by_method] : by_name)
        for (auto first = by_method.begin(); first != by_method.end(); ++first)
            for (auto second = std::next(first); second != by_method.end(); ++second)
            {
                const std::string& ours = study.design.ours;
                if (!ours.empty() && first->first != ours && second->first != ours)
                    continue;
                Comparison& comparison = found[{first->first, second->first}];
                comparison.first = first->first;
                comparison.second = second->first;
                comparison.pairs.emplace_back(first->second, second->second);
            }
    std::vector<Comparison> result;
    for (auto& [methods, comparison] : found)
        result.push_back(std::move(comparison));
    return result;
}

Study make_study(const std::vector<Group>& groups, std::vector<std::string> questions, int pairs_count, Design design,
                 std::uint64_t seed, std::string_view shown)
{
    std::vector<std::pair<Picture, std::filesystem::path>> all;
    for (const Group& group : groups)
        for (const auto& [method, file] : group.files)
            all.emplace_back(Picture{method, group.name}, file);
    fresco::Random random(seed);
    for (std::size_t i = all.size(); i > 1; --i)
        std::swap(all[i - 1], all[static_cast<std::size_t>(random.below(static_cast<std::int64_t>(i)))]);

    Study study;
    Value::List hashes;
    for (auto& [picture, file] : all)
    {
        hashes.emplace_back(fresco::file_hash(file));
        study.pictures.push_back(std::move(picture));
    }
    study.questions = std::move(questions);
    study.pairs_count = pairs_count;
    study.design = std::move(design);
    check_design(study);
    study.id = fresco::content_hash(key_text(study) + fresco::to_json(Value(std::move(hashes))) + std::string(shown));
    return study;
}

std::vector<std::string> split_questions(std::string_view text)
{
    std::vector<std::string> questions;
    for (std::size_t start = 0; start <= text.size();)
    {
        const std::size_t end = std::min(text.find('|', start), text.size());
        std::string_view part = text.substr(start, end - start);
        while (!part.empty() && (part.front() == ' ' || part.front() == '\n'))
            part.remove_prefix(1);
        while (!part.empty() && (part.back() == ' ' || part.back() == '\n'))
            part.remove_suffix(1);
        if (part.empty())
            throw Error("option \"questions\": a question is empty; write them as 'One? | Another?'");
        questions.emplace_back(part);
        start = end + 1;
    }
    return questions;
}

std::vector<Hint> hints_from(std::string_view text, std::string_view source)
{
    const Value root = fresco::parse_json(text, source);
    return hints_from(JsonPlace(root, std::string(source)));
}

std::string key_text(const Study& study)
{
    return fresco::to_json(Value::Map{{"format", key_format},
                                      {"version", key_version},
                                      {"study", study.id},
                                      {"questions", Value::List(study.questions.begin(), study.questions.end())},
                                      {"pairs_count", study.pairs_count},
                                      {"ours", study.design.ours},
                                      {"mixes_questions", study.design.mixes_questions},
                                      {"hints", hints_value(study.design.hints)},
                                      {"pictures", pictures_value(study.pictures)}},
                           1) +
           "\n";
}

Study key_from(std::string_view text, std::string_view source)
{
    const Value root = fresco::parse_json(text, source);
    const JsonPlace whole(root, std::string(source));
    if (whole["format"].value() != Value(key_format) || whole["version"].value() != Value(key_version))
        whole.fail(fmt::format("not the key of a study, version {}", key_version));
    whole.has_only({"format", "version", "study", "questions", "pairs_count", "ours", "mixes_questions", "hints", "pictures"});
    Study study;
    study.id = whole["study"].text();
    study.questions = whole["questions"].texts();
    study.pairs_count = static_cast<int>(whole["pairs_count"].integer());
    study.design.ours = whole["ours"].text();
    study.design.mixes_questions = whole["mixes_questions"].flag();
    study.design.hints = hints_from(whole["hints"]);
    std::set<std::pair<std::string, std::string>> known;
    for (const JsonPlace& picture : whole["pictures"].list())
    {
        picture.has_only({"method", "name"});
        study.pictures.push_back({picture["method"].text(), picture["name"].text()});
        if (!known.emplace(study.pictures.back().method, study.pictures.back().name).second)
            picture.fail(study.pictures.back().name + " of " + study.pictures.back().method + " appears twice");
    }
    try
    {
        check_design(study);
    }
    catch (const Error& error)
    {
        whole.fail(error.what());
    }
    if (study.questions.empty() || comparisons(study).empty())
        whole.fail("it has no question, or no pair of pictures");
    return study;
}

}  // namespace study
